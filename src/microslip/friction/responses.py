"""What a backbone law shows of itself: to solvers, and to those who think in sliders."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, plain
from microslip._core.frozen import Locked
from microslip.errors import Argument, InputError


class PeriodicResponse(NamedTuple):
    """The settled cycle of a periodic displacement, as solvers need it: (19.20)-(19.24), closed.

    For any parameter p of the displacement c (a Fourier coefficient, say), with D = dT/dp and
    c' = dc/dp: D[root] = stiffness[root] c'[root], and in the cyclic order that begins at the root
    D[t] = D[parent[t]] + stiffness[t] (c'[t] - c'[parent[t]]).
    """

    force: Floats
    """Forces of the settled cycle [N]."""
    stiffness: Floats
    """Tangent stiffness at each sample [N/m]."""
    parent: NDArray[np.int64]
    """Index of the reversal that each sample hangs from; the root is its own parent."""
    root: int
    """Index of the sample of largest size, which lies on the first loading curve."""


@dataclass(frozen=True, eq=False)
class Sliders(Locked):
    """A backbone seen as a parallel Iwan model: elastic sliders by their yield displacement.

    After Iwan (1966), DOI 10.1115/1.3625199.
    T0(u) is the sum over sliders of stiffness times min(u, yield displacement).
    """

    yield_displacements: Floats
    """Yield displacements of the discrete sliders [m]."""
    stiffnesses: Floats
    """Stiffnesses of the discrete sliders [N/m]."""
    _density: Callable[[Floats], Floats] | None

    def density(self, yield_displacement: ArrayLike) -> Any:
        """Stiffness per yield displacement -T0'' [N/m^2] of the spread sliders, any shape.

        Raises
        ------
        InputError
            Yield displacements [m] that are negative, not finite, or none.
        """
        u = floats("yield_displacement", yield_displacement)
        if u.min() < 0.0:
            raise InputError(
                Argument("yield_displacement"), f" must not be negative, got {u.min():g} m"
            )
        if self._density is None:
            return plain(np.zeros(u.shape))
        return plain(self._density(u.reshape(-1)).reshape(u.shape))
