"""Floor 8: the files of a result. All numbers are in SI units and read back bit for bit."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from microslip.study.result import UNITS, Floats

if TYPE_CHECKING:
    from microslip.study.result import Progress, Result

_BLOCK = 20_000


def write(result: Result, folder: Path, progress: Progress | None = None) -> None:
    """Write every file of a result into an existing folder.

    Parameters
    ----------
    result : Result
        What to write.
    folder : pathlib.Path
        Where.
    progress : callable, optional
        Called after each file with the share that is done, 0 … 1.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    names = result.summary["files"]
    for index, name in enumerate(names):
        path = folder / name
        if name == "summary.json":
            text = json.dumps(result.summary, indent=1, ensure_ascii=False, allow_nan=False)
            path.write_text(text + "\n", encoding="utf-8", newline="\n")
        elif name == "study.toml":
            path.write_text(result.study.text or "", encoding="utf-8", newline="\n")
        elif name == "loops.csv":
            write_table(path, loop_blocks(result))
        elif name == "curves.csv":
            write_table(path, curve_blocks(result))
        else:
            from microslip.study import figures  # only here is matplotlib imported

            figures.write(result, path)
        if progress is not None:
            progress((index + 1) / len(names))


def loop_blocks(result: Result) -> Iterator[dict[str, Floats]]:
    """Samples of the loops in long form, one block of columns for each load and amplitude."""
    for joint, loops, row in zip(result.joints, result.loops, result.rows, strict=True):
        for loop, amplitude in zip(loops, row.amplitude, strict=True):
            size = len(loop.displacement)
            yield {
                "normal_load": np.full(size, joint.normal_load),
                "amplitude": np.full(size, amplitude),
                "displacement": np.asarray(loop.displacement),
                "force": np.asarray(loop.force),
            }


def curve_blocks(result: Result) -> Iterator[dict[str, Floats]]:
    """Curves in long form, one block of columns for each load."""
    for joint, curve in zip(result.joints, result.curves, strict=True):
        load = np.full(len(curve.amplitude), joint.normal_load)
        yield {"normal_load": load, **curve.columns()}


def write_table(path: Path, blocks: Iterator[dict[str, Floats]]) -> None:
    """Write blocks of equal columns as one CSV file whose header names columns and units."""
    with path.open("w", encoding="utf-8", newline="") as file:
        for number, block in enumerate(blocks):
            if number == 0:
                file.write(",".join(f"{name} [{UNITS[name]}]" for name in block) + "\n")
            columns = list(block.values())
            for start in range(0, len(columns[0]), _BLOCK):
                # repr is the shortest text that reads back as the same double.
                texts = [map(repr, column[start : start + _BLOCK].tolist()) for column in columns]
                file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))
