"""What a load level is called, so that names are as short as the loads are certain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microslip.identification.folding import Folded

_DIGITS = 4
_CLOSE, _LARGEST = 1e-3, 4e-3
"""Shares of a load that came out of a channel which its name may leave out, by itself and by its
uncertainty; levels differ by more."""


def labels_of(folded: Sequence[Folded], levels: Sequence[int]) -> dict[int, str]:
    """The load of each level in newtons, as a name has it.

    A load that was given as one number has four digits; one that a channel measured as few as its
    uncertainty allows.
    """
    labels = {}
    for level in sorted(set(levels)):
        of_level = [
            record
            for record, record_level in zip(folded, levels, strict=True)
            if record_level == level
        ]
        loads = [record.normal_load for record in of_level if record.normal_load is not None]
        if not loads:
            continue
        mean = float(np.mean(loads))
        error = max(record.load_error for record in of_level)
        room = min(max(3.0 * error, _CLOSE * abs(mean)), _LARGEST * abs(mean)) if error else 0.0
        texts = [f"{mean:.{digits}g}" for digits in range(1, _DIGITS + 1)]
        near = (text for text in texts if abs(float(text) - mean) <= room)
        labels[level] = f"{float(next(near, texts[-1])):g}"
    return labels
