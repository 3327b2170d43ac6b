"""Floor 10: what a study file may hold, as a tree of frozen models.

Each quantity is text with a unit in the file and an SI float here. Reading a file, and turning
what is wrong with it into one line, is the work of :mod:`microslip.study.description`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationInfo,
    model_validator,
)

from microslip._core.units import FORCE, LENGTH, TIME, Kind, engineering
from microslip._core.wording import shorten
from microslip.study import fields
from microslip.study.columns import Column, ColumnName, UnitName, text
from microslip.study.fields import array, different, integer, one_of
from microslip.study.joints import AnyJoint
from microslip.study.metals import with_metals
from microslip.study.part import KeyedError, Part, optional, required
from microslip.study.structure import StructurePart
from microslip.study.surfaces import AnyMaterial, AnySurface
from microslip.study.uncertain import with_followers
from microslip.study.uncertainty import UncertaintyPart

if TYPE_CHECKING:
    from numpy.typing import NDArray

SCHEMA = 1
MAX_POINTS = 1_000_000
MAX_HARMONIC = 10
FORMATS = ("netcdf", "csv", "svg", "png", "pdf")


class Curve(Part):
    """Amplitudes of the curves [m], evenly spaced on a log axis."""

    start: fields.Amplitude = required("Smallest amplitude.", '"1 nm"', alias="from")
    to: fields.Amplitude = required("Largest amplitude.", '"100 um"')
    points: Annotated[int, integer(2, MAX_POINTS, 200)] = optional(
        "How many amplitudes, evenly spaced on a log axis.", default=200
    )

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if not self.start < self.to:
            start, end = (engineering(x, "m", trim=True) for x in (self.start, self.to))
            raise KeyedError("excitation.curve.to", f"wanted more than `from` ({start}), got {end}")
        return self


class LoadVariation(Part):
    """A normal load that varies over each cycle, as a sine about the load of the joint."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": ["amplitude"]}, {"required": ["share"]}]}
    )

    amplitude: fields.UncertainLoad | None = optional(
        "Amplitude of the load, at every load.", '"400 N"'
    )
    share: fields.LoadShare | None = optional(
        "Amplitude of the load as a share of each normal load, in its place.", "0.2"
    )
    phase: fields.Phase = optional(
        "How far the load is ahead of the displacement, in its own periods.",
        '"90 deg"',
        default=0.0,
    )
    harmonic: Annotated[int, integer(1, MAX_HARMONIC, 2)] = optional(
        "Periods of the load in a cycle of the displacement.", default=1
    )

    @model_validator(mode="after")
    def _check_size(self) -> Self:
        if (self.amplitude is None) == (self.share is None):
            came = "neither" if self.share is None else "both"
            raise KeyedError(
                "excitation.load_variation",
                f'wanted amplitude = "400 N" or share = 0.2, one of them, got {came}',
            )
        return self

    def share_of(self, load: float) -> float:
        """Amplitude as a share of a normal load [N]."""
        if self.amplitude is not None:
            return self.amplitude / load
        assert self.share is not None  # one of both is given
        return self.share


class LoadColumn(Part):
    """Normal loads [N] along a history, in another column of its file."""

    column: ColumnName = required(
        'Name of the column, with or without the unit of its header: "N" or "N [kN]".', '"load"'
    )
    unit: UnitName | None = optional(
        'Unit of the column; not needed where its header has one, "[kN]" or "(kN)".', '"N"'
    )


class History(Column):
    """A history of the joint from rest, displacements [m] or forces [N], in a CSV file."""

    quantity: Annotated[Literal["displacement", "force"], one_of("displacement", "force")] = (
        optional("What the column holds.", default="displacement")
    )
    normal_load: LoadColumn | None = optional(
        "Normal loads along the history, where they are not constant."
    )
    time: ColumnName | None = optional(
        "Name of a column of its times, which its figure is drawn against; they decide "
        "nothing else.",
        '"t [s]"',
    )

    _values: tuple[float, ...] = PrivateAttr(default=())
    _loads: tuple[float, ...] | None = PrivateAttr(default=None)
    _times: tuple[float, ...] | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        kind = LENGTH if self.quantity == "displacement" else FORCE
        self._values = self.read(kind, "any", info, "excitation.history")
        if len(self._values) < 2:
            raise ValueError(f"{shorten(self.file, 100)}: wanted at least two rows, got one")
        if self.normal_load is not None:
            self._loads = self._read_loads(self.normal_load, info)
        if self.time is not None:
            key = "excitation.history.time"
            self._times = self._column_beside(self.time, None, TIME, key, info)
            if not np.all(np.diff(self._times) > 0.0):
                raise KeyedError(key, f"{shorten(self.file, 100)}: wanted times that rise")
        return self

    def _column_beside(
        self, name: str, unit: str | None, kind: Kind, key: str, info: ValidationInfo
    ) -> tuple[float, ...]:
        """Another column of the same file."""
        try:
            return Column(file=self.file, column=name, unit=unit).read(kind, "any", info, key)
        except ValueError as error:
            raise KeyedError(key, str(error)) from None

    def _read_loads(self, column: LoadColumn, info: ValidationInfo) -> tuple[float, ...]:
        key = "excitation.history.normal_load"
        loads = self._column_beside(column.column, column.unit, FORCE, key, info)
        for row, load in enumerate(loads, start=1):
            if load < 0.0:
                raise KeyedError(
                    key,
                    f"{shorten(self.file, 100)}: wanted loads of zero or more, "
                    f"got {engineering(load, 'N', 6, trim=True)} in row {row} of the numbers",
                )
        return loads

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
    """What the joint goes through: amplitudes of loops, range of the curves, an own history."""

    model_config = ConfigDict(
        json_schema_extra={"not": {"required": ["amplitudes", "force_amplitudes"]}}
    )

    amplitudes: fields.Amplitudes | None = optional(
        "Displacement amplitudes of the loops, one loop each at every load.", '["0.1 um", "1 um"]'
    )
    force_amplitudes: fields.ForceAmplitudes | None = optional(
        "Force amplitudes of the loops, instead of displacement amplitudes.", '["50 N", "200 N"]'
    )
    curve: Curve | None = optional(
        "Displacement amplitudes of the curves, evenly spaced on a log axis."
    )
    load_variation: LoadVariation | None = optional(
        "How the normal load varies over the cycles of the loops."
    )
    history: History | None = optional("A history from rest, in a column of a CSV file.")

    @property
    def load_varies(self) -> bool:
        """Whether the normal load varies, over the cycles of the loops or along the history."""
        along = self.history is not None and self.history.normal_load is not None
        return along or self.load_variation is not None

    @model_validator(mode="after")
    def _check_amplitudes(self) -> Self:
        if self.amplitudes is not None and self.force_amplitudes is not None:
            raise KeyedError(
                "excitation.force_amplitudes",
                "wanted amplitudes or force_amplitudes, got both; remove one",
            )
        if self.force_amplitudes is not None and self.load_variation is not None:
            raise KeyedError(
                "excitation.load_variation",
                "wanted with displacement amplitudes, got force_amplitudes; remove one "
                "(under force control a load that varies can make a joint ratchet: no closed loop)",
            )
        return self


class OscillatorPart(Part):
    """A mass [kg] on a spring [N/m], held by the joint as well; viscous damping ratio [–]."""

    mass: fields.Mass = required("Mass.", '"2 kg"')
    stiffness: fields.Stiffness = required("Stiffness of the spring beside the joint.", '"1e6 N/m"')
    viscous_damping_ratio: fields.ViscousRatio = optional(
        "Damping ratio of the structure without the joint, at its frequency at rest.",
        "0.01",
        default=0.0,
    )


class Output(Part):
    """What is written besides `summary.json` and the copy of the study."""

    formats: Annotated[
        tuple[Annotated[str, one_of(*FORMATS)], ...],
        array('["netcdf", "csv", "svg"]', 20),
        AfterValidator(different),
    ] = optional("Files that are written; PNG and PDF where asked for.", default=FORMATS[:3])
    report: fields.YesOrNo = optional(
        "Whether a page with all results, report.html, is written.", default=True
    )


class StudyTables(Part):
    """A validated description of one prediction; quantities are SI floats."""

    version: Annotated[int, integer(SCHEMA, SCHEMA, words="schema = 1")] = required(
        "Version of this format: 1.", "1", alias="schema"
    )
    title: fields.Line = optional("One line for figures, tables and the report.", default="")
    not_identified: (
        Annotated[
            tuple[Annotated[str, text('a key such as "surface.radius"')], ...],
            array('["surface.radius"]', 20, single=True),
        ]
        | None
    ) = optional(
        "Keys whose numbers loops did not tell, as `microslip identify` writes them: "
        "they are asked back until they are known.",
        '["surface.radius"]',
    )
    material: dict[str, AnyMaterial] = Field(
        default_factory=dict,
        description="Materials by names of your own. A metal of the table needs no entry; where "
        "it has one, the keys given win.",
        examples=['{ mine = { young_modulus = "69 GPa", poisson_ratio = 0.33 } }'],
    )
    surface: AnySurface = optional("The two bodies and how they touch; only for the law interface.")
    joint: AnyJoint = required("Friction and load, or a friction law by its own parameters.")
    excitation: Excitation = Field(
        default_factory=Excitation, description="Amplitudes, curves and histories."
    )
    oscillator: OscillatorPart | None = optional("A mass on a spring that the joint holds, too.")
    structure: StructurePart | None = optional(
        "A bolted structure that the surface holds together."
    )
    uncertainty: UncertaintyPart | None = optional(
        "How numbers that are given with their scatter are drawn."
    )
    output: Output = Field(default_factory=Output, description="What is written.")

    @model_validator(mode="before")
    @classmethod
    def _complete(cls, raw_value: Any, info: ValidationInfo) -> Any:
        return (
            with_followers(with_metals(raw_value, info))
            if isinstance(raw_value, dict)
            else raw_value
        )
