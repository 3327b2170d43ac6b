"""Normal laws of the nodes of a face that yields, each tightened to its own pressure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.contact.base import NormalLaw
from microslip.contact.load_curve import LoadCurve


class OwnTightening(NamedTuple):
    """Factors by which the normal laws of nodes differ from that of their surface.

    Yielding during tightening changes the law of a node. At separation d the node then carries
    ``shares`` times the load curve of the surface at the step (d - ``origins``)/``lengths``.
    """

    shares: Floats
    """Tightening pressures of the nodes over that of the surface [-]; also factors on the load."""
    lengths: Floats
    """Factors on the separation [-]."""
    origins: Floats
    """Separations [m] at the origin of the load curve."""

    @classmethod
    def in_proportion(
        cls, surface: NormalLaw, curve: LoadCurve, loads: Floats
    ) -> OwnTightening | None:
        """Return the factors of nodes that were tightened in proportion to their loads.

        The node with the largest load was tightened to the tightening pressure of the surface.

        Parameters
        ----------
        surface : NormalLaw
            Law of the surface.
        curve : LoadCurve
            Load curve of the surface.
        loads : ndarray
            Loads at rest, each scaled from the area of its node to that of the surface [N], shape
            (nodes,). A node without load keeps the law of the surface.

        Returns
        -------
        OwnTightening or None
            None if the surface does not yield or all loaded nodes have equal loads.
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
        """Return the factors of nodes that were each tightened by exactly their load at rest.

        With them each node carries its load at its separation at rest [m], shape (nodes,). Other
        arguments are as for :meth:`in_proportion`. The tightening load is limited to the range of
        1e-6 to 1 times that of the surface. None if the surface does not yield.
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
