"""Joints in JAX: forces, harmonics and energies with exact derivatives, under jit, grad and vmap.

The numbers come from the compiled kernel by callbacks; the derivatives by displacements are the
tangents of the branches, those by parameters :meth:`microslip.BackboneLaw.parameter_derivatives`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from microslip import kernels
from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.friction import BackboneLaw
from microslip.memory import Memory

_Answer = tuple[Floats, Floats, Floats]
"""A result, and its derivatives by parameters and by displacements, along last axes."""


class DifferentiableJoint:
    """A law that is made of parameters, as functions of JAX.

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

        def answer(law: BackboneLaw, x: Floats, names: list[str]) -> _Answer:
            by = law.parameter_derivatives("force", x, names)
            tree = Memory().tree(x)
            parent: NDArray[np.int64] = tree.parent
            changes = np.eye(x.size)
            changes[parent >= 0] -= np.eye(x.size)[parent[parent >= 0]]
            slopes = law._slope(tree.half)[:, None] * changes
            kernels.compiled.accumulate(parent, slopes, np.zeros(x.size))
            return law.force(x), _columns(by, names, x.shape), slopes

        return self._call(answer, parameters, displacement)

    def harmonics(
        self,
        parameters: Mapping[str, Any],
        coefficients: Any,
        harmonics: tuple[int, ...] = (0, 1),
        rest: Any = 0.0,
    ) -> Any:
        """Coefficients of the settled force [N] from those of the displacement [m]."""

        def answer(law: BackboneLaw, c: Floats, names: list[str]) -> _Answer:
            options: dict[str, Any] = {"harmonics": harmonics, "rest": rest}
            by = law.parameter_derivatives("harmonics", c, names, **options)
            force, jacobian = law.harmonics(c, **options)
            return force, _columns(by, names, c.shape), jacobian

        return self._call(answer, parameters, coefficients)

    def dissipated_energy(self, parameters: Mapping[str, Any], amplitude: Any) -> Any:
        """Energy of a closed cycle [J] of one amplitude [m]."""

        def answer(law: BackboneLaw, a: Floats, names: list[str]) -> _Answer:
            by = law.parameter_derivatives("dissipated_energy", a, names)
            slope = law._energy_slope(a.reshape(1)).reshape(())
            return np.asarray(law.dissipated_energy(a)), _columns(by, names, ()), slope

        return self._call(answer, parameters, amplitude)

    def _call(
        self,
        answer: Callable[[BackboneLaw, Floats, list[str]], _Answer],
        parameters: Mapping[str, Any],
        x: Any,
    ) -> Any:
        if not jax.config.jax_enable_x64:
            raise InputError(
                "JAX must compute with 64 bits, since forces of microslip lose their meaning with "
                'less: write jax.config.update("jax_enable_x64", True) before all else'
            )
        names = sorted(parameters)
        values = jnp.stack([jnp.asarray(parameters[name], dtype=float) for name in names])
        place = jnp.asarray(x, dtype=float)

        def evaluate(p: Any, at: Any, *, derivatives: bool) -> Any:
            real = jnp.float64
            shapes = jax.ShapeDtypeStruct(at.shape, real)
            shape_of_answer: Any = shapes
            if derivatives:
                by_parameter = jax.ShapeDtypeStruct((*at.shape, len(names)), real)
                shape_of_answer = shapes, by_parameter, jax.ShapeDtypeStruct(at.shape * 2, real)

            def ask(p: Any, at: Any) -> Any:
                law = self.make(**dict(zip(names, np.asarray(p).tolist(), strict=True)))
                parts = answer(law, np.array(at, dtype=float), names)
                arrays = tuple(np.asarray(part, dtype=float) for part in parts)
                return arrays if derivatives else arrays[0]

            return jax.pure_callback(ask, shape_of_answer, p, at, vmap_method="sequential")

        @jax.custom_jvp  # type: ignore[untyped-decorator]
        def function(p: Any, at: Any) -> Any:
            return evaluate(p, at, derivatives=False)

        @function.defjvp  # type: ignore[untyped-decorator]
        def _(primals: Any, tangents: Any) -> Any:
            p, at = primals
            value, by_parameter, by_place = evaluate(p, at, derivatives=True)
            moved, shifted = tangents
            along = by_place * shifted if shifted.ndim == 0 else by_place @ shifted
            return value, by_parameter @ moved + along

        return function(values, place)


def _columns(by: Mapping[str, Any], names: list[str], shape: tuple[int, ...]) -> Floats:
    return np.stack([np.asarray(by[name]).reshape(shape) for name in names], axis=-1)
