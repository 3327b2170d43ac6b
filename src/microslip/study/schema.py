"""Floor 8: what a study file may hold, as a tree of frozen models.

Each quantity is text with a unit in the file and an SI float here. Reading a file, and turning
what is wrong with it into one line, is the work of :mod:`microslip.study.load`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
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

from microslip.study.columns import Column
from microslip.study.fields import (
    Amplitude,
    Amplitudes,
    ForceAmplitudes,
    Friction,
    Line,
    Loads,
    Mass,
    Stiffness,
    ViscousRatio,
    YesOrNo,
    array,
    different,
    one_of,
    whole,
)
from microslip.study.metals import with_metals
from microslip.study.part import KeyedError, Part
from microslip.study.sense import check
from microslip.study.surfaces import AnyMaterial, AnySurface
from microslip.study.units import FORCE, LENGTH, engineering
from microslip.study.wording import shorten

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from microslip.study.result import Progress, Result

SCHEMA = 1
MAX_POINTS = 1_000_000
FORMATS = ("netcdf", "csv", "svg", "png")


class Joint(Part):
    """What presses and holds the surfaces: friction coefficient [–] and normal loads [N]."""

    friction_coefficient: Friction = Field(
        description="Coulomb's coefficient of friction, above zero.", examples=["0.55"]
    )
    normal_load: Loads = Field(
        description="One normal load or a list of different ones; one joint for each.",
        examples=['["500 N", "2 kN"]'],
    )


class Curve(Part):
    """Amplitudes of the curves [m], evenly spaced on a log axis."""

    start: Amplitude = Field(alias="from", description="Smallest amplitude.", examples=['"1 nm"'])
    to: Amplitude = Field(description="Largest amplitude.", examples=['"100 um"'])
    points: Annotated[
        int, whole(f"a whole number from 2 to {MAX_POINTS}, such as 200", 2, MAX_POINTS)
    ] = Field(default=200, description="How many amplitudes, evenly spaced on a log axis.")

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if not self.start < self.to:
            start, end = (engineering(x, "m", trim=True) for x in (self.start, self.to))
            raise KeyedError("excitation.curve.to", f"wanted more than `from` ({start}), got {end}")
        return self


class History(Column):
    """A history of the joint from rest, displacements [m] or forces [N], in a CSV file."""

    quantity: Annotated[Literal["displacement", "force"], one_of("displacement", "force")] = Field(
        default="displacement", description="What the column holds."
    )

    _values: tuple[float, ...] = PrivateAttr(default=())

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        kind = LENGTH if self.quantity == "displacement" else FORCE
        self._values = self.read(kind, "any", info, "excitation.history")
        if len(self._values) < 2:
            raise ValueError(f"{shorten(self.file, 100)}: wanted at least two rows, got one")
        return self

    @property
    def values(self) -> NDArray[np.float64]:
        """The history [m], or [N] for forces, one value a sample."""
        return np.array(self._values)


class Excitation(Part):
    """What the joint goes through: amplitudes of loops, range of the curves, an own history."""

    model_config = ConfigDict(
        json_schema_extra={"not": {"required": ["amplitudes", "force_amplitudes"]}}
    )

    amplitudes: Amplitudes | None = Field(
        default=None,
        description="Displacement amplitudes of the loops, one loop each at every load.",
        examples=['["0.1 um", "1 um"]'],
    )
    force_amplitudes: ForceAmplitudes | None = Field(
        default=None,
        description="Force amplitudes of the loops, instead of displacement amplitudes.",
        examples=['["50 N", "200 N"]'],
    )
    curve: Curve | None = Field(
        default=None,
        description="Displacement amplitudes of the curves, evenly spaced on a log axis.",
    )
    history: History | None = Field(
        default=None, description="A history from rest, in a column of a CSV file."
    )

    @model_validator(mode="after")
    def _one_kind_of_amplitudes(self) -> Self:
        if self.amplitudes is not None and self.force_amplitudes is not None:
            raise KeyedError(
                "excitation.force_amplitudes",
                "wanted amplitudes or force_amplitudes, got both; remove one",
            )
        return self


class OscillatorPart(Part):
    """A mass [kg] on a spring [N/m], held by the joint as well; viscous damping ratio [–]."""

    mass: Mass = Field(description="Mass.", examples=['"2 kg"'])
    stiffness: Stiffness = Field(
        description="Stiffness of the spring beside the joint.", examples=['"1e6 N/m"']
    )
    viscous_damping_ratio: ViscousRatio = Field(
        default=0.0,
        description="Damping ratio of the structure without the joint, at its frequency at rest.",
        examples=["0.01"],
    )


class Output(Part):
    """What is written besides `summary.json` and the copy of the study."""

    formats: Annotated[
        tuple[Annotated[str, one_of(*FORMATS)], ...],
        array('["netcdf", "csv", "svg", "png"]', 20),
        AfterValidator(different),
    ] = Field(default=FORMATS, description="Files that are written.")
    report: YesOrNo = Field(
        default=True, description="Whether a page with all results, report.html, is written."
    )


class Study(Part):
    """A validated description of one prediction; quantities are SI floats.

    Made from a file by :meth:`load`, from text by :meth:`from_toml`, or in Python with the keys
    of the file and quantities as text, ``Study(schema=1, surface={"radius": "1 mm", …}, …)``.

    Raises
    ------
    StudyError
        If it is no study; one line with key, what came and what was wanted.
    """

    version: Annotated[int, whole("schema = 1", SCHEMA, SCHEMA)] = Field(
        alias="schema", description="Version of this format: 1.", examples=["1"]
    )
    title: Line = Field(default="", description="One line for figures, tables and the report.")
    material: dict[str, AnyMaterial] = Field(
        default_factory=dict,
        description="Materials by names of your own. A metal of the table needs no entry; where "
        "it has one, the keys given win.",
        examples=['{ mine = { young_modulus = "69 GPa", poisson_ratio = 0.33 } }'],
    )
    surface: AnySurface = Field(description="The two bodies and how they touch.", examples=[""])
    joint: Joint = Field(description="Friction and load.", examples=[""])
    excitation: Excitation = Field(
        default_factory=Excitation, description="Amplitudes, curves and histories."
    )
    oscillator: OscillatorPart | None = Field(
        default=None, description="A mass on a spring that the joint holds, too."
    )
    output: Output = Field(default_factory=Output, description="What is written.")

    _name: str = PrivateAttr(default="study")
    _text: str | None = PrivateAttr(default=None)
    _given: dict[str, Any] = PrivateAttr(default_factory=dict)
    _notes: tuple[str, ...] = PrivateAttr(default=())

    def __init__(self, /, **given: Any) -> None:
        from microslip.study.load import fill

        fill(self, given)

    @model_validator(mode="before")
    @classmethod
    def _metals(cls, given: Any, info: ValidationInfo) -> Any:
        return with_metals(given, info) if isinstance(given, dict) else given

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        check(self)
        return self

    @property
    def name(self) -> str:
        """Name of the file, or what stands for it in messages."""
        return self._name

    @property
    def text(self) -> str:
        """TOML text of the study: as it was read, overrides applied; comments are kept."""
        if self._text is None:
            from microslip.study.overrides import dump

            self._text = dump(self._given)
        return self._text

    @property
    def notes(self) -> tuple[str, ...]:
        """What was taken from elsewhere: table values and their sources, files, overrides."""
        return self._notes

    @classmethod
    def load(cls, path: str | Path, overrides: Sequence[str] = ()) -> Study:
        """Read a study file (TOML).

        Parameters
        ----------
        path : str or pathlib.Path
            The file. Files that it names are relative to its folder.
        overrides : sequence of str
            Keys and their values in place of those in the file, such as
            ``'joint.normal_load="3 kN"'``. The value is TOML; what is not TOML is text.

        Returns
        -------
        Study
            The validated study, in SI units.

        Raises
        ------
        StudyError
            If the file cannot be read or is not a study; one line with file, key, what came and
            what was wanted.
        """
        from microslip.study.load import read

        return read(Path(path), overrides)

    @classmethod
    def from_toml(
        cls,
        text: str,
        name: str = "study",
        overrides: Sequence[str] = (),
        folder: str | Path | None = None,
    ) -> Study:
        """Read a study from TOML text.

        Parameters
        ----------
        text : str
            What would be in the file.
        name : str
            What stands for the file in messages.
        overrides : sequence of str
            As in :meth:`load`.
        folder : str or pathlib.Path, optional
            Folder of the files that the study names; by default the current one.

        Returns
        -------
        Study
            The validated study, in SI units.

        Raises
        ------
        StudyError
            If the text is not a study.
        """
        from microslip.study.load import parse

        return parse(text, name, overrides, None if folder is None else Path(folder))

    def run(self, progress: Progress | None = None) -> Result:
        """Compute every loop and curve of the study.

        Parameters
        ----------
        progress : callable, optional
            Called now and then with the share that is done, 0 … 1.

        Returns
        -------
        Result
            Joints, loops, curves and the summary.

        Raises
        ------
        StudyError
            If the physics has no answer, such as a load that the surface cannot carry.
        """
        from microslip.study.run import run

        return run(self, progress)
