"""Floor 8: a result on one page of HTML that needs nothing but a browser, and mails well."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from microslip._core.units import engineering
from microslip.study import figures
from microslip.study import report_tables as tables
from microslip.study.summary import REMINDER
from microslip.study.varying import in_words

if TYPE_CHECKING:
    from jinja2 import Environment

    from microslip.study.result import Progress, Result

MOST_TEXT = 20_000
"""Characters of the study's TOML that the page shows."""
LARGEST_SVG = 200_000
"""Bytes up to which a figure is lines in any case; beyond, where these are less than a picture."""

_LAWS = {
    "greenwood-williamson": "of a Greenwood–Williamson surface",
    "population": "of a given population of summits",
    "sphere": "of one sphere on a flat",
    "table": "with a tabulated normal law",
    "scan": "of a scanned surface",
}
_HEADLINES = {
    "ok": "All assumptions of the model hold.",
    "not judged": "What was judged holds, but not all was:",
    "watch": "Read with care:",
    "outside": "Outside the model’s range:",
    "none": "No limits are known for this law: what it assumes is for you to judge.",
}
_SCALES = {
    "slip_per_indentation * heights.std": "κ times the standard deviation of the heights",
    "slip_per_indentation * heights.scale": "κ times the mean height",
    "slip_per_indentation * spread of the heights": (
        "κ times the spread of the heights (the standard deviation, where that is finite)"
    ),
    "force_limit / tangential_stiffness": "the force limit over the stiffness at rest",
}


class Picture(NamedTuple):
    """A figure as the page shows it."""

    name: str
    source: str
    """A data URI."""
    alternative: str
    """What it is, for those who cannot see it."""
    caption: str
    """What to see in it."""


def write(result: Result, path: Path, progress: Progress | None = None) -> None:
    """Write the report of a result.

    Parameters
    ----------
    result : Result
        What to report.
    path : pathlib.Path
        The HTML file.
    progress : callable, optional
        Called after each figure with the share that is done, 0 … 1.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    path.write_text(page(result, progress), encoding="utf-8", newline="\n")


def page(result: Result, progress: Progress | None = None) -> str:
    """Make the report of a result.

    Parameters
    ----------
    result : Result
        What to report.
    progress : callable, optional
        Called after each figure with the share that is done, 0 … 1.

    Returns
    -------
    str
        One page of HTML5 without scripts and without anything to fetch.
    """
    summary = result.summary
    judged = tables.judgements(summary)
    text = result.study.text
    drawn = _pictures(result, progress)
    meaning = summary["joints"][0]["slip_scale_meaning"]
    return (
        environment()
        .get_template("report.html")
        .render(
            title=summary["title"] or "Joint",
            version=summary["generator"]["version"],
            sentence=predicted(result),
            word=judged[0].word if judged else "none",
            headline=_HEADLINES[judged[0].word if judged else "none"],
            doubts=[j for j in judged if j.word != "ok"],
            judged=judged,
            load_varies=result.study.excitation.load_varies,
            groups=tables.study_groups(result.study),
            toml=text[:MOST_TEXT],
            cut=len(text) > MOST_TEXT,
            joint=tables.joint_table(summary),
            scale=_SCALES.get(meaning, meaning),
            cycles=tables.cycle_table(summary),
            varying=tables.varying_table(summary) if result.varying else None,
            oscillator=tables.oscillator_table(summary) if result.oscillators else None,
            history=tables.history_table(summary) if result.histories else None,
            pictures=drawn,
            notes=[note for note in summary["notes"] if note != REMINDER],  # it is in the head
            law=tables.law_of(result.study),
            known=result.joints[0].contact_area is not None,
            generator=summary["generator"],
            files=tables.file_groups(summary["files"]),
        )
    )


def environment() -> Environment:
    """Where the templates of all pages are, and how they are filled in."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def predicted(result: Result) -> str:
    """Say in a sentence what was computed.

    Parameters
    ----------
    result : Result
        Any result.

    Returns
    -------
    str
        Such as "Hysteresis, stiffness and damping of a joint of …".
    """
    study = result.study
    excitation = study.excitation
    loads = [joint.normal_load for joint in result.joints]
    if excitation.force_amplitudes is not None:
        what, unit, values = "force amplitude", "N", result.rows[0].force_amplitude
    else:
        what, unit, values = "displacement amplitude", "m", result.rows[0].amplitude
    sentence = (
        f"Hysteresis, stiffness and damping {_LAWS[study.surface.law]}, friction coefficient "
        f"{study.joint.friction_coefficient:g}, at {_several('normal load', loads, 'N')}, "
        f"cycled at {_several(what, values.tolist(), unit)}"
    )
    if result.histories:
        sentence += f", along a history of {result.histories[0].force.size} samples"
    if result.oscillators:
        sentence += ", and in an oscillator"
    return sentence + "."


def _several(what: str, values: list[float], unit: str) -> str:
    texts = [engineering(value, unit, 4, trim=True) for value in values]
    if len(values) == 1:
        return f"one {what}, {texts[0]}"
    ends = [texts[values.index(end)] for end in (min(values), max(values))]
    return f"{len(values)} {what}s, {ends[0]} to {ends[1]}"


# -- figures -------------------------------------------------------------------------------------


def _pictures(result: Result, progress: Progress | None) -> list[Picture]:
    names = figures.names(result)
    drawn = []
    for index, name in enumerate(names):
        alternative, caption = _CAPTIONS[name]
        if result.study.excitation.load_varies:
            caption = _while_varying(result, name, caption)
        drawn.append(Picture(name, _source(result, name), alternative, caption))
        if progress is not None:
            progress((index + 1) / len(names))
    return drawn


def _while_varying(result: Result, name: str, caption: str) -> str:
    """The caption of a figure of a study in which the normal load varies somewhere."""
    variation = result.study.excitation.load_variation
    if name == "history":
        if result.histories[0].varying_normal_load is None:
            return f"{caption} The normal load is constant along it."
        return f"{caption} The normal load starts from that of the joint and follows the file."
    if name == "loops" and variation is not None:
        return (
            f"Closed hysteresis loops, {_PANELS}. The normal load varies over these cycles about "
            f"the one named: {in_words(variation)}. So the loops need not be symmetric. The area "
            "is the energy lost in a cycle."
        )
    if variation is not None:
        for constant, varying in _OTHERWISE:
            caption = caption.replace(constant, varying)
        if name in ("energy_damping", "force_damping"):
            return f"{caption} Lines and hollow markers are at constant normal load."
    return f"{caption} All this is at constant normal load."


def _source(result: Result, name: str) -> str:
    return data_uri(
        figures.picture(result, name, "svg"), lambda: figures.picture(result, name, "png")
    )


def data_uri(svg: bytes, png: Callable[[], bytes]) -> str:
    """A figure as a data URI: apart from the page, so that its names and styles stay its own.

    Parameters
    ----------
    svg : bytes
        The figure as SVG.
    png : callable
        Gives it as PNG; called where the SVG is large.

    Returns
    -------
    str
        The smaller one, or the SVG if it is small enough in any case.
    """
    small = packed(svg)
    if len(small) > LARGEST_SVG:
        pixels = png()
        if len(pixels) < len(small):
            return _uri("image/png", pixels)
    return _uri("image/svg+xml", small)


def svg_uri(svg: bytes) -> str:
    """An SVG figure, however large, as a data URI."""
    return _uri("image/svg+xml", packed(svg))


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def packed(svg: bytes) -> bytes:
    """An SVG file without what only its editors use: indentation, comments, names of groups."""
    svg = re.sub(rb"<!--.*?-->|<metadata>.*?</metadata>", b"", svg, flags=re.DOTALL)
    svg = re.sub(rb'<g id="(?:line2d|text|patch|[xy]tick)_\d+">', b"<g>", svg)
    return re.sub(rb">\s+<", b"><", svg)


_PANELS = "one panel for each amplitude and one loop for each load"
# What holds of loops at constant normal load only, and what stands for it where that varies.
_OTHERWISE = (
    ("every loop follows", "every loop at constant load follows"),
    ("which no force amplitude passes", "which no force amplitude passes at constant load"),
    (
        "markers are the loops.",
        "filled markers are the loops, under a load that varies about the one named; hollow ones "
        "are at their amplitudes.",
    ),
)
_CAPTIONS = {
    "loops": (
        "Hysteresis loops, force against displacement",
        f"Closed hysteresis loops, {_PANELS}. Thin "
        "and pointed: most contacts stick (microslip). A parallelogram with flat ends: all slide. "
        "The area is the energy lost in a cycle.",
    ),
    "backbone": (
        "Force and stiffness of first loading against displacement",
        "First loading from rest (the backbone), from which every loop follows: its slope is kₜ "
        "while all sticks, and it ends at the force limit μN. Below, the tangent stiffness and the "
        "secant stiffness, which a linear model of the joint would have at that amplitude.",
    ),
    "energy_damping": (
        "Dissipated energy, loss factor and exponent against displacement amplitude",
        "Energy lost in a cycle, loss factor η with damping ratio ζ = η/2, and the local exponent "
        "of the energy, over the displacement amplitude; markers are the loops. The exponent is 3 "
        "in the microslip of a smooth backbone and 1 in gross slip.",
    ),
    "force_damping": (
        "Dissipated energy, loss factor and exponent against force amplitude",
        "The same over the force amplitude, as tests under force control show it. Dotted lines are "
        "the force limits μN, which no force amplitude passes; towards them energy and exponent "
        "rise steeply.",
    ),
    "contact_state": (
        "Contacts and real contact area against load, sticking share against displacement",
        "Contacts and real contact area over the normal load, with the loads of the study marked; "
        "below, the share of the contact area that still sticks after a displacement from rest.",
    ),
    "slider_density": (
        "Slider density and share of the force limit against yield displacement",
        "The joint as a parallel Iwan model: the stiffness of its sliders per yield displacement, "
        "and the share of the force limit that the sliders up to a yield displacement carry.",
    ),
    "history": (
        "Displacement, force and dissipated energy along the history, and its path",
        "The own history from rest: displacement, force and energy lost so far over the samples, "
        "and the path that force and displacement take.",
    ),
    "oscillator": (
        "Frequency and damping of the oscillator against displacement amplitude",
        "A mass on a spring that the joint holds, too: its frequency, the shift of it, and the "
        "damping ratio of the mode (solid) beside the interface’s own (dashed). The two differ: "
        "energy is lost in the joint alone, but the whole mode stores it.",
    ),
}
