"""Joints and fields in JAX, with exact derivatives under jit, grad and vmap.

JAX calls the compiled kernel through ``pure_callback``, once per batch under ``vmap``. Only first
derivatives exist; second derivatives raise an error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero

from microslip._core.errors import InputError
from microslip.export.hosts import differentiable
from microslip.export.hosts.differentiable import DifferentiableLaw, Evaluation


def _called(
    answer: Callable[..., tuple[Any, ...]],
    shapes: list[tuple[int, ...]],
    apply: Callable[[Any, Any], Any],
    *arguments: Any,
) -> Any:
    """Call a NumPy function from JAX, with derivatives.

    ``answer(row, wanted)`` evaluates one entry of a batch. ``row`` is the tuple of its arguments;
    ``wanted`` has one bool per argument, true if the derivative with respect to this argument is
    needed. It returns the value, then the derivative for each argument (of any value if not
    wanted). ``shapes`` are the shapes of the value and of these derivatives. ``apply(derivative,
    tangent)`` multiplies a derivative by a change of its argument (a tangent in JAX).
    """
    if not jax.config.jax_enable_x64:
        raise InputError(
            "JAX must use 64-bit numbers; write "
            'jax.config.update("jax_enable_x64", True) before any other call of JAX'
        )
    dimensions = [jnp.ndim(argument) for argument in arguments]

    def evaluate(wanted: tuple[bool, ...], *given: Any) -> Any:
        kept = [0, *(1 + i for i, flag in enumerate(wanted) if flag)]

        def rows(*arrays: Any) -> Any:
            flat = [
                np.asarray(array, dtype=float).reshape(-1, *np.shape(array)[np.ndim(array) - n :])
                for array, n in zip(arrays, dimensions, strict=True)
            ]
            batch = np.shape(arrays[0])[: np.ndim(arrays[0]) - dimensions[0]]
            found = [answer(row, wanted) for row in zip(*flat, strict=True)]
            return tuple(
                np.stack([parts[k] for parts in found]).reshape((*batch, *shapes[k])) for k in kept
            )

        kinds = tuple(jax.ShapeDtypeStruct(shapes[k], jnp.float64) for k in kept)
        return jax.pure_callback(rows, kinds, *given, vmap_method="broadcast_all")

    none = (False,) * len(arguments)

    @jax.custom_jvp  # type: ignore[untyped-decorator]
    def function(*given: Any) -> Any:
        return evaluate(none, *given)[0]

    def derivatives(wanted: tuple[bool, ...], *given: Any) -> Any:
        @jax.custom_jvp  # type: ignore[untyped-decorator]
        def once(*given: Any) -> Any:
            return evaluate(wanted, *given)

        @once.defjvp  # type: ignore[untyped-decorator]
        def _(primals: Any, tangents: Any) -> Any:
            raise InputError(
                "joints of microslip have first derivatives only; use jax.lax.stop_gradient to "
                "stop second derivatives"
            )

        return once(*given)

    @partial(function.defjvp, symbolic_zeros=True)
    def _(primals: Any, tangents: Any) -> Any:
        wanted = tuple(not isinstance(tangent, SymbolicZero) for tangent in tangents)
        value, *slopes = derivatives(wanted, *primals)
        moving = [tangent for tangent, flag in zip(tangents, wanted, strict=True) if flag]
        along = jnp.zeros_like(value)
        for slope, tangent in zip(slopes, moving, strict=True):
            along += apply(slope, tangent)
        return value, along

    return function(*arguments)


def _product(slope: Any, tangent: Any) -> Any:
    return jnp.tensordot(slope, tangent, jnp.ndim(tangent))


def _by_nodes(slope: Any, tangent: Any) -> Any:
    return jnp.einsum("nabij,nbj->nai", slope, tangent)


class DifferentiableJoint(DifferentiableLaw):
    """Functions of JAX for a law made from parameters; JAX must use 64-bit numbers."""

    def _call(self, quantity: Evaluation, parameters: Mapping[str, Any], x: Any) -> Any:
        names = sorted(parameters)
        values = jnp.stack([jnp.asarray(parameters[name], dtype=float) for name in names])
        place = jnp.asarray(x, dtype=float)

        def answer(row: Any, wanted: tuple[bool, ...]) -> Any:
            return self._evaluated(quantity, names, row[0], row[1], wanted[0])

        shapes = [place.shape, (*place.shape, len(names)), place.shape * 2]
        return _called(answer, shapes, _product, values, place)


class DifferentiableField(differentiable.DifferentiableField):
    """Functions of JAX for a field of contact nodes; JAX must use 64-bit numbers."""

    def _call(self, motion: list[Any], quantity: Callable[[Any], Any]) -> Any:
        place = jnp.stack([jnp.asarray(part, dtype=float) for part in motion], axis=1)
        nodes, kinds, size = place.shape
        shapes = [place.shape, (nodes, kinds, kinds, size, size)]
        return _called(lambda row, wanted: quantity(row[0]), shapes, _by_nodes, place)
