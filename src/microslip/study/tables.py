"""Floor 8: a result on the terminal, and what a study says before it is one."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, TextIO

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.report.printer import Printer
from microslip.study.cells import (
    contact_count,
    force_ratio,
    is_by_force,
    pictures,
    ratio,
    standardised,
    verdict_limit,
    verdict_value,
)
from microslip.study.result import some
from microslip.study.summary import REMINDER

MOST_JOINTS = 20
MOST_LOOPS = 40
MOST_VERDICTS = 3
MOST_ITEMS = 4

Places = list[tuple[dict[str, Any], int]]
"""Joints of a summary, each with the index of one of its amplitudes."""

# The first one that applies.
_VERDICTS = (
    ("outside", "Outside of what the model assumes; it runs all the same."),
    ("watch", "Fine, but see the verdicts."),
    ("not judged", "Fine as far as it was judged: see the verdicts."),
    ("ok", "Fine."),
)


def show(summary: dict[str, Any], stream: TextIO | None) -> None:
    """Print a result so that it can be read at a glance.

    Parameters
    ----------
    summary : dict
        Of a :class:`~microslip.study.result.Result`.
    stream : file object or None
        Such as `sys.stdout`.

    Raises
    ------
    OSError
        If the stream cannot be written.
    """
    out = Printer(stream)
    joints = summary["joints"]
    out.line(summary["title"] or "Joint", style="bold")
    out.line()
    _joints(out, summary)
    amplitudes = len(joints[0]["amplitudes"])
    loops = len(joints) * amplitudes
    shown = joints
    if loops > MOST_LOOPS:
        shown = [joints[i] for i in some(len(joints), 4)]
    kept = some(amplitudes, MOST_LOOPS // len(shown))
    places = [(joint, i) for joint in shown for i in kept]
    left_out = _left_out(len(places), loops, "loops")
    _cycles(out, summary, places, left_out)
    _varying(out, places, left_out)
    _oscillator(out, summary, places, left_out)
    _histories(out, [joints[i] for i in some(len(joints), MOST_JOINTS)])
    _validity(out, joints)
    out.line()
    notes = [note for note in summary["notes"] if note != REMINDER]  # which comes in symbols
    for note in notes:
        out.line(note)
    if notes:
        out.line()
    out.line(
        "η (loss factor) and ζ = η/2 (damping ratio) are the interface's own, not a mode's: "
        "in a structure ζ_mode = ΣE_d / 4πU."
    )


def show_files(summary: dict[str, Any], folder: Path, stream: TextIO | None) -> None:
    """Print what was written: files by what they are for; a figure once, whatever its formats.

    Parameters
    ----------
    summary : dict
        Of a :class:`~microslip.study.result.Result`.
    folder : pathlib.Path
        Where its files are.
    stream : file object or None
        Such as `sys.stdout`.

    Raises
    ------
    OSError
        If the stream cannot be written.
    """
    out = Printer(stream)
    names = summary["files"]
    figures, kinds = pictures(names)
    if figures:
        figures.append(f"({', '.join(kinds)})")
    out.line()
    out.path(f"Written to {shorten(str(folder), 1000)}:")
    for head, group in (
        ("  report", [name for name in names if name.endswith(".html")]),
        ("  figures", figures),
        ("  tables", [name for name in names if name.endswith((".nc", ".csv"))]),
        ("  summary", [name for name in names if name.endswith(".json")]),
        ("  study", [name for name in names if name.endswith(".toml")]),
    ):
        if group:
            out.words(head, group, 11)


def show_preview(found: dict[str, Any], command: str, stream: TextIO | None) -> None:
    """Print what :func:`microslip.study.preview.preview` found.

    Parameters
    ----------
    found : dict
        What it gave.
    command : str
        What to type next.
    stream : file object or None
        Such as `sys.stdout`.

    Raises
    ------
    OSError
        If the stream cannot be written.
    """
    out = Printer(stream)
    out.line(found["title"] or "Joint", style="bold")
    out.line()
    out.table(
        "Quantities",
        ["key", "written", "in SI units"],
        [_quantity_row(quantity) for quantity in found["quantities"]],
        text=(0, 1, 2),
    )
    _joints(out, found)
    _validity(out, found["joints"])
    out.line()
    for note in found["notes"]:
        out.line(note)
    if found["notes"]:
        out.line()
    parts = [f"{found['loops']} loops", f"curves of {found['points']} points in all"]
    if found["samples"]:
        parts.append(f"histories of {found['samples']} samples in all")
    words = {verdict["word"] for joint in found["joints"] for verdict in joint["validity"]}
    verdict = next(text for word, text in _VERDICTS if word in {*words, "ok"})
    out.line(f"{verdict} To compute {', '.join(parts)}, and write {len(found['files'])} files:")
    out.path(f"  {command}")


def _quantity_row(quantity: dict[str, Any]) -> list[str]:
    written, unit = quantity["written"], quantity["unit"]
    if "count" in quantity:
        ends = (si(quantity[end]) for end in ("smallest", "largest"))
        value = f"{quantity['count']} values, {' to '.join(ends)}"
    else:
        value = _list(quantity["value"], si)
    shown = "– (table of metals)" if written is None else _list(written, str)
    return [quantity["key"], shown, value if unit == "-" else f"{value} {unit}"]


def _list(value: Any, write: Callable[[Any], str]) -> str:
    """One value, or those of a list as far as there is room."""
    if not isinstance(value, list):
        return write(value)
    if len(value) <= MOST_ITEMS:
        return ", ".join(map(write, value))
    first, second, last = map(write, (value[0], value[1], value[-1]))
    return f"{first}, {second} … {last} ({len(value)})"


def _joints(out: Printer, summary: dict[str, Any]) -> None:
    law = summary["study"]["surface"]["law"]
    joints = summary["joints"]
    shown = [joints[i] for i in some(len(joints), MOST_JOINTS)]
    head = ["load", "contacts", "real area", "kₜ", "μN", "slip scale", "h"]
    rows = [_joint_row(joint, law) for joint in shown]
    # Columns of which nothing is known are left out, as in the report.
    known = [i for i in range(len(head)) if any(row[i] != "–" for row in rows)]
    out.table(
        "Joint" + _left_out(len(shown), len(joints), "loads"),
        [head[i] for i in known],
        [[row[i] for i in known] for row in rows],
    )


def _cycles(out: Printer, summary: dict[str, Any], places: Places, left_out: str) -> None:
    """Cyclic quantities; what was chosen comes first, displacements or forces."""
    head = ["load", "amplitude", "T/μN", "energy/cycle", "η", "ζ"]
    rows = [_cycle_row(joint, joint["amplitudes"][i]) for joint, i in places]
    if is_by_force(summary):
        head.insert(1, "force")
        for (joint, i), cells in zip(places, rows, strict=True):
            force = joint["amplitudes"][i]["force_amplitude"]
            cells.insert(1, engineering(force, "N", trim=True))
    at = " at constant load" if "varying" in places[0][0] else ""
    out.table(f"Cycles{at}" + left_out, head, rows, keys=2)


def _varying(out: Printer, places: Places, left_out: str) -> None:
    """The loops under a normal load that varies, if it does."""
    if "varying" not in places[0][0]:
        return
    rows = []
    for joint, i in places:
        row = joint["varying"][i]
        ends = (row[f"{end}_normal_load"] for end in ("smallest", "largest"))
        rows.append(
            [
                engineering(joint["normal_load"], "N", trim=True),
                engineering(row["amplitude"], "m", trim=True),
                " – ".join(engineering(end, "N", trim=True) for end in ends),
                engineering(row["dissipated_energy"], "J"),
                ratio(row["energy_share"]),
                ratio(row["loss_factor"]),
            ]
        )
    head = ["load", "amplitude", "load varies", "energy/cycle", "/ at constant", "η"]
    out.table("Cycles as the load varies" + left_out, head, rows, keys=2)


def _oscillator(out: Printer, summary: dict[str, Any], places: Places, left_out: str) -> None:
    """What the joint does to the oscillator, if there is one."""
    if "oscillator" not in places[0][0]:
        return
    by_force = is_by_force(summary)
    key, unit = ("force_amplitude", "N") if by_force else ("amplitude", "m")
    rows = []
    for joint, i in places:
        mode = joint["oscillator"]["amplitudes"][i]
        at_rest = joint["oscillator"]["frequency_at_rest"]
        rows.append(
            [
                engineering(joint["normal_load"], "N", trim=True),
                engineering(joint["amplitudes"][i][key], unit, trim=True),
                engineering(mode["frequency"], "Hz", 5),
                _shift(mode["frequency"] / at_rest - 1.0),
                ratio(mode["damping_ratio"]),
            ]
        )
    head = ["load", "force" if by_force else "amplitude", "frequency", "shift", "ζ_mode"]
    out.table("Oscillator" + left_out, head, rows, keys=2)


def _histories(out: Printer, joints: list[dict[str, Any]]) -> None:
    """The own history at each load, if there is one."""
    if "history" not in joints[0]:
        return
    out.table(
        "History",
        ["load", "largest displacement", "largest force", "energy"],
        [
            [
                engineering(joint["normal_load"], "N", trim=True),
                engineering(joint["history"]["largest_displacement"], "m"),
                engineering(joint["history"]["largest_force"], "N"),
                engineering(joint["history"]["dissipated_energy"], "J"),
            ]
            for joint in joints
        ],
    )


def _left_out(shown: int, count: int, what: str) -> str:
    return "" if shown == count else f" ({shown} of {count} {what}; all are in summary.json)"


def _joint_row(joint: dict[str, Any], law: str) -> list[str]:
    share = joint["contact_area_fraction"]
    return [
        engineering(joint["normal_load"], "N", trim=True),
        contact_count(joint["contact_count"], law),
        _area(joint["contact_area"]) if share is None else f"{significant(100.0 * share)} %",
        engineering(joint["tangential_stiffness"], "N/m"),
        engineering(joint["force_limit"], "N"),
        engineering(joint["slip_scale"], "m"),
        standardised(joint["standardised_separation"]),
    ]


def _area(area: float | None) -> str:
    return "–" if area is None else f"{significant(area * 1e6)} mm²"


def _cycle_row(joint: dict[str, Any], row: dict[str, Any]) -> list[str]:
    return [
        engineering(joint["normal_load"], "N", trim=True),
        engineering(row["amplitude"], "m", trim=True),
        force_ratio(row["force_ratio"]),
        engineering(row["dissipated_energy"], "J"),
        ratio(row["loss_factor"]),
        ratio(row["damping_ratio"]),
    ]


def si(value: float) -> str:
    """Write a number with all its digits and a short exponent.

    Parameters
    ----------
    value : float
        Any number.

    Returns
    -------
    str
        Such as "6.9e10" or "0.0002".
    """
    text = f"{value:.10g}"
    if abs(value) >= 1e6 and "e" not in text:
        mantissa, _, exponent = f"{value:.9e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{exponent}"
    return re.sub(r"e([+-])0*", lambda found: f"e{found[1].strip('+')}", text)


def _shift(value: float) -> str:
    """A relative change in percent."""
    return "0 %" if value == 0.0 else f"{significant(100.0 * value)} %"


def _judged(verdict: dict[str, Any]) -> str:
    """Value of a verdict that is not ok, and where ok would be."""
    name, value, limit = verdict["name"], verdict["value"], verdict["limit"]
    if value is None:
        return f"not known (ok up to {verdict_limit(name, limit)})"
    side = "from" if value < limit else "up to"
    return f"{verdict_value(name, value)} (ok {side} {verdict_limit(name, limit)})"


def _where(load: float, worst: float | None, *, all_loads: bool) -> str:
    """Load of the joint at which a verdict holds and, if it varies, to where it then goes."""
    at = "" if all_loads else f" at {engineering(load, 'N', trim=True)}"
    if worst is None or worst == load:
        return at
    goes = f"{'grows' if worst > load else 'falls'} to {engineering(worst, 'N', trim=True)}"
    return f"{at}, as it {goes}" if at else f" as the load {goes}"


def _validity(out: Printer, joints: list[dict[str, Any]]) -> None:
    """Each verdict that is not ok, with its value and where ok is; the others only by name."""
    out.line("Validity", style="bold")
    fine: list[str] = []
    for name in dict.fromkeys(v["name"] for joint in joints for v in joint["validity"]):
        found = [
            (joint, verdict)
            for joint in joints
            for verdict in joint["validity"]
            if verdict["name"] == name
        ]
        doubtful = [(joint, verdict) for joint, verdict in found if verdict["word"] != "ok"]
        if not doubtful:
            fine.append(name)
        alike = {(v["value"], v.get("normal_load")) for _, v in doubtful}
        same = len(doubtful) == len(joints) and len(alike) == 1
        doubtful.sort(key=lambda pair: pair[1]["word"] != "outside")
        shown = doubtful[: 1 if same else MOST_VERDICTS]
        for joint, verdict in shown:
            at = _where(joint["normal_load"], verdict.get("normal_load"), all_loads=same)
            out.verdict(
                verdict["word"],
                f"{name}{at}: {_judged(verdict)} – assumed: {verdict['meaning']}",
            )
        if not same and len(doubtful) > len(shown):
            left = len(doubtful) - len(shown)
            out.verdict("", f"and at {left} other load{'s' if left > 1 else ''}")
    if fine:
        out.verdict("ok", ", ".join(fine))
    if not any(joint["validity"] for joint in joints):
        out.line("  no limits are known for this law")
