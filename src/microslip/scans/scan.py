"""A measured surface: heights on a regular grid, and their source."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, plain, show, sized
from microslip.errors import InputError
from microslip.materials import MaterialPair
from microslip.normal import MeasuredContact
from microslip.readers.files import POINTS
from microslip.scans.conditioning import Steps, condition
from microslip.scans.cutoffs import CutoffTable, over_cutoffs
from microslip.scans.file_reading import read
from microslip.scans.height_fit import HeightFit, height_distribution
from microslip.scans.height_map import HeightMap
from microslip.scans.heights_in_files import Wishes
from microslip.scans.joint_over_cutoffs import joint_over_cutoffs as _joint_over_cutoffs
from microslip.scans.levelling import Level
from microslip.scans.spectrum import Spectrum, spectrum
from microslip.scans.summits import Summits, find_summits
from microslip.scans.surface_parameters import (
    ArealParameters,
    Autocorrelation,
    ProfileParameters,
    areal_parameters,
    autocorrelation,
    profile_parameters,
    slope_over_distance,
)


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
        key: str | None = None,
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
        key : str, optional
            Array of an ``.npz``, ``.mat`` or HDF5 that holds more than one, such as "run.z".
        channel : str or int, optional
            Channel of an instrument's file, by name or from 0.
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
        wishes = Wishes(format, unit, pixel, key, channel, valid)
        heights, steps, name, notes = read(Path(path), wishes, limit)
        return cls(heights, steps, name=name, notes=notes)

    def condition(
        self,
        *,
        level: Level | None = None,
        outliers: float | None = None,
        fill: Literal["interpolate"] | None = None,
        cutoff: float | str | None = None,
        long_cutoff: float | str | None = None,
        filter: Literal["gaussian", "robust", "spline"] = "gaussian",
        crop: Any = None,
    ) -> Scan:
        """Crop, remove outliers, level, fill and limit the band of wavelengths, in this order.

        Parameters
        ----------
        level : {"plane", "quadratic", "cylinder", "lines", "mean"}, optional
            Form to be removed, by least squares on the points there are. "cylinder" is a plane
            and a parabola across one direction, whichever fits best; "lines" a straight line of
            each row (along x) by itself, which takes away steps and drift from row to row, and
            with them the waves along y that a row sees as a constant.
        outliers : float, optional
            Points farther than so many robust standard deviations from the median of their
            neighbours go missing; 6 is usual.
        fill : {"interpolate"}, optional
            Fill missing points from those around them (see Notes).
        cutoff : float or str, optional
            Short-wave cut-off [m], or such as "10 um": shorter waves are removed.
        long_cutoff : float or str, optional
            Long-wave cut-off [m]: longer waves, the mean among them, are removed.
        filter : {"gaussian", "robust", "spline"}
            Filter of the long-wave cut-off. "robust" is a Gaussian regression of second order that
            scratches and pits do not pull (ISO 16610-31:2016, -71:2014), "spline" a smoothing
            cubic spline (ISO 16610-22:2015; of areas a plate, the same in all directions). Neither
            bends at the ends.
        crop : float, str or pair of them, optional
            Length [m] that is cut off each end, or one along x and one along y.

        Returns
        -------
        Scan
            The conditioned scan; its notes and cut-offs tell what was done.

        Notes
        -----
        In words of ISO 25178-3 ``cutoff`` is the nesting index of the S-filter, ``level`` the
        F-operation and ``long_cutoff`` the nesting index of the L-filter. The form goes first here,
        so that a tilt does not leak through the ends of the S-filter; inside the two orders agree.
        The Gaussian filters transmit half the amplitude at the cut-off (ISO 16610-61:2015; of
        profiles, ISO 16610-21:2011). At edges and gaps the weights of the points there are sum to
        one, by normalised convolution. Filling solves the discrete Laplace equation in the gaps
        approximately, from coarse to fine grids: smooth, the same on every machine, and in a time
        that grows with the number of points.
        """
        return condition(self, Steps(level, outliers, fill, cutoff, long_cutoff, filter, crop))

    def spectrum(self) -> Spectrum:
        """Power spectrum of the heights, radial and by axis; errors as :meth:`measurable`."""
        return spectrum(self.measurable())

    def areal_parameters(self) -> ArealParameters:
        """Parameters of ISO 25178-2:2021 beyond heights and moments, in SI units.

        Sp, Sv, Sz, S10z; Sk, Spk, Svk, Smr1, Smr2; Vmp, Vmc, Vvc, Vvv (at 10 and 80 %); Sal, Str,
        Std; Sdr, Sdq; Spd and Spc.

        Of the scan as it is: level and filter it first, and say its cut-offs with them. Errors as
        :meth:`measurable`; a profile has none.
        """
        return areal_parameters(self)

    def profile_parameters(
        self, section: float | str | None = None, axis: Literal["x", "y"] = "x"
    ) -> ProfileParameters:
        """Parameters of ISO 21920-2:2021: Ra, Rq, Rz, Rsm, Rdq, Rk and others, in SI units.

        Of the heights as they are, each line above its mean: level them first, and apply the
        long-wave cut-off that goes with the numbers.

        Parameters
        ----------
        section : float or str, optional
            Section length [m], or such as "0.8 mm"; by default the long-wave cut-off, or a fifth
            of the profile where there is none.
        axis : {"x", "y"}
            Of an area the lines along x or along y: the parameters are the means over all lines
            without gaps.

        Returns
        -------
        ProfileParameters
            The parameters, with the section length and how many sections there are.
        """
        return profile_parameters(self, section, axis)

    def material_ratio(self, height: ArrayLike) -> Any:
        """Share of points that are higher than heights [m] above the mean, Rmr(c) and Smr(c).

        Material ratio of heights of any shape, in the same shape [-].
        """
        there = np.sort(self.heights[~np.isnan(self.heights)], axis=None)
        places = np.asarray(sized("height", height)) + there.mean()
        return plain(1.0 - np.searchsorted(there, places, side="right") / there.size)

    def autocorrelation(self) -> Autocorrelation:
        """Normalised autocorrelation of the heights [-] against lags [m], of pairs there are.

        Errors as :meth:`measurable`; a profile has none.
        """
        return autocorrelation(self)

    def slope_over_distance(self) -> tuple[Floats, Floats]:
        """Rms slope between points, against their distance; errors as :meth:`measurable`.

        Returns
        -------
        tuple of ndarray
            Distances [m], doubling from one pixel to a quarter of the scan, and the root mean
            square of the difference in height over the distance [-], in the mean over the axes;
            one-dimensional (Sanner et al. 2022, DOI 10.1016/j.apsadv.2021.100190).
        """
        return slope_over_distance(self.measurable())

    def height_distribution(self) -> HeightFit:
        """Density of the heights, and how well the usual distributions fit it.

        Errors as :meth:`measurable`.
        """
        return height_distribution(self.measurable())

    def summits(
        self,
        cutoff: float | str | None,
        *,
        method: Literal["watershed", "neighbours"] = "watershed",
        prominence: float | str | None = None,
        level: Level | None = None,
        window: int = 3,
    ) -> Summits:
        """Find the summits, after levelling if that is asked for, and the short-wave cut-off.

        Parameters
        ----------
        cutoff : float, str or None
            Short-wave cut-off [m], or such as "10 um". It decides the result and has no default;
            None must be written and says that the pixel decides. What :meth:`condition` has cut
            off counts: nothing is filtered twice.
        method : {"watershed", "neighbours"}
            Definition: summits that rise enough above the saddle to a higher one, or every point
            above its eight neighbours.
        prominence : float or str, optional
            Least rise above that saddle [m], or such as "2 nm"; by default, of "watershed", some
            standard deviations of the noise that passes the cut-off.
        level : {"plane", "quadratic", "cylinder", "lines", "mean"}, optional
            Form to be removed before, where :meth:`condition` has not done so.
        window : int
            Points along a side of the square that a quadric is fitted to: 3, 5, 7 ... 15.

        Returns
        -------
        Summits
            Positions, heights and radii.
        """
        return find_summits(
            self.measurable(),
            cutoff,
            method=method,
            prominence=prominence,
            level=level,
            window=window,
        )

    def to_contact(
        self,
        pair: MaterialPair,
        *,
        hardness: float | None = None,
        tightening_pressure: float | None = None,
        **how: Any,
    ) -> MeasuredContact:
        """Solve the scan point by point: a normal law of interacting contacts that yield.

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
        return MeasuredContact(self.measurable(), pair, hardness, tightening_pressure, **how)

    joint_over_cutoffs = _joint_over_cutoffs

    def over_cutoffs(
        self,
        cutoffs: ArrayLike | None = None,
        *,
        level: Level | None = "plane",
        counted: bool = True,
        method: Literal["watershed", "neighbours"] = "watershed",
        prominence: float | str | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> CutoffTable:
        """Every parameter against the short-wave cut-off.

        Parameters
        ----------
        cutoffs : array_like, optional
            Cut-offs [m], or such as "10 um", one-dimensional, 0 or None for none; by default none,
            and from a few pixels to an eighth of the scan, of a small one to a third.
        level : {"plane", "quadratic", "cylinder", "lines", "mean"}, optional
            Form to be removed before; None for none.
        counted : bool
            Whether to count the summits at each cut-off as well.
        method, prominence
            Definition of a summit: see :meth:`summits`.
        progress : callable, optional
            Called with the cut-offs done and those to do, after each.

        Returns
        -------
        CutoffTable
            The parameters, one column each.
        """
        return over_cutoffs(
            self.measurable(),
            cutoffs,
            level=level,
            counted=counted,
            method=method,
            prominence=prominence,
            progress=progress,
        )
