"""First loading along a straight path of separation and displacement, in closed form."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, beyond, floats, plain, positive, show
from microslip.errors import InputError
from microslip.normal import NormalLaw
from microslip.normal.grids import sum_over_pairs


class FirstLoading(NamedTuple):
    """What contacts carry after one straight step from rest, with its tangents.

    After Jaeger (1998), DOI 10.1115/1.2833765; see :func:`first_loading`.
    """

    force: Any
    """Tangential forces T [N], shape of the arguments together."""
    load: Any
    """Normal loads N [N], the same shape."""
    tangent: Floats
    """d(T, N)/d(displacement, separation) [N/m], two axes of length 2 after that shape."""

    @property
    def normal_load(self) -> Any:
        """The same as ``load``, as it was called before trials and fields had that name."""
        return self.load


def first_loading(
    surface: NormalLaw,
    friction_coefficient: float,
    displacement: ArrayLike,
    *,
    separation: ArrayLike,
    start: ArrayLike,
) -> FirstLoading:
    """Forces after one straight step from (start, 0) to (separation, displacement), from rest.

    What a static or quasi-static solver asks at all of its contacts at once.

    Parameters
    ----------
    surface : NormalLaw
        The surface that all contacts share.
    friction_coefficient : float
        Coulomb's coefficient mu [-], above zero.
    displacement : array_like
        Displacements delta at the end [m], any shape. For a motion in two tangential directions
        the size of the displacement: on a straight path the force points along it.
    separation : array_like
        Separations d at the end [m], any shape that goes with the others.
    start : array_like
        Separations d0 before the step [m], where displacement and force were zero. There need not
        be a contact.

    Returns
    -------
    FirstLoading
        ``force`` and ``load`` [N], and ``tangent`` [N/m], see there.

    Notes
    -----
    Where slip has begun, T = mu [N(d) - N(d + abs(delta)/kappa)] with kappa = mu E*/4G*. Where the
    surfaces have come nearer by w = d0 - d >= abs(delta)/kappa, new contact sticks as it forms,
    and T = mu delta/(kappa w) [N(d) - N(d0)] (Jaeger 1998, DOI 10.1115/1.2833765). Between the two
    the tangent jumps; where both hold it is that of sticking.
    """
    if not isinstance(surface, NormalLaw):
        raise InputError(f"surface must be a normal load law, got {show(surface)}")
    mu = positive("friction_coefficient", friction_coefficient)
    return loaded(surface, mu, mu * surface.stiffness_ratio, displacement, separation, start)


def loaded(
    law: NormalLaw,
    friction: float,
    slip: float,
    displacement: ArrayLike,
    separation: ArrayLike,
    start: ArrayLike,
) -> FirstLoading:
    """The same with the displacement ``slip`` per place beside the coefficient."""
    x = floats("displacement", displacement)
    # By their own names, should they be refused.
    end = law._separations(floats("separation", separation))
    before = law._separations(floats("start", start))
    try:
        x, end, before = np.broadcast_arrays(x, end, before)
    except ValueError:
        raise InputError(
            "displacement, separation and start must have shapes that go together, got "
            f"{x.shape}, {end.shape} and {before.shape}"
        ) from None
    force, load, tangent = _loaded(law, friction, slip, *(v.ravel() for v in (x, end, before)))
    return FirstLoading(
        plain(force.reshape(x.shape)),
        plain(load.reshape(x.shape)),
        tangent.reshape(*x.shape, 2, 2),
    )


def _loaded(
    law: NormalLaw, friction: float, slip: float, x: Floats, d: Floats, d0: Floats
) -> tuple[Floats, Floats, Floats]:
    place = beyond(np.abs(x), slip)
    fall = d0 - d
    sticks = place <= fall
    width = np.where(sticks, fall, place)  # over which D is not 0
    drop, load = sum_over_pairs(law, "drop", d, width), law._derivative(d, 0)
    here, there = -law._derivative(d, 1), sum_over_pairs(law, "fall", d, width)
    share = np.divide(place, fall, out=np.ones_like(place), where=sticks & (fall > 0.0))
    mean = np.divide(drop, width, out=here.copy(), where=width > 0.0)
    tangent = np.empty((x.size, 2, 2))
    tangent[:, 0, 0] = friction / slip * np.where(sticks, mean, there)
    # The integral of (w - v) N''(d + v) over 0 <= v <= w, or of N'' where slip has begun.
    bend = here - there
    if sticks.any():
        late = 2.0 * sum_over_pairs(law, "excess_slope", d[sticks], width[sticks])
        bend[sticks] -= np.divide(
            late, width[sticks], out=np.zeros_like(late), where=width[sticks] > 0.0
        )
    tangent[:, 0, 1] = -friction * np.copysign(share, x) * bend
    tangent[:, 1, 0] = 0.0
    tangent[:, 1, 1] = -here
    return friction * np.copysign(share, x) * drop, load, tangent
