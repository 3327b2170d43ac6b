"""The harmonic force on a structure of a study."""

from __future__ import annotations

from microslip.study.fields import LOAD, PLACE, one_of
from microslip.study.part import Part, key
from microslip.study.readers import Items

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
        "Where it pushes, from the middle of the lap: along, across, upwards; at the sensor "
        "unless given.",
        default=None,
    )
    direction: str | None = key(
        one_of("x", "y", "z"),
        "Direction: along (x), across (y) or upwards (z); that of the sensor unless given.",
        default=None,
    )
