"""The result of a study, which can be saved and opened again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microslip._core.checks import show
from microslip._core.netcdf import dataset
from microslip.errors import InputError
from microslip.report.document import Progress
from microslip.report.files import save
from microslip.results.predicted.document import document
from microslip.results.predicted.files import contents, files
from microslip.results.predicted.numbers import KIND, summarise
from microslip.runs.columns import AmplitudeCurve as AmplitudeCurve
from microslip.runs.columns import HistoryResponse as HistoryResponse
from microslip.runs.columns import Limits as Limits
from microslip.runs.columns import OscillatorCurve as OscillatorCurve
from microslip.runs.predict import run
from microslip.runs.prediction import Prediction
from microslip.study.description import StudyDescription


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
        For each load, one for each amplitude of the study; under a normal load that varies each
        is a :class:`~microslip.runs.columns.VaryingLoop`.
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
    oscillators : tuple of OscillatorCurve
        For each load, the oscillator of the study over the range of the curves; empty without one.
    varying : tuple of VaryingCycles
        For each load, the cyclic quantities of the loops where the study lets the normal load vary,
        else empty; rows and curves are at constant load all the same.
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
        from microslip.report import draw

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
