"""Inverse design of a structure: a mode's frequency or damping by bolts, form, friction or lap."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import StudyError
from microslip.report.document import Progress
from microslip.runs.design import (
    KEYS,
    AnySearch,
    DesignPoint,
    Range,
    Search,
    Target,
    is_pointwise,
)
from microslip.runs.structure import keys_of_model, refined_model, scales, scaling_keys, tightened
from microslip.structures import ReducedJoint
from microslip.study.build import blame
from microslip.study.description import StudyDescription
from microslip.study.uncertain import value_at, with_values

_TURNS = 8
_MARGIN, _CLOSE = 2e-3, 0.015
"""Shares of a key by which a step goes beyond what slopes ask for, and by which a design may."""


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
