"""Floor 8: an identified joint as files and on a terminal."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TextIO

from rich.cells import cell_len

from microslip._version import __version__
from microslip.report.printer import Printer

if TYPE_CHECKING:
    from microslip.identification import Comparison, Identification
    from microslip.study.identified_tables import Row
    from microslip.study.schema import Study
    from microslip.tribometer import Record

KIND = "microslip-identification"
"""What summary.json says of a folder of an identified joint."""


@dataclass(frozen=True)
class Identified:
    """What one command has found."""

    results: tuple[Identification, ...]
    """One for each law; the first is what the pictures and the study are of."""
    comparison: Comparison | None
    study: Study | None
    """The study that materials and start are from."""

    @property
    def first(self) -> Identification:
        """The law that was asked for first."""
        return self.results[0]

    @property
    def failed(self) -> Identification | None:
        """The first law, if its fit has not converged: then there are no numbers to give."""
        return None if self.first.converged else self.first


def units_of(laws: Sequence[str]) -> dict[str, str]:
    """Units of the parameters that some laws have, and of the rig's stiffness.

    Parameters
    ----------
    laws : sequence of str
        Names of laws.

    Returns
    -------
    dict
        SI units by names; "" for a plain number.
    """
    from microslip.identification.models import model_of

    found = {p.name: p.unit for law in laws for p in model_of(law).parameters}
    return {**found, "rig_stiffness": "N/m"}


def identified(
    records: Sequence[Record],
    laws: Sequence[str],
    study: Study | None,
    options: Mapping[str, Any],
    progress: Callable[[float], None],
) -> Identified:
    """Identify laws from records.

    Parameters
    ----------
    records : sequence of Record
        What was measured.
    laws : sequence of str
        Names of laws; the first is the one that is reported, the others are compared with it.
    study : Study or None
        Where materials, kind of heights and start of an interface are from.
    options : mapping
        As :func:`microslip.identify` takes them.
    progress : callable
        Called with the share that is done, 0 ... 1.

    Returns
    -------
    Identified
        Results and comparison.

    Raises
    ------
    InputError
        What :func:`microslip.identify` refuses.
    """
    from microslip.errors import InputError
    from microslip.identification import Comparison, identify
    from microslip.study.build import build_joints

    fits: dict[str, Identification] = {}
    failed: dict[str, str] = {}
    for index, law in enumerate(laws):
        own, names = dict(options), units_of([law])
        for key in ("fixed", "bounds"):
            own[key] = {name: value for name, value in options[key].items() if name in names}
        if law != "interface":
            own["contact_area"] = None
            own["known"] = None
        if law == "bouc-wen" and len(laws) > 1:
            own["rig_stiffness"] = None  # its elastic part stands for the rig
        if index > 0:
            own["intervals"] = "curvature"  # of what is compared there are no profiles
        model = law if law != "interface" or study is None else build_joints(study)[0]

        def report(share: float, index: int = index) -> None:
            progress((index + share) / len(laws))

        try:
            fits[law] = identify(records, model, progress=report, **own)
        except InputError as error:
            if index == 0:
                raise
            failed[law] = str(error)
    comparison = None
    if len(laws) > 1:
        ordered = sorted(fits.items(), key=lambda item: (not item[1].converged, item[1].aic))
        comparison = Comparison(MappingProxyType(dict(ordered)), MappingProxyType(failed))
    return Identified(tuple(fits.values()), comparison, study)


# -- files -----------------------------------------------------------------------------------------


def summarise(
    found: Identified, files: Sequence[str] = (), spell: Callable[[str], str] = str
) -> dict[str, Any]:
    """What summary.json holds.

    Parameters
    ----------
    found : Identified
        What was identified.
    files : sequence of str
        Names of the other files.
    spell : callable, optional
        Puts messages into the words of who asked, such as the options of a command.

    Returns
    -------
    dict
        Plain values in SI units.
    """
    first, *others = (_spelled(result.summary(), spell) for result in found.results)
    for record, values in zip(found.first.records, first["records"], strict=True):
        values["rms_residual"] = math.sqrt(float((record.residual**2).mean()))
    return {
        "kind": KIND,
        "version": __version__,
        "study": None if found.study is None else found.study.name,
        "identification": first,
        "others": others,
        "comparison": None if found.comparison is None else _compared(found.comparison),
        "files": [*files, *(("summary.json",) if files else ())],
    }


def _spelled(summary: dict[str, Any], spell: Callable[[str], str]) -> dict[str, Any]:
    """A summary with its messages spelled."""
    summary["message"] = spell(summary["message"])
    summary["notes"] = [spell(note) for note in summary["notes"]]
    for number in (*summary["parameters"].values(), *summary["derived"].values()):
        number["reason"], number["remedy"] = spell(number["reason"]), spell(number["remedy"])
    return summary


def _compared(comparison: Comparison) -> dict[str, Any]:
    """Laws side by side, the best first; no infinities, which JSON has not."""
    rows = [
        {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in row.items()
        }
        for row in comparison.rows()
    ]
    rigs = {
        name: {
            law: {
                "value": one.value if math.isfinite(one.value) else None,
                "low": one.low if math.isfinite(one.low) else None,
                "high": one.high if math.isfinite(one.high) else None,
                "unit": one.unit,
                "low_open": one.low_open,
                "high_open": one.high_open,
            }
            for law, one in laws.items()
        }
        for name, laws in comparison.rigs().items()
    }
    return {
        "best": comparison.best, "laws": rows, "rigs": rigs, "failed": dict(comparison.failed)
    }  # fmt: skip


def write(
    found: Identified,
    folder: Path,
    progress: Callable[[float], None] | None = None,
    spell: Callable[[str], str] = str,
) -> dict[str, Any]:
    """Write residuals.csv, the figures, joint.toml, the page and summary.json.

    Parameters
    ----------
    found : Identified
        What was identified.
    folder : pathlib.Path
        An existing folder.
    progress : callable, optional
        Called with the share that is done, 0 ... 1.
    spell : callable, optional
        As for :func:`summarise`.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    from microslip.study import identified_figure, identified_report
    from microslip.study.identified_study import joint_text

    report = progress or (lambda share: None)
    texts = {"residuals.csv": _residuals(found.first)}
    toml, why = joint_text(found, spell)
    if toml is not None:
        texts["joint.toml"] = toml
    names = [*texts, *identified_figure.write(found.first, folder)]
    report(0.6)
    summary = summarise(found, [*names, "report.html"], spell)
    if why:
        summary["identification"]["notes"].append(why)
    texts["report.html"] = identified_report.page(found, summary, toml, folder)
    texts["summary.json"] = json.dumps(summary, indent=1, ensure_ascii=False) + "\n"
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    report(1.0)
    return summary


def _residuals(result: Identification) -> str:
    """Measured and modelled force of every record over a cycle."""
    heads = "phase [rad],displacement [m],measured force [N],model force [N],residual [N]"
    lines = [f"record,normal load [N],{heads}"]
    for record in result.records:
        name = record.name.replace('"', '""')
        load = "" if record.normal_load is None else repr(float(record.normal_load))
        columns = (
            record.phase, record.displacement, record.measured, record.model, record.residual
        )  # fmt: skip
        for row in zip(*(column.tolist() for column in columns), strict=True):
            lines.append(",".join([f'"{name}"', load, *map(repr, row)]))
    return "\n".join(lines) + "\n"


# -- on a terminal ---------------------------------------------------------------------------------


def _numbers(out: Printer, title: str, what: str, level: str, rows: Sequence[Row]) -> None:
    """A table of numbers, in which value and interval stay beside each other."""
    cells = [list(row[:4]) for row in rows]
    head = [what, "value", level, "verdict"]
    columns = zip(*([cell_len(text) for text in line] for line in (head, *cells)), strict=True)
    if sum(max(column) for column in columns) + 3 * (len(head) - 1) > out.width:
        # Both in one column; where even that is too wide, the verdict alone stands apart.
        head = [what, f"value, {level}", "verdict"]
        cells = [[line[0], _beside(line[1], line[2]), line[3]] for line in cells]
    out.table(title, head, cells, text=(0, len(head) - 1))


def _beside(value: str, interval: str) -> str:
    return value if interval in ("", "–") else f"{value}, {interval}"


def show(summary: dict[str, Any], stream: TextIO | None) -> None:
    """Print what was identified, and what was not.

    Parameters
    ----------
    summary : dict
        Of :func:`summarise`.
    stream : file object or None
        Such as `sys.stdout`.

    Raises
    ------
    OSError
        If the stream cannot be written.
    """
    from microslip.study import identified_tables as tables
    from microslip.study.identified_given import given_table, hanging_of, rig_texts

    out = Printer(stream)
    found = summary["identification"]
    out.line(tables.headline(found), style="bold")
    out.line(tables.message_of(found))
    out.line()
    level = f"{100.0 * found['confidence']:g} % interval"
    for title, key in (("Parameters", "parameters"), ("What follows from them", "derived")):
        rows = tables.rows_of(found[key])
        if rows:
            what = "parameter" if key == "parameters" else "quantity"
            _numbers(out, title, what, level, rows)
    for item in tables.open_of(found):
        out.hanging("  ", f"{item.name}, {item.verdict}: {item.reason}.", 2)
        if item.remedy:
            out.hanging("  ", f"To settle it: {item.remedy}.", 4)
    for text in tables.directions_of(found):
        out.hanging("  ", text, 2)
    for hint in (*hanging_of(found), *tables.hints_of(found, summary["study"])):
        out.line(hint)
    out.line()
    given = given_table(found)
    if given is not None:
        out.table("What was given", given.head, given.rows, text=(0, len(given.head) - 1))
    records = tables.record_table(found["records"])
    out.table("Residuals", records.head, records.rows, text=(0,))
    for text in tables.quality_of(found):
        out.line(text)
    out.line()
    correlations = tables.correlation_table(found)
    if correlations is not None:
        out.table("Correlations", correlations.head, correlations.rows, text=(0,))
    if summary["comparison"] is not None:
        laws = tables.law_table(summary["comparison"])
        out.table("Laws compared", laws.head, laws.rows, text=(0, 1))
        for text in rig_texts(summary["comparison"]):
            out.line(text)
        for law, why in summary["comparison"]["failed"].items():
            out.line(f"{law}: {why}")
    for text in found["notes"]:
        out.line(text)
