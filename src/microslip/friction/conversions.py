"""Conversion of any law to an Iwan model: `to_iwan`.

The model is a subclass of :class:`~microslip.friction.base.BackboneLaw`, so the module of the base
class cannot import it. Importing this module gives the conversion to the base class.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from microslip._core.checks import Floats, exact, positive, whole_number
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip.friction.base import BackboneLaw
from microslip.friction.iwan import Iwan, IwanFit

_PANELS_PER_CELL = 16  # panels per cell on which the law is evaluated
_KNOT_OFFSET = 1e-12  # relative distance of the knots on either side of a discrete slider
_SAMPLES = 24  # amplitudes between two yield displacements at which errors are evaluated
_MOST_SAMPLES = 20_000
_ERROR_MARGIN = 1.01  # bound of the error between samples over the largest sampled error
_NEGLECTED_PART = 0.4  # neglected part of the limit over the squared step of the ladder
_ROUNDING = 8.0 * float(np.finfo(float).eps)  # smaller fractions of stiffness or force are rounding


def discretise(law: BackboneLaw, count: int, span: tuple[float, float] | None = None) -> Iwan:
    """Return at most ``count`` Iwan cells whose backbone is a polygon of tangents to T0 of the law.

    The tangents touch T0 at knots. One cell replaces all sliders that yield between two knots: its
    stiffness is the decrease of T0' between them, its force limit the increase of T0 - u T0'. Force
    and slope are exact at every knot, as are the stiffness at rest and the force limit. Between
    knots at a distance h the polygon is above T0 by up to h^2 |T0''|/8. With ``span``, a range of
    amplitudes [m], the relative error is uniform over the range, see :func:`_range_knots`.
    """
    sliders = law.sliders()
    places = sliders.yield_displacements
    if sliders._density is None and places.size <= count:
        return Iwan(sliders.stiffnesses, sliders.stiffnesses * places)
    alone = np.zeros(0)
    if 2 * places.size < count:  # each discrete slider gets its own cell
        alone = np.concatenate((places * (1.0 - _KNOT_OFFSET), places * (1.0 + _KNOT_OFFSET)))
    if span is None:
        knots = np.union1d(_knots(law, count - alone.size), alone)
    else:
        rungs = max(count - 1 - alone.size, 1)
        knots = np.union1d(np.append(0.0, _range_knots(law, rungs, *span)), alone)
    slopes = np.append(law._slope(knots), 0.0)
    forces = np.append(0.25 * law._energy_slope(knots), law.force_limit)
    stiffnesses, limits = -np.diff(slopes), np.diff(forces)
    # Drop differences within the rounding error of their terms, or of the whole law.
    whole = law.tangential_stiffness, law.force_limit
    stiff, force = whole if span is None else (slopes[:-1], forces[1:])
    real = (stiffnesses > _ROUNDING * stiff) & (limits > _ROUNDING * force)
    return Iwan(stiffnesses[real], limits[real])


def _amplitudes(cells: Iwan, smallest: float, largest: float) -> Floats:
    """Return amplitudes [m] in a range, several between any two adjacent yield displacements."""
    yields = cells.sliders().yield_displacements
    corners = yields[(yields > smallest) & (yields < largest)]
    corners = np.concatenate(([smallest], corners, [largest]))
    steps = min(_SAMPLES, max(_MOST_SAMPLES // corners.size, 1))
    corners = corners[:: max(corners.size // _MOST_SAMPLES, 1)]
    shares = np.arange(steps) / steps
    between = corners[:-1, None] * (corners[1:] / corners[:-1])[:, None] ** shares
    return np.append(np.clip(between.ravel(), smallest, largest), largest)


def _errors(law: BackboneLaw, cells: Iwan, a: Floats) -> IwanFit:
    force, energy = law._backbone(a), law._energy(a)
    lost = energy > 0.0
    off = np.abs(cells._energy(a)[lost] / energy[lost] - 1.0)
    free = float(np.max(cells._energy(a)[~lost], initial=0.0))  # where the law is elastic
    most = float(np.max(off, initial=0.0))
    return IwanFit(
        backbone_error=_ERROR_MARGIN * float(np.max(np.abs(cells._backbone(a) / force - 1.0))),
        energy_error=math.inf if free > 0.0 else _ERROR_MARGIN * most,
        smallest_amplitude=float(a[0]),
        largest_amplitude=float(a[-1]),
    )


def _range_knots(law: BackboneLaw, count: int, smallest: float, largest: float) -> Floats:
    """Return ``count`` knots [m] up to ``largest``, or to nearly full slip if that is smaller.

    The knots are in geometric progression, except where the slider density is high, as at the slip
    limit of a sphere. A polygon above T0 by up to h^2 |T0''|/8 changes the energy E of a cycle of
    amplitude a by up to 4 a h^2 |T0''|/8. Where the density is high, h is therefore proportional to
    sqrt(E/(a |T0''|)), which makes the relative error of E uniform. The first knots are below
    ``smallest`` [m], since sliders that yield below it contribute too.
    """
    height = math.log(largest / smallest) / count
    low, top = smallest, largest
    for _ in range(60):  # later sliders carry less than the discretisation error
        middle = math.sqrt(low * top)
        yielded = 0.25 * float(law._energy_slope(np.array([middle]))[0])
        few = law.force_limit - yielded < _NEGLECTED_PART * height * height * law.force_limit
        low, top = (low, middle) if few else (middle, top)
    end = min(1.000001 * top, largest)

    def mass(low: Floats, high: Floats, drop: Floats) -> Floats:
        energy = law._energy(high)
        rate = np.divide(drop, energy, out=np.zeros_like(drop), where=energy > 0.0)
        crowded = np.sqrt((high - low) * high * rate / 1.5)
        return np.maximum(np.log(high / low), crowded)

    # The first cell, up to c times the smallest amplitude, changes its energy by c^3/2; the
    # ladder with logarithmic step h changes it by about h^2/6.
    below = min(0.5, (height * height / 3.0) ** (1.0 / 3.0))
    places, parts = _refined_panels(law, np.geomspace(below * smallest, end, 129), mass, count)
    return np.interp(np.linspace(0.0, parts[-1], count), parts, places)


def _knots(law: BackboneLaw, count: int) -> Floats:
    """Return ``count`` knots [m], the first at 0, that divide the integral of sqrt(-T0'') evenly.

    The error of the polygon of tangents is then uniform, and of second order in 1/count even if the
    slider density is infinite at a point or extends to infinity. The density -T0'' is not
    evaluated. The displacement is divided into panels, intervals so narrow that the density is
    nearly constant in each; the integral over a panel is then sqrt(width * decrease of T0'). At a
    discrete slider this product vanishes with the width.
    """
    # An irregular factor, so that no edge of a panel coincides with a corner of the law.
    edge = 1.0123456789 * law.force_limit / law.tangential_stiffness
    edges = [0.0, edge]
    total = np.sqrt(law.force_limit)  # sqrt(stiffness * reach)
    while edge < 1e200:
        slope = float(law._slope(np.array([edge]))[0])
        if np.sqrt(edge * slope) * 64.0 * count < total:
            break
        edge *= 2.0
        edges.append(edge)
    places, parts = _refined_panels(
        law, np.array(edges), lambda low, high, drop: np.sqrt((high - low) * drop), count
    )
    return np.asarray(np.interp(parts[-1] / count * np.arange(count), parts, places))


def _refined_panels(
    law: BackboneLaw, places: Floats, mass: Callable[[Floats, Floats, Floats], Floats], count: int
) -> tuple[Floats, Floats]:
    """Bisect panels of displacement until none has more than 1/(16 count) of the total mass.

    The mass is the integral that ``count`` knots are to divide evenly; ``mass`` computes it from
    lower ends, upper ends and decreases of T0' of panels. ``places`` are the first edges of the
    panels [m]. Return the final edges [m] and the cumulative mass at each of them.
    """
    slopes = law._slope(places)
    while True:
        low, high = places[:-1], places[1:]
        masses = mass(low, high, np.maximum(-np.diff(slopes), 0.0))
        coarse = np.flatnonzero(masses * _PANELS_PER_CELL * count > masses.sum())
        middles = low[coarse] + 0.5 * (high - low)[coarse]
        new = (middles > places[coarse]) & (middles < places[coarse + 1])
        if not new.any():
            return places, np.append(0.0, np.cumsum(masses))
        coarse, middles = coarse[new], middles[new]
        places = np.insert(places, coarse + 1, middles)
        slopes = np.insert(slopes, coarse + 1, law._slope(middles))


MOST_CELLS = 10_000_000


def to_iwan(
    law: BackboneLaw,
    cells: Any,
    smallest_amplitude: float | None,
    largest_amplitude: float | None,
) -> Iwan:
    """Convert a law to Iwan cells; see :meth:`BackboneLaw.to_iwan`."""
    count = whole_number("cells", cells, 1, MOST_CELLS)
    check_not_rigid(law, "Iwan's cells")
    if smallest_amplitude is None and largest_amplitude is None:
        return discretise(law, count)
    low, high = amplitude_range(law, smallest_amplitude, largest_amplitude)
    model = discretise(law, count, (low, high))
    assign(model, fit=_errors(law, model, _amplitudes(model, low, high)))
    return model


def check_not_rigid(law: BackboneLaw, model: str) -> None:
    """Raise InputError for a law that is rigid at rest, and has no equivalent ``model``."""
    if math.isinf(law.tangential_stiffness):
        raise InputError(
            f"{model} need a finite stiffness at rest, got {type(law).__name__} friction, "
            "which is rigid at rest"
        )


def amplitude_range(
    law: BackboneLaw, smallest: float | None, largest: float | None
) -> tuple[float, float]:
    """Return the amplitude range [m], by default 0.01 to 10 times force limit over stiffness."""
    reach = law.force_limit / law.tangential_stiffness
    low = 0.01 * reach if smallest is None else smallest
    high = 10.0 * reach if largest is None else largest
    low = positive("smallest_amplitude", low, "m", 1e-8)
    high = positive("largest_amplitude", high, "m", 1e-5)
    if high <= low:
        raise InputError(
            f"`largest_amplitude` must be above the smallest, {exact(low)} m, got {exact(high)} m"
        )
    return low, high


BackboneLaw._to_iwan = to_iwan
