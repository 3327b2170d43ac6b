"""Dimensions of bolts by size against a second table of the standards."""

from __future__ import annotations

import pytest

from microslip.friction.pressure import BOLTS

# Width and height of heads (ISO 4014), height of nuts (ISO 4032), width and thickness of washers
# (ISO 7089) and medium holes (ISO 273, as washers of ISO 7091 have them) [mm], as the open library
# BOLTS lists them (github.com/boltsparts/BOLTS_archive, data/hex.blt, nut.blt and washer.blt).
LISTED = {
    "M5": (8, 3.5, 4.7, 10, 1, 5.5),
    "M6": (10, 4, 5.2, 12, 1.6, 6.6),
    "M8": (13, 5.3, 6.8, 16, 1.6, 9),
    "M10": (16, 6.4, 8.4, 20, 2, 11),
    "M12": (18, 7.5, 10.8, 24, 2.5, 13.5),
    "M14": (21, 8.8, 12.8, 28, 2.5, 15.5),
    "M16": (24, 10, 14.8, 30, 3, 17.5),
    "M20": (30, 12.5, 18, 37, 3, 22),
}


@pytest.mark.parametrize("size", LISTED)
def test_dimensions_are_those_of_the_standards(size: str) -> None:
    bolt, (width, head, nut, washer, thick, hole) = BOLTS[size], LISTED[size]
    found = bolt.flats, bolt.heights, bolt.washer, bolt.washer_thickness, bolt.hole
    expected = [1e-3 * value for value in (width, head + nut, washer, thick, hole)]
    assert found == pytest.approx(expected, rel=1e-12)
