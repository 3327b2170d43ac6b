"""Random surfaces with prescribed moments.

A random surface is a sum of waves with random phases and a self-affine power spectrum C(q) ~ q^(-2
- 2 H) between two wavenumbers. The ends of the band are solved for m2/m0 and m4/m2 on the discrete
grid, with the finite differences of :meth:`Scan.moments`; the scale of the spectrum gives m0.
Amplitudes follow the spectrum exactly and are not random, so that each surface, not only the
ensemble, has the moments; a sum of many waves with random phases is still Gaussian.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import Floats, exact, number, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip.surfaces.checks import pixel_of
from microslip.surfaces.scan import Scan

_LARGEST = 1 << 27  # points of a grid, 1 GB


def random_surface(
    shape: tuple[int, int],
    pixel: float | tuple[float, float],
    *,
    m0: float,
    m2: float,
    m4: float,
    hurst: float = 0.8,
    seed: int = 0,
    name: str = "random surface",
) -> Scan:
    """Make a random isotropic surface with prescribed moments.

    The surface is periodic, approximately Gaussian (for many waves) and self-affine between two
    wavelengths (Nayak 1971, DOI 10.1115/1.3451608, on the moments of such surfaces).

    Parameters
    ----------
    shape : tuple of int
        Rows (along y) and columns (along x), at least 16 of each.
    pixel : float or pair of float
        Distance between neighbouring points [m].
    m0, m2, m4 : float
        Variance of heights [m^2], mean square slope [-] and curvature [1/m^2] of profiles as
        computed by :meth:`Scan.moments`; met within 2 %.
    hurst : float
        Hurst exponent H [-] of the spectrum q^(-2 - 2 H), from -1 (white) to 2.
    seed : int
        Seed of the phases; the same seed gives the same surface.
    name : str
        Name of the scan.

    Returns
    -------
    Scan
        The surface; its notes state the band.
    """
    rows, columns = _shape(shape)
    dx, dy = _pair(pixel)
    for key, value, unit in (("m0", m0, "m^2"), ("m2", m2, ""), ("m4", m4, "1/m^2")):
        positive(key, value, unit)
    hurst = number("hurst", hurst)
    if not -1.0 <= hurst <= 2.0:
        raise InputError(f"`hurst` must be from -1 to 2, got {hurst:g}")
    if not isinstance(seed, (int, np.integer)) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"`seed` must be a whole number from 0, got {show(seed)}")
    qx: Floats = 2.0 * math.pi * np.fft.rfftfreq(columns, dx).astype(float)
    qy: Floats = 2.0 * math.pi * np.fft.fftfreq(rows, dy).astype(float)
    q = np.hypot(qy[:, None], qx[None, :])
    q[0, 0] = math.inf  # the mean has no amplitude
    band = _Band(q, qx, qy, (dx, dy), hurst)
    low, high = band.solve(m0, m2, m4)
    amplitude = np.sqrt(band.power(q, low, high), out=q)
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, amplitude.shape)
    waves = amplitude * np.exp(1j * phase)
    del phase, amplitude, q
    # Waves along y occur twice in the half plane, as conjugates: required for real heights.
    for column in {0, waves.shape[1] - 1} if columns % 2 == 0 else {0}:
        half = (rows - 1) // 2
        waves[-half:, column] = waves[half:0:-1, column].conj()
        if rows % 2 == 0:
            waves[rows // 2, column] = abs(waves[rows // 2, column])
    heights = np.fft.irfft2(waves, s=(rows, columns))
    heights -= heights.mean()
    heights *= math.sqrt(m0 / float(np.mean(heights * heights)))
    return Scan(
        lock(heights),
        (dx, dy),
        name=name,
        notes=(
            f"random surface, seed {seed}: waves from {2.0 * math.pi / high:.4g} m to "
            f"{2.0 * math.pi / low:.4g} m, spectrum q^{-2.0 - 2.0 * hurst:g}",
        ),
    )


class _Band:
    """Spectral moments of the waves of a grid between two wavenumbers, binned by wavenumber."""

    def __init__(
        self, q: Floats, qx: Floats, qy: Floats, pixel: tuple[float, float], hurst: float
    ) -> None:
        self.exponent = -2.0 - 2.0 * hurst
        self.least = min(float(qx[1]), float(qy[1]))
        self.most = math.pi / max(pixel)
        # Finite differences replace q by K = (2/h) sin(q h/2).
        kx, ky = (
            (2.0 / h * np.sin(0.5 * along * h)) ** 2
            for along, h in zip((qx, qy), pixel, strict=True)
        )
        # Waves with qx > 0 also represent their conjugates, except the Nyquist wave.
        twice = np.full(qx.size, 2.0)
        twice[0] = 1.0
        if (2.0 * math.pi / pixel[0] - 2.0 * qx[-1]) < 1e-6 * qx[1]:
            twice[-1] = 1.0
        self.edge = 0.5 * self.least
        bins = max(8, int(16.0 * self.most / self.least))
        width = self.most * 1.001 / bins
        sums: list[Any] = [np.zeros(bins) for _ in range(4)]
        for row in range(qy.size):
            at = np.minimum(q[row] / width, bins).astype(np.intp)
            inside = at < bins
            at = at[inside]
            weight = twice[inside]
            second = 0.5 * (kx[inside] + ky[row])
            fourth = 0.5 * (kx[inside] ** 2 + ky[row] ** 2)
            for total, part in zip(
                sums,
                (weight, weight * q[row][inside], weight * second, weight * fourth),
                strict=True,
            ):
                total += np.bincount(at, part, minlength=bins)
        full = sums[0] > 0.0
        self.count, radial, self.second, self.fourth = (total[full] for total in sums)
        self.q = radial / self.count

    def power(self, q: Floats, low: float, high: float) -> Floats:
        """Return the relative power of waves of wavenumber q, zero outside ``low`` to ``high``."""
        # Ends are smoothed over half a grid step, so that sums vary smoothly with them.
        rise = np.clip((q - low) / self.edge + 0.5, 0.0, 1.0)
        rise *= np.clip((high - q) / self.edge + 0.5, 0.0, 1.0)
        with np.errstate(invalid="ignore"):
            rise *= np.where(np.isfinite(q), (q / self.most) ** self.exponent, 0.0)
        return rise

    def moments(self, low: float, high: float) -> tuple[float, float, float]:
        power = self.power(self.q, low, high)
        return (
            float(power @ self.count),
            float(power @ self.second),
            float(power @ self.fourth),
        )

    def solve(self, m0: float, m2: float, m4: float) -> tuple[float, float]:
        """Return the wavenumbers at the ends of the band that give the ratios of the moments.

        The lower end is solved from m2/m0, with the upper end that m4/m2 requires for it.
        """
        from scipy.optimize import brentq

        target, slope = m4 / m2, m2 / m0
        first_q, last_q = self.least, self.most

        def upper(low: float) -> float:
            def excess(high: float) -> float:
                _, second, fourth = self.moments(low, high)
                return math.log(fourth / second / target)

            start = low + 2.0 * self.edge
            if start >= last_q or excess(start) >= 0.0:
                return start
            if excess(last_q) <= 0.0:
                return last_q
            return float(brentq(excess, start, last_q, rtol=1e-10))

        def off(low: float) -> float:
            first, second, _ = self.moments(low, upper(low))
            return math.log(second / first / slope)

        top = last_q - 3.0 * self.edge
        alpha = m0 / m2 * target
        within = self._ratio(first_q, first_q + 2.0 * self.edge), self._ratio(top, last_q)
        if not within[0] < target < within[1]:
            raise InputError(
                f"m4/m2 = {exact(target)} 1/m^2 cannot be reached on this grid: its waves give "
                f"{within[0]:.3g} to {within[1]:.3g} 1/m^2; use another pixel or more points"
            )
        if self._ratio(first_q, last_q) < target:
            # The band must start at shorter waves even if it extends to the shortest waves.
            first_q = float(brentq(lambda low: self._ratio(low, last_q) - target, first_q, top))
        if off(first_q) > 0.0:
            first, second, fourth = self.moments(first_q, upper(first_q))
            reach = first / second * (fourth / second)
            raise InputError(
                f"Nayak's alpha = m0 m4/m2^2 = {alpha:.4g} cannot be reached on this grid: with "
                f"this m4/m2 and hurst the maximum is {reach:.4g}; use more points, a smaller "
                "pixel or another hurst"
            )
        if off(top) < 0.0:
            raise InputError(
                f"Nayak's alpha = m0 m4/m2^2 must be above 1.5 for an isotropic surface, "
                f"got {alpha:.4g}"
            )
        low = float(brentq(off, first_q, top, rtol=1e-10))
        high = upper(low)
        first, second, fourth = self.moments(low, high)
        if not (
            0.995 < second / first / slope < 1.005 and 0.995 < fourth / second / target < 1.005
        ):
            raise InputError(
                f"Nayak's alpha = m0 m4/m2^2 = {alpha:.4g} is below 1.5, impossible for an "
                "isotropic surface, or too close to 1.5 for the waves of this grid"
            )
        return low, high

    def _ratio(self, low: float, high: float) -> float:
        _, second, fourth = self.moments(low, high)
        return fourth / second


def _shape(shape: Any) -> tuple[int, int]:
    good = (
        isinstance(shape, (tuple, list))
        and len(shape) == 2
        and all(isinstance(n, (int, np.integer)) and not isinstance(n, bool) for n in shape)
        and min(shape) >= 16
        and shape[0] * shape[1] <= _LARGEST
    )
    if not good:
        raise InputError(
            f"`shape` must be (rows, columns), each 16 or more and not above {_LARGEST} "
            f"points in all, got {show(shape)}"
        )
    return int(shape[0]), int(shape[1])


def _pair(pixel: Any) -> tuple[float, float]:
    steps = pixel_of(pixel, 2)
    return steps[0], steps[1]
