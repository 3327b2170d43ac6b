#!/usr/bin/env python3
"""Compare microslip with what there is, and write the table of docs/validation.md.

References of many digits, models that share no code with it, closed forms of others, other
programs: each row says what was compared, with what, how often, and the largest difference; those
that are no agreement say so.

Usage: make_validation.py [--page]
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import microslip as ms

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]
PAGE = ROOT / "docs" / "validation.md"
BEGIN = "<!-- validation: written by tools/make_validation.py --page -->"
END = "<!-- validation: end -->"

Row = tuple[str, str, str, str, str]
ABSENT = "not here"


def joint() -> ms.Interface:
    """The worked example."""
    return ms.Interface.examples()[0]


def relative(got: object, wanted: object) -> float:
    got, wanted = np.asarray(got, dtype=float), np.asarray(wanted, dtype=float)
    return float(np.max(np.abs(got / wanted - 1.0)))


def references() -> Iterator[Row]:
    """Numbers of forty digits, rounded to doubles."""
    from cases import interface_of, own_cases, shared_cases

    for cases, source in (
        (own_cases(), "40-digit integrals, `tests/reference/make_reference.py`"),
        (shared_cases(), "a second, independent set of such numbers"),
    ):
        if not cases:
            yield "interfaces", source, "", ABSENT, ""
            continue
        for name, words in (
            ("backbone", "force of first loading"),
            ("dissipated_energy", "energy of a cycle"),
            ("loss_factor", "loss factor"),
        ):
            worst, count = 0.0, 0
            for case in cases:
                rows = case["result"]["amplitudes"]
                if name not in rows:
                    continue
                wanted = np.array(rows[name], dtype=float)
                fine = np.isfinite(wanted) & (np.abs(wanted) > 1e-290)
                got = np.asarray(getattr(interface_of(case), name)(rows["displacement"]))
                worst = max(worst, relative(got[fine], wanted[fine]))
                count += int(fine.sum())
            yield words, source, f"{count} values of {len(cases)} joints", f"{worst:.1e}", "agrees"
    moments = json.loads((ROOT / "tests/reference/gaussian_moments.json").read_text("utf-8"))
    worst, count = 0.0, 0
    heights = ms.Gaussian(std=1.0)
    for h, row in zip(moments["h"], moments["moments"], strict=True):
        for order, wanted in zip(moments["orders"], row, strict=True):
            if wanted is not None:
                got = heights.partial_moment(float(order), float(h))
                worst, count = max(worst, relative(got, float(wanted))), count + 1
    yield (
        "moments F_n(h) of Gaussian heights", "40-digit parabolic cylinder functions",
        f"{count} values", f"{worst:.1e}", "agrees",
    )  # fmt: skip


def populations() -> Iterator[Row]:
    """Asperities that each follow the chapter by themselves."""
    import run as bench

    own = joint()
    population = bench.explicit_population(own)
    history = bench.gaussian_noise(100)
    error = np.abs(population.force(history) - own.force(history)).max() / own.force_limit
    yield (
        "forces along Gaussian noise", "10⁵ asperities, each with a state of its own (NumPy)",
        "100 samples", f"{error:.1e} of μN", "agrees to the sampling of the heights",
    )  # fmt: skip
    error = bench.difference(bench.naive_force(own, history), own.force(history), own)
    yield (
        "the same", "the rules of memory in plain Python", "100 samples", f"{error:.1e} of μN",
        "agrees",
    )  # fmt: skip


def mindlin() -> Iterator[Row]:
    """Energy of one sphere: Mindlin and Deresiewicz (1953), DOI 10.1115/1.4010702."""
    steel = ms.Material(210e9, 0.3)
    sphere = ms.SphereOnFlat(ms.MaterialPair(steel, steel), radius=5e-3)
    own = ms.Interface(sphere, friction_coefficient=0.4, normal_load=50.0)
    a = math.sqrt(own.contact_area / math.pi)
    share = np.linspace(0.02, 0.98, 49)
    bracket = 1.0 - (1.0 - share) ** (5 / 3)
    bracket -= 5.0 * share / 6.0 * (1.0 + (1.0 - share) ** (2 / 3))
    factor = 9.0 / 10.0 * own.force_limit**2 / a * 2.0 * (2.0 - 0.3) / steel.shear_modulus
    got = own.dissipated_energy(force_amplitude=share * own.force_limit)
    # The closed form loses digits where little slips, as the cube of the force.
    yield (
        "energy of a sphere's cycle", "Mindlin and Deresiewicz 1953, closed form in the force",
        f"{share.size} forces", f"{relative(got, factor * bracket):.1e}",
        "agrees to the digits that their formula keeps",
    )  # fmt: skip


def conversions() -> Iterator[Row]:
    """Other models made from the joint: what they miss."""
    own = joint()
    scale = own.slip_scale
    amplitudes = scale * np.logspace(-2.0, 1.0, 60)
    for count in (10, 50, 200):
        iwan = own.to_iwan(count, smallest_amplitude=1e-2 * scale, largest_amplitude=10.0 * scale)
        error = relative(iwan.dissipated_energy(amplitudes), own.dissipated_energy(amplitudes))
        yield (
            "energy of a cycle", f"parallel Iwan model of {count} sliders made from the joint",
            "amplitudes over three decades", f"{error:.1e}", "a conversion, not the model",
        )  # fmt: skip


def browser() -> Iterator[Row]:
    """The explorer's JavaScript."""
    if shutil.which("node") is None:
        yield "energy of a cycle", "the explorer's JavaScript", "", ABSENT, "needs Node"
        return
    sys.path[:0] = [str(ROOT / "tests" / "unit")]
    import test_explorer as page

    cases = page.joints(300)
    u = [
        (j.force_limit / j.tangential_stiffness * np.logspace(-5, 3, 9)).tolist() for _, j in cases
    ]
    said = page.in_node(
        "given.map(([p, u]) => u.map(makeJoint(p).energy))",
        [(choice, own) for (choice, _), own in zip(cases, u, strict=True)],
    )
    worst = max(
        relative(answer, j.dissipated_energy(own))
        for (_, j), own, answer in zip(cases, u, said, strict=True)
    )
    yield "energy of a cycle", "the explorer's JavaScript", "300 joints", f"{worst:.1e}", "agrees"


def programs() -> Iterator[Row]:
    """The joint in programs of others, as `make hosts` runs it, and how they differ from Python."""
    sys.path[:0] = [str(ROOT / "tests" / "physics")]

    def opensees(folder: Path) -> tuple[object, object]:
        import test_hosts_opensees as host

        return host.driven(".py", host.in_python, folder)

    def calculix(folder: Path) -> tuple[object, object]:
        import test_hosts_calculix as host

        if host.CCX is None:
            raise ImportError("ccx")
        return host.static_cycle(folder)

    import pytest

    for what, program, run, verdict in (
        ("forces of 50 exported cells", "OpenSees", opensees, "agrees"),
        (
            "forces of 12 exported cells",
            "CalculiX",
            calculix,
            "agrees to its seven digits",
        ),
    ):
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            try:
                found, wanted = (np.asarray(x, dtype=float) for x in run(Path(folder)))
            except (ImportError, pytest.skip.Exception):
                yield what, program, "", ABSENT, "needs the program: `make hosts`"
                continue
        error = np.abs(found - wanted).max() / np.abs(wanted).max()
        yield what, program, f"{found.size} values", f"{error:.1e} of the largest", verdict


def half_space() -> Iterator[Row]:
    """Summits that do not feel each other beside the elastic half space that does."""
    import real_area

    for row in real_area.compare(256, 8, 24, seed=1, loads=(0.001, 0.006, 0.02)):
        ratio = row["gaussian ratio"]
        off = f"{100.0 * abs(ratio - 1.0):.0f} %"
        yield (
            f"normal stiffness at a real area of {100.0 * row['gaussian area']:.2g} %",
            "boundary elements on the same rough surface (256 x 256, periodic)", "one surface",
            f"{ratio:.2f} times", f"differs: the half space is {off} "
            f"{'stiffer' if ratio > 1.0 else 'softer'}; see the verdict on the real area",
        )  # fmt: skip


COMPARISONS: tuple[Callable[[], Iterator[Row]], ...] = (
    references, populations, mindlin, browser, half_space, programs, conversions,
)  # fmt: skip


def table(earlier: str = "") -> str:
    """All comparisons as a table of Markdown; one that cannot be made here stays as it was."""
    lines = ["| what | against | how much | largest difference | verdict |", "| --- " * 5 + "|"]
    for comparison in COMPARISONS:
        for row in comparison():
            kept = [line for line in earlier.splitlines() if f"| {row[1]}" in line]
            lines += kept if row[3] == ABSENT and kept else [f"| {' | '.join(row)} |"]
            print(lines[-1], flush=True)
    return "\n".join(lines)


def main() -> None:
    """Compare, print, and write what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--page", action="store_true", help="write the table of docs/validation.md")
    given = parser.parse_args()
    before, _, rest = PAGE.read_text("utf-8").partition(BEGIN)
    earlier, _, after = rest.partition(END)
    text = table(earlier)
    if given.page:
        PAGE.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
