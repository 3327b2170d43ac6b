"""Inverse design of any study: its joints built sample by sample, slopes by differences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import Argument, InputError, StudyError
from microslip.kernels import Integers
from microslip.results.design.search import (
    KEYS,
    Range,
    Search,
    Target,
    is_pointwise,
    not_a_range,
    parts_of,
)
from microslip.study.build import build_joints
from microslip.study.description import StudyDescription
from microslip.study.draws import Design, at_middle, is_uncertain
from microslip.study.uncertain import spreads_of, value_at, with_values

_SAMPLES = 32  # where the study does not say how many: each builds its joints
_STEP = 1e-4  # of a logarithm, for central differences: 1e-8 of the slopes
_LEAST = 1e-300  # a joint that loses nothing has no logarithm


def open_search(
    study: StudyDescription, target: Target, ranges: Sequence[str], probability: float
) -> Search:
    """The search by exact derivatives where there are some, else that of any study."""
    keys = [text.partition("=")[0].strip() for text in ranges]
    if is_pointwise(study) and all(key in KEYS for key in keys):
        return Search(study, target, [Range.read(text) for text in ranges], probability)
    return AnySearch(study, target, ranges, probability)


class AnySearch(Search):
    """Keys of any study with a joint; of several loads the one that is furthest from the target."""

    is_costly = True

    def __init__(
        self, study: StudyDescription, target: Target, texts: Sequence[str], probability: float
    ) -> None:
        part = study.uncertainty
        if part is not None and (part.scan_patches or part.identification):
            raise StudyError(
                f"{study.name}: uncertainty: a design wants uncertain keys here; patches of a scan "
                "and identifications go with a Greenwood–Williamson surface and one load"
            )
        self._varied = study
        self._known: dict[bytes, Floats] = {}
        self._found: dict[bytes, tuple[float, Floats]] = {}
        ranges = [self._read(text) for text in texts]
        rows: list[dict[str, float]] = [{}]
        if is_uncertain(study):
            from scipy.special import ndtr

            design = Design(study)
            points = design.points(None if part is not None else _SAMPLES)
            scores = design.scores(points.reshape(-1, len(design.inputs)))
            rows = [design.values(ndtr(row)) for row in scores]
        self._rows = rows
        super().__init__(study, target, ranges, probability)

    def _read(self, text: str) -> Range:
        """A range by the study's own reading of its ends; the key is free in it from now on."""
        key, low, high = parts_of(text)
        change = f"{key}={{low={_toml(low)}, high={_toml(high)}}}"
        study = self._varied
        self._varied = StudyDescription.from_toml(study.text, study.name, [change], study._folder)
        spread = dict(spreads_of(self._varied)).get(key)
        if spread is None or spread.low is None or spread.high is None or not spread.low > 0.0:
            raise not_a_range(key, text)
        return Range(key, spread.low, spread.high)

    def _start(self) -> tuple[list[str], dict[str, Any]]:
        middle, values = at_middle(self.study), {}
        for r in self.ranges:
            value = value_at(middle, r.key)
            if value is None or value <= 0.0:
                raise StudyError(f"{self.study.name}: {r.key}: wanted one number of the study")
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
            study = with_values(self._varied, {**row, **scaled})
            measure = self.target.quantity
            quantities.append(
                worst(
                    float(getattr(joint, measure)(self.target.amplitude))
                    for joint in build_joints(study)
                )
            )
        return np.log(np.maximum(quantities, _LEAST))

    def values(self, logs: Floats) -> Floats:
        """Ln of the quantity over the samples; the search asks for a place more than once."""
        place = np.asarray(logs).tobytes()
        if place not in self._known:
            self._known[place] = self._of_samples(logs, np.arange(len(self._rows)))
        return self._known[place]

    def quantile(self, logs: Floats) -> tuple[float, Floats]:
        """As of any search, once a place."""
        place = np.asarray(logs).tobytes()
        if place not in self._found:
            self._found[place] = super().quantile(logs)
        return self._found[place]

    def _slopes(self, logs: Floats, near: Integers) -> Floats:
        ends = [
            [float(self._of_samples(logs + sign * step, near).mean()) for sign in (-1.0, 1.0)]
            for step in _STEP * np.eye(len(logs))
        ]
        return np.array([(high - low) / (2.0 * _STEP) for low, high in ends])


def _toml(end: str) -> str:
    """A plain number as it is, a quantity as text."""
    text = end.strip()
    try:
        value = float(text)
    except ValueError:
        quoted = text.replace('"', "")
        return f'"{quoted}"'
    if not math.isfinite(value):
        raise InputError(Argument("vary"), f" must have finite ends, got {text!r}")
    return repr(value)
