"""Inverse design: values of keys at which a joint meets a target, with a probability."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import (
    AREA,
    DENSITY,
    FORCE,
    FREQUENCY,
    LENGTH,
    STIFFNESS,
    Kind,
    ends_of,
    engineering,
    to_si,
)
from microslip.errors import InputError, StudyError
from microslip.kernels import Integers
from microslip.report.document import Progress
from microslip.study.build import (
    Design,
    at_middle,
    build_summits,
    is_uncertain,
)
from microslip.study.description import StudyDescription
from microslip.study.joints import Joint
from microslip.study.surfaces import Elastic
from microslip.sweeps import evaluate
from microslip.sweeps.derivatives import QUANTITIES, log_derivatives

MOST_KEYS = 8
_LEVELS = 11  # of the trade-off
_TARGET = re.compile(
    r"^\s*(?:mode\s+(\d{1,3})\s+)?(\w+)\s*(>=|<=)\s*([^@]+?)\s*(?:at|@)\s*(.+?)\s*$"
)
OF_MODES = ("frequency", "damping_ratio")
UNITS = {"dissipated_energy": "J", "secant_stiffness": "N/m", "frequency": "Hz"}
_KINDS = {"secant_stiffness": STIFFNESS, "frequency": FREQUENCY}
_JOULES = {"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "µJ": 1e-6, "nJ": 1e-9}
_WRITTEN = '"damping_ratio >= 0.005 at 10 um"'
KEYS: dict[str, tuple[str, Kind | None]] = {
    "joint.normal_load": ("normal_load", FORCE),
    "joint.friction_coefficient": ("friction_coefficient", None),
    "surface.heights.std": ("std", LENGTH),
    "surface.heights.scale": ("std", LENGTH),
    "surface.radius": ("radius", LENGTH),
    "surface.density": ("density", DENSITY),
    "surface.area": ("area", AREA),
}
"""Keys that are searched by exact derivatives: argument of evaluate, and kind of quantity."""


class Target(NamedTuple):
    """A quantity that is to be at least, or at most, some value at an amplitude [m]."""

    quantity: str
    at_least: bool
    value: float
    amplitude: float
    mode: int = 0
    """The mode of a structure that it is a quantity of, from 1; 0 if of the joint."""

    @classmethod
    def read(cls, text: str) -> Target:
        """From text such as "damping_ratio >= 0.005 at 10 um", or with "mode 1 " before it."""
        match = _TARGET.match(text)
        if match is None:
            raise InputError(f"`target` must read like {_WRITTEN}, got {text!r}")
        mode, name, sign, value, amplitude = match.groups()
        if mode is not None and int(mode) < 1:
            raise InputError("`target`: modes are counted from 1, got mode 0")
        names = QUANTITIES if mode is None else OF_MODES
        if name not in names:
            known = ", ".join(names) + ("" if mode is None else " of a mode")
            hint = " (of a mode: mode 1 frequency)" if name == "frequency" else ""
            raise InputError(f"`target` must be among {known}, got {name!r}{hint}")
        try:
            size = to_si(amplitude, LENGTH, "10 um")
            number = _value(name, value)
        except ValueError as error:
            raise InputError(f"`target`: {error}") from None
        return cls(name, sign == ">=", number, size, int(mode or 0))

    @property
    def written(self) -> str:
        """The target as text with units."""
        sign, unit = ">=" if self.at_least else "<=", UNITS.get(self.quantity)
        value = engineering(self.value, unit, 6, trim=True) if unit else f"{self.value:g}"
        mode = f"mode {self.mode} " if self.mode else ""
        amplitude = engineering(self.amplitude, "m", 6, trim=True)
        return f"{mode}{self.quantity} {sign} {value} at {amplitude}"


def _value(name: str, text: str) -> float:
    """A value above zero: plain or in percent, of what has a unit in SI units or with its own."""
    match = re.fullmatch(r"([-+.\deE]+)\s*(\S.*)?", text)
    try:
        number, unit = float(match[1]), match[2]  # type: ignore[index]
    except (TypeError, ValueError):
        raise ValueError(f"wanted a value above zero, got {text!r}") from None
    if unit and name in _KINDS:
        number = to_si(text, _KINDS[name], _KINDS[name].usual[0])
    elif unit:
        factors = (
            _JOULES if name == "dissipated_energy" else {"%": 0.01} if name not in _KINDS else {}
        )
        if unit not in factors:
            known = ", ".join(factors)
            raise ValueError(f"wanted {name} as a number or in {known}, got {text!r}")
        number *= factors[unit]
    if not (math.isfinite(number) and number > 0.0):
        raise ValueError(f"wanted a value above zero, got {text!r}")
    return number


class Range(NamedTuple):
    """A key of the study and between which values [SI] it is searched."""

    key: str
    low: float
    high: float

    @classmethod
    def read(cls, text: str) -> Range:
        """From text such as "joint.normal_load=500 N..5 kN"."""
        key, low, high = parts_of(text)
        if key not in KEYS:
            raise InputError(f"`vary` must be among {', '.join(KEYS)}, got {key!r}")
        kind = KEYS[key][1]
        try:
            values = [
                float(end) if kind is None else to_si(end, kind, kind.usual[0])
                for end in (low, high)
            ]
        except ValueError as error:
            raise InputError(f"`vary`: {key}: {error}") from None
        if not 0.0 < values[0] < values[1]:
            raise range_error(key, text)
        return cls(key, *values)


def parts_of(text: str) -> tuple[str, str, str]:
    """Key and ends of a range such as "joint.normal_load=500 N..5 kN"."""
    key, _, range_text = text.partition("=")
    ends = ends_of(range_text)
    if ends is None:
        raise InputError(f'`vary` must read like "joint.normal_load=500 N..5 kN", got {text!r}')
    return key.strip(), *ends


def range_error(key: str, text: str) -> InputError:
    """Error message of ends that are no range."""
    ends = text.partition("=")[2]
    return InputError(f"`vary`: {key}: wanted low..high above zero, got {ends!r}")


@dataclass(frozen=True)
class DesignPoint:
    """One design."""

    values: Mapping[str, float]
    """The keys that were searched, in SI units."""
    level: float
    """The target."""
    reached: float
    """The quantity at the wanted probability."""
    probability: float
    """Share of the samples that meet the target."""
    feasible: bool
    """Whether it is met within the ranges."""
    change: float
    """Distance from the study: root of the sum of squared logarithms."""
    samples: int = 1
    """Samples that the probability is a share of."""


class Search:
    """The smallest change of a study that meets a target with a probability."""

    is_costly = False
    """Whether one beginning is enough once it has led to an answer."""

    def __init__(
        self, study: StudyDescription, target: Target, ranges: Sequence[Range], probability: float
    ) -> None:
        if not 1 <= len(ranges) <= MOST_KEYS or len({r.key for r in ranges}) < len(ranges):
            raise InputError(f"`vary` must name one to {MOST_KEYS} different keys")
        if not 0.0 < probability < 1.0:
            raise InputError(f"`probability` must be above 0 and below 1, got {probability:g}")
        self.study, self.target, self.ranges = study, target, tuple(ranges)
        self.is_certain = not is_uncertain(study)
        self.probability = 0.5 if self.is_certain else probability
        self.names, self.middle = self._start()
        self.bounds = [(math.log(r.low), math.log(r.high)) for r in ranges]
        self.start = np.log([float(self.middle[name]) for name in self.names])

    def _start(self) -> tuple[list[str], dict[str, Any]]:
        """Names of the ranges, and the values that the study has of them and of others."""
        middle = _arguments(at_middle(self.study))
        names = [KEYS[r.key][0] for r in self.ranges]
        for r, name in zip(self.ranges, names, strict=True):
            if name not in middle:
                raise StudyError(
                    f"{self.study.name}: {r.key}: wanted a key of the study, got none there"
                )
        self.middle = middle
        self.factors = self._factors()
        return names, middle

    def _factors(self) -> dict[str, Floats]:
        """Factors of the samples on the arguments of the middle."""
        if not is_uncertain(self.study):
            return {}
        design = Design(self.study)
        points = design.points().reshape(-1, len(design.inputs))
        samples = [_arguments(design.at(row)) for row in design.scores(points)]
        numbers = [name for name, value in self.middle.items() if isinstance(value, float)]
        return {
            name: np.array([sample[name] for sample in samples]) / self.middle[name]
            for name in numbers
        }

    def _keywords(self, logs: Floats) -> dict[str, Any]:
        arguments = dict(self.middle)
        arguments |= dict(zip(self.names, np.exp(logs).tolist(), strict=True))
        for name, factor in self.factors.items():
            arguments[name] = arguments[name] * factor
        return {**arguments, "amplitude": self.target.amplitude}

    def values(self, logs: Floats) -> Floats:
        """Ln of the quantity over the samples."""
        quantities = evaluate(**self._keywords(logs), quantities=[self.target.quantity])
        return np.atleast_1d(np.log(quantities[self.target.quantity]))

    def quantile(self, logs: Floats) -> tuple[float, Floats]:
        """Ln of what the wanted share of the samples reaches, and its exact derivatives.

        It is one sample, the last that must meet the target so that no fewer than wanted do, and
        its derivatives are that sample's; those of the few next to it are averaged, since which
        one it is changes on the way.
        """
        samples = self.values(logs)
        order = np.argsort(samples, kind="stable")
        place = math.floor((1.0 - self.probability) * samples.size + 1e-9)
        if not self.target.at_least:
            place = samples.size - 1 - place
        reach = max(1, samples.size // 64)
        near = order[max(0, place - reach) : place + reach + 1]
        return float(samples[order[place]]), self._slopes(logs, near)

    def _slopes(self, logs: Floats, near: Integers) -> Floats:
        """Mean slopes of some samples along the ranges."""
        arguments = {
            name: (v[near] if isinstance(v, np.ndarray) else v)
            for name, v in self._keywords(logs).items()
        }
        slopes = log_derivatives(self.target.quantity, arguments, self.names)
        return np.array([float(np.mean(slopes[name])) for name in self.names])

    def solve(self, level: float | None = None, progress: Progress | None = None) -> DesignPoint:
        """The design that changes the study least; begins from the study and from its ends."""
        log_level, sign = self._ln_level(level)
        start = np.clip(self.start, *np.transpose(self.bounds))
        constraint = {
            "type": "ineq",
            "fun": lambda x: sign * (self.quantile(x)[0] - log_level),
            "jac": lambda x: sign * self.quantile(x)[1],
        }
        best = None
        # From the study, and from its ends: the quantity need not be monotone in between.
        ends = [np.array([bound[k] for bound in self.bounds]) for k in (0, 1)]
        begins = (start, *(0.5 * (start + end) for end in ends))
        for number, begin in enumerate(begins, start=1):
            minimum = self._least_change(begin, constraint, {"maxiter": 100, "ftol": 1e-10})
            x = self._onto(np.clip(minimum.x, *np.transpose(self.bounds)), sign, log_level)
            miss = sign * (self.quantile(x)[0] - log_level)
            key = (miss < -1e-5, max(-miss, 0.0) if miss < -1e-5 else float(minimum.fun))
            if best is None or key < best[0]:
                best = key, x
            if progress is not None:
                progress(1.0 if self.is_costly and not best[0][0] else number / 3.0)
            if self.is_costly and not best[0][0]:
                break
        assert best is not None
        return self.at(best[1], math.exp(log_level))

    def _ln_level(self, level: float | None) -> tuple[float, float]:
        """Ln of the level, the target's own unless given, and the sign of what lies beyond it."""
        value = self.target.value if level is None else level
        return math.log(value), 1.0 if self.target.at_least else -1.0

    def _least_change(
        self, begin: Floats, constraint: dict[str, Any], options: dict[str, Any] | None = None
    ) -> Any:
        """The smallest change of the study that keeps to a constraint and the ranges."""
        from scipy.optimize import minimize

        return minimize(
            lambda x: float(((x - self.start) ** 2).sum()), begin,
            jac=lambda x: 2.0 * (x - self.start), bounds=self.bounds,
            constraints=[constraint], method="SLSQP", options=options,
        )  # fmt: skip

    def _onto(self, x: Floats, sign: float, log_level: float) -> Floats:
        """The place where the way from the study through x meets the target, if it does.

        A quantile of samples has corners, at which the search stops a little short or beyond.
        """
        from scipy.optimize import brentq

        def place(share: float) -> Floats:
            far = self.start + share * (x - self.start)
            return np.asarray(np.clip(far, *np.transpose(self.bounds)))

        def miss(share: float) -> float:
            return sign * (self.quantile(place(share))[0] - log_level)

        shares = (0.5, 0.8, 0.95, 1.0, 1.05, 1.2, 2.0)
        for low, high in pairwise(shares):
            if miss(low) < 0.0 <= miss(high):
                return place(float(brentq(miss, low, high, xtol=1e-9)) + 1e-8)
        return x

    def at(self, x: Floats, level: float) -> DesignPoint:
        """Result of a design."""
        samples, (reached, _) = self.values(x), self.quantile(x)
        sign = 1.0 if self.target.at_least else -1.0
        share = float(np.mean(sign * (samples - math.log(level)) >= -1e-9))
        values = {r.key: float(math.exp(v)) for r, v in zip(self.ranges, x, strict=True)}
        feasible = sign * (reached - math.log(level)) >= -1e-4
        change = float(np.sqrt(((x - self.start) ** 2).sum()))
        return DesignPoint(
            values, level, math.exp(reached), share, bool(feasible), change, samples.size
        )

    def trade_off(self, progress: Progress | None = None) -> list[DesignPoint]:
        """The designs for levels about what is asked for."""
        designs = []
        for level in self.target.value * np.geomspace(1.0 / 3.0, 3.0, _LEVELS):
            designs.append(self.solve(float(level)))
            if progress is not None:
                progress(len(designs) / _LEVELS)
        return designs


def is_pointwise(study: StudyDescription) -> bool:
    """Whether :func:`microslip.evaluate` has its joint: summits of a density, one even load."""
    joint = study.joint
    return (
        isinstance(joint, Joint)
        and study.surface.law == "greenwood-williamson"
        and len(joint.normal_load) == 1
        and joint.tightening_load is None
        and joint.pressure is None
    )


def _arguments(study: StudyDescription) -> dict[str, Any]:
    """A study without anything uncertain as arguments of evaluate; plain numbers and heights."""
    joint = study.joint
    law: Any = study._law or build_summits(study)
    bodies = [study.material[name] for name in study.surface.materials]
    arguments: dict[str, Any] = {}
    for prefix, body in zip(("", "other_"), bodies, strict=True):
        modulus, ratio = math.inf, 0.3
        if isinstance(body, Elastic):
            modulus, ratio = float(body.young_modulus), float(body.poisson_ratio)
        arguments[f"{prefix}young_modulus"], arguments[f"{prefix}poisson_ratio"] = modulus, ratio
    if math.isinf(arguments["young_modulus"]):  # the first one is the one that deforms
        for name in ("young_modulus", "poisson_ratio"):
            arguments[name], arguments[f"other_{name}"] = (
                arguments[f"other_{name}"],
                arguments[name],
            )
    heights = law.heights
    if type(heights).__name__ != "Gaussian":
        arguments["heights"] = heights
    elif heights.mean:
        arguments["mean"] = float(heights.mean)
    return {
        **arguments,
        "std": float(heights.spread),
        "radius": float(law.radius),
        "density": float(law.density),
        "area": float(law.area),
        "friction_coefficient": float(joint.friction_coefficient),
        "normal_load": float(joint.normal_load[0]),
    }
