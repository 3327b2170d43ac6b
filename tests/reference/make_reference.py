#!/usr/bin/env python3
"""Reference numbers for the tests, made with mpmath alone.

Usage: python make_reference.py            (writes the JSON files beside this program)

The model is the Extended Greenwood Model of chapter 19 of *The Mechanics of Jointed Structures*
(DOI 10.1007/978-3-319-56818-8_19), freed of its misprints. All inputs are doubles and enter the
arithmetic exactly. Arithmetic runs with 100 digits, so that no cancellation below matters: the
worst, the dissipated energy at 1e-13 m, eats about 25 of them. Outputs are the nearest doubles;
numbers below 1e-305 are left out of the moments (null) and are 0.0 elsewhere.

What it does differently from the library, and how it checks itself:

- Gaussian moments: Maclaurin series of the definition with guard digits, asymptotic series where
  it reaches the working precision; checked against the parabolic cylinder function, the confluent
  hypergeometric U and quadrature of the definition.
- Forces on a history: no stack. For each sample the whole past is searched for the dominant
  extremes (last largest |displacement|, then the farthest point on the other side since, and so
  on). Checked against parallel stop operators, one for each slider of the Iwan form.
- Dissipated energy: difference of the integrated backbone; checked against the integral with the
  positive integrand (continuous heights) and the sum over asperities of a factored closed form
  (finite populations).
- Backbone: difference of two normal loads; checked against the sum of (19.15) over the heights.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import mpmath as mp

DIGITS = 100
SMALLEST = mp.mpf("1e-305")
ORDERS = (-0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5)
AMPLITUDES = (1e-13, 1e-11, 2.5e-10, 3e-9, 4e-8, 1.7e-7, 6e-7, 2.3e-6, 1.1e-5, 1e-4)
THREE_HALVES = mp.mpf(3) / 2


# Partial moments F_n(h) = integral of (u - h)^n phi(u) over u > h.


def gaussian_moment(n: Any, h: Any) -> Any:
    """Moment of the standard normal density."""
    n, h = mp.mpf(n), mp.mpf(h)
    if h > 0 and h * h > 5 * (mp.mp.dps + 5):
        return asymptotic_moment(n, h)
    # (u - h)^n exp(-u^2/2), u = h + t, expanded in powers of h t. For h > 0 the terms alternate
    # and cancel from exp(h^2/2) down to order one.
    guard = 20 + int(0.44 * max(h, 0) ** 2 / 2)
    with mp.workdps(mp.mp.dps + guard):
        even = mp.mpf(2) ** ((n - 1) / 2) * mp.gamma((n + 1) / 2)
        odd = -h * mp.mpf(2) ** (n / 2) * mp.gamma(n / 2 + 1)
        total, largest, k, square = mp.mpf(0), mp.mpf(0), 0, h * h
        while k <= square or abs(even) + abs(odd) > largest * mp.eps:
            total += even + odd
            largest = max(largest, abs(even), abs(odd))
            even *= square * (n + k + 1) / ((k + 1) * (k + 2))
            odd *= square * (n + k + 2) / ((k + 2) * (k + 3))
            k += 2
        value = total * mp.exp(-square / 2) / mp.sqrt(2 * mp.pi)
    return +value


def asymptotic_moment(n: Any, h: Any) -> Any:
    """Moment of the standard normal density at large h, DLMF 12.9.1."""
    term, total, k = mp.mpf(1), mp.mpf(0), 0
    while abs(term) > mp.eps:
        total += term
        ratio = -(n + 2 * k + 1) * (n + 2 * k + 2) / (2 * (k + 1) * h * h)
        if abs(ratio) >= 1:
            raise ArithmeticError(f"h = {h} is too small for {mp.mp.dps} digits")
        term *= ratio
        k += 1
    return total * mp.gamma(n + 1) * h ** (-n - 1) * mp.exp(-h * h / 2) / mp.sqrt(2 * mp.pi)


def exponential_moment(n: Any, h: Any) -> Any:
    """Moment of the density exp(-u), u > 0, for h of any sign."""
    n, h = mp.mpf(n), mp.mpf(h)
    if h >= 0:
        return mp.gamma(n + 1) * mp.exp(-h)
    return mp.exp(-h) * mp.gammainc(n + 1, -h)


# Normal load laws. Each gives the load and its derivatives, and how many summits touch where.


class StatisticalLaw:
    """Summits of one radius whose heights have a density, (19.5)-(19.8)."""

    def __init__(self, case: dict[str, Any], modulus: Any) -> None:
        heights = case["heights"]
        gaussian = heights["kind"] == "gaussian"
        self.moment = gaussian_moment if gaussian else exponential_moment
        self.scale = mp.mpf(heights["std" if gaussian else "scale"])
        self.mean = mp.mpf(heights.get("mean", 0.0))
        self.summits = mp.mpf(case["density"]) * mp.mpf(case["area"])
        self.radius = mp.mpf(case["radius"])
        self.hertz = mp.mpf(4) / 3 * modulus * mp.sqrt(self.radius)
        self.cache: dict[Any, Any] = {}

    def standardised(self, d: Any) -> Any:
        return (d - self.mean) / self.scale

    def sum_of_powers(self, n: Any, d: Any) -> Any:
        """Sum over touching summits of indentation^n."""
        key = (mp.mpf(n), mp.mpf(d), mp.mp.prec)
        if key not in self.cache:
            self.cache[key] = (
                self.summits * self.scale ** mp.mpf(n) * self.moment(n, self.standardised(d))
            )
        return self.cache[key]

    def load(self, d: Any) -> Any:
        return self.hertz * self.sum_of_powers(THREE_HALVES, d)

    def slope(self, d: Any) -> Any:
        return -THREE_HALVES * self.hertz * self.sum_of_powers(mp.mpf(1) / 2, d)

    def curvature(self, d: Any) -> Any:
        return mp.mpf(3) / 4 * self.hertz * self.sum_of_powers(-mp.mpf(1) / 2, d)

    def integral(self, d: Any) -> Any:
        """Integral of the load from d to infinity."""
        return mp.mpf(2) / 5 * self.hertz * self.sum_of_powers(mp.mpf(5) / 2, d)

    def contacts(self, d: Any) -> tuple[Any, Any]:
        """Number of summits in contact and their area."""
        return self.sum_of_powers(0, d), mp.pi * self.radius * self.sum_of_powers(1, d)

    def bracket(self) -> tuple[Any, Any]:
        return self.mean - 60 * self.scale, self.mean + 36 * self.scale


class FiniteLaw:
    """Finitely many summits, each with its height and radius; one sphere is the case of one."""

    def __init__(self, case: dict[str, Any], modulus: Any) -> None:
        heights = case["heights"]
        if heights["kind"] == "sphere":
            pairs = [(0.0, case["radius"])]
        else:
            pairs = list(zip(heights["values"], heights["radii"], strict=True))
        self.summits = [(mp.mpf(y), mp.mpf(r)) for y, r in pairs]
        self.modulus = modulus

    def touching(self, d: Any) -> list[tuple[Any, Any]]:
        """Indentation and radius of each summit in contact."""
        return [(y - d, r) for y, r in self.summits if y > d]

    def hertz_sum(self, n: Any, d: Any) -> Any:
        return mp.fsum(
            mp.mpf(4) / 3 * self.modulus * mp.sqrt(r) * s ** mp.mpf(n) for s, r in self.touching(d)
        )

    def load(self, d: Any) -> Any:
        return self.hertz_sum(THREE_HALVES, d)

    def slope(self, d: Any) -> Any:
        return -THREE_HALVES * self.hertz_sum(mp.mpf(1) / 2, d)

    def curvature(self, d: Any) -> Any:
        return mp.mpf(3) / 4 * self.hertz_sum(-mp.mpf(1) / 2, d)

    def integral(self, d: Any) -> Any:
        return mp.mpf(2) / 5 * self.hertz_sum(mp.mpf(5) / 2, d)

    def contacts(self, d: Any) -> tuple[Any, Any]:
        touching = self.touching(d)
        return mp.mpf(len(touching)), mp.pi * mp.fsum(r * s for s, r in touching)

    def bracket(self) -> tuple[Any, Any]:
        highest = max(y for y, _ in self.summits)
        return highest - mp.mpf("1e-2"), highest


def solve_separation(law: Any, load: Any) -> Any:
    """Separation at which the law carries the load: bisection, then secants on load^(2/3)."""
    low, high = law.bracket()
    with mp.workdps(20):
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if law.load(middle) > load else (low, middle)
    goal = load ** (1 / THREE_HALVES)
    d = low
    for _ in range(12):
        power = law.load(d) ** (1 / THREE_HALVES)
        # d(N^(2/3))/dd; nearly linear in d, and exactly linear for one sphere.
        step = (power - goal) / (law.slope(d) / THREE_HALVES * power ** (-mp.mpf(1) / 2))
        d -= step
        if abs(step) < abs(d) * mp.mpf(10) ** (8 - DIGITS):
            return d
    raise ArithmeticError(f"no separation carries {load} N")


# The interface.


class Interface:
    """One interface at its normal load: backbone, energy, and forces on any history."""

    def __init__(self, case: dict[str, Any]) -> None:
        normal = tangential = mp.mpf(0)
        for body in case["materials"]:
            if body.get("rigid"):
                continue
            young, poisson = mp.mpf(body["young_modulus"]), mp.mpf(body["poisson_ratio"])
            normal += (1 - poisson**2) / young
            tangential += (2 - poisson) / (young / (2 * (1 + poisson)))
        self.composite_modulus, self.composite_shear_modulus = 1 / normal, 1 / tangential
        self.ratio = self.composite_modulus / (4 * self.composite_shear_modulus)
        self.mu = mp.mpf(case["friction_coefficient"])
        self.kappa = self.mu * self.ratio
        statistical = case["heights"]["kind"] in ("gaussian", "exponential")
        make = StatisticalLaw if statistical else FiniteLaw
        self.law: Any = make(case, self.composite_modulus)
        if "separation" in case:
            self.separation = mp.mpf(case["separation"])
        else:
            self.separation = solve_separation(self.law, mp.mpf(case["normal_load"]))
        self.load = self.law.load(self.separation)

    def shifted(self, x: Any) -> Any:
        """Separation whose contacts are those that still stick after first loading to x."""
        return self.separation + x / self.kappa

    def backbone(self, x: Any) -> Any:
        return self.mu * (self.load - self.law.load(self.shifted(x)))

    def tangent(self, x: Any) -> Any:
        return -self.mu / self.kappa * self.law.slope(self.shifted(x))

    def sliders(self, x: Any) -> Any:
        """Density of sliders whose yield displacement is x, minus the backbone's curvature."""
        return self.mu / self.kappa**2 * self.law.curvature(self.shifted(x))

    def energy(self, x: Any) -> Any:
        """Loss of one cycle, eight times the backbone's area less four times its rectangle."""
        area = self.load * x - self.kappa * (
            self.law.integral(self.separation) - self.law.integral(self.shifted(x))
        )
        return 8 * self.mu * area - 4 * x * self.backbone(x)

    def energy_again(self, x: Any) -> Any:
        """The same by another road, good to some 20 digits."""
        if isinstance(self.law, FiniteLaw):
            terms = []
            for s, r in self.law.touching(self.separation):
                limit, friction = self.kappa * s, self.mu * 4 / 3 * mp.sqrt(r) * s**THREE_HALVES
                # (24/5) {1 - w^5 - (5/6)(1 - w^3)(1 + w^2)} = (4/5)(1 - w)^3 (1 + 3w + w^2)
                w = mp.sqrt(1 - min(x / limit, 1))
                loop = mp.mpf(4) / 5 * (1 - w) ** 3 * (1 + 3 * w + w * w) * limit
                terms.append(friction * (loop + 4 * max(x - limit, 0)))
            return self.law.modulus * mp.fsum(terms)
        with mp.workdps(26):
            width = self.kappa * self.law.scale
            top = self.kappa * (self.law.mean - self.separation)
            steps = [0, 0.5, 1, 2, 3, 4, 6, 8, 11, 15, 20, 30]
            marks = [c * width for c in steps]
            if self.law.moment is exponential_moment and top > 0:
                # The curvature has a root singularity where the separation passes zero.
                marks += [top + c * width for c in steps]
                method = "tanh-sinh"
            else:
                marks += [top + c * width for c in (-5, -3, -2, -1, 0, 1, 2, 3, 5, 8)]
                method = "gauss-legendre"
            nodes = [0, *sorted(m / x for m in marks if 0 < m < x), 1]
            # Scaled to order one, for quad stops at an absolute error.
            unit = self.sliders(0)
            integral = mp.quad(
                lambda v: v * (1 - v) * self.sliders(x * v) / unit, nodes, method=method
            )
            return 4 * x**3 * unit * integral

    def force(self, extremes: Sequence[Any]) -> Any:
        """Force at the end of the dominant extremes of a history."""
        first = extremes[0]
        total = mp.sign(first) * self.backbone(abs(first))
        for start, end in pairwise(extremes):
            total += 2 * mp.sign(end - start) * self.backbone(abs(end - start) / 2)
        return total

    def stiffness(self, extremes: Sequence[Any]) -> Any:
        if len(extremes) == 1:
            return self.tangent(abs(extremes[0]))
        return self.tangent(abs(extremes[-1] - extremes[-2]) / 2)


def dominant_extremes(past: Sequence[Any], tie: bool = True) -> list[Any]:
    """Turning points that a history still remembers, ending at its last point.

    The largest |displacement| so far, then the farthest point on the other side since then, and so
    on to the present. Of equal candidates the last counts (a closed loop is forgotten where it
    closes); with ``tie`` false the present point closes nothing by merely being equal, which tells
    the branch that led up to it.
    """
    now = len(past) - 1
    while now > 0 and past[now - 1] == past[now]:
        now -= 1
    points = past[: now + 1]

    def last_best(indices: Iterable[int], measure: Callable[[Any], Any]) -> int:
        best = -1
        for i in indices:
            if best < 0 or measure(points[i]) > measure(points[best]):
                best = i
            elif measure(points[i]) == measure(points[best]) and (tie or i < now):
                best = i
        return best

    at = last_best(range(now + 1), abs)
    found = [points[at]]
    sign = 1 if points[at] > 0 else -1
    while at < now:
        # Away from an extreme of this sign the path has been on the other side ever since.
        at = last_best(range(at + 1, now + 1), lambda v, s=sign: -s * v)  # type: ignore[misc]
        found.append(points[at])
        sign = -sign
    return found


# Cases.


def history(unit: float) -> list[float]:
    """A displacement history with every kind of event, in multiples of a unit, as doubles.

    First loading; a repeated sample; a minor loop closed exactly and one passed; return to the
    first reversal and resumption of first loading; symmetric closure at exactly minus the extreme
    and passing it; tiny turns; nested loops wiped out at once; gross slip; rest.
    """
    tiny = 2.0**-30
    steps = [
        *(0.2, 0.55, 0.55, 0.3, 0.35, 0.31, 0.35, 0.4, 0.1, -0.2, 0.15, -0.05, 0.15, 0.4),
        *(0.55, 0.7, 0.2, -0.7, -0.7, -0.9, -0.4, -0.4 - tiny, -0.4, -0.4 + tiny, -0.6),
        *(0.9, 0.5, 0.8, 0.6, 0.75, 0.65, 0.7, 0.95, 1.6, 1.6, -0.5, -1.3, 0.4, -1.6, -2.2),
        *(1.0, 0.0, 0.0, 2.2, -9.0, 3.0, 4.0, 0.0),
    ]
    return [step * unit for step in steps]


def cycle(unit: float) -> list[float]:
    """One period of an asymmetric displacement with two minor loops, as doubles."""
    steps = [
        *(0.1, 0.6, 1.1, 0.8, 0.95, 1.2, 1.5, 1.3, 0.7, 0.2, -0.2, 0.3, 0.05, -0.3, -0.45),
        *(-0.6, -0.35, -0.1),
    ]
    return [step * unit for step in steps]


AL2017 = {"young_modulus": 69e9, "poisson_ratio": 0.33}
STEEL = {"young_modulus": 208e9, "poisson_ratio": 0.29}
TITANIUM = {"young_modulus": 114e9, "poisson_ratio": 0.34}
POLYMER = {"young_modulus": 3.1e9, "poisson_ratio": 0.38}
BRASS = {"young_modulus": 101e9, "poisson_ratio": 0.35}
RIGID = {"rigid": True}


def cases() -> list[dict[str, Any]]:
    """Interfaces: inputs are doubles, `unit` is the step of the histories [m]."""

    def rough(name: str, materials: Any, mu: float, heights: Any, **rest: Any) -> dict[str, Any]:
        return {
            "name": name,
            "materials": list(materials),
            "friction_coefficient": mu,
            "heights": heights,
            **rest,
        }

    return [
        rough(
            "gaussian-very-light",
            (AL2017, AL2017),
            0.55,
            {"kind": "gaussian", "std": 5e-7, "mean": 0.0},
            **{"radius": 1e-3, "density": 1e8, "area": 2e-4, "normal_load": 1e-9, "unit": 6e-8},
        ),
        rough(
            "gaussian-light-mean",
            (STEEL, TITANIUM),
            0.31,
            {"kind": "gaussian", "std": 8.3e-7, "mean": 2.9e-7},
            **{"radius": 4.1e-4, "density": 3.7e8, "area": 1.5e-4, "normal_load": 7.5},
            unit=1.1e-7,
        ),
        rough(
            "gaussian-al2017",
            (AL2017, AL2017),
            0.55,
            {"kind": "gaussian", "std": 5e-7, "mean": 0.0},
            **{"radius": 1e-3, "density": 1e8, "area": 2e-4, "normal_load": 2000.0, "unit": 3e-7},
        ),
        rough(
            "gaussian-separation-rigid",
            (RIGID, BRASS),
            0.18,
            {"kind": "gaussian", "std": 1.9e-6, "mean": -7e-7},
            **{"radius": 2.6e-5, "density": 5.2e9, "area": 3.3e-5, "separation": 1.25e-6},
            unit=4e-7,
        ),
        rough(
            "gaussian-heavy-mean",
            (TITANIUM, STEEL),
            0.42,
            {"kind": "gaussian", "std": 3.3e-7, "mean": -2.5e-7},
            **{"radius": 7e-4, "density": 1.3e9, "area": 6e-5, "normal_load": 2.3e5, "unit": 5e-7},
        ),
        rough(
            "gaussian-very-heavy",
            (POLYMER, STEEL),
            0.73,
            {"kind": "gaussian", "std": 6e-7, "mean": 1e-7},
            **{"radius": 3e-4, "density": 2e8, "area": 1e-4, "separation": -7.1e-6, "unit": 6e-6},
        ),
        rough(
            "exponential-light",
            (STEEL, BRASS),
            0.27,
            {"kind": "exponential", "scale": 9.1e-7},
            **{"radius": 5.5e-4, "density": 4.4e7, "area": 2.5e-4, "normal_load": 310.0},
            unit=2.4e-7,
        ),
        rough(
            "exponential-heavy",
            (AL2017, RIGID),
            0.61,
            {"kind": "exponential", "scale": 4.7e-7},
            **{"radius": 9e-4, "density": 8e7, "area": 1.2e-4, "normal_load": 2.6e4, "unit": 8e-7},
        ),
        rough(
            "sphere",
            (POLYMER, RIGID),
            0.35,
            {"kind": "sphere"},
            **{"radius": 6.35e-3, "normal_load": 12.5, "unit": 2.9e-6},
        ),
        rough(
            "seven-summits",
            (BRASS, AL2017),
            0.47,
            {
                "kind": "summits",
                "values": [1.1e-6, -4e-7, 2.05e-6, 7.3e-7, 1.62e-6, -1.9e-6, 1.37e-6],
                "radii": [3e-4, 8e-4, 1.2e-4, 5.1e-4, 2.2e-4, 9.7e-4, 3.9e-4],
            },
            **{"normal_load": 2.2, "unit": 4e-7},
        ),
    ]


def moment_grid() -> list[float]:
    """Irregular points from -40 to 38, whole numbers, and the neighbourhood of likely seams."""
    points = {float(i) for i in range(-40, 39)}
    points |= {0.0, 1e-9, -1e-9, 1e-300, -1e-17, 3e-5, -3e-5, 37.25, 37.4}
    for seam in (-20.0, -10.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 20.0, 30.0):
        points |= {seam - 2.0**-40, seam + 2.0**-40, seam + 2.0**-7}
    golden = 0.6180339887498949
    points |= {round(-40 + 78 * (i * golden % 1), 3) for i in range(1, 61)}
    points |= {round(-11 + 22 * (i * golden % 1), 4) for i in range(1, 71)}
    return sorted(points)


# Output and self-check.


def nearest(value: Any) -> float:
    """Nearest double; what double precision holds badly is zero."""
    if abs(value) < SMALLEST:
        return 0.0
    return float(mp.nstr(value, 40))


def make_moments() -> dict[str, Any]:
    grid = moment_grid()
    rows = []
    with mp.workdps(50):
        for h in grid:
            values = [gaussian_moment(n, h) for n in ORDERS]
            rows.append([None if v < SMALLEST else nearest(v) for v in values])
    return {
        "about": "F_n(h) = int_h^oo (u - h)^n exp(-u^2/2)/sqrt(2 pi) du; moments[i][j] is F_n(h) "
        "for h = h[i], n = orders[j]; null below 1e-305. Made by make_reference.py.",
        "orders": list(ORDERS),
        "h": grid,
        "moments": rows,
    }


def make_interface(case: dict[str, Any]) -> dict[str, Any]:
    joint = Interface(case)
    count, area = joint.law.contacts(joint.separation)
    scalars = {
        "composite_modulus": joint.composite_modulus,
        "composite_shear_modulus": joint.composite_shear_modulus,
        "stiffness_ratio": joint.ratio,
        "slip_per_indentation": joint.kappa,
        "separation": joint.separation,
        "normal_load": joint.load,
        "contact_count": count,
        "contact_area": area,
        "normal_stiffness": -joint.law.slope(joint.separation),
        "tangential_stiffness": joint.tangent(mp.mpf(0)),
        "force_limit": joint.mu * joint.load,
    }
    result: dict[str, Any] = {key: nearest(value) for key, value in scalars.items()}

    rows: dict[str, list[float]] = {}
    for amplitude in AMPLITUDES:
        x = mp.mpf(amplitude)
        force, tangent, energy = joint.backbone(x), joint.tangent(x), joint.energy(x)
        agree(energy, joint.energy_again(x), 1e-22, f"{case['name']}: energy at {amplitude}")
        row = {
            "displacement": x,
            "backbone": force,
            "tangent_stiffness": tangent,
            "secant_stiffness": force / x,
            "dissipated_energy": energy,
            "energy_ratio": energy / (4 * x * force),
            "loss_factor": energy / (mp.pi * x * force),
            "damping_ratio": energy / (2 * mp.pi * x * force),
            "dissipation_exponent": 4 * x * (force - x * tangent) / energy,
            "stick_area": joint.law.contacts(joint.shifted(x))[1],
            "slider_density": joint.sliders(x),
        }
        for key, value in row.items():
            rows.setdefault(key, []).append(nearest(value))
    result["amplitudes"] = rows

    path = history(case["unit"])
    exact = [mp.mpf(x) for x in path]
    forces = [joint.force(dominant_extremes(exact[: i + 1])) for i in range(len(exact))]
    check_with_stops(case["name"], joint, path, forces)
    result["history"] = {"displacement": path, "force": [nearest(t) for t in forces]}

    period = cycle(case["unit"])
    exact = [mp.mpf(x) for x in period] * 2
    settled_force, settled_stiffness = [], []
    for i in range(len(period), 2 * len(period)):
        memory = dominant_extremes(exact[: i + 1])
        after = joint.stiffness(memory)
        before = joint.stiffness(dominant_extremes(exact[: i + 1], tie=False))
        settled_force.append(nearest(joint.force(memory)))
        settled_stiffness.append(nearest(after) if after == before else None)
    result["settled_cycle"] = {
        "displacement": period,
        "force": settled_force,
        "tangent_stiffness": settled_stiffness,
    }
    return {**case, "result": result}


def agree(value: Any, other: Any, tolerance: float, what: str) -> None:
    if abs(value - other) > tolerance * abs(value):
        raise ArithmeticError(f"{what}: {mp.nstr(value, 25)} and {mp.nstr(other, 25)} differ")


def stop_sliders(
    joint: Interface, reach: float, count: int
) -> tuple[list[tuple[float, float]], float]:
    """The Iwan form as (yield displacement, weight) pairs and the stiffness of all the rest."""
    if isinstance(joint.law, FiniteLaw):
        sliders = []
        for s, r in joint.law.touching(joint.separation):
            limit = joint.kappa * s
            weight = joint.mu * 2 * joint.law.modulus * mp.sqrt(r) * s**THREE_HALVES / limit
            for i in range(count // 2):
                v = (i + mp.mpf(1) / 2) / (count // 2)
                sliders.append((float(limit * (1 - v * v)), float(weight / (count // 2))))
        return sliders, 0.0
    with mp.workdps(18):
        # Finer where the yield displacements are small; the weights add up to the stiffness.
        edges = [reach * (mp.mpf(i) / count) ** 2 for i in range(count + 1)]
        slopes = [joint.tangent(u) for u in edges]
        sliders = [
            (float((edges[i] + edges[i + 1]) / 2), float(slopes[i] - slopes[i + 1]))
            for i in range(count)
        ]
        return sliders, float(slopes[-1])


def check_with_stops(name: str, joint: Interface, path: list[float], forces: list[Any]) -> None:
    """Each slider is an elastic stop that knows its own stretch only; so much for memory rules."""
    sliders, elastic = stop_sliders(joint, max(abs(x) for x in path), 600)
    stretch = [0.0] * len(sliders)
    before, limit = 0.0, float(joint.mu * joint.load)
    for x, force in zip(path, forces, strict=True):
        total = elastic * x
        for i, (u, weight) in enumerate(sliders):
            stretch[i] = min(max(stretch[i] + (x - before), -u), u)
            total += weight * stretch[i]
        before = x
        if abs(total - float(force)) > 2e-4 * limit:
            raise ArithmeticError(f"{name}: stops give {total} at {x}, not {float(force)}")


def self_check() -> None:
    """Hold the moments and the backbone against other definitions of the same."""
    with mp.workdps(40):
        for h in moment_grid()[::3]:
            x = mp.mpf(h)
            for n in map(mp.mpf, ORDERS):
                value = gaussian_moment(n, x)
                factor = mp.gamma(n + 1) / mp.sqrt(2 * mp.pi) * mp.exp(-x * x / 4)
                agree(value, factor * mp.pcfd(-n - 1, x), 1e-32, f"D: F_{n}({h})")
                if x > 0:
                    half = mp.mpf(2) ** (-(n + 1) / 2) * mp.exp(-x * x / 4)
                    other = factor * half * mp.hyperu((n + 1) / 2, mp.mpf(1) / 2, x * x / 2)
                    agree(value, other, 1e-32, f"U: F_{n}({h})")
    with mp.workdps(30):
        for h in (-31.7, -9.3, -3, -1e-9, 0.4, 2, 6.1, 11, 24.5, 37):
            x = mp.mpf(h)
            span = mp.sqrt(max(0, -x) + 14)
            for n in map(mp.mpf, ORDERS):
                # The definition, with u = h + t^2 to tame the root.
                density = mp.quad(
                    lambda t, n=n, x=x: (
                        2 * t ** (2 * n + 1) * mp.exp(-((x + t * t) ** 2 - x * x) / 2)
                    ),
                    mp.linspace(0, span, 9),
                )
                value = density * mp.exp(-x * x / 2) / mp.sqrt(2 * mp.pi)
                agree(gaussian_moment(n, x), value, 1e-24, f"quadrature: F_{n}({h})")
        for h in (-5.2, -0.3):
            x = mp.mpf(h)
            for n in map(mp.mpf, ORDERS):
                value = mp.quad(
                    lambda u, n=n, x=x: (u - x) ** n * mp.exp(-u), [0, 0.2, 1, 3, 8, 20, 50, 90]
                )
                agree(exponential_moment(n, x), value, 1e-24, f"exponential F_{n}({h})")
        # Sum over heights of one asperity's force (19.15), each with its own slip limit (19.12).
        joint = Interface(cases()[2])
        law, d = joint.law, joint.separation
        for amplitude in (4e-8, 6e-7):
            x = mp.mpf(amplitude)

            def asperity(s: Any, x: Any = x) -> Any:
                contact, load = mp.sqrt(law.radius * s), law.hertz * s**THREE_HALVES
                limit = 3 * joint.mu * load / (16 * contact * joint.composite_shear_modulus)
                return joint.mu * load * (1 - (1 - min(x / limit, 1)) ** THREE_HALVES)

            def density(s: Any) -> Any:
                return law.summits / law.scale * mp.npdf(law.standardised(d + s))

            marks = [
                0,
                x / joint.kappa,
                *(x / joint.kappa + c * law.scale for c in (1, 2, 4, 7, 12)),
            ]
            total = mp.quad(lambda s: asperity(s) * density(s), marks)
            agree(joint.backbone(x), total, 1e-20, f"sum over asperities at {amplitude}")


def write(name: str, content: Any) -> None:
    path = Path(__file__).with_name(name)
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    mp.mp.dps = DIGITS
    self_check()
    write("gaussian_moments.json", make_moments())
    write(
        "interfaces.json",
        {
            "about": "Interfaces of the Extended Greenwood Model in SI units, nearest doubles. "
            "Made by make_reference.py.",
            "cases": [make_interface(case) for case in cases()],
        },
    )
