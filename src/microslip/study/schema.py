"""Tables of a study file, as a tree of immutable objects.

A quantity is text with a unit in the file and an SI float here. Files are read, and errors are
raised, by :mod:`microslip.study.description`.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from microslip._core.frozen import lock
from microslip._core.units import FORCE, LENGTH, engineering
from microslip._core.wording import shorten
from microslip.study.fields import (
    AMPLITUDE,
    COLUMN,
    COLUMN_UNIT,
    FILE,
    LINE,
    YES_NO,
    column_values,
    integer,
    one_of,
    scalar,
    with_unit,
)
from microslip.study.joints import ANY_JOINT
from microslip.study.part import LOCATED_TABLES, Part, SubTable, key, located_tables, optional_key
from microslip.study.readers import KeyedError, ListOf, NamedValues, Place
from microslip.study.structure import StructurePart
from microslip.study.surfaces import ANY_MATERIAL, ANY_SURFACE
from microslip.study.uncertain import Uncertain

_MOST_SAMPLES = 65_536
GROUPS = 8
"""Number of independent scramblings; their differences give the error of a quantile."""


class UncertaintyPart(Part):
    """Sampling of the uncertain inputs, and the quantiles that are reported."""

    samples: int = key(
        integer(64, _MOST_SAMPLES, "512"),
        "Number of samples, rounded up to eight times a power of two.",
        default=512,
    )
    seed: int = key(
        integer(0, 2**32 - 1, noun="a whole number of at least 0"),
        "Seed of the scrambling; the same seed gives the same results.",
        default=0,
    )
    quantiles: tuple[float, ...] = key(
        ListOf(scalar("0.05", above=0.0, below=1.0), "[0.05, 0.5, 0.95]", (1, 9), distinct=True),
        "Quantiles of the bands.",
        default=(0.05, 0.5, 0.95),
    )

    def check(self, place: Place) -> None:
        """Sort the quantiles."""
        self.__dict__["quantiles"] = tuple(sorted(self.quantiles))


_SCHEMA = 1
_MAX_POINTS = 1_000_000
_FORMATS = ("netcdf", "csv", "svg", "png", "pdf")


class CurveRange(Part):
    """Amplitudes of the curves [m], evenly spaced on a log axis."""

    start: float = key(AMPLITUDE, "Smallest amplitude.", '"1 nm"', alias="from")
    to: float = key(AMPLITUDE, "Largest amplitude.", '"100 um"')
    points: int = key(
        integer(2, _MAX_POINTS, "200"),
        "Number of amplitudes, evenly spaced on a log axis.",
        default=200,
    )

    def check(self, place: Place) -> None:
        """Raise an error for a range whose end is not above its start."""
        if not self.start < self.to:
            start, end = (engineering(x, "m", trim=True) for x in (self.start, self.to))
            raise KeyedError(".to", f"wanted more than `from` ({start}), got {end}")


_QUANTITIES = {
    "displacement": with_unit(LENGTH, "1 um", "any"),
    "force": with_unit(FORCE, "100 N", "any"),
}


class History(Part):
    """History of displacements [m] or forces [N] of the joint from rest, in a CSV file."""

    file: str = key(FILE)
    column: str = key(COLUMN)
    unit: str | None = key(COLUMN_UNIT)
    quantity: Literal["displacement", "force"] = key(
        one_of(*_QUANTITIES), "Quantity in the column.", default="displacement"
    )

    values: NDArray[np.float64]
    """The history [m], or [N] for forces, one value per sample."""

    def check(self, place: Place) -> None:
        """Read the column of the file."""
        declared = _QUANTITIES[self.quantity]
        values = column_values(declared, place, self.file, self.column, self.unit)
        if len(values) < 2:
            raise ValueError(f"{shorten(self.file, 100)}: wanted at least two rows, got one")
        self.keep(values=lock(np.array(values)))


class ExcitationTable(Part):
    """Excitation of the joint: amplitudes of loops, range of the curves, a time history."""

    rules = {"not": {"required": ["amplitudes", "force_amplitudes"]}}  # noqa: RUF012

    amplitudes: tuple[float, ...] | None = optional_key(
        ListOf(Uncertain(AMPLITUDE), '["0.1 um", "1 um"]', distinct=True),
        "Displacement amplitudes of the loops, one loop each at every load.",
    )
    force_amplitudes: tuple[float, ...] | None = optional_key(
        ListOf(Uncertain(with_unit(FORCE, "100 N")), '["50 N", "200 N"]', distinct=True),
        "Force amplitudes of the loops, instead of displacement amplitudes.",
    )
    curve: CurveRange | None = optional_key(
        SubTable(CurveRange),
        "Displacement amplitudes of the curves, evenly spaced on a log axis.",
    )
    history: History | None = optional_key(
        SubTable(History), "A history from rest, in a column of a CSV file."
    )

    def check(self, place: Place) -> None:
        """Reject displacement and force amplitudes that are given together."""
        if self.amplitudes is not None and self.force_amplitudes is not None:
            raise KeyedError(
                ".force_amplitudes",
                "wanted amplitudes or force_amplitudes, got both; remove one",
            )


class OutputTable(Part):
    """Files written besides `summary.json` and the copy of the study."""

    formats: tuple[str, ...] = key(
        ListOf(one_of(*_FORMATS), '["netcdf", "csv", "svg"]', (1, 20), distinct=True),
        "Formats of the files; PNG and PDF only on request.",
        default=_FORMATS[:3],
    )
    report: bool = key(YES_NO, "Also write a page with all results, report.html.", default=True)


class StudyTables(Part):
    """All tables of a study, with quantities as floats in SI units."""

    version: int = key(
        integer(_SCHEMA, _SCHEMA, noun="schema = 1"),
        "Version of this format: 1.",
        "1",
        alias="schema",
    )
    title: str = key(LINE, "Title of figures, tables and the report; one line.", default="")
    material: dict[str, Any] = key(
        NamedValues(ANY_MATERIAL, '{ mine = { young_modulus = "69 GPa", poisson_ratio = 0.33 } }'),
        "Materials by name. Metals of `microslip materials` need no entry; an entry "
        "overrides the values of the metal.",
        default={},
    )
    surface: Any = key(
        ANY_SURFACE,
        "The two bodies and their contact; absent if joint.law_file is given.",
        default=None,
    )
    joint: Any = key(ANY_JOINT, "Friction and normal load, or the file of a friction law.")
    excitation: ExcitationTable = key(
        SubTable(ExcitationTable), "Amplitudes, curves and histories.", default=ExcitationTable.of()
    )
    structure: StructurePart | None = optional_key(
        SubTable(StructurePart), "A bolted structure whose contact faces have this surface."
    )
    uncertainty: UncertaintyPart | None = optional_key(
        SubTable(UncertaintyPart), "Sampling of the uncertain inputs."
    )
    output: OutputTable = key(SubTable(OutputTable), "Output files.", default=OutputTable.of())


LOCATED_TABLES.extend(located_tables(StudyTables))
