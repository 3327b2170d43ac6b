"""The files of a prediction. All numbers are in SI units and read back bit for bit."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from microslip._core.quantities import UNITS
from microslip.report.document import File
from microslip.report.files import (
    Blocks,
    csv_file,
    netcdf_file,
    standard_files,
    text_file,
)
from microslip.results.predicted.arrays import contents
from microslip.results.predicted.document import document
from microslip.results.structure.document import columns as structure_columns
from microslip.runs.columns import Columns, Floats, VaryingLoop, blocks
from microslip.runs.prediction import Prediction
from microslip.runs.scatter import Scatter


def files(result: Prediction, destination: Path) -> tuple[File, ...]:
    """What a result writes; the copy of the study names its files as seen from the destination."""
    study = result.study
    samples = sum(len(loop.force) for loops in result.loops for loop in loops)
    tables = [csv_file("loops.csv", partial(loop_blocks, result), samples, UNITS, 5)]
    numbers = 5 * samples
    by_joint = {
        "curves": result.curves,
        "history": result.histories,
        "oscillator": result.oscillators,
        "varying": result.varying,
    }
    for name, joints in by_joint.items():
        if joints:
            columns = [table.columns() for table in joints]
            rows = sum(len(next(iter(named.values()))) for named in columns)
            width = 1 + len(columns[0])
            parts = partial(_blocks, result, joints)
            tables.append(csv_file(f"{name}.csv", parts, rows, UNITS, width))
            numbers += rows * width
    in_one_piece = {} if result.structure is None else {
        "structure": structure_columns(result.structure)
    }  # fmt: skip
    if result.scatter is not None:
        in_one_piece["bands"] = band_columns(result, result.scatter)
    for name, arrays in in_one_piece.items():
        rows = len(next(iter(arrays.values())))
        parts = partial(iter, [arrays])
        tables.append(csv_file(f"{name}.csv", parts, rows, UNITS, len(arrays)))
        numbers += (2 if name == "bands" else 1) * rows * len(arrays)
    tables.append(netcdf_file("result.nc", partial(contents, result), numbers))
    tables.append(text_file("study.toml", lambda: study.text_for(destination)))
    return standard_files(replace(document(result), files=tuple(tables)))


def band_columns(result: Prediction, scatter: Scatter) -> dict[str, Floats]:
    """Quantiles of the curves in long form: a row a load, an amplitude and a quantile."""
    parts: list[dict[str, Floats]] = []
    for load, (joint, curve) in enumerate(zip(result.joints, result.curves, strict=True)):
        for place, share in enumerate(scatter.quantiles.tolist()):
            size = curve.amplitude.size
            columns = scatter.curve(place, load, curve.amplitude).columns()
            at = getattr(joint, "normal_load", np.nan)
            heads = {"normal_load": np.full(size, at), "quantile": np.full(size, share)}
            parts.append({**heads, **columns})
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def loop_blocks(result: Prediction) -> Blocks:
    """Samples of the loops in long form, one block of columns for each load and amplitude."""
    by_force = result.study.excitation.force_amplitudes is not None
    for joint, loops, row in zip(result.joints, result.loops, result.rows, strict=True):
        for place, loop in enumerate(loops):
            heads = {"normal_load": getattr(joint, "normal_load", np.nan)}
            heads["amplitude"] = row.amplitude[place]
            if by_force:  # by what was given the rows of a loop are found
                heads["force_amplitude"] = row.force_amplitude[place]
            size = len(loop.displacement)
            columns = {name: np.full(size, value) for name, value in heads.items()}
            columns |= {"displacement": loop.displacement, "force": loop.force}
            if isinstance(loop, VaryingLoop):
                columns["varying_normal_load"] = loop.normal_load
            yield columns


def _blocks(result: Prediction, tables: tuple[Columns, ...]) -> Blocks:
    for joint, table in zip(result.joints, tables, strict=True):
        columns = table.columns()
        size = len(next(iter(columns.values())))
        for piece in blocks(size):
            load = np.full(piece.stop - piece.start, getattr(joint, "normal_load", np.nan))
            yield {"normal_load": load, **{name: a[piece] for name, a in columns.items()}}
