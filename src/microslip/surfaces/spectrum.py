"""The power spectrum of a measured surface, radial and along each axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip._core.wording import quoted
from microslip.surfaces.height_map import HeightMap
from microslip.surfaces.moments import Moments

Window = Literal["hann"] | None

_HANN_ALIKE = 35.0 / 18.0  # n sum w^8 / (sum w^4)^2 of the taper w = sin^2


@dataclass(frozen=True, eq=False)
class AxisSpectrum(Locked):
    """One-sided power spectrum of the profiles along one axis, in the mean over all of them."""

    wavenumber: Floats
    """Wavenumbers q = 2 pi/wavelength [rad/m], rising from one wave on the length of the scan."""
    power: Floats
    """Variance [m^2] in the band about each; they sum to m0 less the variance of the profiles'
    means, which do not vary along this axis."""
    density: Floats
    """The same per wavenumber [m^3]: its integral over q is the sum."""
    pixel: float
    """Distance of neighbours [m]."""

    @property
    def wavelength(self) -> Floats:
        """Wavelengths [m], falling."""
        return 2.0 * math.pi / self.wavenumber

    def moment(self, order: int, *, differences: bool = False) -> float:
        """Spectral moment of the profiles."""
        if order not in (0, 2, 4):
            raise InputError(f"`order` must be 0, 2 or 4, got {show(order)}")
        q = self.wavenumber
        if differences:
            q = 2.0 / self.pixel * np.sin(0.5 * self.pixel * q)
        return float(self.power @ q**order)


@dataclass(frozen=True, eq=False)
class Spectrum(Locked):
    """Power spectrum of a scan; of a profile, there is the one axis only.

    Normalised so that the integral of the density over the plane of wavenumbers is m0; see
    Jacobs, Junge and Pastewka (2017), DOI 10.1088/2051-672X/aa51f8, for other habits.
    """

    wavenumber: Floats
    """Wavenumbers q [rad/m] of the rings, rising; only rings that hold waves."""
    density: Floats
    """Mean density C [m^4] of a ring; of a profile, that along it [m^3]."""
    power: Floats
    """Variance in each ring [m^2]; they sum to m0."""
    axes: tuple[AxisSpectrum, ...]
    """Spectra along x and along y; of a profile, along it."""
    window: Window
    """Taper at the edges of the scan."""
    cutoff: float | None = None
    long_cutoff: float | None = None
    """Band of wavelengths [m] that conditioning has left."""
    waves: Floats = field(default_factory=lambda: np.zeros(0))
    """Waves of each ring [-], mirrored ones counted twice."""

    @property
    def relative_error(self) -> Floats:
        """Standard deviation of the density over it [-], of a Gaussian surface; one at most.

        A ring is the mean of its waves, each of which scatters as much as it is large. Waves that
        mirror each other count once, and a Hann taper makes neighbours alike: along a ring 1.94
        of them are one.
        """
        alike = _HANN_ALIKE if self.window else 1.0
        independent = np.maximum(0.5 * self.waves / alike, 1.0)
        return np.asarray(1.0 / np.sqrt(independent))

    @property
    def wavelength(self) -> Floats:
        """Wavelengths of the rings [m], falling."""
        return 2.0 * math.pi / self.wavenumber

    @property
    def m0(self) -> float:
        """Integral of the spectrum [m^2]."""
        return float(self.power.sum())

    def moments(self, *, differences: bool = False) -> Moments:
        """Moments m0, m2 and m4 of the spectrum, in the mean over the axes and of each.

        With ``differences`` they take what finite differences see in place of the wavenumber, and
        are those of :meth:`Scan.moments` but for taper and edges; without, each wave counts in
        full, noise at the pixel too. A surface without waves is an InputError.
        """
        second = tuple(axis.moment(2, differences=differences) for axis in self.axes)
        fourth = tuple(axis.moment(4, differences=differences) for axis in self.axes)
        count = len(self.axes)
        return Moments(
            self.m0, math.fsum(second) / count, math.fsum(fourth) / count, second, fourth
        )


def spectrum(scan: HeightMap, *, window: Window = "hann") -> Spectrum:
    """Power spectrum of the heights, radial and by axis, of a scan tapered by Hann's window or not.

    Errors as :meth:`measurable`.
    """
    if window is not None and not (isinstance(window, str) and window == "hann"):
        raise InputError(f"`window` must be {quoted(['hann'])} or None, got {show(window)}")
    heights, steps = scan.measurable().heights, scan.pixel
    tapers = [_taper(n, window) for n in heights.shape]
    weight: Any = tapers[0] if heights.ndim == 1 else tapers[0][:, None]
    missing = np.isnan(heights)
    has_gaps = bool(missing.any())
    z = np.where(missing, 0.0, heights) if has_gaps else heights.copy()
    here = [(~missing).astype(float) if has_gaps else None]
    z -= _weighted_mean(z, tapers, here[0])
    if has_gaps:
        z[missing] = 0.0
    z *= weight
    if heights.ndim == 2:
        z *= tapers[1]
    square = _weighted_sum([taper * taper for taper in tapers], here[0])
    del missing, here
    if heights.ndim == 1:
        power = np.abs(np.fft.rfft(z)) ** 2
        power *= mirrored_counts(heights.size) / (heights.size * square)
        axis = _axis(power, heights.size, steps[0])
        radial = axis.wavenumber, axis.density, axis.power
        counts = lock(np.full(axis.wavenumber.size, 2.0))
        return Spectrum(*radial, (axis,), window, scan.cutoff, scan.long_cutoff, counts)
    rows, columns = z.shape
    dx, dy = steps
    waves = np.fft.rfft2(z)
    del z
    full = waves.real**2
    full += waves.imag**2
    del waves
    full *= mirrored_counts(columns) / (rows * columns * square)
    along_x = full.sum(axis=0)
    rows_power = full.sum(axis=1)
    # Fold negative wavenumbers along y onto the positive ones.
    along_y = rows_power[: rows // 2 + 1].copy()
    along_y[1 : (rows + 1) // 2] += rows_power[: rows // 2 : -1]
    q, power, count = _rings(full, (dx, dy), columns)
    cell = (2.0 * math.pi) ** 2 / (rows * dx * columns * dy)
    radial = lock(q), lock(power / (count * cell)), lock(power)
    axes = _axis(along_x, columns, dx), _axis(along_y, rows, dy)
    return Spectrum(*radial, axes, window, scan.cutoff, scan.long_cutoff, lock(count))


def _taper(count: int, window: Window) -> Floats:
    if window is None:
        return np.ones(count)
    # Half a step off the edges, so that no point is without weight.
    return np.sin(math.pi * (np.arange(count) + 0.5) / count) ** 2


def _weighted_sum(tapers: list[Floats], present: Floats | None) -> float:
    if present is None:
        return math.prod(float(taper.sum()) for taper in tapers)
    if len(tapers) == 1:
        return float(present @ tapers[0])
    return float(tapers[0] @ present @ tapers[1])


def _weighted_mean(z: Floats, tapers: list[Floats], present: Floats | None) -> float:
    # The mean under the taper, so that the mean itself leaks into no wave.
    return _weighted_sum(tapers, z) / _weighted_sum(tapers, present)


def mirrored_counts(count: int) -> Floats:
    """Number of waves of the full transform for each one of the half; the mean has none."""
    sides = np.full(count // 2 + 1, 2.0)
    if count % 2 == 0:
        sides[-1] = 1.0
    sides[0] = 1.0
    return sides


def _axis(power: Floats, count: int, step: float) -> AxisSpectrum:
    unit = 2.0 * math.pi / (count * step)
    varying = power[1:].copy()  # without what does not vary along this axis
    q = unit * np.arange(1, varying.size + 1)
    return AxisSpectrum(lock(q), lock(varying), lock(varying / unit), step)


def _rings(full: Floats, steps: tuple[float, float], columns: int) -> tuple[Floats, Floats, Floats]:
    """Mean wavenumber, power and number of waves of each ring."""
    rows = full.shape[0]
    qx = 2.0 * math.pi * np.fft.rfftfreq(columns, steps[0])
    qy = 2.0 * math.pi * np.fft.fftfreq(rows, steps[1])
    # As wide as the coarser step of the grid: no ring is empty for want of waves.
    width = max(float(qx[1]), abs(float(qy[1])))
    sides = mirrored_counts(columns)
    bins = int(math.hypot(float(qx[-1]), float(np.abs(qy).max())) / width + 0.5) + 1
    sums = np.zeros((3, bins))
    for row in range(rows):
        q = np.hypot(qx, qy[row])
        ring = (q / width + 0.5).astype(np.intp)
        # Rings are about multiples of the width; what is nearer to zero joins the first.
        ring = np.maximum(ring, 1)
        waves = sides.copy()
        if row == 0:
            waves[0] = 0.0
        sums[0] += np.bincount(ring, waves, minlength=bins)
        sums[1] += np.bincount(ring, waves * q, minlength=bins)
        sums[2] += np.bincount(ring, full[row], minlength=bins)
    count, radial, power = sums[:, sums[0] > 0.0]
    return radial / count, power, count
