"""Floor 8: a scan looked at: what was asked, what was found, and what summary.json says of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from microslip._core.units import AREA, LENGTH, Kind, Sign, engineering, to_si
from microslip.errors import InputError
from microslip.scans import Scan
from microslip.scans.height_distribution import height_distribution
from microslip.scans.height_map import HeightMap
from microslip.scans.spectrum import spectrum as spectrum_of
from microslip.scans.verdicts import verdicts
from microslip.study.scanned_errors import errors_of
from microslip.study.scanned_reasons import differences

if TYPE_CHECKING:
    from microslip.friction import Verdict
    from microslip.scans.cutoffs import CutoffTable
    from microslip.scans.height_distribution import HeightFit
    from microslip.scans.moments import Moments
    from microslip.scans.spectrum import Spectrum
    from microslip.scans.statistics import Statistics
    from microslip.scans.summit_statistics import SummitStatistics
    from microslip.scans.summits import Summits

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Request:
    """What is wanted of a scan; lengths in metres."""

    path: Path
    cutoff: float | None
    given: bool
    """Whether the cut-off was said, be it that there is none."""
    long_cutoff: float | None
    level: str
    outliers: float | None
    fill: bool
    method: str
    prominence: float | None
    area: float | None
    reading: Mapping[str, Any]
    """How the file is read, by the keys of :meth:`Scan.read`; what is not said is None."""

    @classmethod
    def of(
        cls,
        path: Path,
        *,
        cutoff: str | None = None,
        long_cutoff: str | None = None,
        level: str = "plane",
        outliers: float | None = None,
        fill: bool = False,
        method: str = "watershed",
        prominence: str | None = None,
        area: str | None = None,
        pixel: tuple[str, ...] = (),
        channel: str | None = None,
        valid: tuple[str, str] | None = None,
        **reading: str | None,
    ) -> Request:
        """What the words of a command ask for.

        Parameters
        ----------
        path : pathlib.Path
            The file.
        cutoff, long_cutoff : str, optional
            Lengths such as "10 um"; the first one may be "none".
        level : str
            Form that is removed; "none" for none.
        outliers : float, optional
            Robust standard deviations.
        fill : bool
            Whether missing points are interpolated.
        method : str
            What counts as a summit.
        prominence : str, optional
            Least rise of a summit, such as "2 nm".
        area : str, optional
            Apparent area such as "2 cm^2".
        pixel : tuple of str
            No, one or two lengths.
        channel : str, optional
            Name or number.
        valid : tuple of str, optional
            Lowest and highest possible height, such as ("-1 mm", "1 mm").
        **reading : str, optional
            The other keys of :meth:`Scan.read`.

        Returns
        -------
        Request
            The same in SI units.

        Raises
        ------
        InputError
            A quantity that cannot be used.
        """
        if len(pixel) > 2:
            raise InputError(f"--pixel: wanted once, or twice for x and y, got {len(pixel)} times")
        steps = tuple(_si("--pixel", text, LENGTH, "1.66 um") for text in pixel)
        number = channel is not None and channel.isdecimal() and channel.isascii()
        none = cutoff is None or cutoff.strip().casefold() == "none"
        return cls(
            path=path,
            cutoff=None if none else _si("--cutoff", cutoff, LENGTH, "10 um"),
            given=cutoff is not None,
            long_cutoff=_maybe("--long-cutoff", long_cutoff, LENGTH, "0.8 mm"),
            level=level,
            outliers=outliers,
            fill=fill,
            method=method,
            prominence=_maybe("--prominence", prominence, LENGTH, "2 nm"),
            area=_maybe("--area", area, AREA, "2 cm^2"),
            reading={
                **reading,
                "pixel": None if not steps else steps[0] if len(steps) == 1 else steps,
                "channel": int(channel) if channel is not None and number else channel,
                "valid": valid and tuple(_si("--valid", z, LENGTH, "1 mm", "any") for z in valid),
            },
        )


def _maybe(option: str, text: str | None, kind: Kind, example: str) -> float | None:
    return None if text is None else _si(option, text, kind, example)


def _si(
    option: str,
    text: str | None,
    kind: Kind,
    example: str,
    sign: Sign = "positive",
) -> float:
    try:
        return to_si(text, kind, example, sign=sign)
    except ValueError as error:
        message = str(error)
        if option == "--cutoff":
            message = message.replace('"10 um"', '"10 um", or "none"', 1)
        raise InputError(f"{option}: {message}") from None


@dataclass(frozen=True)
class Findings:
    """All that was found in a scan."""

    request: Request
    raw: Scan
    """As it is in the file."""
    levelled: Scan
    """Without outliers, form and long waves."""
    scan: HeightMap
    """The same without short waves: what all parameters are of."""
    statistics: Statistics
    moments: Moments
    estimates: dict[str, SummitStatistics | None]
    """Summit statistics by the name of the estimate; None where there are none."""
    reasons: tuple[str, ...]
    """Why there are none, and why estimates differ."""
    summits: Summits | None
    whole_spectrum: Spectrum
    """Of the scan without outliers and form, before any cut-off."""
    spectrum: Spectrum
    fit: HeightFit
    table: CutoffTable
    errors: dict[str, float]
    """Standard errors from patches, by names such as "rms" and "mccool.density"."""
    verdicts: tuple[Verdict, ...]

    def cutoff_text(self) -> str:
        """The cut-off in words; there is always something to say."""
        if self.request.cutoff is not None:
            text = f"cut-off {engineering(self.request.cutoff, 'm', 4, trim=True)}"
        elif self.request.given:
            text = "no cut-off: the pixel decides"
        else:
            text = "no cut-off given: the pixel decides"
        if self.request.long_cutoff is None:
            return text
        return f"{text}, long-wave {engineering(self.request.long_cutoff, 'm', 4, trim=True)}"

    def title(self, what: str) -> str:
        """Title of a figure, which names the scan and the cut-off."""
        from microslip._core.wording import shorten

        return f"{what} of {shorten(self.raw.name, 50)}, {self.cutoff_text()}"


def analyse(request: Request, progress: Progress | None = None) -> Findings:
    """Measure a scan.

    Parameters
    ----------
    request : Request
        What is wanted.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.

    Returns
    -------
    Findings
        Parameters, spectra, summits and their dependence on the cut-off.

    Raises
    ------
    InputError
        A file that cannot be read, or heights that cannot be measured.
    """
    report = progress or (lambda share: None)
    raw = Scan.read(request.path, **request.reading)
    report(0.1)
    level: Any = None if request.level == "none" else request.level
    whole = raw.condition(
        outliers=request.outliers, level=level, fill="interpolate" if request.fill else None
    )
    levelled = whole.condition(long_cutoff=request.long_cutoff)
    report(0.2)
    summits, reasons = _summits(request, levelled)
    scan = levelled.condition(cutoff=request.cutoff) if summits is None else summits.scan
    statistics, moments = scan.statistics(), scan.moments()
    report(0.3)
    estimates: dict[str, SummitStatistics | None] = {}
    makers: dict[str, Callable[[], SummitStatistics]] = {
        "mccool": moments.mccool,
        "nayak": lambda: moments.nayak_summits().statistics(),
    }
    if summits is not None:
        makers["counted"] = lambda: summits.statistics("counted")
        makers["neighbours"] = lambda: summits.statistics("neighbours")
    for name, make in makers.items():
        try:
            estimates[name] = make()
        except InputError as error:
            estimates[name] = None
            reasons.append(f"No summits by {NAMES[name]}: {error}.")
    report(0.4)
    whole_spectrum = whole.spectrum()
    cut = request.cutoff is not None or request.long_cutoff is not None
    spectrum = spectrum_of(scan.measurable()) if cut else whole_spectrum
    fit = height_distribution(scan.measurable())
    report(0.5)
    judged = _verdicts(scan, summits, estimates["mccool"])
    table = _over_cutoffs(levelled, request, summits, lambda share: report(0.5 + 0.4 * share))
    found = Findings(
        request=request,
        raw=raw,
        levelled=levelled,
        scan=scan,
        statistics=statistics,
        moments=moments,
        estimates=estimates,
        reasons=(),
        summits=summits,
        whole_spectrum=whole_spectrum,
        spectrum=spectrum,
        fit=fit,
        table=table,
        errors=errors_of(scan, summits),
        verdicts=judged,
    )
    report(1.0)
    return replace(found, reasons=(*reasons, *differences(found)))


NAMES = {
    "mccool": "McCool's moments",
    "nayak": "Nayak's moments",
    "counted": "counting",
    "neighbours": "eight neighbours",
}
"""Estimates of summits in words."""


def _summits(request: Request, levelled: Scan) -> tuple[Summits | None, list[str]]:
    if levelled.is_profile:
        return None, [
            "A profile has peaks but no summits: only moments tell of them, as if it were of an "
            "isotropic Gaussian surface."
        ]
    try:
        method: Any = request.method
        return levelled.summits(
            request.cutoff, method=method, prominence=request.prominence, level=None
        ), []
    except InputError as error:
        return None, [f"No summits were counted: {error}."]


def _over_cutoffs(
    levelled: Scan, request: Request, summits: Summits | None, report: Progress
) -> CutoffTable:
    """Parameters against the usual cut-offs and the one that was asked for."""
    import numpy as np

    from microslip.scans.cutoffs import default_cutoffs, over_cutoffs

    cutoffs = default_cutoffs(levelled)
    if request.cutoff is not None:
        apart = np.abs(cutoffs - request.cutoff) > 0.1 * request.cutoff
        cutoffs = np.append(cutoffs[apart], request.cutoff)
    return over_cutoffs(
        levelled,
        cutoffs,
        level=None,
        method=request.method,  # type: ignore[arg-type]
        prominence=request.prominence,
        progress=lambda done, count: report(done / count),
        known=summits,
    )


def _verdicts(
    scan: HeightMap, summits: Summits | None, mccool: SummitStatistics | None
) -> tuple[Verdict, ...]:
    found = list(verdicts(scan))
    if scan.is_profile and mccool is not None:
        from microslip.scans.verdicts import judged, radius_in_pixels

        found += judged(radius_in_pixels(mccool.radius, scan.pixel))
    if summits is not None:
        # Of moments of no Gaussian surface the verdicts of the scan tell, as of the kurtosis.
        with suppress(InputError):
            known = {v.name for v in found}
            found += [
                v
                for v in summits.validity()
                if v.name not in known and not v.name.startswith("kurtosis")
            ]
    return tuple(found)
