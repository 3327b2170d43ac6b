"""Floor 8: the files of a measured scan: tables, figures, a page, and a surface for a study."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from microslip.study.scanned_block import block, makes_surface
from microslip.study.scanned_errors import HEIGHTS
from microslip.study.scanned_summary import summarise

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from microslip.study.report import Picture
    from microslip.study.scanned import Findings, Progress

FIGURES = ("heights", "density", "spectrum", "cutoffs")

_UNITS = {"density": "1/mm^2"}


def write(
    found: Findings,
    folder: Path,
    progress: Progress | None = None,
    destination: Path | None = None,
) -> dict[str, Any]:
    """Write every file of a measured scan.

    Parameters
    ----------
    found : Findings
        What was found.
    folder : pathlib.Path
        An existing folder.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.
    destination : pathlib.Path, optional
        Where the folder will be once it is whole, if not where it is.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    report = progress or (lambda share: None)
    names = ["report.html", "cutoffs.csv"]
    _write(folder / "cutoffs.csv", _cutoffs(found))
    if found.summits is not None:
        _write(folder / "summits.csv", _summits(found))
        names.append("summits.csv")
    if makes_surface(found):
        _write(folder / "surface.toml", block(found, destination or folder))
        names.append("surface.toml")
    pictures = {}
    shown = figures_of(found)
    for number, name in enumerate(shown, start=1):
        pictures[name] = _picture(found, name, folder)
        names += [f"{name}.svg", f"{name}.png"]
        report(number / (len(shown) + 1))
    summary = summarise(found, tuple(names))
    _write(folder / "report.html", page(found, summary, pictures, destination or folder))
    _write(folder / "summary.json", json.dumps(summary, indent=1, ensure_ascii=False) + "\n")
    report(1.0)
    return summary


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _cutoffs(found: Findings) -> str:
    """Parameters against the cut-off; empty where there is no cut-off or no value."""
    units = {"cutoff": "m", "counted": "-", "m0": "m^2", "m2": "-", "m4": "1/m^2", "nayak": "-"}
    names = found.table.names
    heads = [units.get(name) or ("1/m^2" if name.endswith("density") else "m") for name in names]
    lines = [",".join(f"{name} [{unit}]" for name, unit in zip(names, heads, strict=True))]
    for row in found.table.rows():
        cells = [
            "" if value != value or (name == "cutoff" and value == 0.0) else repr(value)
            for name, value in row.items()
        ]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def _summits(found: Findings) -> str:
    """The summits, one a row, highest first."""
    assert found.summits is not None
    summits = found.summits
    head = "x [m],y [m],height [m],radius [m],curvature_1 [1/m],curvature_2 [1/m],prominence [m]"
    columns = np.column_stack(
        [
            summits.positions,
            summits.heights,
            summits.radii,
            summits.curvatures,
            summits.prominences,
        ]
    )[np.argsort(-summits.heights, kind="stable")]
    rows = [",".join(map(repr, row)) for row in columns.tolist()]
    return "\n".join([head, *rows]) + "\n"


# -- figures --------------------------------------------------------------------------------------


def figures_of(found: Findings) -> tuple[str, ...]:
    """Names of the figures; a scan with no cut-off to choose has none of parameters over them."""
    return tuple(name for name in FIGURES if name != "cutoffs" or found.table.cutoff.size > 1)


def figure(found: Findings, name: str) -> Figure:
    """One of the figures.

    Parameters
    ----------
    found : Findings
        What was found.
    name : str
        One of :data:`FIGURES`.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, laid out.
    """
    from microslip.study import scanned_cutoffs, scanned_density, scanned_map, scanned_spectrum
    from microslip.study.drawing import settle

    makers: dict[str, Callable[[Findings], Figure]] = {
        "heights": scanned_map.draw,
        "density": scanned_density.draw,
        "spectrum": scanned_spectrum.draw,
        "cutoffs": scanned_cutoffs.draw,
    }
    drawn = makers[name](found)
    settle(drawn)
    return drawn


def _picture(found: Findings, name: str, folder: Path) -> Picture:
    """Write a figure as SVG and PNG; and for the page, whichever is the smaller."""
    from matplotlib import style

    from microslip.study.drawing import STYLE
    from microslip.study.report import Picture, data_uri

    # From matplotlib's own defaults, whatever the user's matplotlibrc says.
    with style.context(["default", STYLE]):
        drawn = figure(found, name)
        # No dates: the same scan gives the same files.
        drawn.savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})
        drawn.savefig(folder / f"{name}.png", metadata={"Software": None})
    alternative, caption = _CAPTIONS[name]
    if name == "heights" and found.scan.is_profile:
        alternative, caption = "The profile", "Heights above the mean. {cutoff}."
    if name == "spectrum" and found.scan.missing > 0.0:
        caption += _GAPS
    source = data_uri(
        (folder / f"{name}.svg").read_bytes(), lambda: (folder / f"{name}.png").read_bytes()
    )
    return Picture(name, source, alternative, caption.format(cutoff=_capital(found.cutoff_text())))


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


_CAPTIONS = {
    "heights": (
        "Map of the heights with the summits, and a part of it",
        "Heights above the mean, and the summits. {cutoff}. The framed part is shown larger, with "
        "every summit; colours end where half a percent of the points is beyond them.",
    ),
    "density": (
        "A trace of the heights, and their density with fits",
        "Roughness in the manner of Fig. 19.6 of the chapter: a trace, the density of all heights "
        "with the distributions that fit best, and its logarithm, which shows the tails. {cutoff}. "
        "The percentages are the largest share of the points that a distribution misses. Where "
        "nearly all heights would be a spike, (b) shows those between the dotted lines.",
    ),
    "spectrum": (
        "Power spectrum against wavelength, radial and along both axes",
        "Power spectrum: the variance of the heights by wavelength; grey ground is what the "
        "cut-offs remove. {cutoff}.",
    ),
    "cutoffs": (
        "Summit density, radius, spread, rms height and slope, Nayak's alpha against the cut-off",
        "Every parameter against the short-wave cut-off. {cutoff}. A parameter that does not level "
        "off is one of the cut-off as much as of the surface.",
    ),
}


_GAPS = (
    " Missing points count as points on the mean, and steps at the edges of gaps make waves of "
    "every length: of such is what seems to have passed a cut-off, and not of the surface."
)


# -- page -----------------------------------------------------------------------------------------


def page(
    found: Findings, summary: dict[str, Any], pictures: dict[str, Picture], folder: Path
) -> str:
    """The report of a measured scan.

    Parameters
    ----------
    found : Findings
        What was found.
    summary : dict
        Of :func:`microslip.study.scanned_summary.summarise`.
    pictures : dict
        The figures.
    folder : pathlib.Path
        Where the page will be.

    Returns
    -------
    str
        One page of HTML5 without scripts and without anything to fetch.
    """
    from microslip.study import scanned_tables as tables
    from microslip.study.report import environment

    judged = tables.judgements(summary)
    word = judged[0].word
    summits = tables.summit_table(summary)
    return (
        environment()
        .get_template("scanned.html")
        .render(
            title=f"Surface of {summary['name']}",
            version=summary["version"],
            sentence=f"{tables.described(summary)}. {_capital(found.cutoff_text())}.",
            word="watch" if word == "ok" and summary["warnings"] else word,
            headline=_HEADLINES[word] if not summary["warnings"] else "Read with care:",
            remarks=summary["warnings"],
            parameters=tables.parameter_table(summary),
            errors=_errors(summary),
            summits=summits,
            cutoffs=tables.cutoff_table(summary),
            explained=tables.cutoffs_explained(summary),
            pictures=list(pictures.values()),
            fits=summary["heights"]["verdict"],
            judged=judged,
            notes=summary["notes"],
            toml=block(found, folder) if makes_surface(found) else None,
            files=[name for name in summary["files"] if name != "report.html"],
        )
    )


_HEADLINES = {
    "ok": "The scan bears what is read from it.",
    "watch": "Read with care: see the verdicts.",
    "outside": "Some of the numbers are not to be built on: see the verdicts.",
}


def _errors(summary: dict[str, Any]) -> str:
    if all(summary["parameters"][name]["error"] is None for name in HEIGHTS):
        return "The scan is too small for error bars from patches of it."
    return (
        "Error bars are standard errors of the mean over nine patches of the scan; waves longer "
        "than a patch make them too small."
    )
