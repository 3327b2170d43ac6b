"""Rough faces in a study: as a scan, as a drawing or as summits, alone or two together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import reduce
from typing import TYPE_CHECKING, Any, NamedTuple

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.errors import InputError
from microslip.scans.options import BREADTH, PERSSON, PROCESS, RA, RQ, RSM, RZ
from microslip.study.fields import AREA, DENSITY, MATERIALS, RADIUS, ROUGHNESS
from microslip.study.part import Part, SurfaceTable, Table, key, optional_key, tag
from microslip.study.readers import Items, KeyedError, Place
from microslip.study.scanned_surface import SCAN, Scanned, ScanSurface
from microslip.study.uncertain import Unsure

if TYPE_CHECKING:
    from microslip.friction import Verdict
    from microslip.materials import MaterialPair
    from microslip.normal import NormalLaw
    from microslip.scans import SummitStatistics, SurfaceFinish
    from microslip.scans.combination import Spread

_MOST_SCANS = 50


class RoughFace(NamedTuple):
    """Known properties of one face."""

    statistics: SummitStatistics
    origin: str
    """Source, in a sentence without its end."""
    verdicts: tuple[Verdict, ...] = ()
    """Verdicts for a joint."""
    spread: Spread | None = None
    """Scatter from scan to scan."""
    ranges: dict[str, tuple[float, float]] | None = None
    """Between what its numbers lie."""


class SummitsFace(Part):
    """A face by its summits: spread of their heights, radius [m], density [1/m^2]."""

    std: float = key(ROUGHNESS, "Standard deviation of the summit heights.", '"0.4 um"')
    radius: float = key(RADIUS, "One over the mean curvature of the summits.", '"20 um"')
    density: float = key(DENSITY, "Summits per area.", '"3000 1/mm^2"')

    def face(self) -> RoughFace:
        """Its summits."""
        from microslip.scans import SummitStatistics

        return RoughFace(SummitStatistics(self.density, self.radius, self.std), "as given")


class DrawnFace(Part):
    """A face by its drawing: Ra, Rq or Rz, RSm [m], or the process that made it."""

    ra: float | None = key(Unsure(RA))
    rq: float | None = key(Unsure(RQ))
    rz: float | None = key(Unsure(RZ))
    rsm: float | None = key(Unsure(RSM))
    process: str | None = key(PROCESS)
    breadth: float | None = key(BREADTH)

    def check(self, place: Place) -> None:
        """Refuse values that no drawing has."""
        try:
            _ = self.finish
        except InputError as error:
            if error.argument is None:  # of the height there is too little or too much
                raise KeyedError(".ra", str(error)) from None
            raise

    @property
    def finish(self) -> SurfaceFinish:
        """Surface of the drawing."""
        from microslip.scans import SurfaceFinish

        return SurfaceFinish(**{name: getattr(self, name) for name in DrawnFace.keys})

    def face(self) -> RoughFace:
        """Summits in the middle of the ranges."""
        finish = self.finish
        origin = f"by its drawing, within {self._range_texts(finish.ranges)}"
        return RoughFace(finish.statistics, origin, ranges=finish.ranges)

    def _range_texts(self, ranges: Mapping[str, tuple[float, float]]) -> str:
        entries = []
        for name, (low, high) in ranges.items():
            ends = [
                f"{significant(1e-6 * x)} 1/mm^2"
                if name == "density"
                else engineering(x, "m").replace("µ", "u")
                for x in (low, high)
            ]
            entries.append(f'{name} = {{ low = "{ends[0]}", high = "{ends[1]}" }}')
        return ", ".join(entries)


class ScannedFace(Scanned):
    """A face by one scan or several of it, at one cut-off."""

    scan: tuple[str, ...] = key(
        Items(SCAN, '["ground1.plu", "ground2.plu"]', (1, _MOST_SCANS), single=True),
        "Scan of the face, or several of it, which are averaged; relative to the "
        "folder of the study.",
    )

    _scans: tuple[ScanSurface, ...] = ()

    def check(self, place: Place) -> None:
        """Read the scans."""
        if self.estimate in ("population", PERSSON):
            raise KeyedError(
                ".estimate", f'wanted one radius for all summits, got "{self.estimate}"'
            )
        # A profile has no area, and the joint has its own.
        usual = {name: item.default for name, item in ScanSurface.keys.items()}
        values = {name: getattr(self, name) for name in self.keys}
        scans = []
        for name in self.scan:
            scan = ScanSurface.__new__(ScanSurface)
            scan.__dict__.update(usual, **values, law="scan", materials=("", ""), area=1e-6)
            scan.__dict__["scan"] = name
            scan.check(place)
            scans.append(scan)
        self._scans = tuple(scans)

    def face(self) -> RoughFace:
        """Summits of all scans together, and how much they differ."""
        from microslip.scans import average

        statistics, spread = average([
            scan._of_profile() if scan.read_scan.is_profile
            else scan.summits.statistics(scan.estimate)  # type: ignore[arg-type]
            for scan in self._scans
        ])  # fmt: skip
        if len(self._scans) == 1:
            return RoughFace(statistics, f"by {shorten(self.scan[0], 100)}", self.verdicts())
        scatter = ", ".join(
            f"{name} {100.0 * value:.2g} %"
            for name, value in zip(spread._fields, spread, strict=True)
        )
        origin = f"by {len(self._scans)} scans, which scatter by {scatter} (standard deviation)"
        return RoughFace(statistics, origin, self.verdicts(), spread)

    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts on the faces as inputs of a joint."""
        return tuple(verdict for scan in self._scans for verdict in scan.verdicts())


FACES = (ScannedFace, DrawnFace, SummitsFace)
"""Ways to describe a face."""


def _kind(raw: Any) -> str:
    """Way in which the face is described; without keys, what summits need."""
    if "scan" in raw:
        return ScannedFace.__name__
    return (DrawnFace if raw.keys() & DrawnFace.keys else SummitsFace).__name__


AnyFace = ScannedFace | DrawnFace | SummitsFace
_ANY_FACE = Table(*FACES, tell=_kind)


class FacedSurface(SurfaceTable):
    """A surface of rough faces, as summits against a flat."""

    materials: tuple[str, str] = MATERIALS
    area: float = key(AREA, "Apparent area.")

    _faces: dict[str, RoughFace] | None = None

    def face_tables(self) -> dict[str, AnyFace]:
        """Tables of the faces, by their keys."""
        raise NotImplementedError

    @property
    def faces(self) -> dict[str, RoughFace]:
        """Known properties of each face; found once."""
        if self._faces is None:
            self._faces = {key: part.face() for key, part in self.face_tables().items()}
        return self._faces

    @property
    def statistics(self) -> SummitStatistics:
        """Summits of the one surface that meets a flat as the faces meet each other."""
        from microslip.scans import combine

        return reduce(combine, (face.statistics for face in self.faces.values()))

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Normal law of the summits."""
        return self.statistics.to_surface(pair, self.area)

    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts on the faces as inputs of a joint."""
        return tuple(verdict for face in self.faces.values() for verdict in face.verdicts)

    def sentences(self) -> list[str]:
        """Sources of the summits."""
        sentences = [
            f"surface{key}: {face.statistics}, {face.origin}." for key, face in self.faces.items()
        ]
        if len(sentences) > 1:
            sentences.append(
                f"surface: both faces together {self.statistics}: their spectral moments add "
                "(Greenwood 1984), as of independent isotropic Gaussian faces."
            )
        return sentences

    @property
    def law_name(self) -> str:
        """Name of the normal law of the summits."""
        return "greenwood-williamson"

    def findings(self) -> dict[str, Any]:
        """Known properties of the faces, in SI units."""
        faces = {
            key.lstrip(".") or "face": {
                **asdict(face.statistics),
                **({"scatter": face.spread._asdict()} if face.spread else {}),
                **({"ranges": face.ranges} if face.ranges else {}),
            }
            for key, face in self.faces.items()
        }
        summits = {"together": asdict(self.statistics)} if len(faces) > 1 else {}
        return {"faces": {**faces, **summits}}


class TwoFaces(FacedSurface):
    """Two rough faces on each other, or one on a smooth one, by scans, a drawing or summits."""

    law: str = tag("two-faces", "Two rough faces on each other.")
    first: AnyFace = key(
        _ANY_FACE,
        "The face of the first body: { scan, cutoff, … }, { ra, rsm, process } or "
        "{ std, radius, density }.",
        '{ ra = "0.8 um", rsm = "60 um" }',
    )
    second: AnyFace | None = optional_key(
        _ANY_FACE,
        "The face of the second body, likewise; smooth if absent.",
        '{ std = "0.4 um", radius = "20 um", density = "3000 1/mm^2" }',
    )

    def face_tables(self) -> dict[str, AnyFace]:
        """The two, or the one that is rough."""
        return {".first": self.first, **({".second": self.second} if self.second else {})}


class DrawnSurface(DrawnFace, FacedSurface):
    """A rough face by its drawing on a smooth one: Ra, Rq or Rz, RSm, or a process."""

    law: str = tag("drawing", "A face by its drawing on a smooth one.")

    def face_tables(self) -> dict[str, AnyFace]:
        """Itself."""
        return {"": self}
