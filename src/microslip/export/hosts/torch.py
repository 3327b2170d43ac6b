"""Joints in PyTorch: forces, harmonics and energies with exact first derivatives.

``backward``, ``torch.func.grad``, ``jacrev`` and ``vmap`` are supported. Values come from the
compiled kernel.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch

from microslip._core.errors import InputError
from microslip.export.hosts.differentiable import FIRST_ONLY, DifferentiableLaw, Quantity

_REAL = torch.float64


class _Gradients(torch.autograd.Function):  # type: ignore[misc]
    """Vector-Jacobian products for PyTorch; their derivatives raise an error."""

    generate_vmap_rule = True

    @staticmethod
    def forward(weights: Any, values: Any, place: Any, by_parameter: Any, by_place: Any) -> Any:
        if not weights.ndim:
            return by_parameter * weights, by_place * weights
        return weights @ by_parameter, weights @ by_place

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        """Store nothing, since there is no second derivative."""

    @staticmethod
    def backward(ctx: Any, *weights: Any) -> Any:
        raise InputError(FIRST_ONLY.format("detach()"))


class _Evaluate(torch.autograd.Function):  # type: ignore[misc]
    @staticmethod
    def forward(values: Any, place: Any, quantity: Any) -> Any:
        parts = quantity(values.detach().cpu().numpy(), place.detach().cpu().numpy())
        return tuple(torch.from_numpy(part.copy()).to(place.device) for part in parts)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.mark_non_differentiable(*output[1:])
        ctx.save_for_backward(*inputs[:2], *output[1:])

    @staticmethod
    def backward(ctx: Any, weights: Any, *_: Any) -> Any:
        return *_Gradients.apply(weights, *ctx.saved_tensors), None

    @staticmethod
    def vmap(info: Any, in_dims: Any, values: Any, place: Any, quantity: Any) -> Any:
        rows = [
            [array] * info.batch_size if axis is None else array.unbind(axis)
            for array, axis in zip((values, place), in_dims[:2], strict=True)
        ]
        found = [_Evaluate.apply(*row, quantity) for row in zip(*rows, strict=True)]
        return tuple(torch.stack(parts) for parts in zip(*found, strict=True)), (0, 0, 0)


class DifferentiableJoint(DifferentiableLaw):
    """Functions of PyTorch for a law made from parameters.

    Inputs and outputs are 64-bit. Second derivatives raise an error. Each call computes the value
    and all first derivatives.
    """

    def _call(self, quantity: Quantity, parameters: Mapping[str, Any], x: Any) -> Any:
        names = sorted(parameters)
        place = torch.as_tensor(x, dtype=_REAL)
        values = torch.stack(
            [torch.as_tensor(parameters[name], dtype=_REAL, device=place.device) for name in names]
        )

        def evaluate(p: Any, at: Any) -> Any:
            return self._evaluated(quantity, names, p, at, True)

        return _Evaluate.apply(values, place, evaluate)[0]
