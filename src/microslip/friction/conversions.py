"""Conversion of a law to another model: `to_iwan` and `to_segalman` of every law.

The models are laws themselves, so these conversions live above them. Importing this module hands
them to :class:`~microslip.friction.base.BackboneLaw`; the models load when they are asked for.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import exact, positive, whole_number
from microslip.errors import InputError
from microslip.friction.base import BackboneLaw, CellModel, SegalmanFit

MOST_CELLS = 10_000_000


def to_iwan(
    law: BackboneLaw,
    cells: Any,
    smallest_amplitude: float | None,
    largest_amplitude: float | None,
) -> CellModel:
    """See :meth:`BackboneLaw.to_iwan`."""
    from microslip.friction.cells import discretise, discretise_over

    count = whole_number("cells", cells, 1, MOST_CELLS)
    check_not_rigid(law, "Iwan's cells")
    if smallest_amplitude is None and largest_amplitude is None:
        return discretise(law, count)
    low, high = amplitude_range(law, smallest_amplitude, largest_amplitude)
    return discretise_over(law, count, low, high)


def to_segalman(
    law: BackboneLaw, smallest_amplitude: float | None, largest_amplitude: float | None
) -> SegalmanFit:
    """See :meth:`BackboneLaw.to_segalman`."""
    from microslip.friction.segalman import fit_segalman

    check_not_rigid(law, "the four parameters")
    low, high = amplitude_range(law, smallest_amplitude, largest_amplitude)
    return fit_segalman(law, np.geomspace(low, high, 61))


def check_not_rigid(law: BackboneLaw, model: str) -> None:
    """Springs beside each other have no place where a law is rigid at rest."""
    if math.isinf(law.tangential_stiffness):
        raise InputError(
            f"{model} need a finite stiffness at rest, "
            f"and {type(law).__name__} friction is rigid there"
        )


def amplitude_range(
    law: BackboneLaw, smallest: float | None, largest: float | None
) -> tuple[float, float]:
    """A range of amplitudes [m]; 0.01 to 10 times limit over stiffness where it was not given."""
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


BackboneLaw._conversions.update(iwan=to_iwan, segalman=to_segalman)
