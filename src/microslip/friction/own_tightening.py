"""Nodes of a face that yields, each tightened by its own load."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.contact.base import NormalLaw
from microslip.contact.load_curve import LoadCurve


class OwnTightening(NamedTuple):
    """Laws of nodes that differ from the law of the surface by a factor on load and separation."""

    shares: Floats
    """Factors on the load [-], which are those on the tightening load."""
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
            The law of the surface.
        curve : LoadCurve
            Its load curve.
        loads : ndarray
            Loads at rest on the area of the surface [N]. Without a load a node keeps the law of
            the surface.

        Returns
        -------
        OwnTightening or None
            None where the surface does not yield, or all nodes are alike.
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
        """Tighten each node by its load at rest, where it is at a given separation.

        Parameters
        ----------
        surface, curve, loads
            As of :meth:`in_proportion`.
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
"""Least tightening of a node over that of the surface [-]."""
