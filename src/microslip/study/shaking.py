"""A structure of a study under a force, on a shaker, in noise, under shocks; its geometry."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import ACCELERATION, FORCE, FREQUENCY, TIME
from microslip.structures.base_motion import ControlOf
from microslip.structures.geometry import geometry
from microslip.study.fields import (
    FILE,
    LENGTH,
    LINE,
    LOAD,
    PLACE,
    column_values,
    number,
    one_of,
    quantity,
    whole_number,
)
from microslip.study.part import Part, Table, key
from microslip.study.readers import Items, KeyedError, Place

_LEVELS = Items(quantity(ACCELERATION, "5 m/s^2"), '["5 m/s^2", "20 m/s^2"]', (1, 20), single=True)
_HERTZ = quantity(FREQUENCY, "150 Hz")
_COORDINATE, _FORCE = PLACE, quantity(FORCE, "2 N", "any")
Axis = Literal["x", "y", "z"]
MOST_FORCES = 10


class ForcePart(Part):
    """A harmonic force on the structure and the response near each mode."""

    amplitude: tuple[float, ...] = key(
        Items(LOAD, '["1 N", "5 N"]', (1, MOST_FORCES), single=True),
        "Amplitude of the force, or several of them.",
        '"5 N"',
    )
    at: tuple[float, float, float] | None = key(
        Items(PLACE, '["0.3 m", "0 m", "0 m"]', (3, 3)),
        "Point of application, from the middle of the lap: along, across, upwards; at the sensor "
        "unless given.",
        default=None,
    )
    direction: str | None = key(
        one_of("x", "y", "z"),
        "Direction: along (x), across (y) or upwards (z); that of the sensor unless given.",
        default=None,
    )


class _Shaken(Part):
    """Keys of a moving ground."""

    direction: Axis = key(
        one_of("x", "y", "z"), "Direction in which the ground moves.", '"z"', default="z"
    )


class BasePart(_Shaken):
    """Sines of the ground, as a shaker table makes them, stepped through the first mode."""

    acceleration: tuple[float, ...] = key(
        _LEVELS, "Levels, a sweep each: of the ground, or of the sensor where that is controlled."
    )
    control: ControlOf = key(
        one_of("base", "response"),
        "Quantity controlled along a sweep: the acceleration of the ground (base), or the absolute "
        "acceleration of the sensor (response), where the resonance does not fold over.",
        default="base",
    )
    frequencies: tuple[float, float] | None = key(
        Items(_HERTZ, '["150 Hz", "200 Hz"]', (2, 2)),
        "Range of the sweep; 10 % about the first mode unless given.",
        default=None,
    )
    points: int = key(whole_number(5, 500, "60"), "How many frequencies.", default=60)

    def check(self, place: Place) -> None:
        """Refuse values that do not rise."""
        if self.frequencies is not None and not self.frequencies[0] < self.frequencies[1]:
            raise KeyedError(".frequencies", "wanted the lower one first, and another one")


class RandomPart(_Shaken):
    """Noise of the ground by its power spectral density, straight between points."""

    frequencies: tuple[float, ...] = key(
        Items(_HERTZ, '["20 Hz", "2 kHz"]', (2, 1000)), "Frequencies of the points, rising."
    )
    levels: tuple[float, ...] = key(
        Items(number("0.5", least=0.0), "[0.5, 0.5]", (2, 1000)),
        "Levels there, one-sided, in (m/s^2)^2/Hz.",
    )
    duration: float = key(
        quantity(TIME, "60 s"), "Duration of the noise, for the expected peaks.", default=60.0
    )
    modes: int = key(
        whole_number(1, 10, "2"),
        "Number of modes with nonlinear joints; others are linear.",
        default=2,
    )

    def check(self, place: Place) -> None:
        """A level each, over rising frequencies."""
        if len(self.levels) != len(self.frequencies):
            raise KeyedError(
                ".levels",
                f"wanted one a frequency, {len(self.frequencies)} of them, got {len(self.levels)}",
            )
        if (np.diff(self.frequencies) <= 0.0).any():
            raise KeyedError(".frequencies", "wanted rising frequencies")
        if not any(self.levels):
            raise KeyedError(".levels", "wanted some level above zero")


class ShockPart(_Shaken):
    """Half-sine pulses of the ground, as shock tests have them (IEC 60068-2-27)."""

    acceleration: tuple[float, ...] = key(_LEVELS, "Severities: the peak of each pulse.")
    duration: float = key(quantity(TIME, "11 ms"), "Duration of the pulses.")


class CoordinatePart(Part):
    """A place whose displacement says how far a thin part bends."""

    at: tuple[float, float, float] = key(
        Items(PLACE, '["0 mm", "0 mm", "0.75 mm"]', (3, 3)),
        "Its place from the middle of the lap: along, across, upwards.",
    )
    direction: Axis = key(one_of("x", "y", "z"), "Direction.", '"z"', default="z")
    displacement: str = key(LINE, "Column of its displacements.", '"u"', default="u")
    force: str = key(LINE, "Column of the forces that hold it there.", '"F"', default="F")


class GeometryPart(Part):
    """Thin, curved parts that stiffen or soften as they bend: drawn, or by cases of a solver."""

    file: str | None = key(FILE, example='"cases.csv"', default=None)
    coordinates: tuple[CoordinatePart, ...] = key(
        Items(Table(CoordinatePart), '[{ at = ["0 mm", "0 mm", "0.75 mm"] }]', (1, 6)),
        "Places that are moved in the cases of a file, all others free.",
        default=(),
    )
    reach: float | None = key(
        LENGTH,
        "Largest bending of the middle of a drawn part, where there is no file; 1.5 of its "
        "thicknesses unless given.",
        '"2 mm"',
        default=None,
    )
    _cases: tuple[Floats, Floats]

    def check(self, place: Place) -> None:
        """Read the cases, and see that they tell one potential."""
        if (self.file is None) != (not self.coordinates):
            raise KeyedError(
                ".coordinates" if self.file else ".file",
                "wanted both, file and coordinates, or neither for the part of a drawing between "
                "two grounds",
            )
        if self.file is None:
            return
        if self.reach is not None:
            raise KeyedError(".reach", "wanted none beside a file, whose cases say how far")
        file = self.file
        z, forces = (
            np.array([
                column_values(declared, place.at(name), file, getattr(part, name))
                for part in self.coordinates
            ]).T
            for name, declared in (("displacement", _COORDINATE), ("force", _FORCE))
        )  # fmt: skip
        geometry(np.eye(len(self.coordinates)), None, None, (z, forces), None, None)
        self._cases = z, forces

    @property
    def cases(self) -> tuple[Floats, Floats]:
        """Displacements [m] and forces [N], (cases, coordinates)."""
        return self._cases

    @property
    def sensors(self) -> dict[str, Any]:
        """Its places and directions by name."""
        return {f"bend {i}": (c.at, c.direction) for i, c in enumerate(self.coordinates, 1)}


BASE: Any = key(Table(BasePart), "Sine sweeps of the ground, as on a shaker table.", default=None)
RANDOM: Any = key(Table(RandomPart), "Random vibration of the ground.", default=None)
SHOCK: Any = key(Table(ShockPart), "Shock pulses of the ground.", default=None)
GEOMETRY: Any = key(
    Table(GeometryPart), "Geometric nonlinearity of thin or curved parts in bending.", default=None
)
EXCITED = ("base", "random", "shock")
"""Tables that want something on the ground."""


def check_ground(part: Any, grounded: bool) -> None:
    """Refuse a ground that moves and holds nothing."""
    for name in EXCITED:
        if getattr(part, name) is not None and not grounded:
            raise KeyedError(
                f".{name}", "wanted a structure on the ground: write structure.ground, or "
                "structure.mesh.ground for a mesh",
            )  # fmt: skip
