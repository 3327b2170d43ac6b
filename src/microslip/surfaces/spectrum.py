"""Power spectrum of a measured surface, radial and along each axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock
from microslip.surfaces.height_map import HeightMap

_HANN_ALIKE = 35.0 / 18.0  # n sum w^8 / (sum w^4)^2 for the taper w = sin^2


@dataclass(frozen=True, eq=False)
class Spectrum(Locked):
    """Power spectrum of a scan, averaged over rings of wavenumbers, or along one axis.

    The density is normalised so that its integral over the plane of wavenumbers is m0; for other
    conventions see Jacobs, Junge and Pastewka (2017), DOI 10.1088/2051-672X/aa51f8. The spectrum
    along an axis, such as that of a profile, is one-sided and averaged over all profiles; its
    integral is m0 less the variance of the means of the profiles.
    """

    wavenumber: Floats
    """Wavenumbers q = 2 pi/wavelength [rad/m] of the non-empty rings or along the axis, rising."""
    density: Floats
    """Mean density C [m^4] of a ring; along an axis, power per wavenumber [m^3]."""
    power: Floats
    """Variance in each ring, or in the band about each wavenumber [m^2]."""
    waves: Floats
    """Number of waves per ring [-], mirrored waves counted twice; 2 along an axis."""
    axes: tuple[Spectrum, ...] = ()
    """Spectra along x and y; for a profile, along it."""

    @property
    def relative_error(self) -> Floats:
        """Standard deviation of the density over its mean [-] for a Gaussian surface; at most one.

        The density is a mean over the waves of a ring, each with a standard deviation equal to its
        mean. Waves q and -q count once, and a Hann taper correlates neighbours: 1.94 waves along a
        ring count as one.
        """
        independent = np.maximum(0.5 * self.waves / _HANN_ALIKE, 1.0)
        return np.asarray(1.0 / np.sqrt(independent))

    @property
    def wavelength(self) -> Floats:
        """Mean wavelengths of the rings of wavenumbers [m], in decreasing order."""
        return 2.0 * math.pi / self.wavenumber


def spectrum(scan: HeightMap) -> Spectrum:
    """Compute the power spectrum of the heights, averaged over directions and along each axis.

    The scan is tapered by a Hann window. Raises the errors of :meth:`measurable`.
    """
    heights, steps = scan.measurable().heights, scan.pixel
    tapers = [_taper(n) for n in heights.shape]
    weight: Any = tapers[0] if heights.ndim == 1 else tapers[0][:, None]
    missing = np.isnan(heights)
    has_gaps = bool(missing.any())
    z = np.where(missing, 0.0, heights) if has_gaps else heights.copy()
    here = [(~missing).astype(float) if has_gaps else None]
    # The mean is weighted by the taper, so that it does not leak into waves.
    z -= _weighted_sum(tapers, z) / _weighted_sum(tapers, here[0])
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
        return replace(axis, axes=(axis,))
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
    axes = _axis(along_x, columns, dx), _axis(along_y, rows, dy)
    return Spectrum(lock(q), lock(power / (count * cell)), lock(power), lock(count), axes)


def _taper(count: int) -> Floats:
    # Half a step from the edges, so that every point has weight.
    return np.sin(math.pi * (np.arange(count) + 0.5) / count) ** 2


def _weighted_sum(tapers: list[Floats], present: Floats | None) -> float:
    if present is None:
        return math.prod(float(taper.sum()) for taper in tapers)
    if len(tapers) == 1:
        return float(present @ tapers[0])
    return float(tapers[0] @ present @ tapers[1])


def mirrored_counts(count: int) -> Floats:
    """Return how many waves of a complex FFT each wave of the real FFT represents, 1 or 2.

    For ``count`` points it is 1 for the mean and, if ``count`` is even, for the shortest wave.
    """
    sides = np.full(count // 2 + 1, 2.0)
    if count % 2 == 0:
        sides[-1] = 1.0
    sides[0] = 1.0
    return sides


def _axis(power: Floats, count: int, step: float) -> Spectrum:
    unit = 2.0 * math.pi / (count * step)
    varying = power[1:].copy()  # without the mean along this axis
    q = unit * np.arange(1, varying.size + 1)
    return Spectrum(lock(q), lock(varying / unit), lock(varying), lock(np.full(q.size, 2.0)))


def _rings(full: Floats, steps: tuple[float, float], columns: int) -> tuple[Floats, Floats, Floats]:
    rows = full.shape[0]
    qx = 2.0 * math.pi * np.fft.rfftfreq(columns, steps[0])
    qy = 2.0 * math.pi * np.fft.fftfreq(rows, steps[1])
    # Rings as wide as the coarser grid step are never empty.
    width = max(float(qx[1]), abs(float(qy[1])))
    sides = mirrored_counts(columns)
    bins = int(math.hypot(float(qx[-1]), float(np.abs(qy).max())) / width + 0.5) + 1
    sums = np.zeros((3, bins))
    for row in range(rows):
        q = np.hypot(qx, qy[row])
        ring = (q / width + 0.5).astype(np.intp)
        # Rings are centred on multiples of the width; waves nearer to zero join the first ring.
        ring = np.maximum(ring, 1)
        waves = sides.copy()
        if row == 0:
            waves[0] = 0.0
        sums[0] += np.bincount(ring, waves, minlength=bins)
        sums[1] += np.bincount(ring, waves * q, minlength=bins)
        sums[2] += np.bincount(ring, full[row], minlength=bins)
    count, radial, power = sums[:, sums[0] > 0.0]
    return radial / count, power, count
