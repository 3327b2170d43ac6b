"""Forces, harmonics and energies of a law with derivatives, for JAX and PyTorch.

Derivatives by displacements are the tangents of the branches; derivatives by parameters come from
:meth:`microslip.BackboneLaw.parameter_derivatives`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip.friction import BackboneLaw
from microslip.friction.memory import Memory

Derivatives = tuple[Floats, Floats, Floats]
"""Value, its derivatives by parameters, and its derivatives by displacements, along last axes."""

Quantity = Callable[[BackboneLaw, Floats, list[str]], Derivatives]
"""Function of a law, displacements [m] and parameter names that returns an :data:`Derivatives`."""


def force(law: BackboneLaw, x: Floats, names: list[str]) -> Derivatives:
    """Forces [N] along a displacement history from rest."""
    by = law.parameter_derivatives("force", x, names)
    tree = Memory().tree(x)
    parent: NDArray[np.int64] = tree.parent
    changes = np.eye(x.size)
    changes[parent >= 0] -= np.eye(x.size)[parent[parent >= 0]]
    slopes = law._slope(tree.half)[:, None] * changes
    kernels.compiled.accumulate(parent, slopes, np.zeros(x.size))
    return law.force(x), _columns(by, names, x.shape), slopes


def settled_force(numbers: tuple[int, ...], rest: Any) -> Quantity:
    """Return the function for coefficients of the settled force [N]."""
    options: dict[str, Any] = {"harmonics": numbers, "rest": rest}

    def evaluate(law: BackboneLaw, c: Floats, names: list[str]) -> Derivatives:
        by = law.parameter_derivatives("harmonics", c, names, **options)
        response, jacobian = law.harmonics(c, **options)
        return response, _columns(by, names, c.shape), jacobian

    return evaluate


def dissipated_energy(law: BackboneLaw, a: Floats, names: list[str]) -> Derivatives:
    """Energy of a closed cycle [J] at one amplitude [m]."""
    by = law.parameter_derivatives("dissipated_energy", a, names)
    slope = law._energy_slope(a.reshape(1)).reshape(())
    return np.asarray(law.dissipated_energy(a)), _columns(by, names, ()), slope


def evaluated_in_numpy(
    make: Callable[..., BackboneLaw], quantity: Quantity, names: list[str], values: Any, place: Any
) -> Derivatives:
    """Evaluate a quantity of the law for parameter values."""
    law = make(**dict(zip(names, np.asarray(values, dtype=float).tolist(), strict=True)))
    result, by_parameter, by_place = quantity(law, np.array(place, dtype=float), names)
    return tuple(np.asarray(part, dtype=float) for part in (result, by_parameter, by_place))  # type: ignore[return-value]


def _columns(by: Mapping[str, Any], names: list[str], shape: tuple[int, ...]) -> Floats:
    return np.stack([np.asarray(by[name]).reshape(shape) for name in names], axis=-1)


class DifferentiableLaw:
    """Base class of the joints for JAX and PyTorch.

    Parameters
    ----------
    make : callable
        Function that returns the law for named parameters, such as ``lambda std, normal_load:
        Interface(...)``; the names of :meth:`microslip.BackboneLaw.parameter_derivatives` are
        accepted.

    Notes
    -----
    The first argument of each function is a mapping of parameters. Calls are not batched: ``vmap``
    evaluates them one after the other.
    """

    def __init__(self, make: Callable[..., BackboneLaw]) -> None:
        self.make = make

    def force(self, parameters: Mapping[str, Any], displacement: Any) -> Any:
        """Forces [N] along a one-dimensional displacement history [m] from rest.

        The derivative by the displacements has the shape (samples, samples).
        """
        return self._call(force, parameters, displacement)

    def harmonics(
        self,
        parameters: Mapping[str, Any],
        coefficients: Any,
        harmonics: tuple[int, ...] = (0, 1),
        rest: Any = 0.0,
    ) -> Any:
        """Coefficients of the settled force [N] from coefficients of the displacement [m]."""
        return self._call(settled_force(harmonics, rest), parameters, coefficients)

    def dissipated_energy(self, parameters: Mapping[str, Any], amplitude: Any) -> Any:
        """Energy of a closed cycle [J] at one amplitude [m]."""
        return self._call(dissipated_energy, parameters, amplitude)

    def _call(self, quantity: Quantity, parameters: Mapping[str, Any], x: Any) -> Any:
        raise NotImplementedError
