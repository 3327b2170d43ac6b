"""Floor 8: the files of a result. All numbers are in SI units and read back bit for bit."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from microslip._core.quantities import UNITS
from microslip.study.result import Columns, Floats, blocks
from microslip.study.varying import VaryingLoop

if TYPE_CHECKING:
    from microslip.study.result import Progress, Result

Blocks = Iterator[dict[str, Floats]]

# Seconds, more or less, for the sake of progress: a number as text, a number, a figure, anything.
_TEXT, _NUMBER, _FIGURE, _FILE = 6e-7, 9e-8, 0.7, 1e-3


def write(
    result: Result,
    folder: Path,
    progress: Progress | None = None,
    destination: Path | None = None,
) -> None:
    """Write every file of a result into an existing folder.

    Parameters
    ----------
    result : Result
        What to write.
    folder : pathlib.Path
        Where.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.
    destination : pathlib.Path, optional
        Where the folder goes then: the copy of the study names its files as seen from there.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    names = result.summary["files"]
    ends = np.cumsum([_cost(result, name) for name in names])
    ends /= ends[-1]
    begin = 0.0
    for name, end in zip(names, ends.tolist(), strict=True):
        if name == "study.toml":
            text = result.study.text_for(destination or folder)
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
        else:
            _write(result, folder / name, _part(progress, begin, end))
        begin = end
        if progress is not None:
            progress(end)


def _part(progress: Progress | None, begin: float, end: float) -> Progress | None:
    if progress is None:
        return None
    return lambda share: progress(min(begin + (end - begin) * share, end))


def _write(result: Result, path: Path, progress: Progress | None) -> None:
    """Write one file; libraries load with the first one that needs them."""
    if path.name == "summary.json":
        text = json.dumps(result.summary, indent=1, ensure_ascii=False, allow_nan=False)
        path.write_text(text + "\n", encoding="utf-8", newline="\n")
    elif path.name == "report.html":
        from microslip.study import report

        report.write(result, path, progress)
    elif path.name == "result.nc":
        from microslip.study import netcdf

        netcdf.write(result, path, progress)
    elif path.suffix == ".csv":
        write_table(path, TABLES[path.stem](result), _rows(result)[path.stem], progress)
    else:
        from microslip.study import figures

        figures.write(result, path)


def _rows(result: Result) -> dict[str, int]:
    """How many rows each table has."""
    return {
        "loops": sum(len(loop.force) for loops in result.loops for loop in loops),
        "curves": sum(len(curve.amplitude) for curve in result.curves),
        "history": sum(len(response.force) for response in result.histories),
        "oscillator": sum(len(curve.amplitude) for curve in result.oscillators),
        "varying": sum(len(cycles.amplitude) for cycles in result.varying),
    }


def _cost(result: Result, name: str) -> float:
    stem, _, kind = name.partition(".")
    rows = _rows(result)
    columns = {"loops": 5, "curves": 14, "history": 5, "oscillator": 5, "varying": 11}
    if kind == "csv":
        return rows[stem] * columns[stem] * _TEXT
    if kind == "nc":
        return sum(rows[table] * columns[table] for table in rows) * _NUMBER
    # Figures are drawn once, all for the page or each for the first of its files.
    drawn = _FILE if "report.html" in result.summary["files"] else 0.5 * _FIGURE
    return {"html": 8 * _FIGURE, "svg": drawn, "png": drawn}.get(kind, _FILE)


# -- tables --------------------------------------------------------------------------------------


def loop_blocks(result: Result) -> Blocks:
    """Samples of the loops in long form, one block of columns for each load and amplitude."""
    by_force = result.study.excitation.force_amplitudes is not None
    for joint, loops, row in zip(result.joints, result.loops, result.rows, strict=True):
        amplitudes = zip(loops, row.amplitude, row.force_amplitude, strict=True)
        for loop, amplitude, force_amplitude in amplitudes:
            size = len(loop.displacement)
            yield {
                "normal_load": np.full(size, joint.normal_load),
                "amplitude": np.full(size, amplitude),
                # By what was given the rows of a loop are found.
                **({"force_amplitude": np.full(size, force_amplitude)} if by_force else {}),
                "displacement": loop.displacement,
                "force": loop.force,
                **(
                    {"varying_normal_load": loop.normal_load}
                    if isinstance(loop, VaryingLoop)
                    else {}
                ),
            }


def curve_blocks(result: Result) -> Blocks:
    """Curves in long form, block by block of each load."""
    return _blocks(result, result.curves)


def history_blocks(result: Result) -> Blocks:
    """The history in long form, block by block of each load."""
    return _blocks(result, result.histories)


def varying_blocks(result: Result) -> Blocks:
    """The cycles under a load that varies in long form, one block for each load."""
    return _blocks(result, result.varying)


def oscillator_blocks(result: Result) -> Blocks:
    """The curves of the oscillator in long form, block by block of each load."""
    return _blocks(result, result.oscillators)


TABLES: dict[str, Callable[[Result], Blocks]] = {
    "loops": loop_blocks,
    "curves": curve_blocks,
    "history": history_blocks,
    "oscillator": oscillator_blocks,
    "varying": varying_blocks,
}
"""The tables by their names."""


def _blocks(result: Result, tables: tuple[Columns, ...]) -> Blocks:
    for joint, table in zip(result.joints, tables, strict=True):
        columns = table.columns()
        size = len(next(iter(columns.values())))
        for piece in blocks(size):
            load = np.full(min(piece.stop, size) - piece.start, joint.normal_load)
            yield {"normal_load": load, **{name: a[piece] for name, a in columns.items()}}


def write_table(path: Path, parts: Blocks, rows: int, progress: Progress | None = None) -> None:
    """Write blocks of equal columns as one CSV file whose header names columns and units.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    parts : iterator of dict
        Columns by name, piece by piece.
    rows : int
        How many rows there will be.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    done = 0
    with path.open("w", encoding="utf-8", newline="") as file:
        for number, part in enumerate(parts):
            if number == 0:
                file.write(",".join(f"{name} [{UNITS[name]}]" for name in part) + "\n")
            # repr is the shortest text that reads back as the same double.
            texts = [map(repr, column.tolist()) for column in part.values()]
            file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))
            done += len(next(iter(part.values())))
            if progress is not None:
                progress(done / rows)
