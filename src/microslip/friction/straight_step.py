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
    """Tangential force and normal load after one straight step from rest, with tangents.

    After Jaeger (1998), DOI 10.1115/1.2833765; see :func:`first_loading`.
    """

    force: Any
    """Tangential forces T [N], broadcast shape of the arguments."""
    load: Any
    """Normal loads N [N], the same shape."""
    tangent: Floats
    """d(T, N)/d(displacement, separation) [N/m], broadcast shape with two more axes of length 2."""

    @property
    def normal_load(self) -> Any:
        """Alias of ``load`` [N]."""
        return self.load


def first_loading(
    surface: NormalLaw,
    friction_coefficient: float,
    displacement: ArrayLike,
    *,
    separation: ArrayLike,
    start: ArrayLike,
) -> FirstLoading:
    """Compute the forces after one straight step from (start, 0) to (separation, displacement).

    The step is straight in separation and displacement. Many contacts are computed at once.

    Parameters
    ----------
    surface : NormalLaw
        Surface of all contacts.
    friction_coefficient : float
        Coulomb's coefficient mu [-], above zero.
    displacement : array_like
        Displacements delta at the end [m], any shape. For motion in two tangential directions use
        the magnitude of the displacement: on a straight path the force is parallel to it.
    separation : array_like
        Separations d at the end [m], any shape that broadcasts with the others.
    start : array_like
        Separations d0 [m] before the step, with or without contact, at zero displacement and force.

    Returns
    -------
    FirstLoading
        ``force`` [N], ``load`` [N] and ``tangent`` [N/m].

    Notes
    -----
    With kappa = mu E*/(4 G*) and the approach w = d0 - d: if w >= abs(delta)/kappa, new contact
    sticks as it forms and T = mu delta/(kappa w) [N(d) - N(d0)]. Otherwise part of the contact
    slips, and abs(T) = mu [N(d) - N(d + abs(delta)/kappa)] (Jaeger 1998, DOI 10.1115/1.2833765).
    The tangent jumps between the two cases; on their boundary it is that of sticking.
    """
    check_surface(surface)
    mu = positive("friction_coefficient", friction_coefficient)
    slip = mu * surface.stiffness_ratio
    return first_loading_by_slip(surface, mu, slip, displacement, separation, start)


def first_loading_by_slip(
    surface: NormalLaw,
    friction: float,
    slip: float,
    displacement: ArrayLike,
    separation: ArrayLike,
    start: ArrayLike,
) -> FirstLoading:
    """Compute :func:`first_loading` for ``friction`` mu and ``slip`` per indentation kappa [-]."""
    x = floats("displacement", displacement, "m")
    # Convert one by one, so that an error names the argument.
    end = surface._separations(floats("separation", separation, "m"))
    before = surface._separations(floats("start", start, "m"))
    try:
        x, end, before = np.broadcast_arrays(x, end, before)
    except ValueError:
        raise InputError(
            "`displacement`, `separation` and `start` must have shapes that broadcast, got "
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
    """Return T/mu, N, d(T/mu)/d(place), d(T/mu)/d(step) and -N' after one straight step from rest.

    T is the friction force, mu the coefficient of friction and N the normal load of ``curve``.
    On a straight step, displacement and separation change in proportion. ``place`` is the
    displacement divided by kappa [m], the slip per indentation; ``rest`` and ``step`` are the
    separations before and after the step, relative to the origin of the curve [m]. All are
    one-dimensional.
    """
    size, approach = np.abs(place), rest - step
    sticks = size <= approach
    width = np.where(sticks, approach, size)  # support of the memory diagram D
    load, fall = curve.load(step)
    drop, ahead = curve.drop(step, width), curve.fall(step + width)
    density = np.copysign(
        np.divide(size, approach, out=np.ones_like(size), where=sticks & (approach > 0.0)), place
    )
    mean = np.divide(drop, width, out=fall.copy(), where=width > 0.0)
    by_place = np.where(sticks, mean, ahead)
    return density * drop, load, by_place, density * (by_place - fall), fall
