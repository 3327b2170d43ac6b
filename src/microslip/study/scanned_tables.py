"""Floor 8: a measured scan in tables of text, on the terminal and in the report alike."""

from __future__ import annotations

import math
from typing import Any, TextIO

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.report.printer import Printer
from microslip.study.report_tables import Judgement, Table
from microslip.study.scanned import NAMES
from microslip.study.scanned_errors import HEIGHTS, MOMENTS
from microslip.study.scanned_surface import NO_CUTOFF

_WORDS = ("ok", "watch", "outside")
NOT_SAID = "not given: the pixel decides"


def described(summary: dict[str, Any]) -> str:
    """Size of the scan in a sentence.

    Parameters
    ----------
    summary : dict
        Of a measured scan.

    Returns
    -------
    str
        Such as "768 x 576 points, pixel 1.66 µm, 1.27 x 0.956 mm".
    """
    points = " x ".join(str(n) for n in summary["points"])
    pixel = " x ".join(engineering(step, "m", 4) for step in dict.fromkeys(summary["pixel"]))
    size = " x ".join(engineering(length, "m") for length in summary["size"])
    missing = summary["missing"] or 0.0
    lost = f", {significant(100.0 * missing, 2)} % missing" if missing else ""
    return f"{points} points, pixel {pixel}, {size}{lost}"


def cutoff_text(summary: dict[str, Any]) -> str:
    """The short-wave cut-off in words; there is always something to say."""
    if summary["cutoff"] is not None:
        return engineering(summary["cutoff"], "m", 4, trim=True)
    return NO_CUTOFF if summary["cutoff_given"] else NOT_SAID


def parameter_table(summary: dict[str, Any]) -> Table:
    """Heights and moments with their error bars; the cut-off stands in the first row."""
    rows: list[tuple[str, ...]] = [("short-wave cut-off", cutoff_text(summary), "")]
    if summary["long_cutoff"] is not None:
        rows.append(("long-wave cut-off", engineering(summary["long_cutoff"], "m", 4), ""))
    for name, (label, unit) in {**HEIGHTS, **MOMENTS}.items():
        if name == "anisotropy" and len(summary["pixel"]) == 1:
            continue
        part = summary["parameters"][name]
        rows.append((label, written(part["value"], unit, 4), error(part["error"], unit)))
    return Table(("quantity", "value", "± (patches)"), rows)


def summit_table(summary: dict[str, Any]) -> Table | None:
    """Summits by every estimate; None where there is none at all."""
    parts = {name: part for name, part in summary["summits"].items() if part is not None}
    if not parts:
        return None
    rows = []
    for name, part in parts.items():
        cells = [NAMES[name]]
        for key in ("density", "radius", "std", "mean_height"):
            found = part[key]
            value = written(found["value"], found["unit"])
            cells.append(
                value
                if found["error"] is None
                else f"{value} ± {significant(100.0 * found['error'] / abs(found['value']), 2)} %"
                if found["value"]
                else value
            )
        rows.append(tuple(cells))
    head = ("summits by", "density [1/mm²]", "radius", "std of heights", "mean height")
    return Table((f"{head[0]} (cut-off {cutoff_text(summary)})", *head[1:]), rows)


def cutoff_table(summary: dict[str, Any]) -> Table:
    """Every parameter against the cut-off; the one that was asked for is marked."""
    pixel = math.sqrt(math.prod(summary["pixel"]) ** (2.0 / len(summary["pixel"])))
    rows = []
    for row in summary["over_cutoffs"]:
        cutoff = row["cutoff"]
        name = "none" if cutoff is None else engineering(cutoff, "m")
        chosen = cutoff == summary["cutoff"]
        rows.append(
            (
                f"{name} *" if chosen else f"{name}  ",
                written(row["rms"], "m"),
                written(row["nayak"], "-"),
                *(
                    written(row[f"{estimate}_{key}"], unit)
                    for key, unit in (("density", "1/m^2"), ("radius", "m"), ("std", "m"))
                    for estimate in ("mccool", "counted")
                ),
                written(_over(row["counted_radius"] or row["mccool_radius"], pixel), "-"),
            )
        )
    head = (
        *("cut-off", "Sq", "α", "density", "counted", "radius", "counted", "std", "counted"),
        "radius/pixel",
    )
    # Of a profile nothing is counted.
    known = [i for i in range(len(head)) if any(row[i] != "–" for row in rows)]
    return Table(tuple(head[i] for i in known), [tuple(row[i] for i in known) for row in rows])


def cutoffs_explained(summary: dict[str, Any]) -> str:
    """What the columns of the table over cut-offs are."""
    counted = any(row["counted_radius"] is not None for row in summary["over_cutoffs"])
    beside = (
        ", beside each the counted ones; radius/pixel is of the counted ones, where there are any"
        if counted
        else "; none were counted"
        if len(summary["pixel"]) > 1
        else ""
    )
    return (
        f"Density [1/mm²], radius and std of the summits by McCool's moments{beside}. "
        "* what was asked for."
    )


def _over(value: float | None, unit: float) -> float | None:
    return None if value is None else value / unit


def written(value: float | None, unit: str, digits: int = 3) -> str:
    """A number with its unit; powers of a length without prefixes.

    Parameters
    ----------
    value : float or None
        The number [SI unit]; "–" stands for None.
    unit : str
        Its SI unit, "-" for none.
    digits : int
        Significant digits.

    Returns
    -------
    str
        Such as "17.7 nm", and summits per square millimetre for a density.
    """
    if value is None:
        return "–"
    if unit == "m":
        return engineering(value, unit, digits)
    if unit == "1/m^2" and digits == 3:
        return significant(value * 1e-6)
    text = significant(value, digits)
    return text if unit == "-" else f"{text} {unit.replace('^2', '²')}"


def error(value: float | None, unit: str) -> str:
    """An error bar."""
    return "–" if value is None else written(value, unit, 2)


def judgements(summary: dict[str, Any]) -> list[Judgement]:
    """Verdicts, the worst first."""
    found = []
    for verdict in summary["validity"]:
        value, limit, word = verdict["value"], verdict["limit"], verdict["word"]
        rising = value is not None and (value >= limit) == (word == "ok") and value != limit
        bound = f"{'from' if rising else 'up to'} {limit:.3g}"
        found.append(
            Judgement(word, verdict["name"], significant(value), bound, "", verdict["meaning"])
        )
    return sorted(found, key=lambda judged: -_WORDS.index(judged.word))


def show(summary: dict[str, Any], stream: TextIO | None) -> None:
    """Print a measured scan so that it can be read at a glance.

    Parameters
    ----------
    summary : dict
        Of :func:`microslip.study.scanned_summary.summarise`.
    stream : file object or None
        Such as `sys.stdout`.

    Raises
    ------
    OSError
        If the stream cannot be written.
    """
    out = Printer(stream)
    out.line(f"{shorten(summary['name'], 200)}: {described(summary)}", style="bold")
    for text in summary["warnings"]:
        out.verdict("watch", text)
    out.line()
    parameters = parameter_table(summary)
    out.table("Heights and moments", parameters.head, parameters.rows, text=(0,))
    summits = summit_table(summary)
    if summits is not None:
        out.table("Summits", summits.head, summits.rows)
    table = cutoff_table(summary)
    out.table("Every parameter against the cut-off", table.head, table.rows)
    out.line(cutoffs_explained(summary))
    out.line()
    out.line(summary["heights"]["verdict"])
    out.line()
    out.line("Validity", style="bold")
    judged = judgements(summary)
    for one in judged:
        if one.word != "ok":
            out.verdict(
                one.word, f"{one.name}: {one.value} (ok {one.bound}) – assumed: {one.meaning}"
            )
    fine = [one.name for one in judged if one.word == "ok"]
    if fine:
        out.verdict("ok", ", ".join(fine))
    out.line()
    for note in summary["notes"]:
        out.line(note)
