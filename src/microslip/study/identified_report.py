"""Floor 8: an identification on one page of HTML that needs nothing but a browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from microslip._version import __version__
from microslip.study import identified_tables as tables
from microslip.study.identified_given import given_table, hanging_of, rig_texts
from microslip.study.report import Picture, svg_uri

if TYPE_CHECKING:
    from microslip.study.identified import Identified

_CAPTIONS = {
    "loops": (
        "Measured and modelled loops over each other, and the residual",
        "The mean cycle of each record (circles) and the identified law with the rig in series "
        "(line), one pair of panels for each normal load; below, what is left, towards larger "
        "(circles) and smaller displacements (triangles). Within the grey band it is noise.",
    ),
    "intervals": (
        "Interval of each parameter, and correlations",
        "Best values and intervals; an arrow is an end that the records leave open. Beside them "
        "the correlations of the errors.",
    ),
    "profiles": (
        "Likelihood profile of each parameter",
        "By how much χ² rises where a parameter is held at another value and all others are fitted "
        "again, over the factor by which intervals were widened. Values below the dashed level "
        "answer the loops; where the curve stays below it, the interval is open.",
    ),
}


def page(found: Identified, summary: dict[str, Any], toml: str | None, folder: Path) -> str:
    """Make the report of an identification.

    Parameters
    ----------
    found : Identified
        What was identified.
    summary : dict
        What summary.json holds.
    toml : str or None
        Text of joint.toml.
    folder : pathlib.Path
        Where the figures lie.

    Returns
    -------
    str
        One page of HTML5 without scripts and without anything to fetch.

    Raises
    ------
    OSError
        If a figure cannot be read.
    """
    from microslip.study.report import environment

    result = summary["identification"]
    comparison = summary["comparison"]
    return (
        environment()
        .get_template("identified_report.html")
        .render(
            version=__version__,
            title=_title(found),
            sentence=tables.sentence(result),
            word=tables.status_word(result),
            headline=tables.headline(result),
            message=tables.message_of(result),
            level=f"{100.0 * result['confidence']:g} %",
            parameters=tables.rows_of(result["parameters"]),
            derived=tables.rows_of(result["derived"]),
            hints=tables.hints_of(result, summary["study"]),
            open=tables.open_of(result),
            directions=tables.directions_of(result),
            pictures=_pictures(folder, summary["files"]),
            records=tables.record_table(result["records"]),
            quality=tables.quality_of(result),
            correlations=tables.correlation_table(result),
            hanging=hanging_of(result),
            given=given_table(result),
            laws=None if comparison is None else tables.law_table(comparison),
            rigs=[] if comparison is None else rig_texts(comparison),
            toml=toml,
            notes=result["notes"],
            files=", ".join(name for name in summary["files"] if name != "report.html"),
        )
    )


def _title(found: Identified) -> str:
    title = "" if found.study is None else found.study.title
    return f"{title}: identified" if title else "Identified joint"


def _pictures(folder: Path, names: list[str]) -> list[Picture]:
    """The figures that lie in the folder as SVG."""
    stems = [name.removesuffix(".svg") for name in names if name.endswith(".svg")]
    return [
        Picture(stem, svg_uri((folder / f"{stem}.svg").read_bytes()), *_CAPTIONS[stem])
        for stem in stems
    ]
