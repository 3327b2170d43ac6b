"""First loading along a straight path of separation and displacement, in closed form."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, beyond, floats, plain, positive
from microslip._core.errors import InputError
from microslip.contact import NormalLaw
from microslip.contact.load_curve import LoadCurve, check_surface


class FirstLoading(NamedTuple):
    """Forces after one straight step from rest, with their tangents.

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

    Evaluation by a static or quasi-static solver, at all of its contacts at once.

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
    check_surface(surface)
    mu = positive("friction_coefficient", friction_coefficient)
    slip = mu * surface.stiffness_ratio
    return loaded(surface, mu, slip, displacement, separation, start)


def loaded(
    surface: NormalLaw,
    friction: float,
    slip: float,
    displacement: ArrayLike,
    separation: ArrayLike,
    start: ArrayLike,
) -> FirstLoading:
    """The same with the displacement ``slip`` per place beside the coefficient."""
    x = floats("displacement", displacement, "m")
    # By their own names, should they be refused.
    end = surface._separations(floats("separation", separation, "m"))
    before = surface._separations(floats("start", start, "m"))
    try:
        x, end, before = np.broadcast_arrays(x, end, before)
    except ValueError:
        raise InputError(
            "displacement, separation and start must have shapes that go together, got "
            f"{x.shape}, {end.shape} and {before.shape}"
        ) from None
    curve = LoadCurve(surface, 0.0, math.nan)
    place, step, rest = beyond(x.ravel(), slip), end.ravel(), before.ravel()
    value, load, by_place, by_step, fall = straight_step(curve, place, step, rest)
    tangent = np.zeros((x.size, 2, 2))
    tangent[:, 0, 0] = friction / slip * by_place
    tangent[:, 0, 1] = friction * by_step
    tangent[:, 1, 1] = -fall
    return FirstLoading(
        plain(friction * value.reshape(x.shape)),
        plain(load.reshape(x.shape)),
        tangent.reshape(*x.shape, 2, 2),
    )


def straight_step(
    curve: LoadCurve, place: Floats, step: Floats, rest: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """T/mu, N, the derivatives of T/mu by place and step, and -N', one-dimensional."""
    size, approach = np.abs(place), rest - step
    sticks = size <= approach
    width = np.where(sticks, approach, size)  # over which D is not 0
    load, fall = curve.load(step)
    drop, ahead = curve.drop(step, width), curve.fall(step + width)
    density = np.copysign(
        np.divide(size, approach, out=np.ones_like(size), where=sticks & (approach > 0.0)), place
    )
    mean = np.divide(drop, width, out=fall.copy(), where=width > 0.0)
    by_place = np.where(sticks, mean, ahead)
    return density * drop, load, by_place, density * (by_place - fall), fall
