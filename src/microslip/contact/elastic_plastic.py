"""One summit loaded beyond yield: its load, and its shape after unloading.

All in the units of first yield: indentations over s_c, loads over the Hertz load P_c there.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip.contact.materials import MaterialPair

# Fully plastic pressure over yield stress, where a hardness is given (Jackson and Green 2005).
HARDNESS_RATIO = 2.84


@dataclass(frozen=True)
class SummitModel(ABC):
    """Load of an elastic-plastic sphere against its indentation, monotone."""

    pair: MaterialPair
    """The two materials."""
    yield_stress: float
    """Uniaxial yield stress of the softer body [Pa]."""

    name: ClassVar[str]
    edges: ClassVar[tuple[float, ...]]
    """Indentations over s_c at which the formula changes."""

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio of the body that yields first: of the lower yield stress."""
        bodies = (self.pair.first, self.pair.second)
        return min(body.poisson_ratio for body in bodies if not body.is_rigid)

    @property
    @abstractmethod
    def yield_indentation(self) -> float:
        """Indentation s_c at first yield over the radius of the summit [-]."""

    @abstractmethod
    def load(self, r: Floats) -> Floats:
        """Load over P_c at indentations r > 1 over s_c."""

    def load_of(self, r: Floats) -> Floats:
        """Load over P_c at any indentation, Hertz's r^(3/2) up to first yield."""
        beyond = np.maximum(r, 1.0)
        return np.asarray(np.where(r > 1.0, self.load(beyond), np.maximum(r, 0.0) ** 1.5))


class JacksonGreen(SummitModel):
    """Jackson and Green (2005), DOI 10.1115/1.1866166: hardness falls as the contact grows."""

    name = "jackson-green"
    edges = (1.0, 1.9)

    @property
    def _constant(self) -> float:
        return 1.295 * math.exp(0.736 * self.poisson_ratio)

    @property
    def yield_indentation(self) -> float:
        """(pi C S_y / 2E*)^2."""
        share = self.yield_stress / self.pair.composite_modulus
        return (0.5 * math.pi * self._constant * share) ** 2

    def load(self, r: Floats) -> Floats:
        """Hertz up to 1.9 s_c, then their fit to finite elements."""
        share = self.yield_stress / self.pair.composite_modulus
        growth = 0.14 * math.exp(min(23.0 * share, 50.0))
        radius = (
            0.5 * math.pi * self._constant * share * np.sqrt(r)
            * np.maximum(r / 1.9, 1.0) ** (0.5 * growth)
        )  # fmt: skip
        hardness = 2.84 * -np.expm1(-0.82 * radius**-0.7)
        elastic = np.exp(-0.25 * r ** (5.0 / 12.0)) * r**1.5
        plastic = 4.0 * hardness / self._constant * -np.expm1(-0.04 * r ** (5.0 / 9.0)) * r
        return np.asarray(np.where(r > 1.9, elastic + plastic, r**1.5))


class KogutEtsion(SummitModel):
    """Kogut and Etsion (2002), DOI 10.1115/1.1490373: power laws up to 110 s_c, then plastic."""

    name = "kogut-etsion"
    edges: ClassVar[tuple[float, ...]] = (1.0, 6.0, 110.0)

    @property
    def _constant(self) -> float:
        return 0.454 + 0.41 * self.poisson_ratio

    @property
    def yield_indentation(self) -> float:
        """(pi K H / 2E*)^2."""
        hardness = HARDNESS_RATIO * self.yield_stress
        return (0.5 * math.pi * self._constant * hardness / self.pair.composite_modulus) ** 2

    def load(self, r: Floats) -> Floats:
        """Their two fits, and the hardness times the truncated area beyond."""
        return np.asarray(
            np.select(
                [r <= 6.0, r <= 110.0],
                [1.03 * r**1.425, 1.40 * r**1.263],
                3.0 / self._constant * r,
            )
        )


class FullyPlastic(KogutEtsion):
    """Abbott and Firestone's truncation: the hardness times 2 pi R s as soon as a summit yields."""

    name = "fully-plastic"
    edges = (1.0,)

    def load(self, r: Floats) -> Floats:
        """2 pi R s H."""
        return np.asarray(3.0 / self._constant * r)


MODELS: dict[str, type[SummitModel]] = {
    model.name: model for model in (JacksonGreen, KogutEtsion, FullyPlastic)
}


def model_of(name: str, pair: MaterialPair, yield_stress: float) -> SummitModel:
    """The model of a name."""
    if not isinstance(name, str) or name not in MODELS:
        names = ", ".join(f'"{key}"' for key in MODELS)
        raise InputError(f"`model` must be one of {names}, got {show(name)}")
    return MODELS[name](pair, yield_stress)


# -- relieved --------------------------------------------------------------------------------------


def recovery(r: Floats) -> Floats:
    """Indentation that is recovered elastically when relieved from r, over s_c.

    Etsion, Kligerman and Kadin (2005, Int. J. Solids Struct. 42, 3716): s_r/s_m =
    (1 - r^-0.28)(1 - r^-0.69), so r - s_r/s_c = r^0.72 + r^0.31 - r^0.03.
    """
    beyond = np.maximum(r, 1.0)
    return np.asarray(np.where(r > 1.0, beyond**0.72 + beyond**0.31 - beyond**0.03, r))


def recovery_slope(r: Floats) -> Floats:
    """Derivative of :func:`recovery`, one up to first yield."""
    beyond = np.maximum(r, 1.0)
    slope = 0.72 * beyond**-0.28 + 0.31 * beyond**-0.69 - 0.03 * beyond**-0.97
    return np.asarray(np.where(r > 1.0, slope, 1.0))


def indentation_of(recovered: Floats) -> Floats:
    """Inverse of :func:`recovery`, by Newton in logarithms, where it is nearly straight."""
    target = np.log(np.maximum(recovered, 1.0))
    starts, ends = _started()
    u = np.where(target < ends[-1], np.interp(target, ends, starts), target / 0.72)
    # From a table two steps are exact, from the slope of deep indentations six more.
    for _ in range(2 if not target.size or target.max() < ends[-1] else 8):
        r = np.exp(u)
        root, low, lowest = r**0.72, r**0.31, r**0.03
        t = np.maximum(root + low - lowest, 1.0)
        slope = 0.72 * root + 0.31 * low - 0.03 * lowest
        u = np.maximum(u - (np.log(t) - target) * t / slope, 0.0)
    return np.asarray(np.where(recovered > 1.0, np.exp(u), recovered))


@lru_cache(maxsize=1)
def _started() -> tuple[Floats, Floats]:
    """Logarithms of indentations and of what is recovered from them, to begin with."""
    starts = np.linspace(0.0, 30.0, 4001)
    return lock(starts), lock(np.log(recovery(np.exp(starts))))


def flattening(model: SummitModel, r: Floats) -> Floats:
    """Square root of the flattened radius over the radius: P over Hertz's load of the recovery."""
    beyond = np.maximum(r, 1.0)
    return np.asarray(
        np.where(r > 1.0, model.load(beyond) / recovery(beyond) ** 1.5, np.ones_like(beyond))
    )
