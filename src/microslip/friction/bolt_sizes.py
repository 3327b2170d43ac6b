"""Hexagon bolts by their size."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class BoltSize:
    """A metric bolt: pitch, bearing face of the head and medium clearance hole [m]."""

    diameter: float
    pitch: float
    head: float
    hole: float


def _size(*millimetres: float) -> BoltSize:
    return BoltSize(*(1e-3 * value for value in millimetres))


BOLTS = MappingProxyType(
    {
        "M3": _size(3, 0.5, 4.57, 3.4),
        "M4": _size(4, 0.7, 5.88, 4.5),
        "M5": _size(5, 0.8, 6.88, 5.5),
        "M6": _size(6, 1.0, 8.88, 6.6),
        "M8": _size(8, 1.25, 11.63, 9.0),
        "M10": _size(10, 1.5, 14.63, 11.0),
        "M12": _size(12, 1.75, 16.63, 13.5),
        "M14": _size(14, 2.0, 19.64, 15.5),
        "M16": _size(16, 2.0, 22.49, 17.5),
        "M20": _size(20, 2.5, 28.19, 22.0),
        "M24": _size(24, 3.0, 33.61, 26.0),
        "M30": _size(30, 3.5, 42.75, 33.0),
        "M36": _size(36, 4.0, 51.11, 39.0),
    }
)
"""Hexagon bolts by their size (ISO 4014: least bearing face; ISO 273: medium series of holes)."""
