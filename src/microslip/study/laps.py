"""Several laps of a drawing in a study, its ground, and parts of different materials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from microslip.errors import InputError
from microslip.structures.beam_mesh import Lap
from microslip.structures.bolted_beam import GROUNDS, BoltedBeam, Drawing
from microslip.structures.bolts import Bolts
from microslip.structures.lap_joint import LapJoint
from microslip.structures.mesh import slack_bolts
from microslip.study.fields import LENGTH, LINE, MASS_DENSITY, PLACE, one_of, whole_number
from microslip.study.metals import unknown
from microslip.study.part import Part, Table, key
from microslip.study.readers import Items, KeyedError, Place

MOST_LAPS, MOST_BOLTS = 10, 200
DRAWING_KEYS = ("length", "width", "thickness", "lap")


class LapPart(Part):
    """One of several laps: where it lies, how long it is, and where its bolts are."""

    at: float = key(PLACE, "Its middle, from the middle of the beam.", '"-200 mm"')
    length: float = key(LENGTH, "Length of the overlap.", '"60 mm"')
    positions: tuple[float, ...] = key(
        Items(PLACE, '["-15 mm", "15 mm"]', (1, MOST_BOLTS), single=True),
        "Places of its bolts along it, from its middle.",
    )
    across: tuple[float, ...] | None = key(
        Items(PLACE, '["0 mm", "0 mm"]', (1, MOST_BOLTS), single=True),
        "Places across, one a bolt; all in the middle unless given.",
        default=None,
    )

    def check(self, place: Place) -> None:
        """One place across for each along."""
        check_places(self.positions, self.across)


LAPS = key(
    Items(
        Table(LapPart),
        '[{ at = "-80 mm", length = "30 mm", positions = "0 mm" }]',
        (1, MOST_LAPS),
    ),
    "Several laps from left to right, in place of `lap` and the bolts' positions.",
    default=(),
)
GROUND = key(
    Items(one_of(*GROUNDS), '["left"]', (1, 2), single=True, distinct=True),
    "Ends that a lap bolts to rigid ground.",
    default=(),
)
MATERIALS_OF_PARTS = key(
    Items(LINE, '["steel", "aluminium", "steel"]', (1, MOST_LAPS + 1)),
    "Material of each part from left to right; the first of the surface unless given.",
    default=(),
)
DENSITIES_OF_PARTS = key(
    Items(MASS_DENSITY, '["7850 kg/m^3", "2700 kg/m^3"]', (1, MOST_LAPS + 1)),
    "Mass density of each part from left to right; `density` unless given.",
    default=(),
)
SLACK = key(
    Items(whole_number(1, MOST_BOLTS, "3"), "[3]", (1, MOST_BOLTS), single=True, distinct=True),
    "Slack bolts, counted from 1 along the laps; the report compares with all tight.",
    default=(),
)

ORDER = key(
    Items(whole_number(1, MOST_BOLTS, "2"), "[2, 1, 3]", (1, MOST_BOLTS), distinct=True),
    "Order in which the bolts that are not slack are tightened, with friction in the faces; all "
    "at once and without, unless given.",
    default=(),
)
PASSES = key(whole_number(1, 20, "2"), "Number of rounds in that order.", default=1)


def check_bolts(slack: Sequence[int], order: Sequence[int], count: int) -> None:
    """Refuse numbers of bolts that are not there, or not in order."""
    try:
        tight_ones = set(range(count)) - set(slack_bolts(slack, count))
    except InputError as error:
        raise KeyedError(".bolts.slack", str(error)) from None
    if order and {number - 1 for number in order} != tight_ones:
        listed = ", ".join(str(number + 1) for number in sorted(tight_ones))
        raise KeyedError(".bolts.order", f"wanted each of the tight bolts {listed}, got {order}")


def check_places(along: Sequence[float] | None, across: Sequence[float] | None) -> None:
    """Refuse places across that do not go with those along."""
    if across is not None and len(across) != len(along or ()):
        raise KeyedError(
            ".across",
            f"wanted one place a bolt, {len(along or ())} of them, got {len(across)}",
        )


def needed(part: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Keys of a drawing and of its bolts that must be there; others beside laps must not."""
    bolts: tuple[str, ...] = ("shank", "hole", "washer")
    sizes = ("length", "width", "thickness") if part.laps else DRAWING_KEYS
    if not part.densities:
        sizes = (*sizes, "density")
    if not part.laps:
        return sizes, ("positions", *bolts)
    beside = {".lap": part.lap}
    beside |= {f".bolts.{name}": getattr(part.bolts, name) for name in ("positions", "across")}
    for where, value in beside.items():
        if value is not None:
            raise KeyedError(where, "wanted none beside structure.laps, which have it one by one")
    if part.sensor is None and "right" in part.ground:
        raise KeyedError(".sensor", "missing; the right end lies on the ground")
    return sizes, bolts


def _bolts(part: Any, places: Sequence[float], across: Sequence[float] | None) -> Bolts:
    sizes: dict[str, Any] = {
        name: getattr(part, name)
        for name in part.keys
        if name in Bolts.__dataclass_fields__ and name != "positions"
    }
    where = places if across is None else np.stack([places, across], axis=1)
    return Bolts(where, **{k: v for k, v in sizes.items() if v is not None})


def beam_of(part: Any) -> Drawing:
    """The beam of a drawing: one lap in the middle, or several."""
    sizes: dict[str, Any] = {name: getattr(part, name) for name in DRAWING_KEYS}
    if not part.laps:
        if part.ground:
            raise KeyedError(".ground", "wanted structure.laps beside it, which say where they lie")
        if part.rise:
            raise KeyedError(".rise", "wanted structure.laps beside it: it is of parts between two")
        places = part.bolts.positions or ()
        bolts = _bolts(part.bolts, places, part.bolts.across)
        return LapJoint(**sizes, bolts=bolts, style=part.style)
    del sizes["lap"]
    laps = [
        Lap(lap.at, lap.length, _bolts(part.bolts, lap.positions, lap.across)) for lap in part.laps
    ]
    return BoltedBeam(
        **sizes, laps=laps, style=part.style, ground=part.ground, rise=part.rise or 0.0
    )


def check_materials(part: Any, materials: Mapping[str, Any]) -> None:
    """See that a study describes what the parts are made of."""
    for item, name in enumerate(part.materials, start=1):
        if name not in materials:
            raise KeyedError(f"structure.materials, item {item}", unknown(name, materials))
