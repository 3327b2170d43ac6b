"""Uncertainty of predictions: samples, quantiles with errors, and contributions of the inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from microslip._core.checks import Floats, Progress
from microslip._core.dataset import Variable
from microslip._core.errors import InputError, StudyError
from microslip.friction.sweeps.quantiles import intervals, regression
from microslip.study.build import Design, Input
from microslip.study.description import StudyDescription
from microslip.study.runs.columns import AmplitudeCurve

Variables = Mapping[str, Variable]
Compute = Callable[[StudyDescription], Variables]
RANKED = ("loss_factor", "dissipated_energy", "secant_stiffness")
"""Results for which the contributions of the inputs are computed."""

_LARGEST = 60_000_000  # largest number of values of one variable over all samples


@dataclass(frozen=True)
class Contributions:
    """Contributions of the inputs to the scatter of one result at one load and amplitude."""

    name: str  # the result
    load: int  # index of the load
    amplitude: int  # index of the amplitude
    scatter: float  # standard deviation of its logarithm over the samples [-]
    shares: Floats  # fraction of the variance due to each input, by regression on normal scores
    explained: float  # fraction of the variance explained by the regression


@dataclass(frozen=True, eq=False)
class PredictionScatter:
    """Bands of all results of a study over its samples, and each input's part of the scatter."""

    inputs: tuple[Input, ...]  # uncertain inputs
    samples: int  # number of samples
    quantiles: Floats  # cumulative probabilities of the bands
    bands: Variables  # quantiles of the variables of result.nc, along the first dimension
    intervals: Mapping[str, Floats]  # ends of the confidence intervals of quantiles, except curves
    decisions: tuple[Contributions, ...]  # one per ranked result, load and amplitude
    notes: tuple[str, ...]

    def curve(self, quantile: int, load: int, amplitude: Floats) -> AmplitudeCurve:
        """Return one quantile of all cyclic quantities at one load, against displacement.

        ``quantile`` and ``load`` are indices; ``amplitude`` are displacement amplitudes [m].
        """
        columns: dict[str, Any] = {}
        for name in AmplitudeCurve.__dataclass_fields__:
            band = self.bands.get(f"curve_{name}")
            columns[name] = None if band is None else band.values[quantile, load].copy()
        return AmplitudeCurve(**{**columns, "amplitude": amplitude.copy()})

    def decision(self, name: str, load: int, amplitude: int) -> Contributions:
        """Return the contributions of the inputs to one result at one load and amplitude."""
        return next(
            d for d in self.decisions if (d.name, d.load, d.amplitude) == (name, load, amplitude)
        )


def scatter(
    study: StudyDescription,
    nominal: Variables,
    compute: Compute,
    progress: Progress | None = None,
) -> PredictionScatter:
    """Compute the bands of the results of a study with fixed amplitudes.

    ``nominal`` contains the results at the central values; ``compute`` returns the results of a
    study without uncertain inputs.
    """
    report = progress or (lambda share: None)
    design = Design(study)
    points = design.points()
    groups, size, inputs = points.shape
    scores = design.scores(points.reshape(-1, inputs))
    count = groups * size
    names, left_out = _with_bands(nominal, count)
    stacks = {name: np.empty((count, *nominal[name].values.shape)) for name in names}
    for index, row in enumerate(scores):
        try:
            sample = compute(design.at(row))
        except InputError as error:
            reason = str(error).removeprefix(f"{study.name}: ")
            raise StudyError(
                f"{study.name}: uncertainty: sample {index + 1} of {count} cannot be computed: "
                f"{reason}"
            ) from None
        # A quantity that one sample does not have, such as a contact area, has no band.
        stacks = {name: stack for name, stack in stacks.items() if name in sample}
        for name, stack in stacks.items():
            stack[index] = sample[name].values
        report((index + 1) / count)
    quantiles = np.array(design.part.quantiles)
    bands, ends = {}, {}
    for name, stack in stacks.items():
        variable = nominal[name]
        values = np.quantile(stack, quantiles, axis=0)
        bands[name] = variable._replace(dims=("quantile", *variable.dims), values=values)
        if "point" not in variable.dims and not variable.dims[-1].endswith("sample"):
            by_group = stack.reshape(groups, size, *variable.values.shape)
            ends[name] = intervals(by_group, design.part.quantiles)
    decisions = _decisions(stacks, scores)
    notes: tuple[str, ...] = ()
    if left_out:
        notes = (f"Too many values for bands, so none are given: {', '.join(left_out)}.",)
    return PredictionScatter(tuple(design.inputs), count, quantiles, bands, ends, decisions, notes)


def _with_bands(nominal: Variables, count: int) -> tuple[list[str], list[str]]:
    """Return names of results that get bands, and of those too large for ``count`` samples."""
    numbers = [
        name
        for name, variable in nominal.items()
        if variable.values.dtype.kind == "f" and not name.startswith("validity")
    ]
    large = [name for name in numbers if nominal[name].values.size * count > _LARGEST]
    return [name for name in numbers if name not in large], large


def _decisions(stacks: Mapping[str, Floats], scores: Floats) -> tuple[Contributions, ...]:
    decisions = []
    for name in RANKED:
        stack = stacks[name]
        for load in range(stack.shape[1]):
            for amplitude in range(stack.shape[2]):
                values = stack[:, load, amplitude]
                with np.errstate(divide="ignore", invalid="ignore"):
                    logs = np.log(values)
                _, shares, explained = regression(scores, logs)
                decisions.append(
                    Contributions(name, load, amplitude, float(logs.std()), shares, explained)
                )
    return tuple(decisions)
