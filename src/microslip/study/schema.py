"""Floor 8: what a study file may hold, as a tree of frozen models.

Each quantity is text with a unit in the file and an SI float here. Reading a file, and turning
what is wrong with it into one line, is the work of :mod:`microslip.study.load`.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, PrivateAttr, model_validator

from microslip.study.fields import (
    Amplitude,
    Amplitudes,
    Friction,
    Line,
    Loads,
    array,
    one_of,
    whole,
)
from microslip.study.surfaces import AnyMaterial, AnySurface, KeyedError, Part
from microslip.study.units import engineering
from microslip.study.wording import did_you_mean, quoted, show

if TYPE_CHECKING:
    from microslip.study.result import Progress, Result

SCHEMA = 1
MAX_LOOPS = 2000
MAX_POINTS = 1_000_000


class Joint(Part):
    """What presses and holds the surfaces: friction coefficient [–] and normal loads [N]."""

    friction_coefficient: Friction = Field(examples=["0.55"])
    normal_load: Loads = Field(examples=['["500 N", "2 kN"]'])


class Curve(Part):
    """Amplitudes of the curves [m], evenly spaced on a log axis."""

    start: Amplitude = Field(alias="from", examples=['"1 nm"'])
    to: Amplitude = Field(examples=['"100 um"'])
    points: Annotated[
        int, whole(f"a whole number from 2 to {MAX_POINTS}, such as 200", 2, MAX_POINTS)
    ] = 200

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if not self.start < self.to:
            start, end = (engineering(x, "m", trim=True) for x in (self.start, self.to))
            raise KeyedError("excitation.curve.to", f"wanted more than `from` ({start}), got {end}")
        return self


class Excitation(Part):
    """Displacement amplitudes of the loops and range of the curves [m]."""

    amplitudes: Amplitudes | None = None
    curve: Curve | None = None


class Output(Part):
    """What is written besides `summary.json` and the copy of the study."""

    formats: Annotated[
        tuple[Annotated[str, one_of("csv", "svg", "png")], ...],
        array('["csv", "svg", "png"]', 20),
    ] = ("csv", "svg", "png")


class Study(Part):
    """A validated description of one prediction; quantities are SI floats.

    Made from a file by :meth:`load` or from text by :meth:`from_toml`.
    """

    version: Annotated[int, whole("schema = 1", SCHEMA, SCHEMA)] = Field(
        alias="schema", examples=["1"]
    )
    title: Line = ""
    material: dict[str, AnyMaterial] = Field(
        min_length=1, examples=['{ young_modulus = "69 GPa", poisson_ratio = 0.33 }']
    )
    surface: AnySurface = Field(examples=[""])
    joint: Joint = Field(examples=[""])
    excitation: Excitation = Excitation()
    output: Output = Output()

    _name: str = PrivateAttr(default="study")
    _text: str | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _materials_exist(self) -> Self:
        for index, name in enumerate(self.surface.materials, start=1):
            if name not in self.material:
                raise KeyedError(
                    f"surface.materials, item {index}",
                    f"wanted {quoted(self.material)}, the materials of this file, "
                    f"got {show(name)}{did_you_mean(name, self.material)}",
                )
        return self

    @model_validator(mode="after")
    def _not_too_much(self) -> Self:
        loads = len(self.joint.normal_load)
        loops = loads * len(self.excitation.amplitudes or ())
        points = loads * (self.excitation.curve.points if self.excitation.curve else 0)
        if loops > MAX_LOOPS:
            raise KeyedError(
                "excitation.amplitudes",
                f"wanted at most {MAX_LOOPS} loops, got {loops} (loads times amplitudes)",
            )
        if points > MAX_POINTS:
            raise KeyedError(
                "excitation.curve.points",
                f"wanted at most {MAX_POINTS} points in all, got {points} (loads times points)",
            )
        return self

    @property
    def name(self) -> str:
        """Name of the file, or what stands for it in messages."""
        return self._name

    @property
    def text(self) -> str | None:
        """Text that the study was read from."""
        return self._text

    @classmethod
    def load(cls, path: str | Path) -> Study:
        """Read a study file (TOML).

        Parameters
        ----------
        path : str or pathlib.Path
            The file.

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

        return read(Path(path))

    @classmethod
    def from_toml(cls, text: str, name: str = "study") -> Study:
        """Read a study from TOML text.

        Parameters
        ----------
        text : str
            What would be in the file.
        name : str
            What stands for the file in messages.

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

        return parse(text, name)

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
