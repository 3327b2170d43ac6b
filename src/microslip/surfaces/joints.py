"""The joint of a scan that is solved point by point under the load that has tightened it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from microslip._core.errors import InputError
from microslip._core.units import engineering
from microslip.contact import MeasuredContact
from microslip.contact.materials import MaterialPair
from microslip.contact.measured_face import ContactNumbers
from microslip.friction import Interface
from microslip.surfaces.height_map import HeightMap

MOST_POINTS = 512 * 512
"""Points of a scan that is solved unasked, in seconds."""


@dataclass(frozen=True)
class PointByPoint:
    """A scan solved under a load, or why it was not."""

    joint: Interface | None
    pressure: float
    """Mean pressure of tightening [Pa]: that of the load, with four digits, rounded up."""
    piece: int | None
    """Points along a side of its pieces, about."""
    missing: str = ""
    """Reason why there is none."""

    @property
    def law(self) -> MeasuredContact | None:
        """The normal law."""
        surface = None if self.joint is None else self.joint.surface
        return surface if isinstance(surface, MeasuredContact) else None

    def words(self) -> str:
        """Return the result, or why there is none, in words."""
        if self.law is None:
            return f"Not solved point by point: {self.missing}."
        return (
            f"Solved point by point: {contact_words(self.law.numbers)}. Verdicts on summits and "
            "their radii do not apply to it."
        )


def point_by_point(
    scan: HeightMap,
    pair: MaterialPair,
    normal_load: float,
    *,
    area: float | None,
    friction_coefficient: float,
    direction: float | None,
    asked: bool,
    report: Callable[[float], None],
) -> PointByPoint:
    """Solve a scan under a load [N]; one of many points only where that is asked."""
    pressure = _rounded_up(normal_load / (area or math.prod(scan.size)))
    shortest = min(scan.heights.shape)
    piece = 256 if shortest >= 384 else 128 if shortest >= 192 else None
    why = ""
    if scan.missing > 0.0:
        why = "points are missing; fill them by `fill=True`"
    elif scan.heights.size > MOST_POINTS and not asked:
        why = f"{scan.heights.size} points take their time; ask for it by `point_by_point=True`"
    if why:
        return PointByPoint(None, pressure, piece, why)
    try:
        law = MeasuredContact(
            scan, pair, tightening_pressure=pressure, area=area, piece=piece, direction=direction,
            progress=lambda done, total: report(done / total),
        )  # fmt: skip
        joint = Interface(law, friction_coefficient, normal_load=normal_load)
    except InputError as error:
        return PointByPoint(None, pressure, piece, error.text)
    return PointByPoint(joint, pressure, piece)


def contact_words(numbers: ContactNumbers) -> str:
    """The solution of a face, in words."""
    n = numbers
    state = f"elastic up to {engineering(n.pressure, 'Pa')}"
    if n.hardness is not None:
        state = (
            f"tightened to {engineering(n.pressure, 'Pa')} at a hardness of "
            f"{engineering(n.hardness, 'Pa')}, {100.0 * n.hard_share:.0f} % of the contact at it"
        )
    scatter = ""
    if n.scatter is not None:
        scatter = f", whose stiffness scatters by {100.0 * n.scatter:.0f} %"
    low, high = n.stiffness_ratios
    changes = [
        f"{100.0 * (value - 1.0):+.0f} % {how}"
        for value, how in (
            (n.coarser, "by twice the pixel"),
            (n.smoother, f"without waves below {engineering(n.cutoff or 0.0, 'm')}"),
        )
        if value is not None
    ]
    resolution = f"; its stiffness changes by {' and '.join(changes)}" if changes else ""
    return (
        f"{state}; {n.points} points in contact, {100.0 * n.contact_share:.1f} % of the face; "
        f"p/E*h' {n.relative_pressure:.2g}, h' {n.slope:.2g}; {n.pieces} "
        f"piece{'s' if n.pieces > 1 else ''}{scatter}; normal over tangential stiffness "
        f"{low:.3f} to {high:.3f} by direction{resolution}"
    )


def _rounded_up(value: float) -> float:
    """Four digits, so that a study in which they are written bears the load."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 3)
    return math.ceil(value / scale) * scale
