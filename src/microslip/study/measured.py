"""Floor 8: measured records as files and on a terminal."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TextIO

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip._version import __version__
from microslip.report.printer import Printer
from microslip.tribometer import Measurement
from microslip.tribometer.columns import UNITS

KIND = "microslip-measurement"
"""What summary.json says of a folder of measured records."""

_SHOWN = (
    ("amplitude", "amplitude δ_m"),
    ("force_amplitude", "force amplitude T_m"),
    ("normal_load", "normal load N"),
    ("dissipated_energy", "energy/cycle E_d"),
    ("energy_ratio", "energy ratio A"),
    ("loss_factor", "loss factor η"),
    ("damping_ratio", "damping ratio ζ"),
    ("sliding_ratio", "sliding ratio D"),
    ("fouvry_ratio", "B = E_d/4T_mδ_g"),
    ("friction_peak", "friction T_m/N"),
    ("friction_energy", "friction E_d/4Nδ_g"),
    ("reversal_stiffness", "stiffness after reversal"),
    ("closure_error", "closure error"),
)


def summarise(measurements: Sequence[Measurement], files: Sequence[str] = ()) -> dict[str, Any]:
    """What summary.json holds.

    Parameters
    ----------
    measurements : sequence of Measurement
        What was measured.
    files : sequence of str
        Names of the other files.

    Returns
    -------
    dict
        Plain values in SI units.
    """
    return {
        "kind": KIND,
        "version": __version__,
        "records": [measured.summary() for measured in measurements],
        "files": [*files, *(("summary.json",) if files else ())],
    }


def write(measurements: Sequence[Measurement], folder: Path) -> dict[str, Any]:
    """Write cycles.csv, the figure and summary.json.

    Parameters
    ----------
    measurements : sequence of Measurement
        What was measured, at least one.
    folder : pathlib.Path
        An existing folder.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    from microslip.study import measured_figure

    text = _cycles(measurements)
    (folder / "cycles.csv").write_text(text, encoding="utf-8", newline="\n")
    summary = summarise(measurements, ["cycles.csv", *measured_figure.write(measurements, folder)])
    (folder / "summary.json").write_text(
        json.dumps(summary, indent=1, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n"
    )
    return summary


def _cycles(measurements: Sequence[Measurement]) -> str:
    """A row for each cycle; empty where a record does not have the column or the value."""
    columns = [name for name in UNITS if any(name in m.cycles for m in measurements)]
    heads = [f"{name} [{UNITS[name]}]" for name in columns]
    lines = [",".join(["record", "cycle", *heads, "regime"])]
    for measured in measurements:
        name = measured.name.replace('"', '""')
        values = [measured.cycles.get(column) for column in columns]
        for i, regime in enumerate(measured.regimes):
            numbers = [None if column is None else float(column[i]) for column in values]
            cells = ["" if v is None or v != v else repr(v) for v in numbers]
            lines.append(",".join([f'"{name}"', str(i + 1), *cells, regime]))
    return "\n".join(lines) + "\n"


def show(summary: dict[str, Any], stream: TextIO | None) -> None:
    """Print what was measured so that it can be read at a glance.

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
    out = Printer(stream)
    for record in summary["records"]:
        counts = [f"{n} {name}" for name, n in record["regimes"].items() if n]
        cycles = "cycle" if record["cycles"] == 1 else "cycles"
        out.line(f"{shorten(record['name'], 200)}: {', '.join(counts)} {cycles}", style="bold")
        facts = []
        if record["frequency"] is not None:
            facts.append(f"frequency {engineering(record['frequency'], 'Hz', 4, trim=True)}")
        facts.append(f"third harmonic {significant(100.0 * record['third_harmonic'])} %")
        if record["load_ripple"] is not None:
            facts.append(f"load ripple {significant(100.0 * record['load_ripple'])} %")
        if record["rig_stiffness"] is not None:
            facts.append(f"rig of {engineering(record['rig_stiffness'], 'N/m')} taken off")
        out.line(", ".join(facts))
        out.line()
        level = f"{100.0 * record['confidence']:g} % interval of the mean"
        out.table(
            "",
            ["quantity", "mean", level],
            [
                [label, _value(mean["value"], mean["unit"]), _interval(mean)]
                for name, label in _SHOWN
                if (mean := record["mean"].get(name)) is not None
            ],
            text=(0,),
        )
        ends = record["thresholds"]
        out.line(
            f"Regimes: stick up to A = {ends['stick']:.3g}, gross slip from B = "
            f"{ends['gross']:.3g} ({ends['source']})."
        )
        for text in record["notes"]:
            out.line(text)
        out.line()


def _value(value: float | None, unit: str, digits: int = 4) -> str:
    if value is None:
        return "–"
    return significant(value, digits) if unit == "-" else engineering(value, unit, digits)


def _interval(mean: dict[str, Any]) -> str:
    if mean["low"] is None:
        return "–"
    return " … ".join(_value(mean[end], mean["unit"]) for end in ("low", "high"))
