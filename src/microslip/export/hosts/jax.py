"""Joints in JAX: forces, harmonics and energies with exact derivatives under jit, grad and vmap.

JAX calls the compiled kernel through ``pure_callback``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import jax
import jax.numpy as jnp

from microslip._core.errors import InputError
from microslip.export.hosts.differentiable import DifferentiableLaw, Quantity, evaluated_in_numpy


class DifferentiableJoint(DifferentiableLaw):
    """Law made from parameters, as functions of JAX, which must use 64-bit numbers."""

    def _call(self, quantity: Quantity, parameters: Mapping[str, Any], x: Any) -> Any:
        if not jax.config.jax_enable_x64:
            raise InputError(
                "JAX must use 64-bit numbers; write "
                'jax.config.update("jax_enable_x64", True) before any other call of JAX'
            )
        names = sorted(parameters)
        values = jnp.stack([jnp.asarray(parameters[name], dtype=float) for name in names])
        place = jnp.asarray(x, dtype=float)

        def evaluate(p: Any, at: Any, *, derivatives: bool) -> Any:
            shapes = [at.shape, (*at.shape, len(names)), at.shape * 2]
            kinds = tuple(jax.ShapeDtypeStruct(shape, jnp.float64) for shape in shapes)

            def answer(p: Any, at: Any) -> Any:
                parts = evaluated_in_numpy(self.make, quantity, names, p, at)
                return parts if derivatives else parts[0]

            return jax.pure_callback(
                answer, kinds if derivatives else kinds[0], p, at, vmap_method="sequential"
            )

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
