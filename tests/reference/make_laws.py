"""Reference numbers of the laws that the model is compared with, to 30 digits.

    python tests/reference/make_laws.py

writes laws.json beside itself. Nothing of the package is used. Iwan's laws come from their
definition, each slider by itself: T0 = sum or integral of k min(u, y), E_d that of 4 k y (a - y).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mpmath as mp

DIGITS = 30
AMPLITUDES = ("1e-9", "1e-5", "0.01", "0.2", "0.7", "1", "1.3", "2.5", "40")  # of limit/stiffness

SEGALMAN = [
    {"force_limit": 4000.0, "stiffness": 1.5e8, "chi": -0.5, "beta": 0.6},
    {"force_limit": 1100.0, "stiffness": 5.7e9, "chi": 0.0, "beta": 0.0},
    {"force_limit": 2e-3, "stiffness": 1e3, "chi": -0.9, "beta": 5.0},
    {"force_limit": 50.0, "stiffness": 1e7, "chi": 1.5, "beta": 0.02},
    {"force_limit": 300.0, "stiffness": 2e7, "chi": -0.3, "beta": 0.005},
]
IWAN = [
    {"stiffnesses": [5e7], "force_limits": [100.0]},
    {"stiffnesses": [4e8, 1e7, 2e8, 5e7, 1e8], "force_limits": [10.0, 20.0, 30.0, 40.0, 15.0]},
    {
        "stiffnesses": [float((37 * i) % 101 + 1) * 1e5 for i in range(100)],
        "force_limits": [float((53 * i) % 97 + 1) * 0.25 for i in range(100)],
    },
]


# In units of yield_force/stiffness: reversals below and above zero force, rest, gross slip.
def number(value: Any) -> float:
    return float(value)


def segalman(case: dict[str, float]) -> dict[str, Any]:
    """The definition: density R y^chi up to phi and a slider S there, from the four parameters."""
    limit, stiffness, chi, beta = (mp.mpf(v) for v in case.values())
    p = chi + 1
    phi = limit * (1 + beta) / (stiffness * (beta + p / (p + 1)))
    density = stiffness * p / ((1 + beta) * phi**p)
    last = beta * density * phi**p / p

    def spread(share: Any, low: Any, high: Any) -> Any:
        """Integral of share(y) R y^chi: in t = (y/high)^p, which makes the density even."""
        size = share(high / 2)  # quadrature wants numbers of order one
        inner = mp.quad(lambda t: share(high * t ** (1 / p)) / size, [(low / high) ** p, 1])
        return density / p * high**p * size * inner

    # The parameters are what Segalman says they are.
    agree(spread(lambda y: mp.mpf(1), mp.mpf(0), phi) + last, stiffness)
    agree(spread(lambda y: y, mp.mpf(0), phi) + last * phi, limit)
    rows: dict[str, list[float]] = {"displacement": [], "backbone": [], "slope": [], "energy": []}
    for text in AMPLITUDES:
        u = mp.mpf(number(mp.mpf(text) * limit / stiffness))
        inner = min(u, phi)
        force = spread(lambda y: y, mp.mpf(0), inner) + last * inner
        slope = last if u < phi else mp.mpf(0)
        if u < phi:
            sticking = spread(lambda y: mp.mpf(1), u, phi)
            force, slope = force + u * sticking, slope + sticking
        energy = 4 * spread(lambda y, u=u: y * (u - y), mp.mpf(0), inner)
        energy += 4 * last * phi * max(u - phi, 0)
        for name, value in zip(rows, (u, force, slope, energy), strict=True):
            rows[name].append(number(value))
    return {"law": "SegalmanIwan", "parameters": case, "slip_displacement": number(phi), **rows}


def iwan(case: dict[str, list[float]]) -> dict[str, Any]:
    cells = [(mp.mpf(k), mp.mpf(f)) for k, f in zip(*case.values(), strict=True)]
    limit, stiffness = mp.fsum(f for _, f in cells), mp.fsum(k for k, _ in cells)
    rows: dict[str, list[float]] = {"displacement": [], "backbone": [], "slope": [], "energy": []}
    for text in AMPLITUDES:
        # Off the corners: there a slope has two values, an energy no digits.
        u = mp.mpf(number(mp.mpf(text) * limit / stiffness * mp.mpf("1.001")))
        force = mp.fsum(min(k * u, f) for k, f in cells)
        slope = mp.fsum(k for k, f in cells if f / k > u)
        energy = 4 * mp.fsum(f * max(u - f / k, 0) for k, f in cells)
        for name, value in zip(rows, (u, force, slope, energy), strict=True):
            rows[name].append(number(value))
    return {"law": "Iwan", "parameters": case, **rows}


def agree(value: Any, wanted: Any, tolerance: Any = None) -> None:
    if abs(value / wanted - 1) > (tolerance or mp.mpf(10) ** (8 - DIGITS)):
        raise ArithmeticError(f"{value} is not {wanted}")


if __name__ == "__main__":
    mp.mp.dps = DIGITS
    content = {
        "about": "Laws that the Extended Greenwood Model is compared with, SI units, nearest "
        "doubles. Made by make_laws.py.",
        "cases": [
            *map(segalman, SEGALMAN),
            *map(iwan, IWAN),
        ],
    }
    path = Path(__file__).with_name("laws.json")
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
