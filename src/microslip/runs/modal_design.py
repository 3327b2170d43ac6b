"""Inverse design of any study with a joint, and of a mode of a structure, by its own models."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from microslip._core.checks import Floats, show
from microslip.errors import InputError, StudyError
from microslip.friction import Interface
from microslip.kernels import Integers
from microslip.normal import NormalLaw
from microslip.report.document import Progress
from microslip.runs.design import (
    KEYS,
    DesignPoint,
    Range,
    Search,
    Target,
    is_pointwise,
    parts_of,
    range_error,
)
from microslip.runs.structure import keys_of_model, refined_model, scales, scaling_keys, tightened
from microslip.structures import ReducedJoint
from microslip.study.build import (
    Design,
    at_middle,
    blame,
    build_joints,
    is_uncertain,
    surface_inputs,
)
from microslip.study.description import StudyDescription
from microslip.study.joints import Joint
from microslip.study.uncertain import spreads_of, value_at, with_values

_TURNS = 8
_MARGIN, _CLOSE = 2e-3, 0.015
"""Shares of a key by which a step goes beyond what slopes ask for, and by which a design may."""


_SAMPLES = 32  # where the study does not say how many: each builds its joints
_SMALLEST = 1e-300  # a joint that loses nothing has no logarithm


class AnySearch(Search):
    """Keys of any study with a joint; of several loads the one that is furthest from the target."""

    is_costly = True
    _difference = 1e-4
    """Step of a logarithm for central differences: 1e-8 of the slopes."""

    def __init__(
        self, study: StudyDescription, target: Target, texts: Sequence[str], probability: float
    ) -> None:
        part = study.uncertainty
        if part is not None and (part.scan_patches or part.identification):
            raise StudyError(
                f"{study.name}: uncertainty: a design needs uncertain keys here; patches of a scan "
                "and identifications go with a Greenwood–Williamson surface and one load"
            )
        self._varied = study
        self._surfaces: dict[str, NormalLaw] = {}
        self._joints: dict[str, list[Interface]] = {}
        self._values_by_place: dict[bytes, Floats] = {}
        self._quantiles_by_place: dict[bytes, tuple[float, Floats]] = {}
        ranges = [self._read(text) for text in texts]
        rows: list[dict[str, float]] = [{}]
        if is_uncertain(study):
            from scipy.special import ndtr

            design = Design(study)
            count = self._count(study)
            points = design.points() if count is None else design.points(count, 1)
            scores = design.scores(points.reshape(-1, len(design.inputs)))
            rows = [design.values(ndtr(row)) for row in scores]
        self._rows = rows
        super().__init__(study, target, ranges, probability)

    def _count(self, study: StudyDescription) -> int | None:
        """Samples; None where the study says how many groups of them there are."""
        return _SAMPLES if study.uncertainty is None else None

    def _read(self, text: str) -> Range:
        """A range by the study's own reading of its ends; the key is free in it from now on."""
        key, low, high = parts_of(text)
        change = f"{key}={{low={_toml(low)}, high={_toml(high)}}}"
        study = self._varied
        self._varied = StudyDescription.from_toml(study.text, study.name, [change], study._folder)
        spread = dict(spreads_of(self._varied)).get(key)
        if spread is None or spread.low is None or spread.high is None or not spread.low > 0.0:
            raise range_error(key, text)
        return Range(key, spread.low, spread.high)

    def _start(self) -> tuple[list[str], dict[str, Any]]:
        middle, values = at_middle(self.study), {}
        for r in self.ranges:
            value = value_at(middle, r.key)
            if value is None or value <= 0.0:
                raise StudyError(
                    f"{self.study.name}: {r.key}: wanted one number above zero in the study, got "
                    f"{'none or several' if value is None else show(value)}; give it one by --set "
                    f"{r.key}=VALUE"
                )
            values[r.key] = value
        return list(values), values

    def _of_samples(self, logs: Floats, samples: Integers) -> Floats:
        """Ln of the quantity of some samples."""
        targets = dict(zip(self.names, np.exp(logs).tolist(), strict=True))
        worst = min if self.target.at_least else max
        quantities = []
        for row in (self._rows[i] for i in samples):
            scaled = {
                k: v * row.get(k, self.middle[k]) / self.middle[k] for k, v in targets.items()
            }
            quantities.append(worst(self._of_joints(with_values(self._varied, {**row, **scaled}))))
        return np.log(np.maximum(quantities, _SMALLEST))

    def _of_joints(self, study: StudyDescription) -> list[float]:
        """The quantity of each joint of a study.

        Friction only scales: T/mu is a function of delta/mu. So samples that differ in it alone
        share their joints, with what those have tabulated.
        """
        amplitude, measure, factor = self.target.amplitude, self.target.quantity, 1.0
        if not isinstance(study.joint, Joint):
            joints = build_joints(study)
        else:
            mu = float(study.joint.friction_coefficient)
            alike = study.joint.copy(friction_coefficient=1.0).by_keys()
            inputs = repr((surface_inputs(study), alike))
            if inputs not in self._joints:
                self._joints[inputs] = build_joints(study, self._surfaces)
            joints = self._joints[inputs]
            amplitude *= joints[0].friction_coefficient / mu
            if measure == "dissipated_energy":
                factor = (mu / joints[0].friction_coefficient) ** 2
        return [factor * float(getattr(joint, measure)(amplitude)) for joint in joints]

    def values(self, logs: Floats) -> Floats:
        """Ln of the quantity over the samples; the search asks for a place more than once."""
        place = np.asarray(logs).tobytes()
        if place not in self._values_by_place:
            self._values_by_place[place] = self._of_samples(logs, np.arange(len(self._rows)))
        return self._values_by_place[place]

    def quantile(self, logs: Floats) -> tuple[float, Floats]:
        """Quantile as of any search, computed once a place."""
        place = np.asarray(logs).tobytes()
        if place not in self._quantiles_by_place:
            self._quantiles_by_place[place] = super().quantile(logs)
        return self._quantiles_by_place[place]

    def _slopes(self, logs: Floats, near: Integers) -> Floats:
        ends = [
            [float(self._of_samples(logs + sign * step, near).mean()) for sign in (-1.0, 1.0)]
            for step in self._difference * np.eye(len(logs))
        ]
        return np.array([(high - low) / (2.0 * self._difference) for low, high in ends])


def _toml(end: str) -> str:
    """A plain number as it is, a quantity as text."""
    text = end.strip()
    try:
        value = float(text)
    except ValueError:
        quoted = text.replace('"', "")
        return f'"{quoted}"'
    if not math.isfinite(value):
        raise InputError(f"`vary` must have finite ends, got {text!r}")
    return repr(value)


class ModalSearch(AnySearch):
    """A mode of a structure over the samples of what is uncertain in it.

    One reduced model serves all samples and designs; where a dimension of the drawing may change,
    each value that it takes has its own. Slopes are those of the samples that the probability
    points at, and each turn takes the smallest change that meets the target by them.
    """

    def __init__(
        self, study: StudyDescription, target: Target, texts: Sequence[str], probability: float
    ) -> None:
        if study.structure is None:
            raise StudyError(f"{study.name}: structure: wanted one, for a target on a mode")
        self._models: dict[str, tuple[StudyDescription, ReducedJoint]] = {}
        self._keys: list[str] = []
        super().__init__(study, target, texts, probability)
        self._keys = keys_of_model(study, {*self.names, *self._rows[0]})

    def _count(self, study: StudyDescription) -> int | None:
        return study.bolted.samples

    def _model(self, sample: StudyDescription) -> ReducedJoint:
        """The reduced model of a sample: a multiple of one that has its drawing."""
        values = {key: value for key in self._keys if (value := value_at(sample, key)) is not None}
        if repr(values) not in self._models:
            drawing = with_values(self._varied, values)
            self._models[repr(values)] = drawing, refined_model(drawing)
        drawing, model = self._models[repr(values)]
        factors = scales(drawing, sample, scaling_keys(sample))
        # A multiple is another model, that has none of what this one has computed of itself.
        return model if set(factors) <= {1.0} else model.scaled(*factors)

    def _of_joints(self, study: StudyDescription) -> list[float]:
        """The quantity of the mode of one sample."""
        part, target = study.bolted, self.target
        with blame(self.study, "structure"):
            model, state = tightened(study, self._model(study))
            curve = state.modes(
                target.mode - 1,
                [target.amplitude],
                at=model.sensor("sensor"),
                damping_ratio=part.base_damping_ratio,
                harmonics=part.harmonics,
            )
        if not curve.converged[0]:
            raise StudyError(
                f"{self.study.name}: structure: mode {target.mode} has no solution at "
                f"{target.amplitude:g} m: {curve.message}"
            )
        return [float(getattr(curve, target.quantity)[0])]

    _difference = 0.02
    """Step of a logarithm for slopes: frequencies change little."""

    def solve(self, level: float | None = None, progress: Progress | None = None) -> DesignPoint:
        """The design that changes the study least, by its slopes turn by turn."""
        log_level, sign = self._ln_level(level)
        x: Floats = np.clip(self.start, *np.transpose(self.bounds))
        best = None
        for turn in range(_TURNS):
            reached, slopes = self.quantile(x)
            miss = sign * (reached - log_level)
            change = float(((x - self.start) ** 2).sum())
            rank = (miss < 0.0, -miss if miss < 0.0 else change)
            if best is None or rank < best[0]:
                best = rank, x
            if progress is not None:
                progress((turn + 1) / _TURNS)
            if miss >= 0.0 and (turn == 0 or miss < _CLOSE * np.abs(slopes).max()):
                break
            last = x
            short = _MARGIN * float(np.abs(slopes).max()) - miss + float(sign * slopes @ last)
            constraint = {
                "type": "ineq",
                "fun": lambda y, g=sign * slopes, c=short: float(g @ y) - c,
                "jac": lambda y, g=sign * slopes: g,
            }
            x = np.clip(self._least_change(last, constraint).x, *np.transpose(self.bounds))
            if np.abs(x - last).max() < 1e-6:
                break
        assert best is not None
        return self.at(best[1], math.exp(log_level))


def open_search(
    study: StudyDescription, target: Target, ranges: Sequence[str], probability: float
) -> Search:
    """The search by exact derivatives where there are some, else that of any study or mode."""
    if target.mode:
        return ModalSearch(study, target, ranges, probability)
    keys = [text.partition("=")[0].strip() for text in ranges]
    if is_pointwise(study) and all(key in KEYS for key in keys):
        return Search(study, target, [Range.read(text) for text in ranges], probability)
    return AnySearch(study, target, ranges, probability)
