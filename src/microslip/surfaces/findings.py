"""Evaluation of a scan for ``microslip surface``: the request and its findings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from microslip._core.checks import Progress
from microslip._core.errors import InputError
from microslip._core.quantities import named
from microslip._core.units import engineering
from microslip._core.verdicts import Verdict
from microslip._core.wording import shorten
from microslip.contact.materials import Material, MaterialPair
from microslip.friction import Interface
from microslip.surfaces import Scan
from microslip.surfaces.conditioning import condition
from microslip.surfaces.faults import automatic_level
from microslip.surfaces.height_map import HeightMap
from microslip.surfaces.joints import FaceJoint, solve_joint
from microslip.surfaces.moments import Statistics, SummitStatistics
from microslip.surfaces.options import READING
from microslip.surfaces.scan_rules import judged, radius_in_pixels, verdicts
from microslip.surfaces.spectrum import Spectrum, spectrum
from microslip.surfaces.summits import Summits, find_summits

_OF_A_PROFILE = (
    "A profile has peaks but no summits; the summits are estimated from its moments for an "
    "isotropic Gaussian surface."
)


@dataclass(frozen=True)
class Request:
    """Options of ``microslip surface`` in SI units."""

    path: Path
    cutoff: float | None = None
    cutoff_given: bool = False
    """Whether a cut-off was given, "none" included."""
    long_cutoff: float | None = None
    level: Any = "auto"
    """Form to remove; "auto" is quadratic if the scan is bowed, else a plane."""
    crop: tuple[float, ...] | None = None
    area: float | None = None
    materials: tuple[str, str] | None = None
    normal_load: float | None = None
    friction_coefficient: float = 0.5
    amplitude: float | None = None
    direction: float | None = None
    reading: Mapping[str, Any] = field(default_factory=dict)
    """Keywords of :meth:`~microslip.Scan.read`."""

    @classmethod
    def of(cls, path: Path, *, cutoff_given: bool, **options: Any) -> Request:
        """Create a request from the options of the command, in SI units."""
        reading = {option.name: options.pop(option.name, None) for option in READING}
        channel = reading["channel"]
        if isinstance(channel, str) and channel.isdecimal() and channel.isascii():
            reading["channel"] = int(channel)
        for name in ("unit", "pixel"):
            if isinstance(reading[name], tuple) and len(reading[name]) == 1:
                (reading[name],) = reading[name]
        reading = {name: value for name, value in reading.items() if value is not None}
        return cls(path, cutoff_given=cutoff_given, reading=reading, **options)

    def pair(self) -> MaterialPair | None:
        """Materials of the two bodies of the joint, or None if no joint was requested."""
        metals, load = '`materials=("steel", "steel")`', '`normal_load="500 N"`'
        if self.materials is None and self.normal_load is None:
            if self.amplitude is None:
                return None
            raise InputError(f"`amplitude` requires {metals} and {load}")
        if self.materials is None:
            raise InputError(f"`normal_load` requires {metals}")
        if self.normal_load is None:
            raise InputError(f"`materials` requires {load}")
        first, second = map(Material.named, self.materials)
        return MaterialPair(first, second)

    @property
    def is_filtered(self) -> bool:
        """Whether a short-wave or long-wave cut-off is given."""
        return self.cutoff is not None or self.long_cutoff is not None


@dataclass(frozen=True)
class Findings:
    """Results of the evaluation of a scan."""

    request: Request
    raw: Scan
    """Scan as stored in the file."""
    scan: Scan
    """Conditioned scan, the basis of all parameters."""
    statistics: Statistics
    summit_statistics: SummitStatistics | None
    """Density, radius and spread of counted summits; for a profile, from its moments."""
    missing: str
    """Reason why no summits were counted, or empty."""
    summits: Summits | None
    whole_spectrum: Spectrum
    """Spectrum without outliers and form, before any cut-off."""
    spectrum: Spectrum
    verdicts: tuple[Verdict, ...]
    level: str | None = "plane"
    """Removed form."""
    face: FaceJoint | None = None
    """Joint of the face solved point by point, if materials and a load were given."""
    chapter: Interface | None = None
    """Joint after the chapter's summit model, under the same load."""

    def cutoff_text(self) -> str:
        """Describe the cut-offs; if there are none, state that."""
        if self.request.cutoff is not None:
            text = f"cut-off {engineering(self.request.cutoff, 'm', 4, trim=True)}"
        elif self.request.cutoff_given:
            text = "no cut-off: limited by the pixel"
        else:
            text = "no cut-off given: limited by the pixel"
        if self.request.long_cutoff is None:
            return text
        return f"{text}, long-wave {engineering(self.request.long_cutoff, 'm', 4, trim=True)}"

    def title(self, subject: str) -> str:
        """Return a figure title: the subject, the name of the scan and the cut-off."""
        return f"{subject} of {shorten(self.raw.name, 50)}, {self.cutoff_text()}"


def analyse(request: Request, progress: Progress | None = None) -> Findings:
    """Evaluate a scan: parameters, spectrum, summits and, with a load, the joint."""
    report = progress or (lambda share: None)
    pair = request.pair()
    raw = Scan.read(request.path, **request.reading)
    report(0.02)
    if pair is not None and raw.is_profile:
        raise InputError(
            "`normal_load` requires the scan of an area, got a profile, which does not determine "
            "the interaction of contacts"
        )
    whole = condition(raw.repaired(), crop=request.crop)
    level: Any = automatic_level(raw.notes) if request.level == "auto" else request.level
    conditioned = condition(whole, level=level)
    levelled = condition(conditioned, long_cutoff=request.long_cutoff)
    report(0.05)
    summits, missing = None, _OF_A_PROFILE if levelled.is_profile else ""
    if not levelled.is_profile:
        try:
            summits = find_summits(levelled, request.cutoff)
        except InputError as error:
            missing = f"No summits were counted: {error.text}."
    scan = condition(levelled, cutoff=request.cutoff)
    statistics = None if summits is None else summits.statistics()
    if scan.is_profile:
        with suppress(InputError):  # moments impossible for a Gaussian surface
            statistics = scan.moments().mccool()
    report(0.1)
    whole_spectrum = spectrum(conditioned)
    face, chapter = None, None
    if pair is not None:
        load, area = request.normal_load or math.nan, request.area or scan.area
        face = solve_joint(
            scan, pair, load, report=lambda share: report(0.1 + 0.85 * share),
            **named(request, "area", "friction_coefficient", "amplitude", "direction"),
        )  # fmt: skip
        if statistics is not None and statistics.std > 0.0:
            surface = statistics.to_surface(pair, area)
            chapter = Interface(surface, request.friction_coefficient, normal_load=load)
    verdicts_of_face = () if face is None else face.joint.validity
    findings = Findings(
        request=request,
        raw=raw,
        scan=scan,
        statistics=scan.statistics(),
        summit_statistics=statistics,
        missing=missing,
        summits=summits,
        whole_spectrum=whole_spectrum,
        spectrum=spectrum(scan) if request.is_filtered else whole_spectrum,
        verdicts=(*_verdicts(scan, summits, statistics), *verdicts_of_face),
        level=level,
        face=face,
        chapter=chapter,
    )
    report(1.0)
    return findings


def _verdicts(
    scan: HeightMap, summits: Summits | None, statistics: SummitStatistics | None
) -> tuple[Verdict, ...]:
    on_scan = verdicts(scan)
    if scan.is_profile and statistics is not None:
        on_scan += judged(radius_in_pixels(statistics.radius, scan.pixel))
    if summits is not None:
        names = {verdict.name for verdict in on_scan}
        on_scan += tuple(v for v in summits.validity() if v.name not in names)
    return on_scan
