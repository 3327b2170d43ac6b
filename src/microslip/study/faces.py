"""Floor 8: rough faces in a study: as a scan, as a drawing or as summits, alone or two together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    Discriminator,
    ModelWrapValidatorHandler,
    PrivateAttr,
    Tag,
    ValidationError,
    ValidationInfo,
    create_model,
    model_validator,
)

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.errors import InputError
from microslip.scans.options import PERSSON, PROCESS, PROCESSES, RA, RQ, RSM, RZ
from microslip.study.fields import Area, Density, Radius, Roughness, TwoNames, array, number, one_of
from microslip.study.part import KeyedError, Part, SurfaceTable, keyed, optional, required
from microslip.study.scanned_surface import ScanName, ScanSurface

if TYPE_CHECKING:
    from microslip.friction import Verdict
    from microslip.materials import MaterialPair
    from microslip.normal import NormalLaw
    from microslip.scans import SummitStatistics, SurfaceFinish
    from microslip.scans.combination import Spread

_MOST_SCANS = 50


class RoughFace(NamedTuple):
    """What is known of one face."""

    statistics: SummitStatistics
    origin: str
    """Where it is from, in a sentence without its end."""
    verdicts: tuple[Verdict, ...] = ()
    """How far that bears a joint."""
    spread: Spread | None = None
    """Scatter from scan to scan."""
    ranges: dict[str, tuple[float, float]] | None = None
    """Between what its numbers lie."""


class SummitsFace(Part):
    """A face by its summits: spread of their heights, radius [m], density [1/m^2]."""

    std: Roughness = required("Standard deviation of the summit heights.", '"0.4 um"')
    radius: Radius = required("One over the mean curvature of the summits.", '"20 um"')
    density: Density = required("Summits per area.", '"3000 1/mm^2"')

    def face(self) -> RoughFace:
        """Its summits."""
        from microslip.scans import SummitStatistics

        return RoughFace(SummitStatistics(self.density, self.radius, self.std), "as given")


class DrawnFace(Part):
    """A face by its drawing: Ra, Rq or Rz, RSm [m], or the process that made it."""

    ra: Roughness | None = optional(RA.help, RA.written)
    rq: Roughness | None = optional(RQ.help, RQ.written)
    rz: Roughness | None = optional(RZ.help, RZ.written)
    rsm: Roughness | None = optional(RSM.help, RSM.written)
    process: Annotated[str, one_of(*PROCESSES)] | None = optional(PROCESS.help, PROCESS.written)
    breadth: (
        Annotated[
            float,
            number("a number of at least 1.5 such as 10", minimum=1.5),
        ]
        | None
    ) = optional("Nayak's alpha, the breadth of the spectrum; 10 between 2 and 50 if absent.", "10")

    @model_validator(mode="after")
    def _check_drawing(self) -> Self:
        try:
            _ = self.finish
        except InputError as error:
            raise keyed(error, "", "ra") from None
        return self

    @property
    def finish(self) -> SurfaceFinish:
        """What the drawing says."""
        from microslip.scans import SurfaceFinish

        return SurfaceFinish(
            **{
                name: getattr(self, name)
                for name in DrawnFace.model_fields
                if name in _DRAWING_KEYS
            }
        )

    def face(self) -> RoughFace:
        """Summits in the middle of the ranges."""
        finish = self.finish
        origin = f"by its drawing, which leaves open {self._range_texts(finish.ranges)}"
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


_DRAWING_KEYS = ("ra", "rq", "rz", "rsm", "process", "breadth")


class _ScannedFace(Part):
    """A face by one scan or several of it, at one cut-off."""

    scan: Annotated[
        tuple[ScanName, ...], array('["ground1.plu", "ground2.plu"]', _MOST_SCANS, single=True)
    ] = required(
        "Scan of the face, or several of it, which are averaged; relative to the "
        "folder of the study.",
        '["ground1.plu", "ground2.plu"]',
    )

    _scans: tuple[ScanSurface, ...] = PrivateAttr(default=())

    @model_validator(mode="wrap")
    @classmethod
    def _read(
        cls, raw_value: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo
    ) -> Self:
        self = handler(raw_value)
        if not isinstance(raw_value, dict):
            self._scans = raw_value._scans
            return self
        if (estimate := raw_value.get("estimate")) in ("population", PERSSON):
            raise KeyedError(".estimate", f'wanted one radius for all summits, got "{estimate}"')
        # A profile has no area, and the joint has its own.
        keys = {**raw_value, "law": "scan", "materials": ("", ""), "area": "1 mm^2"}
        scans = []
        for name in self.scan:
            try:
                part = ScanSurface.model_validate({**keys, "scan": name}, context=info.context)
            except ValidationError as error:
                raise _at_the_face(error) from None
            scans.append(part)
        self._scans = tuple(scans)
        return self

    def face(self) -> RoughFace:
        """Summits of all scans together, and how much they differ."""
        from microslip.scans import average

        statistics, spread = average([_statistics(scan) for scan in self._scans])
        if len(self._scans) == 1:
            return RoughFace(statistics, f"by {shorten(self.scan[0], 100)}", self.verdicts())
        scatter = ", ".join(
            f"{name} {100.0 * value:.2g} %"
            for name, value in zip(spread._fields, spread, strict=True)
        )
        origin = f"by {len(self._scans)} scans, which scatter by {scatter} (standard deviation)"
        return RoughFace(statistics, origin, self.verdicts(), spread)

    def verdicts(self) -> tuple[Verdict, ...]:
        """How far the scans bear a joint: those of all of them."""
        return tuple(verdict for scan in self._scans for verdict in scan.verdicts())


def _at_the_face(error: ValidationError) -> Exception:
    """What is wrong with a scan, at the key of the face."""
    cause = error.errors(include_url=False)[0].get("ctx", {}).get("error")
    if isinstance(cause, KeyedError):
        return KeyedError(cause.key.removeprefix("surface"), str(cause))
    return ValueError(str(cause or error))


def _statistics(scan: ScanSurface) -> SummitStatistics:
    if scan.read_scan.is_profile:
        return scan._of_profile()
    return scan.summits.statistics(scan.estimate)  # type: ignore[arg-type]


_NOT_OF_A_FACE = ("law", "materials", "scan", "area", "heights", "direction")
ScannedFace: type[_ScannedFace] = create_model(
    "ScannedFace",
    __base__=_ScannedFace,
    __doc__=_ScannedFace.__doc__,
    __module__=__name__,
    **{  # type: ignore[call-overload]
        name: (field.annotation, field)
        for name, field in ScanSurface.model_fields.items()
        if name not in _NOT_OF_A_FACE
    },
)

FACES: dict[str, type[Part]] = {
    "scanned": ScannedFace,
    "drawn": DrawnFace,
    "summits": SummitsFace,
}
"""Ways to describe a face."""


def _kind(raw_value: Any) -> str:
    """Which way was taken; what has keys of none is told what summits need."""
    keys = (
        set(raw_value)
        if isinstance(raw_value, dict)
        else set(getattr(type(raw_value), "model_fields", ()))
    )
    if "scan" in keys:
        return "scanned"
    return "drawn" if keys & set(DrawnFace.model_fields) else "summits"


if TYPE_CHECKING:
    AnyFace = _ScannedFace | DrawnFace | SummitsFace
else:
    AnyFace = Annotated[
        reduce(or_, (Annotated[table, Tag(name)] for name, table in FACES.items())),
        Discriminator(_kind),
    ]


class FacedSurface(SurfaceTable):
    """A surface of rough faces, as summits against a flat."""

    materials: TwoNames = required(
        "Names of the two bodies: materials of this file or metals of the table.",
        '["steel", "steel"]',
    )
    area: Area = required("Apparent area.", '"2 cm^2"')

    _faces: dict[str, RoughFace] | None = PrivateAttr(default=None)

    def face_tables(self) -> dict[str, AnyFace]:
        """Tables of the faces, by their keys."""
        raise NotImplementedError

    @property
    def faces(self) -> dict[str, RoughFace]:
        """What is known of each face; it is found once."""
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
        """How far what the faces are known by bears a joint."""
        return tuple(verdict for face in self.faces.values() for verdict in face.verdicts)

    def sentences(self) -> list[str]:
        """Where the summits are from."""
        sentences = [
            f"surface{key}: {face.statistics}, {face.origin}." for key, face in self.faces.items()
        ]
        if len(sentences) > 1:
            sentences.append(
                f"surface: both faces together {self.statistics}: their spectral moments add "
                "(Greenwood 1984), as of isotropic Gaussian faces that know nothing of each other."
            )
        return sentences

    @property
    def law_name(self) -> str:
        """Name of the normal law of the summits."""
        return "greenwood-williamson"

    def findings(self) -> dict[str, Any]:
        """What is known of the faces, in SI units."""
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

    law: Literal["two-faces"] = required("Two rough faces on each other.")
    first: AnyFace = required(
        "The face of the first body: { scan, cutoff, … }, { ra, rsm, process } or "
        "{ std, radius, density }.",
        '{ ra = "0.8 um", rsm = "60 um" }',
    )
    second: AnyFace | None = optional(
        "The face of the second body, likewise; smooth if absent.",
        '{ std = "0.4 um", radius = "20 um", density = "3000 1/mm^2" }',
    )

    def face_tables(self) -> dict[str, AnyFace]:
        """The two, or the one that is rough."""
        return {".first": self.first, **({".second": self.second} if self.second else {})}


class DrawnSurface(DrawnFace, FacedSurface):
    """A rough face by its drawing on a smooth one: Ra, Rq or Rz, RSm, or a process."""

    law: Literal["drawing"] = required("A face by its drawing on a smooth one.")

    def face_tables(self) -> dict[str, AnyFace]:
        """Itself."""
        return {"": self}
