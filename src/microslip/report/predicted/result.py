"""The result of a study, which can be saved and opened again, and its files.

All numbers in files are in SI units and read back bit for bit.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats, Progress, show
from microslip._core.errors import InputError
from microslip._core.netcdf import Contents, Variable, dataset
from microslip._core.quantities import UNITS
from microslip._version import __version__
from microslip.report.document import File
from microslip.report.files import Blocks, csv_file, netcdf_file, save, standard_files, text_file
from microslip.report.predicted.document import document
from microslip.report.predicted.numbers import KIND, SUMMARY_SCHEMA, summarise, verdicts
from microslip.report.structure.document import columns as structure_columns
from microslip.report.structure.document import labelled as structure_arrays
from microslip.report.structure.driven import RESPONSES, forced_columns
from microslip.report.structure.fitted_study import FITTED_STUDY, fitted_text
from microslip.structures.forced import write_universal
from microslip.study.description import StudyDescription
from microslip.study.runs.columns import AmplitudeCurve as AmplitudeCurve
from microslip.study.runs.columns import Columns, blocks
from microslip.study.runs.columns import HistoryResponse as HistoryResponse
from microslip.study.runs.columns import Limits as Limits
from microslip.study.runs.prediction import Prediction, labelled, run, variables
from microslip.study.runs.scatter import Scatter


def files(result: Prediction, destination: Path) -> tuple[File, ...]:
    """Files of a result; the copy of the study names its files as seen from the destination."""
    study, structure = result.study, result.structure
    samples = sum(len(loop.force) for loops in result.loops for loop in loops)
    tables = [csv_file("loops.csv", partial(loop_blocks, result), samples, UNITS, 5)]
    numbers = 5 * samples
    by_joint = {
        "curves": result.curves,
        "history": result.histories,
    }
    for name, joints in by_joint.items():
        if joints:
            columns = [table.columns() for table in joints]
            rows = sum(len(next(iter(named.values()))) for named in columns)
            width = 1 + len(columns[0])
            parts = partial(_blocks, result, joints)
            tables.append(csv_file(f"{name}.csv", parts, rows, UNITS, width))
            numbers += rows * width
    in_one_piece, units = {}, UNITS
    if structure is not None:
        forced, of_quantity = forced_columns(structure)
        in_one_piece = {"structure": structure_columns(structure), **forced}
        units = UNITS | of_quantity
        if responses := structure.frequency_responses:
            tables.append(File(RESPONSES, lambda path, _: write_universal(responses, path)))
        if structure.identified is not None:
            text = partial(fitted_text, study, structure, destination)
            tables.append(text_file(FITTED_STUDY, text))
    if result.scatter is not None:
        in_one_piece["bands"] = band_columns(result, result.scatter)
    for name, arrays in in_one_piece.items():
        rows = len(next(iter(arrays.values())))
        parts = partial(iter, [arrays])
        tables.append(csv_file(f"{name}.csv", parts, rows, units, len(arrays)))
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
            yield columns


def _blocks(result: Prediction, tables: tuple[Columns, ...]) -> Blocks:
    for joint, table in zip(result.joints, tables, strict=True):
        columns = table.columns()
        size = len(next(iter(columns.values())))
        for piece in blocks(size):
            load = np.full(piece.stop - piece.start, getattr(joint, "normal_load", np.nan))
            yield {"normal_load": load, **{name: a[piece] for name, a in columns.items()}}


WORDS = ("ok", "watch", "outside", "not judged")
"""Words of the verdicts; a variable holds their index, which is that of older files."""


def contents(result: Prediction) -> Contents:
    """Label the arrays of a result."""
    by_force = result.study.excitation.force_amplitudes is not None
    driven = "force_amplitude" if by_force else "amplitude"
    rows, curves = result.rows, result.curves
    loads = np.array([getattr(joint, "normal_load", np.nan) for joint in result.joints])
    dims = {
        "load": len(loads),
        driven: rows[0].amplitude.size,
        "sample": result.loops[0][0].force.size,
        "point": curves[0].amplitude.size,
    }
    coords = {
        "load": labelled(("load",), loads, "normal_load"),
        driven: labelled((driven,), getattr(rows[0], driven), driven),
        "sample": _index("sample", dims["sample"], "sample of a loop"),
        "point": _index("point", dims["point"], "point of the curves"),
        "curve_amplitude": labelled(("point",), curves[0].amplitude, "amplitude"),
    }
    arrays = {**variables(result), **_validity(result)}
    if result.histories:
        dims["history_sample"] = size = result.histories[0].force.size
        coords["history_sample"] = _index("history_sample", size, "sample of the history")
    if result.scatter is not None:
        dims["quantile"] = result.scatter.quantiles.size
        coords["quantile"] = labelled(("quantile",), result.scatter.quantiles, "quantile")
        arrays |= {f"{name}_bands": band for name, band in result.scatter.bands.items()}
    if result.structure is not None:
        sizes, labels, curves_of_modes = structure_arrays(result.structure)
        dims |= sizes
        coords |= labels
        arrays |= curves_of_modes
    return Contents(dims, coords, arrays, _attributes(result))


def _index(dim: str, size: int, meaning: str) -> Variable:
    """Numbers from 0, to label what has no other label."""
    values = np.arange(size, dtype=np.int32)
    return Variable((dim,), values, {"units": "1", "long_name": meaning})


def _validity(result: Prediction) -> dict[str, Variable]:
    """Verdicts: of each its value and the index of its word."""
    arrays = {}
    judged = [verdicts(result.study, joint) for joint in result.joints]
    for place, verdict in enumerate(judged[0][: len(getattr(result.joints[0], "validity", ()))]):
        name = "validity_" + re.sub(r"\W+", "_", verdict.name)
        of_loads = [of_load[place] for of_load in judged]
        values = np.array([np.nan if v.value is None else float(v.value) for v in of_loads])
        words = np.array([WORDS.index(v.word) for v in of_loads], dtype=np.int8)
        about = {"units": "1", "long_name": verdict.name}
        about_values = {"limit": float(verdict.limit), "comment": verdict.meaning}
        arrays[name] = Variable(("load",), values, {**about, **about_values})
        flags = {
            "flag_values": np.arange(len(WORDS), dtype=np.int8),
            "flag_meanings": " ".join(word.replace(" ", "_") for word in WORDS),
        }
        arrays[f"{name}_word"] = Variable(("load",), words, {**about, **flags})
    return arrays


def _attributes(result: Prediction) -> dict[str, Any]:
    texts: Mapping[str, str] = {
        "title": result.study.title,
        "kind": KIND,
        "source": f"microslip {__version__}",
        "kernel": kernels.NAME,
        "study": result.study.text,
        "notes": "\n".join(result.summary["notes"]),
    }
    schema = {"schema": np.int32(SUMMARY_SCHEMA)}
    return {**{name: text for name, text in texts.items() if text}, **schema}


@dataclass(frozen=True, eq=False, repr=False)
class Result(Prediction):
    """Result of :meth:`microslip.Study.run`; index 0 runs over normal loads, 1 over amplitudes.

    Parameters
    ----------
    study : Study
        Prediction.
    joints : tuple of Interface
        One for each normal load.
    loops : tuple of tuple of Loop
        For each load, one for each amplitude of the study.
    rows : tuple of AmplitudeCurve
        For each load, the cyclic quantities at the amplitudes of the loops. Where the study gives
        force amplitudes these are the same for all loads, and the displacement amplitudes differ.
    curves : tuple of AmplitudeCurve
        For each load, the same over the whole range of amplitudes.
    limits : tuple of Limits
        For each load, the asymptotes of the dissipated energy.
    summary : dict
        Content of `summary.json`: numbers in SI units, with a table of their units.
    histories : tuple of HistoryResponse
        For each load, what the joint does along the history of the study; empty without one.
    structure : StructurePrediction or None
        The bolted structure of the study: tightened state, modes, bands.
    scatter : Scatter or None
        Bands of all of these, where numbers of the study are uncertain.
    """

    def save(
        self, folder: str | Path, overwrite: bool = False, progress: Progress | None = None
    ) -> tuple[Path, ...]:
        """Write tables, figures and summary into a new folder, whole or not at all.

        Parameters
        ----------
        folder : str or pathlib.Path
            The folder to make.
        overwrite : bool
            Whether an earlier result in its place may be replaced; nothing else ever is.
        progress : callable, optional
            Called now and then with the share that is done, 0 … 1.

        Returns
        -------
        tuple of pathlib.Path
            The files written.
        """
        return save(files(self, Path(folder)), folder, KIND, "result", overwrite, progress)

    def plot(self, name: str = "loops", ax: Any = None, *, title: bool = False) -> Any:
        """Draw one of the figures of its report; axes name their units, such as [N].

        Parameters
        ----------
        name : str, optional
            Name of its file: "loops", "backbone", "energy_damping", and those that
            docs/results.md lists.
        ax : array of matplotlib.axes.Axes, optional
            Axes to draw on, one for each panel; without, a new figure.
        title : bool, optional
            Whether the title of the study stands above it.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of Axes
            What was drawn on.
        """
        from microslip.figures import draw

        figures = {picture.name: picture for picture in document(self).pictures}
        if not isinstance(name, str) or name not in figures:
            names = ", ".join(figures)
            raise InputError(f"`name` must be one of {names}, got {show(name)}")
        plot = figures[name].plot()
        if not title:
            plot.title = ""
        return draw(plot, ax)

    def to_xarray(self) -> Any:
        """All numbers as one labelled data set, the same as in `result.nc`.

        Returns
        -------
        xarray.Dataset
            Variables with the dimensions load, amplitude (or force_amplitude), sample and point;
            docs/results.md lists them.
        """
        return dataset(contents(self))


class Study(StudyDescription):
    """A validated description of one prediction; quantities are SI floats.

    Made from a file by :meth:`load`, from text by :meth:`from_toml`, or in Python with the keys
    of the file and quantities as text, ``Study(schema=1, surface={"radius": "1 mm", …}, …)``.
    """

    def run(self, progress: Progress | None = None, workers: int = 1) -> Result:
        """Compute every loop and curve of the study.

        Parameters
        ----------
        progress : callable, optional
            Called now and then with the share that is done, 0 … 1.
        workers : int, optional
            Processes among which the samples of uncertain numbers are shared; the results are the
            same for any number of them.

        Returns
        -------
        Result
            Joints, loops, curves and the summary.
        """
        prediction, defaults = run(self, progress, workers)
        summary = summarise(prediction, defaults)
        return Result(**{**vars(prediction), "summary": summary})
