"""Laws of faces over independent boundary elements: cases, their truths, and the comparison."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import microslip as ms
from microslip.surfaces.findings import Request, analyse

from .elements import AMPLITUDES, Floats, Truth, solve
from .kinds import KINDS, Made, made
from .other_kinds import OTHER_KINDS, other

HERE = Path(__file__).parent
LOG = HERE.parents[1] / "build" / "faces.jsonl"
"""Solved truths, one a line, with the digest of their programs."""
STORED = HERE / "truths.jsonl"
"""Those lines of the log that the slow tests need: changed programs solve their cases anew."""
SCANS = HERE.parents[2] / "shared" / "data" / "scans"
"""Scans of the shared folder, which is not part of the repository."""
METALS = ("steel-c45", "steel-c45")
HARDNESS = 2.4e9
PRESSURES = (8e7, 2.5e8)
SEEDS = (0, 1, 2)
DRAWS = 400
"""Random faces of a band; the 95 % quantile of 100 is off by 0.2 standard deviations."""
FRICTION = 0.2
KEPT = ("plu-1.plu", "mnt-1.mnt", "al3d-1.al3d")
"""Scans whose middle is solved."""
_SIDE = 192


@dataclass(frozen=True)
class Row:
    """One case: k_n and energies of a law over the truth, and whether the band holds the truth."""

    kind: str
    pressure: float
    ratios: tuple[float, ...]
    """k_n and the energies at the amplitudes, law over truth."""
    inside: tuple[bool, ...] = ()
    """Whether the 90 % band of each holds the truth."""


def pair() -> ms.MaterialPair:
    body = ms.Material(210e9, 0.3, hardness=HARDNESS)
    return ms.MaterialPair(body, body)


@cache
def _digest() -> str:
    code = b"".join(
        (HERE / name).read_bytes() for name in ("elements.py", "kinds.py", "other_kinds.py")
    )
    return hashlib.sha256(code).hexdigest()[:16]


@cache
def _logged() -> dict[str, Truth]:
    found = {}
    for file in (STORED, LOG):
        for line in file.read_text("utf-8").splitlines() if file.exists() else ():
            digest, key, values = json.loads(line)
            if digest == _digest():
                found[key] = Truth(values[0], tuple(values[1]), values[2])
    return found


def truth(key: str, heights: Floats, pixel: float, pressure: float, hardness: float) -> Truth:
    """Solve a face [m] under a pressure [Pa], or read it from the log; stiffness in Pa/m."""
    modulus = pair().composite_modulus
    known = _logged()
    if key not in known:
        known[key] = solve(heights / pixel, pressure / modulus, hardness / modulus)
        LOG.parent.mkdir(exist_ok=True)
        with LOG.open("a", encoding="utf-8") as file:
            print(json.dumps([_digest(), key, known[key]]), file=file, flush=True)
    found = known[key]
    return found._replace(stiffness=found.stiffness * modulus / pixel)


def _numbers(law: ms.MeasuredContact | ms.DrawnFace, pressure: float) -> list[float]:
    """Return k_n over the area [Pa/m] and the energies over k_t a^2 at the amplitudes."""
    joint = ms.Interface(law, FRICTION, normal_load=pressure * law.area * (1.0 - 1e-9))
    scale = joint.force_limit / joint.tangential_stiffness
    energies = (float(joint.dissipated_energy(a * scale)) / (a * scale) ** 2 for a in AMPLITUDES)
    return [
        joint.normal_stiffness / law.area,
        *(energy / joint.tangential_stiffness for energy in energies),
    ]


def _ratios(numbers: list[float], true: Truth) -> tuple[float, ...]:
    return tuple(n / t for n, t in zip(numbers, (true.stiffness, *true.energies), strict=True))


def drawn_law(face: Made, pressure: float) -> ms.DrawnFace:
    """Return the law of a face by the numbers of its drawing."""
    return ms.DrawnFace(
        pair(), face.rms, face.slope, face.heights.size * face.pixel**2, pressure,
        plateau=face.plateau, lay=face.lay,
    )  # fmt: skip


def _held(drawn: ms.DrawnFace, true: Truth, pressure: float, seed: bytes) -> tuple[bool, ...]:
    """Return whether the 90 % bands of k_n and of the energies [J] hold the truth.

    The amplitudes [m] are shares of mu N/k_t of the truth, so that a band of the energy includes
    the error of the stiffness, as in a study.
    """
    load = pressure * drawn.area * (1.0 - 1e-9)
    tangential = true.stiffness * drawn.area / drawn.stiffness_ratio
    amplitudes = np.array(AMPLITUDES) * FRICTION * load / tangential
    values = [true.stiffness * drawn.area, *(np.array(true.energies) * tangential * amplitudes**2)]
    random, draws = np.random.default_rng([7, *seed]), []
    for _ in range(DRAWS):
        joint = ms.Interface(drawn.drawn(random), FRICTION, normal_load=load)
        draws.append([joint.normal_stiffness, *joint.dissipated_energy(amplitudes)])
    low, high = np.quantile(draws, [0.05, 0.95], axis=0)
    return tuple(bool(a <= t <= b) for a, t, b in zip(low, values, high, strict=True))


def compared(kind: str, seed: int, pressure: float) -> tuple[Row, Row]:
    """Return the comparison of the measured and of the drawn law of one face."""
    face = other(kind, seed) if kind in OTHER_KINDS else made(kind, seed)
    key = f"{kind} {seed} {pressure:g}"
    true = truth(key, face.heights, face.pixel, pressure, HARDNESS)
    measured = ms.MeasuredContact(
        face.heights, pair(), tightening_pressure=pressure, pixel=face.pixel, piece=None
    )
    drawn = drawn_law(face, pressure)
    inside = _held(drawn, true, pressure, key.encode())
    return (
        Row(kind, pressure, _ratios(_numbers(measured, pressure), true)),
        Row(kind, pressure, _ratios(_numbers(drawn, pressure), true), inside),
    )


def compared_scan(name: str, pressure: float) -> Row:
    """Return the comparison of the joint that ``microslip surface`` finds of a scan."""
    path = SCANS / name
    raw = ms.Scan.read(path)
    dx, dy = raw.pixel
    rows, columns = raw.heights.shape
    crop = ((columns - _SIDE) // 2 * dx, (rows - _SIDE) // 2 * dy)
    area = (_SIDE * dx) * (_SIDE * dy)
    findings = analyse(
        Request(path, crop=crop, materials=METALS, normal_load=pressure * area, area=area,
                friction_coefficient=FRICTION)
    )  # fmt: skip
    face = findings.face
    assert face is not None
    law, scan = face.law, findings.scan.solvable()
    if not math.isclose(*scan.pixel, rel_tol=1e-3):
        raise ValueError(f"{name}: the pixel must be square, got {scan.pixel}")
    numbers = law.numbers
    if scan.heights.shape != (_SIDE, _SIDE):
        raise ValueError(f"{name}: must leave {_SIDE} points a side, got {scan.heights.shape}")
    key = f"{name} {numbers.pressure:g} {numbers.hardness}"
    true = truth(key, scan.heights, scan.pixel[0], numbers.pressure, numbers.hardness or math.inf)
    low, high = face.intervals["normal_stiffness"]
    inside = low / area <= true.stiffness <= high / area
    return Row(name, pressure, _ratios(_numbers(law, numbers.pressure), true), (inside,))


def cases() -> list[tuple[str, int, float]]:
    """Return kind, seed and pressure of all cases."""
    return [(kind, seed, p) for seed in SEEDS for p in PRESSURES for kind in (*KINDS, *OTHER_KINDS)]


def scans() -> list[str]:
    """Return the kept scans that are on this machine."""
    return [name for name in KEPT if (SCANS / name).exists()]


def table(rows: list[Row]) -> list[str]:
    """Return medians, ranges and shares inside the band of each kind and of all, as Markdown."""
    lines = ["| face | k_n | E(0.1) | E(0.3) | E(1) | inside: k_n, E(0.1), E(0.3), E(1) |"]
    lines.append("| --- |" + " --- |" * 5)
    for kind in (*dict.fromkeys(row.kind for row in rows), "all"):
        group = [row for row in rows if kind in (row.kind, "all")]
        ratios = np.array([row.ratios for row in group])
        parts = zip(np.median(ratios, axis=0), ratios.min(0), ratios.max(0), strict=True)
        words = [f"{middle:.2f} [{low:.2f}, {high:.2f}]" for middle, low, high in parts]
        held = np.atleast_1d(np.array([row.inside for row in group]).sum(axis=0))
        words.append(", ".join(f"{int(h)}/{len(group)}" for h in held))
        lines.append(f"| {kind} | {' | '.join(words)} |")
    return lines
