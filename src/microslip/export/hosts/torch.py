"""Joints and fields in PyTorch: forces, harmonics and energies with exact first derivatives.

``backward``, ``torch.func.grad``, ``jacrev`` and ``vmap`` are supported. Values come from the
compiled kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import torch

from microslip._core.errors import InputError
from microslip.export.hosts import differentiable
from microslip.export.hosts.differentiable import DifferentiableLaw, Evaluation

_REAL = torch.float64


def _refuse(*_: Any) -> Any:
    raise InputError(
        "joints of microslip have first derivatives only, in reverse mode (grad, jacrev, backward) "
        "and not by jvp, jacfwd or hessian; use detach() to stop second derivatives"
    )


class _Gradients(torch.autograd.Function):  # type: ignore[misc]
    """Vector-Jacobian products for PyTorch; their derivatives raise an error."""

    generate_vmap_rule = True

    @staticmethod
    def forward(
        weights: Any, product: Any, values: Any, place: Any, by_parameter: Any, by_place: Any
    ) -> Any:
        return product(weights, by_parameter), product(weights, by_place)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        """Store nothing, since there is no second derivative."""

    backward = jvp = staticmethod(_refuse)


class _Evaluate(torch.autograd.Function):  # type: ignore[misc]
    """Differentiable value of a NumPy function of parameter values and one array ``place``.

    ``place`` holds displacements, their coefficients or an amplitude. The function ``quantity``
    returns the value and both derivatives; ``product(weights, derivative)`` contracts the incoming
    gradient with a derivative.
    """

    @staticmethod
    def forward(values: Any, place: Any, quantity: Any, product: Any) -> Any:
        parts = quantity(values.detach().cpu().numpy(), place.detach().cpu().numpy())
        return tuple(torch.from_numpy(part.copy()).to(place.device) for part in parts)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.mark_non_differentiable(*output[1:])
        ctx.save_for_backward(*inputs[:2], *output[1:])
        ctx.product = inputs[3]

    @staticmethod
    def backward(ctx: Any, weights: Any, *_: Any) -> Any:
        return *_Gradients.apply(weights, ctx.product, *ctx.saved_tensors), None, None

    jvp = staticmethod(_refuse)

    @staticmethod
    def vmap(info: Any, in_dims: Any, values: Any, place: Any, *functions: Any) -> Any:
        rows = [
            [array] * info.batch_size if axis is None else array.unbind(axis)
            for array, axis in zip((values, place), in_dims[:2], strict=True)
        ]
        found = [_Evaluate.apply(*row, *functions) for row in zip(*rows, strict=True)]
        return tuple(torch.stack(parts) for parts in zip(*found, strict=True)), (0, 0, 0)


def _product(weights: Any, by: Any) -> Any:
    return torch.tensordot(weights, by, dims=weights.ndim)


def _by_nodes(weights: Any, by: Any) -> Any:
    return torch.einsum("nai,nabij->nbj", weights, by) if by.ndim else by


class DifferentiableJoint(DifferentiableLaw):
    """Functions of PyTorch for a law made from parameters.

    Inputs and outputs are 64-bit. Second derivatives raise an error. Each call computes the value
    and all first derivatives.
    """

    def _call(self, quantity: Evaluation, parameters: Mapping[str, Any], x: Any) -> Any:
        names = sorted(parameters)
        place = torch.as_tensor(x, dtype=_REAL)
        values = torch.stack(
            [torch.as_tensor(parameters[name], dtype=_REAL, device=place.device) for name in names]
        )

        def evaluate(p: Any, at: Any) -> Any:
            return self._evaluated(quantity, names, p, at, True)

        return _Evaluate.apply(values, place, evaluate, _product)[0]


class DifferentiableField(differentiable.DifferentiableField):
    """Functions of PyTorch for a field of contact nodes; inputs and outputs are 64-bit."""

    def _call(self, motion: list[Any], quantity: Callable[[Any], Any]) -> Any:
        place = torch.stack([torch.as_tensor(part, dtype=_REAL) for part in motion], dim=1)

        def evaluate(none: Any, at: Any) -> Any:
            value, slopes = quantity(at)
            return value, none, slopes

        return _Evaluate.apply(place.new_zeros(()), place, evaluate, _by_nodes)[0]
