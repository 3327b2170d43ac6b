"""Evaluation of a scan: the request, and all findings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from microslip._core.checks import Progress
from microslip._core.units import engineering
from microslip._core.verdicts import Verdict
from microslip._core.wording import shorten
from microslip.errors import InputError
from microslip.materials import Material, MaterialPair
from microslip.scans import Scan
from microslip.scans.conditioning import condition
from microslip.scans.cutoffs import CutoffTable, default_cutoffs, over_cutoffs
from microslip.scans.height_fit import HeightFit, height_distribution
from microslip.scans.height_laws import HeightLaws, MeasuredSurface
from microslip.scans.height_map import HeightMap
from microslip.scans.joint_over_cutoffs import JointOverCutoffs, joint_over_cutoffs
from microslip.scans.joints import PointByPoint, ProfileJoint, point_by_point, profile_joint
from microslip.scans.moments import BY_MOMENTS, Moments, Statistics
from microslip.scans.options import DRAWING, READING
from microslip.scans.patches import standard_errors
from microslip.scans.scan_rules import judged, radius_in_pixels, verdicts
from microslip.scans.spectrum import SelfAffineFit, Spectrum, spectrum
from microslip.scans.summit_statistics import SummitStatistics
from microslip.scans.summits import Summits, find_summits
from microslip.scans.surface_parameters import (
    ProfileParameters,
    areal_parameters,
    profile_parameters,
    slope_over_distance,
)

ESTIMATES = {
    "mccool": "McCool's moments",
    "nayak": "Nayak's moments",
    "counted": "counting",
    "neighbours": "eight neighbours",
}
"""Estimates of summits in words."""
_COUNTED: tuple[Literal["counted", "neighbours"], ...] = ("counted", "neighbours")


def single_value(values: Any) -> Any:
    """Value of an option given once."""
    return values[0] if isinstance(values, tuple) and len(values) == 1 else values


@dataclass(frozen=True)
class Request:
    """Options of scans by their names, in SI units."""

    path: Path
    cutoff: float | None = None
    cutoff_given: bool = False  # whether it was said, be it that there is none
    long_cutoff: float | None = None
    level: Any = "plane"
    outliers: float | None = None
    fill: bool = False
    filter: Any = "gaussian"
    crop: tuple[float, ...] | None = None
    method: Any = "watershed"
    prominence: float | None = None
    area: float | None = None
    heights: Any = None
    materials: tuple[str, str] | None = None
    normal_load: float | None = None
    friction_coefficient: float = 0.5
    amplitude: float | None = None
    direction: float | None = None
    point_by_point: bool = False
    scans: tuple[Path, ...] = ()
    """Several scans of the face, if there are."""
    against: tuple[Path, ...] = ()
    """Findings of the face that lies on it."""
    drawing: Mapping[str, Any] = field(default_factory=dict)
    """Drawing of the only face, or of the one that lies on the scanned face."""
    reading: Mapping[str, Any] = field(default_factory=dict)
    """Keywords of :meth:`~microslip.Scan.read`."""

    @classmethod
    def of(cls, *scans: Path, cutoff_given: bool, **options: Any) -> Request:
        """Request of the command's options, in SI units."""
        drawing = {option.name: options.pop(option.name, None) for option in DRAWING}
        options["drawing"] = {name: value for name, value in drawing.items() if value is not None}
        options["against"] = tuple(map(Path, options.pop("against", None) or ()))
        options["scans"] = scans
        reading = {option.name: options.pop(option.name, None) for option in READING}
        channel = reading["channel"]
        if isinstance(channel, str) and channel.isdecimal() and channel.isascii():
            reading["channel"] = int(channel)
        for name in ("unit", "pixel"):
            reading[name] = single_value(reading[name])
        reading = {name: value for name, value in reading.items() if value is not None}
        path = scans[0] if scans else Path()
        return cls(path, cutoff_given=cutoff_given, reading=reading, **options)

    @property
    def is_of_faces(self) -> bool:
        """Whether more than one scan is concerned."""
        return len(self.scans) != 1 or bool(self.against or self.drawing)

    def pair(self) -> MaterialPair | None:
        """The two bodies of the joint that is asked for; None where none is."""
        metals, load = '`materials=("steel", "steel")`', '`normal_load="500 N"`'
        if self.materials is None and self.normal_load is None:
            if self.amplitude is None:
                return None
            raise InputError(f"`amplitude` goes with {metals} and {load}")
        if self.materials is None:
            raise InputError(f"`normal_load` goes with {metals}")
        if self.normal_load is None:
            raise InputError(f"`materials` goes with {load}")
        first, second = map(Material.named, self.materials)
        return MaterialPair(first, second)

    @property
    def is_filtered(self) -> bool:
        """Whether there is a cut-off of either kind."""
        return self.cutoff is not None or self.long_cutoff is not None


@dataclass(frozen=True)
class Findings:
    """All findings of a scan."""

    request: Request
    raw: Scan
    """The scan as in the file."""
    levelled: Scan
    """Without outliers, form and long waves."""
    scan: HeightMap
    """The same without short waves: what all parameters are of."""
    statistics: Statistics
    moments: Moments
    estimates: dict[str, SummitStatistics | None]
    """Summit statistics by the name of the estimate; None where there are none."""
    missing: tuple[str, ...]
    """Reason why there are none."""
    summits: Summits | None
    whole_spectrum: Spectrum
    """Spectrum of the scan without outliers and form, before any cut-off."""
    spectrum: Spectrum
    fit: HeightFit
    table: CutoffTable
    errors: dict[str, float]
    """Standard errors from patches, by names such as "rms" and "mccool.density"."""
    verdicts: tuple[Verdict, ...]
    laws: HeightLaws | None = None
    """The joint that was asked for by every law of the summit heights."""
    joint_table: JointOverCutoffs | None = None
    """The same joint against both cut-offs."""
    contact: PointByPoint | None = None
    """The same joint, the scan solved point by point."""
    of_profile: ProfileJoint | None = None
    """The joint that was asked for, of a profile."""

    @property
    def makes_surface(self) -> bool:
        """Whether a study can build on the scan: on its summits, or on a profile's moments."""
        if self.scan.is_profile:
            return self.estimates.get("mccool") is not None
        return self.summits is not None

    def gaussian_surface(self) -> MeasuredSurface:
        """The surface of Gaussian heights on the summits, of the joint that was asked for."""
        pair, summits = self.request.pair(), self.summits
        assert pair is not None
        assert summits is not None
        surface = summits.to_surface(pair, self.request.area)
        assert isinstance(surface, MeasuredSurface)
        return surface

    @property
    def has_cutoffs(self) -> bool:
        """Whether there are cut-offs to choose from."""
        return self.table.cutoff.size > 1

    @property
    def self_affine(self) -> SelfAffineFit | None:
        """The fit to the spectrum before any cut-off; None where there is no room for one."""
        with suppress(InputError):
            return self.whole_spectrum.self_affine_fit()
        return None

    def texture(self) -> dict[str, Any]:
        """Parameters of ISO 25178, self-affine fit and slopes; None for what there is not."""
        distances, slopes = slope_over_distance(self.scan)
        fit = self.self_affine
        return {
            "areal": None if self.scan.is_profile else asdict(areal_parameters(self.scan)),
            "profile": {axis: asdict(found) for axis, found in self._lines()},
            "self_affine": None if fit is None else asdict(fit),
            "slopes": [
                {"distance": distance, "rms_slope": slope}
                for distance, slope in zip(distances.tolist(), slopes.tolist(), strict=True)
            ],
        }

    def _lines(self) -> Iterator[tuple[str, ProfileParameters]]:
        """Parameters along each axis; none where every line has gaps or one is too short."""
        axes: tuple[Literal["x", "y"], ...] = ("x", "y")
        for axis in axes[: self.scan.heights.ndim]:
            with suppress(InputError):
                yield axis, profile_parameters(self.scan, axis=axis)

    def cutoff_text(self) -> str:
        """The cut-offs in words; there is always something to say."""
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
        """Title of a figure, which names the scan and the cut-off."""
        return f"{subject} of {shorten(self.raw.name, 50)}, {self.cutoff_text()}"


def analyse(request: Request, progress: Progress | None = None) -> Findings:
    """Measure a scan: parameters, spectra, summits and their dependence on the cut-off."""
    report = progress or (lambda share: None)
    pair = request.pair()
    raw = Scan.read(request.path, **request.reading)
    raw = condition(raw, crop=request.crop)
    report(0.1)
    conditioned = condition(
        raw,
        level=request.level,
        outliers=request.outliers,
        fill="interpolate" if request.fill else None,
    )
    levelled = condition(conditioned, long_cutoff=request.long_cutoff, filter=request.filter)
    report(0.2)
    summits, missing = _summits(request, levelled)
    scan = condition(levelled, cutoff=request.cutoff) if summits is None else summits.scan
    statistics, moments = scan.statistics(), scan.moments()
    report(0.3)
    estimates: dict[str, SummitStatistics | None] = {}
    makers = {name: partial(made_of, moments) for name, made_of in BY_MOMENTS.items()}
    if summits is not None:
        makers |= {name: partial(summits.statistics, name) for name in _COUNTED}
    for name, make in makers.items():
        try:
            estimates[name] = make()
        except InputError as error:
            estimates[name] = None
            missing.append(f"No summits by {ESTIMATES[name]}: {error.text}.")
    report(0.4)
    whole_spectrum = spectrum(conditioned)
    filtered_spectrum = spectrum(scan) if request.is_filtered else whole_spectrum
    fit = height_distribution(scan)
    report(0.5)
    end = 0.9 if pair is None else 0.7
    table = _over_cutoffs(
        levelled, request, summits, lambda share: report(0.5 + (end - 0.5) * share)
    )
    laws = joint_table = contact = None
    if pair is not None and summits is not None:
        laws, joint_table = _joint(
            request, pair, conditioned, summits, lambda share: report(end + (0.9 - end) * share)
        )
        contact = point_by_point(
            scan,
            pair,
            laws.normal_load,
            area=request.area,
            friction_coefficient=request.friction_coefficient,
            amplitude=request.amplitude,
            direction=request.direction,
            asked=request.point_by_point,
            report=lambda share: report(0.9 + 0.1 * share),
        )
    of_profile = None
    if pair is not None and scan.is_profile:
        of_profile = profile_joint(
            scan, estimates, pair, request.normal_load or 0.0, request.area,
            request.friction_coefficient, request.amplitude,
        )  # fmt: skip
    judged_joint = (
        (() if of_profile is None else of_profile.verdicts())
        if laws is None or joint_table is None or contact is None
        else (*laws.verdicts(), *joint_table.verdicts(), *contact.verdicts)
    )
    result = Findings(
        request=request,
        raw=raw,
        levelled=levelled,
        scan=scan,
        statistics=statistics,
        moments=moments,
        estimates=estimates,
        missing=tuple(missing),
        summits=summits,
        whole_spectrum=whole_spectrum,
        spectrum=filtered_spectrum,
        fit=fit,
        table=table,
        errors=standard_errors(scan, summits),
        verdicts=(*_verdicts(scan, summits, estimates["mccool"]), *judged_joint),
        laws=laws,
        joint_table=joint_table,
        contact=contact,
        of_profile=of_profile,
    )
    report(1.0)
    return result


def _joint(
    request: Request, pair: MaterialPair, conditioned: Scan, summits: Summits, report: Progress
) -> tuple[HeightLaws, JointOverCutoffs]:
    """The joint that was asked for, by the laws of the heights and against both cut-offs."""
    assert request.normal_load is not None
    options: dict[str, Any] = {
        "area": request.area,
        "friction_coefficient": request.friction_coefficient,
        "amplitude": request.amplitude,
    }
    laws = summits.height_laws(pair, request.normal_load, **options)
    table = joint_over_cutoffs(
        conditioned,
        pair,
        request.normal_load,
        cutoff=request.cutoff,
        long_cutoff=request.long_cutoff,
        heights=request.heights or laws.recommended,
        level=None,
        method=request.method,
        prominence=request.prominence,
        filter=request.filter,
        progress=lambda number, count: report(number / count),
        **options,
    )
    return laws, table


def _summits(request: Request, levelled: Scan) -> tuple[Summits | None, list[str]]:
    if levelled.is_profile:
        return None, [
            "A profile has peaks but no summits: moments estimate them, as if it were of an "
            "isotropic Gaussian surface."
        ]
    try:
        summits = find_summits(
            levelled,
            request.cutoff,
            method=request.method,
            prominence=request.prominence,
        )
    except InputError as error:
        return None, [f"No summits were counted: {error.text}."]
    return summits, []


def _over_cutoffs(
    levelled: Scan, request: Request, summits: Summits | None, report: Progress
) -> CutoffTable:
    """Parameters against the usual cut-offs and the one that was asked for."""
    cutoffs = default_cutoffs(levelled)
    if request.cutoff is not None:
        distinct = np.abs(cutoffs - request.cutoff) > 0.1 * request.cutoff
        cutoffs = np.append(cutoffs[distinct], request.cutoff)
    return over_cutoffs(
        levelled,
        cutoffs,
        method=request.method,
        prominence=request.prominence,
        progress=lambda number, count: report(number / count),
        known=summits,
    )


def _verdicts(
    scan: HeightMap, summits: Summits | None, mccool: SummitStatistics | None
) -> tuple[Verdict, ...]:
    on_scan = verdicts(scan)
    if scan.is_profile and mccool is not None:
        on_scan += judged(radius_in_pixels(mccool.radius, scan.pixel))
    if summits is None:
        return on_scan
    # Moments of a surface that is not Gaussian are judged by the verdicts, as on the kurtosis.
    with suppress(InputError):
        names = {verdict.name for verdict in on_scan} | {"kurtosis of the heights"}
        on_scan += tuple(v for v in summits.validity() if v.name not in names)
    return on_scan
