"""The files of a prediction. All numbers are in SI units and read back bit for bit."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from microslip._core.quantities import UNITS
from microslip.report.files import (
    Blocks,
    File,
    csv_file,
    netcdf_file,
    standard_files,
    text_file,
)
from microslip.results.predicted.arrays import contents
from microslip.results.predicted.columns import Columns, Floats, blocks
from microslip.results.predicted.document import document
from microslip.results.predicted.prediction import Prediction
from microslip.results.predicted.varying import VaryingLoop
from microslip.results.structure.document import columns as structure_columns


def files(result: Prediction, destination: Path) -> tuple[File, ...]:
    """What a result writes; the copy of the study names its files as seen from the destination."""
    tables = {
        "curves": result.curves,
        "history": result.histories,
        "oscillator": result.oscillators,
        "varying": result.varying,
    }
    samples = sum(len(loop.force) for loops in result.loops for loop in loops)
    own = [csv_file("loops.csv", partial(loop_blocks, result), samples, UNITS, 5)]
    numbers = 5 * samples
    for name, joints in tables.items():
        if joints:
            columns = [table.columns() for table in joints]
            rows = sum(len(next(iter(named.values()))) for named in columns)
            width = 1 + len(columns[0])
            parts = partial(_blocks, result, joints)
            own.append(csv_file(f"{name}.csv", parts, rows, UNITS, width))
            numbers += rows * width
    if result.structure is not None:
        curves = structure_columns(result.structure)
        rows = len(curves["mode"])
        own.append(csv_file("structure.csv", lambda: iter([curves]), rows, UNITS, len(curves)))
        numbers += rows * len(curves)
    if result.scatter is not None:
        bands = band_columns(result)
        rows = bands["amplitude"].size
        own.append(csv_file("bands.csv", lambda: iter([bands]), rows, UNITS, len(bands)))
        numbers += 2 * rows * len(bands)
    own.append(netcdf_file("result.nc", partial(contents, result), numbers))
    own.append(text_file("study.toml", lambda: result.study.text_for(destination)))
    return standard_files(document(result), result.summary["files"], own)


def band_columns(result: Prediction) -> dict[str, Floats]:
    """Quantiles of the curves in long form: a row a load, an amplitude and a quantile."""
    scatter = result.scatter
    assert scatter is not None  # who calls has looked
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
        amplitudes = zip(loops, row.amplitude, row.force_amplitude, strict=True)
        for loop, amplitude, force_amplitude in amplitudes:
            size = len(loop.displacement)
            yield {
                "normal_load": np.full(size, getattr(joint, "normal_load", np.nan)),
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


def _blocks(result: Prediction, tables: tuple[Columns, ...]) -> Blocks:
    for joint, table in zip(result.joints, tables, strict=True):
        columns = table.columns()
        size = len(next(iter(columns.values())))
        for piece in blocks(size):
            load = np.full(
                min(piece.stop, size) - piece.start, getattr(joint, "normal_load", np.nan)
            )
            yield {"normal_load": load, **{name: a[piece] for name, a in columns.items()}}
