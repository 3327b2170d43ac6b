"""Forces, harmonics and energies of a law or a field with derivatives, for JAX and PyTorch.

Settled forces are those of the periodic state that the force reaches when the displacement is
repeated. Derivatives with respect to displacements are tangent stiffnesses of the loading or
unloading branch at each sample. Derivatives with respect to parameters come from
:meth:`microslip.Interface.parameter_derivatives`; they are computed only for the parameters that
are named.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip.friction import Interface, JointField
from microslip.friction.memory import Memory

Derivatives = tuple[Floats, Floats, Floats]
"""Value, derivatives by parameters, and derivatives by displacements; derivatives have further
last axes."""

_LAWS_KEPT = 16  # laws of the last parameters, which a solver uses again and again

Evaluation = Callable[[Interface, Floats, list[str]], Derivatives]
"""Function of a law, displacements [m] and parameter names that returns an :data:`Derivatives`."""


def force(law: Interface, x: Floats, names: list[str]) -> Derivatives:
    """Return forces [N] along a displacement history [m] from rest, with derivatives."""
    by = law.parameter_derivatives("force", x, names) if names else {}
    tree = Memory().tree(x)
    parent: NDArray[np.int64] = tree.parent
    changes = np.eye(x.size)
    changes[parent >= 0] -= np.eye(x.size)[parent[parent >= 0]]
    slopes = law._slope(tree.half)[:, None] * changes
    kernels.compiled.accumulate(parent, slopes, np.zeros(x.size))
    return law.force(x), _columns(by, names, x.shape), slopes


def settled_force(numbers: tuple[int, ...], rest: Any) -> Evaluation:
    """Return an :data:`Evaluation` of :meth:`microslip.Interface.harmonics`."""
    options: dict[str, Any] = {"harmonics": numbers, "rest": rest}

    def evaluate(law: Interface, c: Floats, names: list[str]) -> Derivatives:
        by = law.parameter_derivatives("harmonics", c, names, **options) if names else {}
        response, jacobian = law.harmonics(c, **options)
        return response, _columns(by, names, c.shape), jacobian

    return evaluate


def dissipated_energy(law: Interface, a: Floats, names: list[str]) -> Derivatives:
    """Return the energy dissipated per cycle [J] at one amplitude [m], with derivatives."""
    by = law.parameter_derivatives("dissipated_energy", a, names) if names else {}
    slope = law._energy_slope(a.reshape(1)).reshape(())
    return np.asarray(law.dissipated_energy(a)), _columns(by, names, ()), slope


def field_harmonics(
    field: JointField, numbers: tuple[int, ...], rest: Any, motion: Floats
) -> tuple[Floats, Floats]:
    """Return Fourier coefficients of the settled forces of nodes [N], and their Jacobian [N/m].

    ``motion``, shape (nodes, 1 or 2, coefficients) [m], holds the coefficients of displacements
    and, as second row, of separations; the result has those of tangential forces and normal loads.
    The Jacobian is that of :meth:`microslip.JointField.harmonics`.
    """
    if motion.shape[-2] == 1:
        found = field.harmonics(motion[:, 0], numbers, rest=rest)
        return found.force[:, None], found.jacobian[:, None, None]
    found = field.harmonics(motion[:, 0], numbers, separations=motion[:, 1], rest=rest)
    return np.stack([found.force, np.asarray(found.load)], axis=1), found.jacobian


def _columns(by: Mapping[str, Any], names: list[str], shape: tuple[int, ...]) -> Floats:
    columns = [np.asarray(by[name]).reshape(shape) for name in names]
    return np.stack(columns, axis=-1) if columns else np.zeros((*shape, 0))


class DifferentiableLaw:
    """Base class of the joints for JAX and PyTorch.

    Parameters
    ----------
    make : callable
        Function that returns the law for named parameters, such as ``lambda std, normal_load:
        Interface(...)``. The names must be among those of
        :meth:`microslip.Interface.parameter_derivatives`.

    Notes
    -----
    The first argument of each method is a mapping of parameters by name. The laws of the last 16
    sets of parameters are kept, since solvers use the same parameters many times.
    """

    def __init__(self, make: Callable[..., Interface]) -> None:
        self.make = make
        self._law = lru_cache(_LAWS_KEPT)(lambda items: make(**dict(items)))

    def _evaluated(
        self, quantity: Evaluation, names: list[str], values: Any, place: Any, by_parameters: bool
    ) -> Derivatives:
        """Return ``quantity`` and its derivatives for the law whose parameters have ``values``."""
        law = self._law(tuple(zip(names, np.asarray(values, dtype=float).tolist(), strict=True)))
        parts = quantity(law, np.array(place, dtype=float), names if by_parameters else [])
        return tuple(np.asarray(part, dtype=float) for part in parts)  # type: ignore[return-value]

    def force(self, parameters: Mapping[str, Any], displacement: Any) -> Any:
        """Return forces [N] along a one-dimensional displacement history [m] from rest.

        The derivative with respect to the displacements has the shape (samples, samples).
        """
        return self._call(force, parameters, displacement)

    def harmonics(
        self,
        parameters: Mapping[str, Any],
        coefficients: Any,
        harmonics: tuple[int, ...] = (0, 1),
        rest: Any = 0.0,
    ) -> Any:
        """Return Fourier coefficients of the settled force [N] for those of the displacement [m].

        They are the mean, cos 1, sin 1, ... for the orders ``harmonics``. ``rest`` is the
        displacement [m] where the force was zero before the motion, or "mean" for the mean of the
        cycle.
        """
        return self._call(settled_force(harmonics, rest), parameters, coefficients)

    def dissipated_energy(self, parameters: Mapping[str, Any], amplitude: Any) -> Any:
        """Return the energy dissipated per cycle [J] at one amplitude [m]."""
        return self._call(dissipated_energy, parameters, amplitude)

    def _call(self, quantity: Evaluation, parameters: Mapping[str, Any], x: Any) -> Any:
        raise NotImplementedError


class DifferentiableField:
    """Base class of the fields of contact nodes for JAX and PyTorch.

    Parameters
    ----------
    field : JointField
        The nodes. Derivatives are with respect to the motion only, not to parameters of the field.
    """

    def __init__(self, field: JointField) -> None:
        self.field = field

    def harmonics(
        self,
        coefficients: Any,
        separations: Any = None,
        harmonics: tuple[int, ...] = (0, 1),
        rest: Any = 0.0,
    ) -> Any:
        """Return Fourier coefficients of the settled forces [N], shape (nodes, coefficients).

        The coefficients of the displacements [m] and those of the ``separations`` [m] have the same
        shape and order, as in :meth:`microslip.JointField.harmonics`. ``rest`` is the displacement
        [m] where the force was zero before the motion, or "mean" for the mean of the cycle. With
        separations a pair is returned: coefficients of the forces and of the normal loads [N].
        """
        motion = [coefficients] if separations is None else [coefficients, separations]
        found = self._call(motion, lambda row: field_harmonics(self.field, harmonics, rest, row))
        return found[:, 0] if separations is None else (found[:, 0], found[:, 1])

    def _call(self, motion: list[Any], quantity: Callable[[Floats], tuple[Floats, Floats]]) -> Any:
        raise NotImplementedError
