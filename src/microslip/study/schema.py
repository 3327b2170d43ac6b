"""Content of a study file, as a tree of frozen models.

Each quantity is text with a unit in the file and an SI float here. Reading a file, and telling
what is wrong with it, is the work of :mod:`microslip.study.description`.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from microslip._core.parameters import REQUIRED, parameter_of
from microslip._core.units import FORCE, LENGTH, TIME, engineering
from microslip._core.wording import shorten
from microslip.structures.oscillator import Oscillator
from microslip.study.fields import (
    AMPLITUDE,
    ANGLE,
    COLUMN,
    COLUMN_UNIT,
    FILE,
    LINE,
    LOAD,
    SHARE,
    YES_NO,
    column_values,
    key_for,
    one_of,
    quantity,
    text,
    whole_number,
)
from microslip.study.joints import ANY_JOINT
from microslip.study.metals import with_metals
from microslip.study.part import HOMES, Part, Table, homes_of, key
from microslip.study.readers import FAILED, Items, KeyedError, Named, Place
from microslip.study.structure import StructurePart
from microslip.study.surfaces import ANY_MATERIAL, ANY_SURFACE
from microslip.study.uncertain import Unsure, with_followers
from microslip.study.uncertainty import UncertaintyPart

SCHEMA = 1
MAX_POINTS = 1_000_000
MAX_HARMONIC = 10
FORMATS = ("netcdf", "csv", "svg", "png", "pdf", "uff")


class Curve(Part):
    """Amplitudes of the curves [m], evenly spaced on a log axis."""

    start: float = key(AMPLITUDE, "Smallest amplitude.", '"1 nm"', alias="from")
    to: float = key(AMPLITUDE, "Largest amplitude.", '"100 um"')
    points: int = key(
        whole_number(2, MAX_POINTS, "200"),
        "Number of amplitudes, evenly spaced on a log axis.",
        default=200,
    )

    def check(self, place: Place) -> None:
        """Refuse values that do not rise."""
        if not self.start < self.to:
            start, end = (engineering(x, "m", trim=True) for x in (self.start, self.to))
            raise KeyedError(".to", f"wanted more than `from` ({start}), got {end}")


class LoadVariation(Part):
    """A normal load that varies over each cycle, as a sine about the load of the joint."""

    rules = {"oneOf": [{"required": ["amplitude"]}, {"required": ["share"]}]}  # noqa: RUF012

    amplitude: float | None = key(
        Unsure(LOAD), "Amplitude of the load, at every load.", '"400 N"', default=None
    )
    share: float | None = key(
        Unsure(SHARE),
        "Amplitude of the load as a share of each normal load, in its place.",
        default=None,
    )
    phase: float = key(
        Unsure(ANGLE),
        "How far the load is ahead of the displacement, in its own periods.",
        default=0.0,
    )
    harmonic: int = key(
        whole_number(1, MAX_HARMONIC, "2"),
        "Periods of the load in a cycle of the displacement.",
        default=1,
    )

    def check(self, place: Place) -> None:
        """One of both sizes."""
        if (self.amplitude is None) == (self.share is None):
            came = "neither" if self.share is None else "both"
            raise ValueError(f'wanted amplitude = "400 N" or share = 0.2, one of them, got {came}')

    def share_of(self, load: float) -> float:
        """Amplitude as a share of a normal load [N]."""
        if self.amplitude is not None:
            return self.amplitude / load
        assert self.share is not None  # one of both is given
        return self.share


class LoadColumn(Part):
    """Normal loads [N] along a history, in another column of its file."""

    column: str = key(
        COLUMN,
        'Name of the column, with or without the unit of its header: "N" or "N [kN]".',
        '"load"',
        default=REQUIRED,
    )
    unit: str | None = key(
        COLUMN_UNIT,
        'Unit of the column; not needed where its header has one, "[kN]" or "(kN)".',
        '"N"',
    )


_QUANTITIES = {
    "displacement": quantity(LENGTH, "1 um", "any"),
    "force": quantity(FORCE, "100 N", "any"),
}
_LOADS = quantity(FORCE, "2 kN", "any").but(least=0.0)
_TIMES = quantity(TIME, "1 s", "any")


class History(Part):
    """A history of the joint from rest, displacements [m] or forces [N], in a CSV file."""

    file: str = key(FILE, default=REQUIRED)
    column: str = key(COLUMN, default=REQUIRED)
    unit: str | None = key(COLUMN_UNIT)
    quantity: Literal["displacement", "force"] = key(
        one_of(*_QUANTITIES), "Quantity in the column.", default="displacement"
    )
    normal_load: LoadColumn | None = key(
        Table(LoadColumn),
        "Normal loads along the history, where they are not constant.",
        default=None,
    )
    time: str | None = key(
        COLUMN,
        "Name of a column of its times, which its figure is drawn against; they decide "
        "nothing else.",
        '"t [s]"',
    )

    _values: tuple[float, ...] = ()
    _loads: tuple[float, ...] | None = None
    _times: tuple[float, ...] | None = None

    def check(self, place: Place) -> None:
        """Read the columns."""
        name = shorten(self.file, 100)
        declared = _QUANTITIES[self.quantity]
        self._values = column_values(declared, place, self.file, self.column, self.unit)
        if len(self._values) < 2:
            raise ValueError(f"{name}: wanted at least two rows, got one")
        if self.normal_load is not None:
            column, unit = self.normal_load.column, self.normal_load.unit
            here = place.at("normal_load")
            loads = here.attempt(lambda: column_values(_LOADS, here, self.file, column, unit))
            self._loads = loads
        if self.time is not None:
            time, here = self.time, place.at("time")
            times = here.attempt(lambda: column_values(_TIMES, here, self.file, time))
            if times is not FAILED and not np.all(np.diff(times) > 0.0):
                raise KeyedError(".time", f"{name}: wanted times that rise")
            self._times = times

    @property
    def values(self) -> NDArray[np.float64]:
        """The history [m], or [N] for forces, one value a sample."""
        return np.array(self._values)

    @property
    def loads(self) -> NDArray[np.float64] | None:
        """Normal loads [N], one for each value; None where the load is that of the joint."""
        return None if self._loads is None else np.array(self._loads)

    @property
    def times(self) -> NDArray[np.float64] | None:
        """Times [s], one for each value; None where there are none."""
        return None if self._times is None else np.array(self._times)


class Excitation(Part):
    """Excitation of the joint: amplitudes of loops, range of the curves, a time history."""

    rules = {"not": {"required": ["amplitudes", "force_amplitudes"]}}  # noqa: RUF012

    amplitudes: tuple[float, ...] | None = key(
        Items(Unsure(AMPLITUDE), '["0.1 um", "1 um"]', distinct=True),
        "Displacement amplitudes of the loops, one loop each at every load.",
        default=None,
    )
    force_amplitudes: tuple[float, ...] | None = key(
        Items(Unsure(quantity(FORCE, "100 N")), '["50 N", "200 N"]', distinct=True),
        "Force amplitudes of the loops, instead of displacement amplitudes.",
        default=None,
    )
    curve: Curve | None = key(
        Table(Curve),
        "Displacement amplitudes of the curves, evenly spaced on a log axis.",
        default=None,
    )
    load_variation: LoadVariation | None = key(
        Table(LoadVariation),
        "Variation of the normal load over the cycles of the loops.",
        default=None,
    )
    history: History | None = key(
        Table(History), "A history from rest, in a column of a CSV file.", default=None
    )

    @property
    def load_varies(self) -> bool:
        """Whether the normal load varies, over the cycles of the loops or along the history."""
        along = self.history is not None and self.history.normal_load is not None
        return along or self.load_variation is not None

    def extremes(self, normal_load: float) -> tuple[float, float]:
        """Smallest and largest load [N] of a joint over its cycles and the history."""
        loads = [normal_load]
        if (variation := self.load_variation) is not None:
            share = variation.share_of(normal_load)
            loads += [normal_load * (1.0 - share), normal_load * (1.0 + share)]
        if self.history is not None and (record := self.history.loads) is not None:
            loads += [float(record.min()), float(record.max())]
        return min(loads), max(loads)

    def check(self, place: Place) -> None:
        """Displacements or forces are controlled."""
        if self.amplitudes is not None and self.force_amplitudes is not None:
            raise KeyedError(
                ".force_amplitudes",
                "wanted amplitudes or force_amplitudes, got both; remove one",
            )
        if self.force_amplitudes is not None and self.load_variation is not None:
            raise KeyedError(
                ".load_variation",
                "wanted with displacement amplitudes, got force_amplitudes; remove one "
                "(under force control a load that varies can make a joint ratchet: no closed loop)",
            )


class OscillatorPart(Part):
    """A mass [kg] on a spring [N/m], held by the joint as well; viscous damping ratio [–]."""

    mass: float = key_for(parameter_of(Oscillator, "mass"))
    stiffness: float = key_for(parameter_of(Oscillator, "stiffness"))
    viscous_damping_ratio: float = key_for(parameter_of(Oscillator, "viscous_damping_ratio"))


class Output(Part):
    """Files written besides `summary.json` and the copy of the study."""

    formats: tuple[str, ...] = key(
        Items(one_of(*FORMATS), '["netcdf", "csv", "svg"]', (1, 20), distinct=True),
        "Formats of the files; PNG, PDF, and UFF of the responses to structure.force, only on "
        "request.",
        default=FORMATS[:3],
    )
    report: bool = key(
        YES_NO, "Whether a page with all results, report.html, is written.", default=True
    )


class StudyTables(Part):
    """A validated description of one prediction; quantities are SI floats."""

    version: int = key(
        whole_number(SCHEMA, SCHEMA, noun="schema = 1"),
        "Version of this format: 1.",
        "1",
        alias="schema",
    )
    title: str = key(LINE, "Title of figures, tables and the report; one line.", default="")
    not_identified: tuple[str, ...] | None = key(
        Items(text("a key", "surface.radius"), '["surface.radius"]', (1, 20), single=True),
        "Keys whose values the loops did not determine, as `microslip identify` writes them: "
        "they are flagged until they are known.",
        default=None,
    )
    material: dict[str, Any] = key(
        Named(ANY_MATERIAL, '{ mine = { young_modulus = "69 GPa", poisson_ratio = 0.33 } }'),
        "Materials by names of your own. A metal of the table needs no entry; where "
        "it has one, the keys given win.",
        default={},
    )
    surface: Any = key(
        ANY_SURFACE,
        "The two bodies and their contact; only for the law interface.",
        default=None,
    )
    joint: Any = key(ANY_JOINT, "Friction and load, or a friction law by its own parameters.")
    excitation: Excitation = key(
        Table(Excitation), "Amplitudes, curves and histories.", default=Excitation()
    )
    oscillator: OscillatorPart | None = key(
        Table(OscillatorPart), "A mass held by a spring and by the joint.", default=None
    )
    structure: StructurePart | None = key(
        Table(StructurePart), "A bolted structure that the surface holds together.", default=None
    )
    uncertainty: UncertaintyPart | None = key(
        Table(UncertaintyPart),
        "Sampling of the uncertain inputs.",
        default=None,
    )
    output: Output = key(Table(Output), "What is written.", default=Output())

    @classmethod
    def prepare(cls, raw: dict[str, Any], place: Place) -> dict[str, Any]:
        """Metals of the table, and numbers that follow others, are put in."""
        return with_followers(with_metals(raw, place.reading))


HOMES.extend(homes_of(StudyTables))
