"""A measured surface: heights on a regular grid, and their source."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip.contact import MeasuredContact
from microslip.contact.materials import MaterialPair
from microslip.readers.files import POINTS
from microslip.surfaces import conditioning, repair, surface_parameters
from microslip.surfaces import spectrum as spectra
from microslip.surfaces import summits as finding
from microslip.surfaces.file_reading import read
from microslip.surfaces.height_map import HeightMap
from microslip.surfaces.heights_in_files import Wishes

MOST_SOLVED = 1 << 20
"""Points of a face that is solved point by point; of larger scans every n-th one is."""


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Scan(HeightMap):
    """Heights of a surface, or of a line on it, on a regular grid.

    Heights count upwards, out of the material. Nothing is levelled or filtered unless
    :meth:`condition` was asked to; the notes tell what was done.

    Parameters
    ----------
    heights : array_like
        Heights z [m]: rows along y, columns along x; or one-dimensional, a profile. Missing points
        are NaN, or masked. At least two rows and two columns; a profile has at least four points.
    pixel : float, str or pair of them
        Distance of neighbours [m], or text with a unit such as "1.66 um": one for both axes, or
        (along x, along y).
    name : str
        Name of the scan in messages and pictures.
    notes : tuple of str
        Source and processing steps.
    cutoff : float, optional
        Wavelength [m] below which conditioning has removed the waves; None if it has not.
    long_cutoff : float, optional
        Wavelength [m] above which it has.
    """

    @classmethod
    def read(
        cls,
        path: str | os.PathLike[str],
        format: str | None = None,
        *,
        unit: str | tuple[str, str] | None = None,
        pixel: Any = None,
        channel: str | int | None = None,
        valid: tuple[float | str, float | str] | None = None,
        limit: int = POINTS,
    ) -> Scan:
        """Read a scan from a file.

        NumPy's ``.npy`` and ``.npz``, text (a matrix of heights; x, y and z of points in columns;
        x and z of a profile) and MATLAB's ``.mat`` up to version 7 need no more than microslip.
        The files of instruments are read by SurfaceTopography, DOI 10.1088/2051-672X/ac860a
        (``pip install "microslip[scan]"``).

        Parameters
        ----------
        path : str or path
            The file.
        format : str, optional
            Its format, the only one tried then: "npy", "npz", "mat", "hdf5", "text" (or what is in
            it: "matrix", "xyz", "profile"), or a name of SurfaceTopography's such as "plu", "mnt"
            or "al3d". An ending such as "csv" or ".npy" will do.
        unit : str or pair of str, optional
            Unit of the heights, such as "um", where the file does not say it: needed for arrays,
            and for text without names such as "z [um]" above its columns. It holds for coordinates
            in the file as well; ("mm", "um") are the units of coordinates and of heights.
        pixel : float, str or pair of them, optional
            Distance of neighbours, [m] or such as "1.66 um", where the file does not say it; it
            takes the place of what an instrument's file says.
        channel : str or int, optional
            Channel of an instrument's file, by name or from 0; or the array of an ``.npz``,
            ``.mat`` or HDF5 that holds more than one, such as "run.z".
        valid : pair of floats or str, optional
            Lowest and highest possible height, [m] or such as ("-1 mm", "1 mm"); whatever is
            beyond is missing. Needed where a number such as -9999 stands for "nothing measured".
        limit : int
            Points that the file may hold; it is refused before they are read.

        Returns
        -------
        Scan
            The scan, as it is in the file.
        """
        if not isinstance(path, (str, os.PathLike)):
            raise InputError(f"`path` must be text or a path, got {show(path)}")
        wishes = Wishes(format, unit, pixel, channel, valid)
        heights, steps, name, notes = read(Path(path), wishes, limit)
        return cls(heights, steps, name=name, notes=notes)

    # Functions of a scan are its methods.
    condition = conditioning.condition
    repaired = repair.repaired
    spectrum = spectra.spectrum
    areal_parameters = surface_parameters.areal_parameters
    profile_parameters = surface_parameters.profile_parameters
    summits = finding.find_summits

    def solvable(self) -> Scan:
        """Return the scan as faces are solved: without gaps, and of at most a million points.

        Missing points are interpolated from around them (:meth:`condition`), and of a larger scan
        every n-th point along x and y is kept; the notes state both.
        """
        scan = self.measurable()
        if scan.missing > 0.0:
            scan = scan.condition(fill="interpolate")
        step = math.ceil(math.sqrt(scan.heights.size / MOST_SOLVED))
        if step == 1 or scan.is_profile:
            return scan
        note = f"solved by every {step}th point along x and y; the effect of the pixel is reported."
        return Scan(
            scan.heights[::step, ::step], tuple(step * length for length in scan.pixel),
            name=scan.name, notes=(*scan.notes, note), cutoff=scan.cutoff,
            long_cutoff=scan.long_cutoff,
        )  # fmt: skip

    def to_contact(
        self,
        pair: MaterialPair,
        *,
        hardness: float | None = None,
        tightening_pressure: float | None = None,
        **how: Any,
    ) -> MeasuredContact:
        """Solve the scan point by point: a normal law of interacting contacts that yield.

        Missing points are filled, and a scan of more than a million points is solved by every n-th
        of them, as :meth:`solvable` says.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        hardness : float, optional
            Most that a point bears [Pa]; by default that of the pair.
        tightening_pressure : float, optional
            Mean pressure [Pa] that the face has been tightened to; without it nothing yields.
        **how
            As of :class:`microslip.MeasuredContact`: `area`, `piece`, `direction` and more.

        Returns
        -------
        MeasuredContact
            The law. The scan is the gap of both faces: of two, that of their sum.
        """
        return MeasuredContact(self.solvable(), pair, hardness, tightening_pressure, **how)
