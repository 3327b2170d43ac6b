"""A prediction: all numbers of a study that was run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from microslip.friction import Interface
from microslip.loops import Loop
from microslip.runs.columns import (
    AmplitudeCurve,
    HistoryResponse,
    Limits,
    OscillatorCurve,
    VaryingCycles,
)
from microslip.runs.scatter import Scatter
from microslip.runs.structure_prediction import StructurePrediction
from microslip.study.description import StudyDescription


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """All numbers of a study, as :class:`microslip.Result` tells them."""

    study: StudyDescription
    joints: tuple[Interface, ...]
    loops: tuple[tuple[Loop, ...], ...]
    rows: tuple[AmplitudeCurve, ...]
    curves: tuple[AmplitudeCurve, ...]
    limits: tuple[Limits, ...]
    histories: tuple[HistoryResponse, ...] = ()
    oscillators: tuple[OscillatorCurve, ...] = ()
    varying: tuple[VaryingCycles, ...] = ()
    structure: StructurePrediction | None = None
    scatter: Scatter | None = None
    summary: dict[str, Any] = field(default_factory=dict)
    """What is said of it, once somebody has: see :class:`microslip.Result`."""

    def __repr__(self) -> str:
        parts = [
            *([repr(self.study.title)] if self.study.title else []),
            _count(len(self.joints), "load"),
            _count(len(self.rows[0].amplitude), "amplitude"),
            f"curves of {len(self.curves[0].amplitude)} points",
            *(f"history of {_count(len(h.force), 'sample')}" for h in self.histories[:1]),
            *("oscillator" for _ in self.oscillators[:1]),
            *("varying load" for _ in self.varying[:1]),
            *(["scatter"] if self.scatter is not None else []),
            *(["structure"] if self.structure is not None else []),
        ]
        return f"Result({', '.join(parts)})"


def _count(count: int, word: str) -> str:
    return f"{count} {word}" if count == 1 else f"{count} {word}s"
