"""Forces, harmonics and energies of a law with their derivatives, as JAX and PyTorch take them.

Derivatives by displacements are the tangents of the branches, those by parameters
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

Answer = tuple[Floats, Floats, Floats]
"""A result, and its derivatives by parameters and by displacements, along last axes."""

Question = Callable[[BackboneLaw, Floats, list[str]], Answer]
"""Quantity of a law at a place [m], and the parameters to derive it by."""


def force(law: BackboneLaw, x: Floats, names: list[str]) -> Answer:
    """Forces [N] along a history from rest."""
    by = law.parameter_derivatives("force", x, names)
    tree = Memory().tree(x)
    parent: NDArray[np.int64] = tree.parent
    changes = np.eye(x.size)
    changes[parent >= 0] -= np.eye(x.size)[parent[parent >= 0]]
    slopes = law._slope(tree.half)[:, None] * changes
    kernels.compiled.accumulate(parent, slopes, np.zeros(x.size))
    return law.force(x), _columns(by, names, x.shape), slopes


def settled(numbers: tuple[int, ...], rest: Any) -> Question:
    """Coefficients of the settled force [N] of those of the displacement."""
    options: dict[str, Any] = {"harmonics": numbers, "rest": rest}

    def answer(law: BackboneLaw, c: Floats, names: list[str]) -> Answer:
        by = law.parameter_derivatives("harmonics", c, names, **options)
        response, jacobian = law.harmonics(c, **options)
        return response, _columns(by, names, c.shape), jacobian

    return answer


def dissipated_energy(law: BackboneLaw, a: Floats, names: list[str]) -> Answer:
    """Energy of a closed cycle [J] of one amplitude."""
    by = law.parameter_derivatives("dissipated_energy", a, names)
    slope = law._energy_slope(a.reshape(1)).reshape(())
    return np.asarray(law.dissipated_energy(a)), _columns(by, names, ()), slope


def ask(
    make: Callable[..., BackboneLaw], question: Question, names: list[str], values: Any, place: Any
) -> Answer:
    """The answer at values of the parameters."""
    law = make(**dict(zip(names, np.asarray(values, dtype=float).tolist(), strict=True)))
    result, by_parameter, by_place = question(law, np.array(place, dtype=float), names)
    return tuple(np.asarray(part, dtype=float) for part in (result, by_parameter, by_place))  # type: ignore[return-value]


def _columns(by: Mapping[str, Any], names: list[str], shape: tuple[int, ...]) -> Floats:
    return np.stack([np.asarray(by[name]).reshape(shape) for name in names], axis=-1)


class DifferentiableLaw:
    """Common base of the joints of JAX and of PyTorch.

    Parameters
    ----------
    make : callable
        Makes the law of parameters by their names, such as ``lambda std, normal_load:
        Interface(...)``; names are those of :meth:`microslip.BackboneLaw.parameter_derivatives`.

    Notes
    -----
    Each function takes a mapping of parameters first. Calls are not batched: ``vmap`` asks for one
    after the other.
    """

    def __init__(self, make: Callable[..., BackboneLaw]) -> None:
        self.make = make

    def force(self, parameters: Mapping[str, Any], displacement: Any) -> Any:
        """Forces [N] along a history of displacements [m] from rest, one-dimensional.

        The derivative by the displacements is a matrix of samples by samples.
        """
        return self._call(force, parameters, displacement)

    def harmonics(
        self,
        parameters: Mapping[str, Any],
        coefficients: Any,
        harmonics: tuple[int, ...] = (0, 1),
        rest: Any = 0.0,
    ) -> Any:
        """Coefficients of the settled force [N] from those of the displacement [m]."""
        return self._call(settled(harmonics, rest), parameters, coefficients)

    def dissipated_energy(self, parameters: Mapping[str, Any], amplitude: Any) -> Any:
        """Energy of a closed cycle [J] of one amplitude [m]."""
        return self._call(dissipated_energy, parameters, amplitude)

    def _call(self, question: Question, parameters: Mapping[str, Any], x: Any) -> Any:
        raise NotImplementedError
