"""The surface of a study that comes from a scan: its keys, its file and its summits."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from microslip._core.parameters import JsonSchema
from microslip._core.quantities import named
from microslip._core.units import engineering
from microslip._core.wording import quoted, shorten, show
from microslip.errors import InputError
from microslip.normal import PerssonCurve
from microslip.scans import options
from microslip.study.fields import MATERIALS, text
from microslip.study.part import SurfaceTable, tag
from microslip.study.part import key as key_of
from microslip.study.readers import KeyedError, Place, Reader

if TYPE_CHECKING:
    from microslip.friction import Verdict
    from microslip.materials import MaterialPair
    from microslip.normal import NormalLaw
    from microslip.scans import Scan
    from microslip.scans.summit_statistics import SummitStatistics
    from microslip.scans.summits import Summits

NO_CUTOFF = "none: limited by the pixel"
"""Word in place of a cut-off, if there is none."""


SCAN = text("the name of a scan", "ground.plu")


class _Channel(Reader):
    """A channel of an instrument's file."""

    help, example, default = options.CHANNEL.help, options.CHANNEL.example_text, None

    def read(self, raw_value: object, place: Place) -> str | int:
        """Its name or number."""
        if isinstance(raw_value, bool) or not isinstance(raw_value, (str, int)) or raw_value == "":
            raise ValueError(f'wanted a channel such as "Topography" or 0, got {show(raw_value)}')
        return raw_value

    def schema(self) -> JsonSchema:
        """Text or a whole number."""
        return {"anyOf": [{"type": "string"}, {"type": "integer"}]}


def _single(values: Any) -> Any:
    """Value of an option given once."""
    return values[0] if values and len(values) == 1 else values


class ReadScan(SurfaceTable):
    """Reading and conditioning of a scan."""

    cutoff: float | None = key_of(options.CUTOFF)
    long_cutoff: float | None = key_of(options.LONG_CUTOFF)
    filter: str = key_of(options.FILTER)
    crop: tuple[float, ...] | None = key_of(options.CROP)
    level: str | None = key_of(options.LEVEL)
    outliers: float | None = key_of(options.OUTLIERS)
    fill: bool = key_of(options.FILL)
    format: str | None = key_of(options.FORMAT)
    unit: tuple[str, ...] | None = key_of(options.UNIT)
    pixel: tuple[float, ...] | None = key_of(options.PIXEL)
    key: str | None = key_of(options.KEY)
    channel: str | int | None = key_of(_Channel())
    valid: tuple[float, ...] | None = key_of(options.VALID, example='["-1 mm", "1 mm"]')
    limit: int = key_of(options.LIMIT)

    read_scan: Scan
    """The scan as it is in the file."""

    def read_file(self, place: Place, file: str) -> None:
        """Read the scan, or say at its key what is wrong."""
        from microslip.scans import Scan

        reading, name = place.reading, shorten(file, 100)
        here = reading.path(file)
        try:
            scan = Scan.read(
                here,
                self.format,
                unit=_single(self.unit),
                pixel=_single(self.pixel),
                key=self.key,
                channel=self.channel,
                valid=None if self.valid is None else (self.valid[0], self.valid[1]),
                limit=self.limit,
            ).condition(crop=self.crop)
        except InputError as error:
            message = " ".join(str(error).split()).replace(str(here), name)
            message = message if message.startswith(name) else f"{name}: {message}"
            if not here.exists():
                message = reading.message(message, file)
            raise KeyedError(".scan", message) from None
        notes = " ".join(scan.notes).replace("`", "")
        reading.notes.append(f"{place.key}.scan: {notes}")
        self.keep(read_scan=scan)

    @property
    def conditioned(self) -> Scan:
        """The scan without outliers, form and long waves; short waves come later."""
        return self.read_scan.condition(
            fill="interpolate" if self.fill else None,
            **named(self, "outliers", "level", "long_cutoff", "filter"),
        )


class Scanned(ReadScan):
    """Reading of scans, and the definition of a summit in them."""

    method: str = key_of(options.METHOD)
    prominence: float | None = key_of(options.PROMINENCE)
    estimate: str = key_of(options.ESTIMATE)


class ScanSurface(Scanned):
    """Summits of a scanned surface; its short-wave cut-off [m] defines a summit."""

    law: str = tag("scan", "Summits found in a scan of a surface.")
    materials: tuple[str, str] = MATERIALS
    scan: str = key_of(SCAN, "File of the scan, relative to the folder of the study.")
    heights: str = key_of(options.HEIGHTS)
    area: float | None = key_of(options.SCAN_AREA)

    _summits: Summits | None = None
    _profile: Scan | None = None
    _other_summits: dict[float, Summits]

    def check(self, place: Place) -> None:
        """Read the scan, and refuse what goes with none such."""
        self._other_summits = {}
        self.read_file(place, self.scan)
        if self.read_scan.is_profile:
            self._check_profile()
        # Summits one by one are counted ones, and have their own heights.
        if self.is_population and (
            self.estimate not in ("counted", "population")
            or self.heights not in ("gaussian", "population")
        ):
            raise KeyedError(
                ".heights",
                f"wanted other heights with estimate = {show(self.estimate)}, got "
                f'{show(self.heights)}; "population" goes with estimate = "counted"',
            )
        if self.estimate == options.PERSSON and self.heights != "gaussian":
            raise KeyedError(
                ".heights",
                f'wanted none beside estimate = "{options.PERSSON}", which knows no summits, got '
                f"{show(self.heights)}",
            )

    def _check_profile(self) -> None:
        """A profile has moments only, and no area."""
        if self.estimate not in options.OF_PROFILES:
            raise KeyedError(
                ".estimate",
                "a profile has peaks but no summits to count: wanted "
                f"{quoted(options.OF_PROFILES)}, got {show(self.estimate)}",
            )
        if self.heights != "gaussian":
            raise KeyedError(
                ".heights",
                f'a profile has no summits to count: wanted "gaussian", got {show(self.heights)}',
            )
        if self.prominence is not None:
            raise KeyedError(".prominence", "means nothing for a profile; leave it out")
        if self.area is None:
            raise KeyedError(".area", 'missing, and a profile has none; write for example "2 cm^2"')

    @property
    def is_population(self) -> bool:
        """Whether each summit stands for itself."""
        return "population" in (self.estimate, self.heights)

    def summits_of(self, scan: Scan, cutoff: float | None) -> Summits:
        """Summits of a conditioned scan, or of a patch of it, at a cut-off."""
        method: Any = self.method
        return scan.summits(cutoff, method=method, prominence=self.prominence, level=None)

    @property
    def summits(self) -> Summits:
        """Summits at the cut-off; they are found once."""
        if self._summits is None:
            self._summits = self.summits_of(self.conditioned, self.cutoff)
        return self._summits

    @property
    def profile(self) -> Scan:
        """A profile at the cut-off; it is filtered once."""
        if self._profile is None:
            self._profile = self.conditioned.condition(cutoff=self.cutoff)
        return self._profile

    def _law(self, pair: MaterialPair, summits: Summits) -> NormalLaw:
        """Normal law of summits, or of the spectrum of their scan."""
        from microslip.scans.spectrum import spectrum

        area = summits.scan.area if self.area is None else self.area
        if self.estimate == options.PERSSON:
            scan = summits.scan.measurable()
            present = scan.heights[np.isfinite(scan.heights)]
            curve = PerssonCurve.from_spectrum(spectrum(scan), pair, area, heights=present)
            return curve.to_surface()
        law: NormalLaw = summits.to_surface(
            pair,
            area=self.area,
            estimate=self.estimate,  # type: ignore[arg-type]
            heights=self.heights,  # type: ignore[arg-type]
        )
        return law

    def build(self, pair: MaterialPair) -> NormalLaw:
        """Normal law of the summits."""
        if self.read_scan.is_profile:
            assert self.area is not None  # checked when read
            of_moments: NormalLaw = self._of_profile().to_surface(pair, self.area)
            return of_moments
        return self._law(pair, self.summits)

    def law_at(self, pair: MaterialPair, factor: float) -> NormalLaw | None:
        """The same at another short-wave cut-off, this times a factor; None where there is none."""
        if self.cutoff is None or self.read_scan.is_profile:
            return None
        if factor not in self._other_summits:
            self._other_summits[factor] = self.summits_of(self.conditioned, factor * self.cutoff)
        return self._law(pair, self._other_summits[factor])

    def cutoff_text(self) -> str:
        """The cut-off as text; there is always something to say."""
        return NO_CUTOFF if self.cutoff is None else engineering(self.cutoff, "m", 6, trim=True)

    def _cutoff_words(self) -> str:
        return (
            f"cut-off {self.cutoff_text()}" if self.cutoff else "no cut-off: limited by the pixel"
        )

    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts on the summits, apart from those that depend on the load."""
        if self.read_scan.is_profile:
            from microslip.scans.scan_rules import judged, radius_in_pixels, verdicts

            radius = radius_in_pixels(self._of_profile().radius, self.profile.pixel)
            return *judged(radius), *verdicts(self.profile)
        with suppress(InputError):  # moments of no Gaussian surface; counting is not asked for them
            return self.summits.validity()
        return ()

    @property
    def law_name(self) -> str:
        """Name of the normal law of its summits, or of its spectrum."""
        if self.estimate == options.PERSSON:
            return options.PERSSON
        return "population" if self.is_population else "greenwood-williamson"

    @property
    def apparent_area(self) -> float:
        """Apparent area [m^2], that of the scan if no other is given."""
        return self.area or self.read_scan.area

    def findings(self) -> dict[str, Any]:
        """Numbers found in the scan, in SI units."""
        summits = None if self.read_scan.is_profile else self.summits
        scan = self.profile if summits is None else summits.scan
        numbers = {
            "name": scan.name,
            **named(self, "cutoff", "long_cutoff", "estimate", "heights"),
            "count": None if summits is None else summits.count,
            "area": None if summits is None else scan.area,
            **{
                name: None if part is None else asdict(part)
                for name, part in self._estimates().items()
            },
            "notes": list(scan.notes if summits is None else summits.notes),
        }
        return {"scan": numbers}

    def _of_profile(self) -> SummitStatistics:
        """Summit statistics of the isotropic surface with the moments of a profile."""
        moments = self.profile.moments()
        return (
            moments.nayak_summits().statistics() if self.estimate == "nayak" else moments.mccool()
        )

    def _estimates(self) -> dict[str, SummitStatistics | None]:
        estimates: dict[str, SummitStatistics | None] = {}
        if self.read_scan.is_profile:
            estimates = dict.fromkeys(options.ESTIMATES[:-1])
            estimates[self.estimate] = self._of_profile()
            return estimates
        for name in options.ESTIMATES[:-1]:
            try:
                estimates[name] = self.summits.statistics(name)  # type: ignore[arg-type]
            except InputError:
                estimates[name] = None
        return estimates

    def sentences(self) -> list[str]:
        """Summits and cut-off in words; the cut-off comes first."""
        name = shorten(Path(self.scan).name, 100)
        part = self._estimates().get("counted" if self.estimate == "population" else self.estimate)
        if self.estimate == options.PERSSON:
            theory = "the power spectrum by Persson's theory, with interacting contacts"
            source = f"surface.scan: {name}, {self._cutoff_words()}"
            return [f"{source}: {theory}. It depends on the cut-off."]
        parameters = "" if part is None else f" {part}"
        remark = {
            "table": ", heights by the density of those counted",
            "discrete": ", heights as they were counted",
            "population": ", each summit by itself",
        }.get("population" if self.is_population else self.heights, "")
        if self.read_scan.is_profile:
            remark = ", as if the profile were of an isotropic Gaussian surface"
        sentence = f"{name}, {self._cutoff_words()}:{parameters}{remark}"
        return [f"surface.scan: {sentence}. These numbers depend on the cut-off."]
