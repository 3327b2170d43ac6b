"""Measured surface: heights on a regular grid, and their source."""

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
from microslip.surfaces.file_reading import read_scan
from microslip.surfaces.height_map import HeightMap

MOST_SOLVED = 1 << 20
"""Largest number of points of a face for the point-by-point solution; larger scans are subsampled.
"""


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Scan(HeightMap):
    """Heights of a surface, or of a line on it, on a regular grid.

    Heights are positive out of the material. Only :meth:`condition` levels or filters; the notes
    record the steps.

    Parameters
    ----------
    heights : array_like
        Heights z [m]: rows along y and columns along x, shape (rows, columns), or one-dimensional
        for a profile. Missing points are NaN, or masked. At least two rows and two columns; a
        profile has at least four points.
    pixel : float, str or pair of them
        Distance between neighbouring points [m], or text with a unit such as "1.66 um": one for
        both axes, or (along x, along y).
    name : str
        Name of the scan in messages and figures.
    notes : tuple of str
        Source and processing steps.
    cutoff : float, optional
        Short-wave cut-off [m]: conditioning has removed shorter waves; None without a filter.
    long_cutoff : float, optional
        Long-wave cut-off [m]: conditioning has removed longer waves; None without a filter.
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

        NumPy ``.npy`` and ``.npz`` files, text (a matrix of heights; columns x, y and z of points;
        columns x and z of a profile) and MATLAB ``.mat`` files up to version 7 need no further
        packages. Instrument files are read by SurfaceTopography, DOI 10.1088/2051-672X/ac860a
        (``pip install "microslip[scan]"``).

        Parameters
        ----------
        path : str or path
            The file.
        format : str, optional
            Format: "npy", "npz", "mat", "hdf5", "text" (or its content: "matrix", "xyz",
            "profile"), or a format of SurfaceTopography such as "plu", "mnt" or "al3d". Detected by
            default.
        unit : str or pair of str, optional
            Unit of the heights and coordinates, such as "um", if the file does not state it:
            required for arrays and text without headings such as "z [um]". A pair such as
            ("mm", "um") gives the units of coordinates and of heights.
        pixel : float, str or pair of them, optional
            Distance between neighbouring points [m], or text such as "1.66 um", if the file does
            not state it; overrides the value of an instrument file.
        channel : str or int, optional
            Channel of an instrument file, by name or number from 0, or array of an ``.npz``,
            ``.mat`` or HDF5 file with several arrays, such as "run.z".
        valid : pair of floats or str, optional
            Lowest and highest possible height [m], or text such as ("-1 mm", "1 mm"); points
            outside are missing. Required if a number such as -9999 stands for missing points.
        limit : int
            Largest number of points; a file that declares more is rejected before reading.

        Returns
        -------
        Scan
            The scan as stored in the file.
        """
        if not isinstance(path, (str, os.PathLike)):
            raise InputError(f"`path` must be text or a path, got {show(path)}")
        heights, steps, name, notes = read_scan(
            Path(path), format, unit, pixel, channel, valid, limit
        )
        return cls(heights, steps, name=name, notes=notes)

    # These functions take a scan as their first argument.
    condition = conditioning.condition
    repaired = repair.repaired
    spectrum = spectra.spectrum
    areal_parameters = surface_parameters.areal_parameters
    profile_parameters = surface_parameters.profile_parameters
    summits = finding.find_summits

    def solvable(self) -> Scan:
        """Return the scan as used for solving faces: without gaps, at most a million points.

        Missing points are interpolated (:meth:`condition`), and larger scans are subsampled along x
        and y; the notes state both.
        """
        scan = self.measurable()
        if scan.missing > 0.0:
            scan = scan.condition(fill="interpolate")
        step = math.ceil(math.sqrt(scan.heights.size / MOST_SOLVED))
        if step == 1 or scan.is_profile:
            return scan
        note = (
            f"subsampled: every {step}th point along x and y; the effect of the pixel is reported."
        )
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
        """Return the load over separation of the scan, solved for the contact of all its points.

        The points interact elastically, and their pressure is limited by the hardness if
        ``tightening_pressure`` is given. Missing points are filled and scans of more than a million
        points subsampled, see :meth:`solvable`.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        hardness : float, optional
            Largest pressure at a point [Pa]; by default that of the pair.
        tightening_pressure : float, optional
            Mean pressure [Pa] to which the face has been tightened: points yield while it is
            applied, and the law is elastic at lower pressures. Without it no point yields.
        **how
            Options of :class:`microslip.MeasuredContact`, such as `area`, `piece` and `direction`.

        Returns
        -------
        MeasuredContact
            The law. The scan is the gap between the faces; for two rough faces, the sum of their
            heights.
        """
        return MeasuredContact(self.solvable(), pair, hardness, tightening_pressure, **how)
