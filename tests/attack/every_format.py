"""``python -m attack.every_format COUNT [PART OF A NAME ...]``: so many mutants of each format."""

from __future__ import annotations

import sys
import time

import numpy as np

from .campaign import Tally
from .files import attack_seed
from .seeds import seeds


def main() -> int:
    """``python -m attack.every_format COUNT [PART OF A NAME ...]``: so many mutants of each."""
    count, names = int(sys.argv[1]), sys.argv[2:]
    wrong = 0
    for number, seed in enumerate(seeds()):
        if names and not any(name in seed.name for name in names):
            continue
        tally, begun = Tally(), time.perf_counter()
        for round_ in range(0, count, 100):
            attack_seed(np.random.default_rng([number, round_]), tally, seed, 100)
        for text in tally.wrong[:20]:
            print(f"WRONG {text}")
        wrong += len(tally.wrong)
        print(
            f"{seed.name:16} {tally.tried:6} tried {tally.refused:6} refused {len(tally.wrong):4} "
            f"wrong, slowest {tally.slowest:.2f} s, {time.perf_counter() - begun:.0f} s in all",
            flush=True,
        )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
