"""Joint by each law of the summit heights, and the law that the tail supports."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip._core.verdicts import Verdict
from microslip.friction import Interface
from microslip.friction.validity import TAIL_RULE
from microslip.normal import GreenwoodWilliamson
from microslip.numerics.quadrature import gauss_legendre
from microslip.scans.scan_rules import judged

Heights = Literal["gaussian", "table", "discrete", "population"]
"""Laws of the heights of summits that were counted."""

TAIL = TAIL_RULE.name

_PANELS = 32


@dataclass(frozen=True, eq=False)
class MeasuredSurface(GreenwoodWilliamson):
    """A surface of fitted summit heights, with the height above which none was measured."""

    highest: float = np.inf
    """Height [m] of the highest summit that was measured; it enters no load, only the verdict."""

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        share = 0.0 if separation is None else self.load_share_above(self.highest, separation)
        return {**super()._assumptions(separation), TAIL: share}

    def load_share_above(self, height: float, separation: float) -> float:
        """Share [-] of the load at a separation [m] that summits above a height [m] carry.

        The partial moment of order 3/2 about the separation, from the height upwards: by parts,
        (t - d)^(3/2) F_0(t) + 3/2 times the integral of (y - d)^(1/2) F_0(y) above t, where F_0
        is the share of summits that are higher.
        """
        heights, start = self._heights, max(height, separation)
        end = min(heights.top, start + 40.0 * heights.spread)
        if not end > start:
            return 0.0
        nodes, weights = gauss_legendre(16)
        # Panels that grow from the start: F_0 falls fast, and above d the root is steep.
        edges = start + (end - start) * np.linspace(0.0, 1.0, _PANELS + 1) ** 3
        width = np.diff(edges)
        y = edges[:-1, None] + width[:, None] * nodes
        above = heights._moment(0, y.ravel()).reshape(y.shape)
        integral = float(((np.sqrt(y - separation) * above) @ weights) @ width)
        first = (start - separation) ** 1.5 * heights._moment_at(0, start)
        share: float = (first + 1.5 * integral) / heights._moment_at(3, separation)
        return min(share, 1.0)


TOLERANCE = 0.1
"""Difference of two stiffnesses (of their logarithms) that is as good as none."""

FEW_SUMMITS = 10
"""Measured summits that carry a load, below which none of the laws has a foundation."""


@dataclass(frozen=True)
class LawAtLoad:
    """A joint at rest by one law of the summit heights."""

    separation: float
    """Separation of the plane from the mean plane of the scan [m]."""
    contacts: float | None
    """Summits in contact [-]; None of a scan solved point by point."""
    real_area: float
    """Real over apparent area [-]."""
    tangential_stiffness: float
    """At rest [N/m]."""
    loss_factor: float | None
    """At the amplitude, if one was given [-]."""
    above: float = 0.0
    """Share of the load above the highest measured summit [-]."""

    @classmethod
    def of(cls, joint: Interface, amplitude: float | None, area: float, above: float = 0.0) -> Self:
        """Numbers of a joint on an apparent area [m^2]; summits are counted where there are any."""
        surface: Any = joint.surface
        summits = hasattr(surface, "summit_count")
        return cls(
            joint.separation,
            float(surface.contact_count(joint.separation)) if summits else None,
            float(surface.contact_area(joint.separation)) / area,
            joint.tangential_stiffness,
            None if amplitude is None else float(joint.loss_factor(amplitude)),
            above,
        )


@dataclass(frozen=True)
class HeightLaws:
    """The same summits and load by every law of their heights."""

    normal_load: float
    """Load of the joint [N]."""
    area: float
    """Its apparent area [m^2]."""
    laws: Mapping[str, LawAtLoad]
    """By "gaussian", "table", "discrete" and "population"; Gaussian is left out where all heights
    are one."""
    measured_contacts: int
    """Summits of the scan that carry load as a population."""
    scatter: float
    """Standard deviation [-] of the logarithm of the population's stiffness at this load, as of
    summits that are independent; those on the same long wave are not, so it is a lower bound."""
    recommended: Heights
    """The law that the loaded tail bears."""
    reason: str
    """Reason, in a sentence."""

    def verdicts(self) -> tuple[Verdict, ...]:
        """On the tail of the Gaussian, how far it misses the stiffness, and the summits in it."""
        values: dict[str, float | None] = {}
        gaussian = self.laws.get("gaussian")
        if gaussian is not None:
            values[TAIL] = gaussian.above
            ratio = gaussian.tangential_stiffness / self.laws["population"].tangential_stiffness
            values["stiffness by Gaussian heights against counted, as a factor"] = math.exp(
                abs(math.log(ratio))
            )
        values["measured summits in contact"] = float(self.measured_contacts)
        return judged(values)


def height_laws(
    surfaces: Mapping[Heights, Any],
    heights: Floats,
    radii: Floats,
    normal_load: float,
    friction_coefficient: float,
    amplitude: float | None,
) -> HeightLaws:
    """Compare the surfaces of some summits, their heights and radii [m], by each law at a load."""
    highest = float(heights.max())
    laws: dict[str, LawAtLoad] = {}
    for name, surface in surfaces.items():
        joint = Interface(surface, friction_coefficient, normal_load=normal_load)
        above = 0.0
        if isinstance(surface, MeasuredSurface):
            above = surface.load_share_above(highest, joint.separation)
        laws[name] = LawAtLoad.of(joint, amplitude, float(surface.area), above)
    separation = laws["population"].separation
    touching = int(np.count_nonzero(heights > separation))
    scatter = _scatter(heights - separation, radii)
    choice: Heights = "population"
    gauss = laws.get("gaussian")
    miss = math.inf
    if gauss is not None:
        miss = math.log(gauss.tangential_stiffness / laws["population"].tangential_stiffness)
    if gauss is None:
        reason = "all heights are one"
    elif abs(miss) <= min(max(TOLERANCE, 2.0 * scatter), 3.0 * TOLERANCE) and gauss.above <= 0.05:
        choice = "gaussian"
        reason = (
            f"Gaussian heights give {_percent(miss)} of the stiffness of the summits themselves, "
            f"within the scatter of {touching} measured contacts, and {100.0 * gauss.above:.2g} % "
            "of the load is above the highest measured summit"
        )
    else:
        reason = (
            f"Gaussian heights give {_percent(miss)} of the stiffness of the summits themselves, "
            f"and put {100.0 * gauss.above:.2g} % of the load above the highest that was measured, "
            f"{engineering(highest, 'm')} above the mean"
        )
    if touching < FEW_SUMMITS:
        carry = "summit carries" if touching == 1 else "summits carry"
        reason += (
            f"; but only {touching} measured {carry} the load: scan a larger area before you trust "
            "either"
        )
    return HeightLaws(
        float(normal_load),
        float(surfaces["population"].area),
        MappingProxyType(laws),
        touching,
        scatter,
        choice,
        reason,
    )


def _percent(miss: float) -> str:
    return f"{100.0 * math.exp(miss):.3g} %"


def _scatter(depth: Floats, radii: Floats) -> float:
    """Standard deviation of ln k of the counted summits at a load, each drawn with Poisson's law.

    More of one summit adds its stiffness at once, and less of all others, as the plane rises by
    dd = N_i/k: d ln k = k_i/k + (k'/k^2) N_i.
    """
    inside = depth > 0.0
    root, depth = np.sqrt(radii[inside]), depth[inside]
    stiff = 1.5 * root * np.sqrt(depth)
    total = float(stiff.sum())
    if not total > 0.0:
        return math.inf
    # Of k' the summits that only just touch have no finite share: their own term is left out.
    change = -0.75 * float((root / np.sqrt(np.maximum(depth, 1e-3 * depth.max()))).sum())
    effect = stiff / total + change / total**2 * root * depth**1.5
    return float(np.sqrt(np.sum(effect**2)))
