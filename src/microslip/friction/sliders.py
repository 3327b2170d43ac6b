"""Sliders of a backbone law, its equivalent parallel Iwan model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, plain
from microslip._core.errors import InputError
from microslip._core.frozen import Locked


@dataclass(frozen=True, eq=False)
class Sliders(Locked):
    """Parallel Iwan model of a backbone T0: sliders by yield displacement, discrete and continuous.

    T0(u) is the sum over all sliders of stiffness * min(u, yield displacement), see Iwan (1966),
    DOI 10.1115/1.3625199.
    """

    yield_displacements: Floats
    """Yield displacements of the discrete sliders [m]."""
    stiffnesses: Floats
    """Stiffnesses of the discrete sliders [N/m]."""
    _density: Callable[[Floats], Floats] | None

    def density(self, yield_displacement: ArrayLike) -> Any:
        """Density -T0'' [N/m^2] of continuous sliders at yield displacements [m] of any shape."""
        u = floats("yield_displacement", yield_displacement, "m")
        if u.min() < 0.0:
            raise InputError(f"`yield_displacement` must not be negative, got {u.min():g} m")
        if self._density is None:
            return plain(np.zeros(u.shape))
        # Beyond every slider, and small enough that laws do not overflow.
        return plain(self._density(np.minimum(u, 1e200).reshape(-1)).reshape(u.shape))
