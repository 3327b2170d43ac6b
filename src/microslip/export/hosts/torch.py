"""Joints in PyTorch: forces, harmonics and energies with exact first derivatives.

They work under ``backward``, ``torch.func.grad``, ``jacrev`` and ``vmap``; the numbers come from
the compiled kernel.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch

from microslip._core.errors import InputError
from microslip.export.hosts.differentiable import DifferentiableLaw, Question, ask

_REAL = torch.float64


class _Gradients(torch.autograd.Function):  # type: ignore[misc]
    """Weighted sums of derivatives, which tell that they have none of their own."""

    generate_vmap_rule = True

    @staticmethod
    def forward(weights: Any, values: Any, place: Any, by_parameter: Any, by_place: Any) -> Any:
        if not weights.ndim:
            return by_parameter * weights, by_place * weights
        return weights @ by_parameter, weights @ by_place

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        """Nothing is kept."""

    @staticmethod
    def backward(ctx: Any, *weights: Any) -> Any:
        raise InputError(
            "joints of microslip have first derivatives alone: write detach() where those of "
            "gradients are not meant"
        )


class _Ask(torch.autograd.Function):  # type: ignore[misc]
    """A question to the law: its answer, then what the derivatives are made of."""

    @staticmethod
    def forward(values: Any, place: Any, question: Any) -> Any:
        parts = question(values.detach().cpu().numpy(), place.detach().cpu().numpy())
        return tuple(torch.from_numpy(part.copy()).to(place.device) for part in parts)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.mark_non_differentiable(*output[1:])
        ctx.save_for_backward(*inputs[:2], *output[1:])

    @staticmethod
    def backward(ctx: Any, weights: Any, *_: Any) -> Any:
        return *_Gradients.apply(weights, *ctx.saved_tensors), None

    @staticmethod
    def vmap(info: Any, in_dims: Any, values: Any, place: Any, question: Any) -> Any:
        rows = [
            [array] * info.batch_size if axis is None else array.unbind(axis)
            for array, axis in zip((values, place), in_dims[:2], strict=True)
        ]
        found = [_Ask.apply(*row, question) for row in zip(*rows, strict=True)]
        return tuple(torch.stack(parts) for parts in zip(*found, strict=True)), (0, 0, 0)


class DifferentiableJoint(DifferentiableLaw):
    """A law that is made of parameters, as functions of PyTorch.

    Numbers are taken and given in 64 bits. Only first derivatives exist: to derive them again is
    refused. Each call brings its derivatives along, whether they are asked for or not.
    """

    def _call(self, question: Question, parameters: Mapping[str, Any], x: Any) -> Any:
        names = sorted(parameters)
        place = torch.as_tensor(x, dtype=_REAL)
        values = torch.stack(
            [torch.as_tensor(parameters[name], dtype=_REAL, device=place.device) for name in names]
        )

        def answer(p: Any, at: Any) -> Any:
            return ask(self.make, question, names, p, at)

        return _Ask.apply(values, place, answer)[0]
