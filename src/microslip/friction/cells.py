"""A law as a finite number of Iwan's cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from microslip._core.checks import Floats
from microslip.friction.iwan import Iwan

if TYPE_CHECKING:
    from microslip.friction.base import BackboneLaw

_FINER = 16  # panels a cell on which the law is looked at
_ASIDE = 1e-12  # on either side of a discrete slider, of its yield displacement
_LEAST = 8.0 * float(np.finfo(float).eps)  # shares of stiffness and force below it are rounding


def discretise(law: BackboneLaw, count: int) -> Iwan:
    """Cells whose backbone is the polygon of a law's tangents; at most ``count`` of them.

    Between two knots one cell stands for all sliders that yield there, with their stiffness, the
    fall of T0', and their force, the rise of T0 - u T0'. So force and slope are exact at every
    knot, and so are the stiffness at rest and the force limit. Between knots h apart the polygon
    is above the law by up to h^2 |T0''|/8.
    """
    sliders = law.sliders()
    places = sliders.yield_displacements
    if sliders._density is None and places.size <= count:
        return Iwan(sliders.stiffnesses, sliders.stiffnesses * places)
    if 2 * places.size < count:  # a cell for each discrete slider alone
        alone = np.concatenate((places * (1.0 - _ASIDE), places * (1.0 + _ASIDE)))
        knots = np.union1d(_knots(law, count - alone.size), alone)
    else:
        knots = _knots(law, count)
    stiffnesses = -np.diff(np.append(law._slope(knots), 0.0))
    limits = np.diff(np.append(0.25 * law._energy_slope(knots), law.force_limit))
    real = stiffnesses > _LEAST * law.tangential_stiffness
    real &= limits > _LEAST * law.force_limit
    return Iwan(stiffnesses[real], limits[real])


def _knots(law: BackboneLaw, count: int) -> Floats:
    """Knots from 0 on that part the integral of sqrt(-T0'') evenly, the last part endless.

    The polygon's error is then of one size everywhere, and of second order in 1/count also where
    the density of sliders is infinite or has no end. Neither it nor its integral is ever asked
    for: on a panel so narrow that it is constant the integral is sqrt(width * fall of T0'), and a
    discrete slider makes that as small as one likes.
    """
    # Off any round number, so that no edge of a panel falls on a corner of the law.
    edge = 1.0123456789 * law.force_limit / law.tangential_stiffness
    edges = [0.0, edge]
    total = np.sqrt(law.force_limit)  # sqrt(stiffness * reach)
    while edge < 1e200:
        slope = float(law._slope(np.array([edge]))[0])
        if np.sqrt(edge * slope) * 64.0 * count < total:
            break
        edge *= 2.0
        edges.append(edge)
    places = np.array(edges)
    slopes = law._slope(places)
    while True:
        widths, falls = np.diff(places), np.maximum(-np.diff(slopes), 0.0)
        masses = np.sqrt(widths * falls)
        coarse = np.flatnonzero(masses * _FINER * count > masses.sum())
        middles = places[coarse] + 0.5 * widths[coarse]
        new = (middles > places[coarse]) & (middles < places[coarse + 1])
        if not new.any():
            break
        coarse, middles = coarse[new], middles[new]
        places = np.insert(places, coarse + 1, middles)
        slopes = np.insert(slopes, coarse + 1, law._slope(middles))
    parts = np.append(0.0, np.cumsum(masses))
    return np.asarray(np.interp(parts[-1] / count * np.arange(count), parts, places))
