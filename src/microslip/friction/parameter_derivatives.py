"""Exact derivatives of the response of an interface with respect to its parameters.

The force along a history, a settled cycle, its harmonics and its energy are linear in the backbone
T0, and the branches depend on the displacements alone. The derivative of a response with respect to
a parameter p is therefore the response of a law with backbone dT0/dp.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, plain, record, show
from microslip._core.errors import InputError
from microslip.friction.cycles import Rest, settled_cycle
from microslip.friction.harmonics import harmonic_force
from microslip.friction.memory import Memory

if TYPE_CHECKING:
    from microslip.contact.materials import Material

_QUANTITIES = ("backbone", "force", "periodic", "harmonics", "dissipated_energy")
"""Quantities that have parameter derivatives."""


@dataclass(frozen=True)
class DerivativeBackbone:
    """Derivative dT0/dp of a backbone T0 with respect to a parameter p, used in place of T0."""

    _backbone: Callable[[Floats], Floats]
    """Function dT0/dp of displacements u >= 0 [m], one-dimensional."""
    _energy: Callable[[Floats], Floats]
    """Function dE_d/dp of amplitudes >= 0 [m], one-dimensional."""
    _kinks: Floats
    """Displacements [m] at which dT0/dp is not smooth."""
    size: float
    """Bound of the terms of dT0/dp relative to T0 [1/unit of the parameter], for rounding."""

    _table = None
    tangential_stiffness = 0.0  # slopes enter only Jacobians, which are not used

    def _slope(self, u: Floats) -> Floats:
        return np.zeros_like(u)


def derivatives_by_parameters(
    law: Any,
    quantity: str,
    at: ArrayLike,
    names: Sequence[str] | None,
    harmonics: Any,
    rest: Rest,
) -> dict[str, Any]:
    """Compute parameter derivatives; see :meth:`microslip.Interface.parameter_derivatives`."""
    if quantity not in _QUANTITIES:
        raise InputError(
            f"`quantity` must be one of {', '.join(_QUANTITIES)}, got {show(quantity)}"
        )
    known = _derivative_backbones(law)
    chosen = tuple(known) if names is None else names
    if isinstance(chosen, str) or not set(chosen) <= set(known):
        raise InputError(f"`names` must be a list of {', '.join(known)}, got {show(names)}")
    of: Callable[[DerivativeBackbone], Any]
    if quantity in ("force", "periodic", "harmonics"):
        rows = floats("at", at, "m")
        if rows.ndim == 0:
            raise InputError(
                f"`at` must be a sequence of displacements [m] for {quantity}, got {rows:g}"
            )
        batch = [record("at", row) for row in rows.reshape(-1, rows.shape[-1])]

        def of_row(backbone: DerivativeBackbone, row: Floats) -> Floats:
            if quantity == "force":
                return Memory().respond(row, backbone._backbone, None)
            if quantity == "periodic":
                return settled_cycle(backbone, row, rest).force
            farthest = np.abs(row).sum() + (0.0 if isinstance(rest, str) else abs(rest))
            least = backbone.size * float(law._backbone(np.array([farthest]))[0])
            return harmonic_force(backbone, row, harmonics, rest, 1e-10, least).force

        def of(backbone: DerivativeBackbone) -> Any:
            return np.array([of_row(backbone, row) for row in batch]).reshape(rows.shape)

    else:
        x = floats("at", at, "m")
        a = np.abs(x).reshape(-1)
        if quantity == "dissipated_energy" and x.min() < 0.0:
            raise InputError(f"`at` must be amplitudes of zero or more [m], got {x.min():g}")

        def of(backbone: DerivativeBackbone) -> Any:
            if quantity == "dissipated_energy":
                return plain(backbone._energy(a).reshape(x.shape))
            return plain(np.copysign(1.0, x) * backbone._backbone(a).reshape(x.shape))

    return {name: of(known[name]) for name in chosen}


def _derivative_backbones(joint: Any) -> Mapping[str, DerivativeBackbone]:
    """Return the derivatives dT0/dp of an Interface by parameter name.

    Surface parameters are included if all summits have one radius. With s = u/kappa, T0 = mu
    drop(s) and E_d = 8 mu kappa excess(s), where drop(s) = N(d) - N(d + s), and excess(s) is half
    the integral of v (s - v) N''(d + v) over 0 <= v <= s. The load is N = C F(d/L), with the load
    scale C and the length scale L, and k_n = -N'(d). At fixed L, a small change of p changes d by
    -N/k_n times the change of ln(N/C), and s/L changes by -s/L times the change of ln(kappa L).
    """
    surface, d = joint.surface, joint.separation
    load, fall = joint.normal_load, joint.normal_stiffness
    mu, kappa = joint._friction, joint.slip_per_indentation

    def derivative(
        friction: float, pressed: float, stiff: float, slip: float, length: float
    ) -> Any:
        """Return dT0/dp, given the derivatives by p of ln mu, ln N, ln C, ln kappa and ln L."""
        shift = -load / fall * (pressed - stiff)
        direct, reach = friction + pressed, -(slip + length)

        def backbone(u: Floats) -> Floats:
            s = joint._steps(u)
            drop, far = surface._drop(d, s), surface._fall(d, s)
            moved = (far - fall + drop * fall / load) * shift + far * s * reach
            return np.asarray(mu * (drop * direct + moved))

        def energy(a: Floats) -> Floats:
            s = joint._steps(a)
            excess, slope = surface._excess(d, s), surface._excess_slope(d, s)
            far = surface._fall(d, s)
            moved = (2.0 * slope - 0.5 * s * (fall - far) + excess * fall / load) * shift
            total = excess * (direct + slip + length) + moved + s * slope * reach
            return np.asarray(8.0 * mu * kappa * total)

        size = abs(direct) + abs(reach) + abs(shift) * fall / load
        return DerivativeBackbone(backbone, energy, joint._kinks, size)

    friction = 1.0 / joint.friction_coefficient
    result = {
        "friction_coefficient": derivative(friction, 0.0, 0.0, friction, 0.0),
        "normal_load": derivative(0.0, 1.0 / load, 0.0, 0.0, 0.0),
    }
    numbers = surface._scales
    if numbers is None:
        return result
    for name, (value, stiff, length) in numbers.items():
        result[name] = derivative(0.0, 0.0, stiff / value, 0.0, length / value)
    pair = surface.pair
    bodies: dict[str, tuple[Material, ...]] = {"": (pair.first, pair.second)}
    if pair.first != pair.second:
        bodies = {"": (pair.first,), "other_": (pair.second,)}
    normal, shear = pair.composite_modulus, pair.composite_shear_modulus
    for prefix, alike in bodies.items():
        if alike[0].is_rigid:
            continue
        modulus, nu, count = alike[0].young_modulus, alike[0].poisson_ratio, len(alike)
        by = {  # d ln E* and d ln G*, of (19.4) and (19.11)
            "young_modulus": (
                normal * (1.0 - nu**2) / modulus**2,
                shear * 2.0 * (2.0 - nu) * (1.0 + nu) / modulus**2,
            ),
            "poisson_ratio": (2.0 * nu * normal / modulus, -shear * (2.0 - 4.0 * nu) / modulus),
        }
        for name, (stiffer, firmer) in by.items():
            stiff, slip = count * stiffer, count * (stiffer - firmer)
            result[prefix + name] = derivative(0.0, 0.0, stiff, slip, 0.0)
    return result
