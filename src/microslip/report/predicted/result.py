"""Result of a study, and its files.

Numbers in the files are in SI units, with all digits, so that they are read back without change.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core import kernels, netcdf
from microslip._core.checks import Progress, show
from microslip._core.dataset import DataSet, Variable
from microslip._core.errors import InputError
from microslip._version import __version__
from microslip.report.document import Document, File
from microslip.report.files import (
    complete,
    csv_file,
    text_file,
    write_all,
)
from microslip.report.folder import staged
from microslip.report.predicted.document import prediction_document
from microslip.report.predicted.numbers import (
    SUMMARY_SCHEMA,
    data_set,
    prediction_summary,
    tables,
)
from microslip.report.structure.driven import FORCED_FIGURE, forced_table
from microslip.study.description import StudyDescription
from microslip.study.runs.columns import AmplitudeCurve as AmplitudeCurve
from microslip.study.runs.columns import HistoryResponse as HistoryResponse
from microslip.study.runs.prediction import Prediction, run_prediction


def result_document(result: Result, folder: Path) -> Document:
    """Return the document of a result with its files, as requested by the study.

    Paths in the copied study are relative to ``folder``.
    """
    study, structure, data, output = (
        result.study,
        result.structure,
        result.data,
        result.study.output,
    )
    files = [text_file("study.toml", lambda: study.text_for(folder))]
    if "netcdf" in output.formats:
        files.append(File("result.nc", lambda path: netcdf.store(path, data)))
    if "csv" in output.formats:
        for name, (columns, dims) in tables(result, data).items():
            files.append(csv_file(f"{name}.csv", lambda: data, columns, dims))
        if structure is not None and structure.part.force is not None:
            files.append(csv_file(f"{FORCED_FIGURE}.csv", lambda: forced_table(structure)))
    document = replace(prediction_document(result), files=tuple(files))
    kinds = [kind for kind in ("svg", "png", "pdf") if kind in output.formats]
    return complete(document, kinds, page=output.report)


@dataclass(frozen=True, eq=False, repr=False)
class Result(Prediction):
    """Result of :meth:`microslip.Study.run`, by normal load (first index) and amplitude (second).

    Parameters
    ----------
    study : Study
        The study.
    joints : tuple of Interface
        One joint for each normal load.
    loops : tuple of tuple of Loop
        For each load, one loop for each amplitude of the study.
    rows : tuple of AmplitudeCurve
        For each load, the cyclic quantities at the amplitudes of the loops. If the study gives
        force amplitudes, these are the same for all loads, and the displacement amplitudes differ.
    curves : tuple of AmplitudeCurve
        For each load, the cyclic quantities over the whole range of amplitudes.
    summary : dict
        Content of `summary.json`: numbers in SI units, with a table of their units.
    histories : tuple of HistoryResponse
        For each load, the response to the history of the study; empty without one.
    structure : StructurePrediction or None
        The bolted structure of the study: tightened state, modes, bands.
    scatter : PredictionScatter or None
        Bands of all quantities, if numbers of the study are uncertain.
    """

    @cached_property
    def data(self) -> DataSet:
        """All results by name with their dimensions, units and meanings, as in `result.nc`."""
        texts = {
            "title": self.study.title,
            "kind": self.summary["kind"],
            "source": f"microslip {__version__}",
            "kernel": kernels.NAME,
            "study": self.study.text,
            "notes": "\n".join(self.summary["notes"]),
        }
        attributes: dict[str, Any] = {name: text for name, text in texts.items() if text}
        attributes["schema"] = np.int32(SUMMARY_SCHEMA)
        return replace(data_set(self), attributes=attributes)

    def __getitem__(self, name: str) -> Variable:
        """Return the values of a result by name, with their dimensions, unit and meaning."""
        return self.data[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def save(
        self, folder: str | Path, overwrite: bool = False, progress: Progress | None = None
    ) -> tuple[Path, ...]:
        """Write tables, figures and summary into a new folder, whole or not at all.

        Parameters
        ----------
        folder : str or pathlib.Path
            Folder to create.
        overwrite : bool
            Whether an existing result may be replaced; other folders never are.
        progress : callable, optional
            Called repeatedly with the completed fraction, 0 to 1.

        Returns
        -------
        tuple of pathlib.Path
            The files written.
        """
        folder = Path(folder)
        with staged(folder, overwrite) as stage:
            files = result_document(self, folder).files
            write_all(files, stage, progress)
        return tuple(folder / file.name for file in files)

    def plot(self, name: str = "loops", ax: Any = None, *, title: bool = False) -> Any:
        """Draw one of the figures of the report; axis labels name their units, such as [N].

        Parameters
        ----------
        name : str, optional
            Name of the figure: "loops", "backbone", "energy_damping" and others, see
            docs/results.md.
        ax : array of matplotlib.axes.Axes, optional
            Axes to draw on, one for each panel; by default a new figure.
        title : bool, optional
            Whether the title of the study is shown.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of Axes
            The axes.
        """
        from microslip.figures import draw

        figures = {picture.name: picture for picture in prediction_document(self).pictures}
        if not isinstance(name, str) or name not in figures:
            names = ", ".join(figures)
            raise InputError(f"`name` must be one of {names}, got {show(name)}")
        plot = figures[name].plot()
        if not title:
            plot.title = ""
        return draw(plot, ax)

    def _repr_html_(self) -> str:
        from microslip.figures.plottable import notebook_view
        from microslip.report.terminal import print_document

        document, text = prediction_document(self), io.StringIO()
        print_document(document, text)
        return notebook_view(self, document.pictures[0].plot(), text.getvalue())

    def to_xarray(self) -> Any:
        """Return all numbers as one labelled data set, as in `result.nc`.

        Returns
        -------
        xarray.Dataset
            Variables with the dimensions load, amplitude (or force_amplitude), sample and point;
            docs/results.md lists them.
        """
        return self.data.to_xarray("save(...) and its result.nc need nothing more")


class Study(StudyDescription):
    """Validated description of a prediction; quantities are floats in SI units.

    Create it from a file with :meth:`load`, from text with :meth:`from_toml`, or in Python with the
    keys of the file and quantities as text, ``Study(schema=1, surface={"radius": "1 mm", …}, …)``.
    """

    def run(self, progress: Progress | None = None) -> Result:
        """Compute every loop and curve of the study.

        Parameters
        ----------
        progress : callable, optional
            Called repeatedly with the completed fraction, 0 to 1.

        Returns
        -------
        Result
            Joints, loops, curves and the summary.
        """
        prediction, defaults = run_prediction(self, progress)
        summary = prediction_summary(prediction, defaults)
        result = Result(**{**vars(prediction), "summary": summary})
        summary["files"] = result_document(result, Path()).data["files"]
        return result
