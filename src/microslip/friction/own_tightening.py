"""Face that yields, with each node tightened by its own load."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.contact.base import NormalLaw
from microslip.contact.load_curve import LoadCurve


class OwnTightening(NamedTuple):
    """Factors on load and separation by which laws of nodes differ from that of the surface."""

    shares: Floats
    """Factors on the load [-], equal to those on the tightening load."""
    lengths: Floats
    """Factors on the separation [-]."""
    origins: Floats
    """Separations [m] at the origin of the load curve."""

    @classmethod
    def in_proportion(
        cls, surface: NormalLaw, curve: LoadCurve, loads: Floats
    ) -> OwnTightening | None:
        """Tighten the most loaded node like the surface, and others in proportion to their load.

        Parameters
        ----------
        surface : NormalLaw
            Law of the surface.
        curve : LoadCurve
            Load curve of the surface.
        loads : ndarray
            Loads at rest scaled to the area of the surface [N]. A node without load keeps the law
            of the surface.

        Returns
        -------
        OwnTightening or None
            None if the surface does not yield or all loads are equal.
        """
        loaded = loads > 0.0
        largest = float(loads.max())
        if (loads[loaded] == largest).all():
            return None
        shares = np.where(loaded, loads / largest, 1.0)
        found = surface._tightened_by(shares)
        if found is None:
            return None
        lengths, offsets = found
        return cls(shares, lengths, offsets + lengths * curve.origin)

    @classmethod
    def at_rest(
        cls, surface: NormalLaw, curve: LoadCurve, separations: Floats, loads: Floats
    ) -> OwnTightening | None:
        """Tighten each node by its load at rest, at given separations.

        Parameters
        ----------
        surface, curve, loads
            As for :meth:`in_proportion`.
        separations : ndarray
            Separations at rest [m].
        """
        loaded = loads > 0.0
        shares = np.where(loaded, np.clip(loads / surface._heaviest, LIGHTEST, 1.0), 1.0)
        found = surface._tightened_by(shares)
        if found is None:
            return None
        lengths, origins = found[0], np.full(loads.size, curve.origin)
        if loaded.any():
            steps = curve.steps_of((loads / shares)[loaded], numbered=False)
            origins[loaded] = separations[loaded] - lengths[loaded] * steps
        return cls(shares, lengths, origins)


LIGHTEST = 1e-6
"""Smallest tightening of a node over that of the surface [-]."""
