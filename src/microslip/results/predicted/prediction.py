"""A prediction: all numbers of a study that was run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from microslip.friction import Interface
from microslip.loops import Loop
from microslip.results.predicted.columns import (
    AmplitudeCurve,
    HistoryResponse,
    Limits,
    OscillatorCurve,
)
from microslip.results.predicted.scatter import Scatter
from microslip.results.predicted.varying import VaryingCycles
from microslip.results.structure.prediction import StructurePrediction
from microslip.study.description import StudyDescription


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """All numbers of a study; index 0 runs over normal loads, 1 over amplitudes.

    Parameters
    ----------
    study : StudyDescription
        What was computed.
    joints : tuple of Interface
        One for each normal load.
    loops : tuple of tuple of Loop
        For each load, one for each amplitude of the study; under a normal load that varies each
        is a :class:`~microslip.results.predicted.varying.VaryingLoop`.
    rows : tuple of AmplitudeCurve
        For each load, the cyclic quantities at the amplitudes of the loops. Where the study gives
        force amplitudes these are the same for all loads, and the displacement amplitudes differ.
    curves : tuple of AmplitudeCurve
        For each load, the same over the whole range of amplitudes.
    limits : tuple of Limits
        For each load, the asymptotes of the dissipated energy.
    summary : dict
        What `summary.json` holds: numbers in SI units, with a table of their units.
    histories : tuple of HistoryResponse
        For each load, what the joint does along the history of the study; empty without one.
    oscillators : tuple of OscillatorCurve
        For each load, the oscillator of the study over the range of the curves; empty without one.
    varying : tuple of VaryingCycles
        For each load, the cyclic quantities of the loops where the study lets the normal load vary,
        else empty; rows and curves are at constant load all the same.
    structure : StructurePrediction or None
        The bolted structure of the study: tightened state, modes, bands.
    scatter : Scatter or None
        Bands of all of these, where numbers of the study are uncertain.
    """

    study: StudyDescription
    joints: tuple[Interface, ...]
    loops: tuple[tuple[Loop, ...], ...]
    rows: tuple[AmplitudeCurve, ...]
    curves: tuple[AmplitudeCurve, ...]
    limits: tuple[Limits, ...]
    summary: dict[str, Any]
    histories: tuple[HistoryResponse, ...] = ()
    oscillators: tuple[OscillatorCurve, ...] = ()
    varying: tuple[VaryingCycles, ...] = ()
    structure: StructurePrediction | None = None
    scatter: Scatter | None = None

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
