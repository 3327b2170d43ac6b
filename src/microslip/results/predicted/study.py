"""A study that computes itself."""

from __future__ import annotations

from microslip.results.predicted.columns import Progress
from microslip.results.predicted.result import Result
from microslip.results.predicted.run import run
from microslip.study.description import StudyDescription


class Study(StudyDescription):
    """A validated description of one prediction; quantities are SI floats.

    Made from a file by :meth:`load`, from text by :meth:`from_toml`, or in Python with the keys
    of the file and quantities as text, ``Study(schema=1, surface={"radius": "1 mm", …}, …)``.

    Raises
    ------
    StudyError
        If it is no study; one line with key, what came and what was wanted.
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

        Raises
        ------
        StudyError
            If the physics has no answer, such as a load that the surface cannot carry.
        """
        return run(self, progress, workers)
