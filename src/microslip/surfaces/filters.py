"""Filters of areas and profiles with gaps and edges.

Gaussian filters (ISO 16610-61 and -21), robust regression and splines (ISO 16610-31, -71, -22 and
-62).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft, sparse
from scipy.interpolate import RectBivariateSpline
from scipy.linalg import solveh_banded

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import lock

REACH = 1.0
"""Half-width of the weights in cut-offs, beyond which they are below 1e-6 of the central weight."""

_LONG_KERNEL = 33  # taps from which the Fourier transform is faster
_BLOCK = 1 << 20  # numbers transformed at a time, to limit memory


def transmission(wavelength: Floats | float, cutoff: float) -> Floats:
    """Return the amplitude transmission of the Gaussian short-wave filter [-].

    2^-(cutoff/wavelength)^2, one half at the cut-off (ISO 16610-21:2011, section 4.3; ISO
    16610-61:2015). The long-wave filter, which removes longer waves, transmits one minus this
    value.
    """
    return np.asarray(np.exp2(-((cutoff / np.asarray(wavelength, dtype=float)) ** 2)))


@lru_cache(maxsize=64)
def weights(cutoff: float) -> Floats:
    """Return the weights of the Gaussian filter with a cut-off [pixels], along one axis.

    The weights are symmetric, positive and have the sum one. The sampled Gaussian exp(-pi (x/(alpha
    cutoff))^2), alpha^2 = ln 2/pi, transmits too much for a cut-off of few pixels: 56 % in place of
    50 % at three. Its width is therefore chosen to transmit exactly half at the cut-off. The
    largest deviation from :func:`transmission`, for waves of two pixels, is 0.06 for a cut-off of
    four pixels, 0.013 for five, 0.002 for six and below 1e-6 from nine on.
    """
    reach = max(2, math.ceil(REACH * cutoff))
    place = np.arange(1, reach + 1, dtype=float)
    wave = np.cos(2.0 * math.pi / cutoff * place)
    square = place * place

    def excess(decay: float) -> float:
        side = np.exp(-decay * square)
        return float((1.0 + 2.0 * (side @ wave)) / (1.0 + 2.0 * side.sum())) - 0.5

    guess = math.pi**2 / (math.log(2.0) * cutoff**2)
    if abs(excess(guess)) > 1e-12:
        from scipy.optimize import brentq

        guess = float(brentq(excess, 0.5 * guess, 4.0 * guess, xtol=1e-15, rtol=1e-14))
    side = np.exp(-guess * square)
    kernel = np.concatenate([side[::-1], [1.0], side])
    return lock(kernel / kernel.sum())


def smooth(heights: Floats, pixel: tuple[float, ...], cutoff: float) -> Floats:
    """Return the heights after the Gaussian short-wave filter.

    They are weighted means over the points that are present; ``pixel`` and ``cutoff`` in metres.
    """
    kernels = [weights(cutoff / step) for step in pixel[::-1]]
    gaps = np.isnan(heights)
    if not gaps.any():
        result = _convolve(heights, kernels)
        # Without gaps the sum of the weights is a product of one factor per axis.
        for axis, kernel in enumerate(kernels):
            shares = _convolve(np.ones(heights.shape[axis]), [kernel])
            result /= np.expand_dims(shares, [a for a in range(heights.ndim) if a != axis])
        return result
    result = np.where(gaps, 0.0, heights)
    result = _convolve(result, kernels)
    present = np.subtract(1.0, gaps)
    shares = _convolve(present, kernels)
    del present
    # Far from any point the sum of weights is zero or rounding; gaps are not needed.
    shares[gaps] = np.nan
    result /= shares
    return result


def _convolve(values: Floats, kernels: list[NDArray[np.float64]]) -> Floats:
    """Convolve with one kernel per axis and zeros outside; returns a new array."""
    result = values
    for axis, kernel in enumerate(kernels):
        result = _along(result, kernel, axis)
    return result


def _along(values: Floats, kernel: Floats, axis: int) -> Floats:
    if kernel.size < _LONG_KERNEL:
        from scipy.ndimage import correlate1d

        return np.asarray(correlate1d(values, kernel, axis=axis, mode="constant", cval=0.0))
    from scipy import fft

    count = values.shape[axis]
    # Weights beyond the length of the scan never meet a point.
    reach = min(kernel.size // 2, count - 1)
    kernel = kernel[kernel.size // 2 - reach : kernel.size // 2 + reach + 1]
    length = fft.next_fast_len(count + reach, real=True)
    # Symmetric about index 0, so that its transform is real.
    ring = np.zeros(length)
    ring[: reach + 1] = kernel[reach:]
    ring[length - reach :] = kernel[:reach]
    transfer = fft.rfft(ring).real
    result = np.empty_like(values, order="C")
    lines, target = np.moveaxis(values, axis, -1), np.moveaxis(result, axis, -1)
    if values.ndim == 1:
        lines, target = lines[None], target[None]
    block = max(1, _BLOCK // length)
    for first in range(0, lines.shape[0], block):
        part = np.ascontiguousarray(lines[first : first + block])
        spectrum = fft.rfft(part, length, axis=-1)
        spectrum *= transfer
        target[first : first + block] = fft.irfft(spectrum, length, axis=-1)[..., :count]
    return result


_WIDTH = 0.7309134280946760
"""Width of the weights exp(-pi (x/(w cutoff))^2) of a second-order regression that transmits half
at the cut-off: (1 + t) exp(-t) = 1/2, t = pi^2 w^2 (ISO 16610-31:2016)."""
_REACH = 2.0 * _WIDTH
"""Half-width of the weights in cut-offs; the weight at the edge is 4e-6."""
_NODES = 16
"""Nodes of the mean surface per cut-off; cubic splines between them are exact to 1e-4."""
_BIWEIGHT = 4.4478
"""Residual over the median absolute residual at which the weight becomes zero: three standard
deviations of a Gaussian (ISO 16610-31:2016)."""
_SETTLED = 1e-3
_TURNS = 30
"""Relative change of the median residual at convergence, and largest number of iterations."""
_RESIDUAL = 1e-8
_STEPS = 1000
"""Relative residual at which the conjugate gradients end, and their largest number."""


def robust_mean(heights: Floats, pixel: tuple[float, ...], cutoff: float) -> Floats:
    """Return the mean surface by robust Gaussian regression of second order.

    Local parabolas or paraboloids are fitted by weighted least squares with Tukey's biweight, which
    makes them insensitive to scratches and pits, until the median residual converges. ISO
    16610-31:2016 for profiles and ISO 16610-71:2014 for areas; forms up to second order pass
    unchanged, up to the ends.
    """
    grid = np.atleast_2d(heights)
    steps = (pixel[0], pixel[-1])
    there = ~np.isnan(grid)
    values = np.where(there, grid, 0.0)
    regression = _Regression(grid.shape, steps, cutoff)
    nothing = 1e-9 * float(values.max() - values.min())
    mean = regression(values, there.astype(float))
    scale = math.inf
    for _ in range(_TURNS):
        residuals = np.abs(values - mean)
        last, scale = scale, _BIWEIGHT * float(np.median(residuals[there]))
        # Residuals at rounding level give no scale for the weights.
        if scale <= nothing or abs(scale - last) <= _SETTLED * scale:
            break
        share = np.minimum(residuals / scale, 1.0)
        mean = regression(values, np.where(there, (1.0 - share * share) ** 2, 0.0))
    return mean.reshape(heights.shape)


def _around(nodes: Floats, places: Floats, powers: int) -> list[sparse.csr_array]:
    """Return sparse matrices of Gaussian weights times x^0, x^1, ..., shape (nodes, points).

    x is the distance of a point from a node, over the cut-off.
    """
    first = np.searchsorted(places, nodes - _REACH)
    count = np.searchsorted(places, nodes + _REACH, side="right") - first
    index = first[:, None] + np.arange(count.max())
    inside = np.arange(count.max()) < count[:, None]
    away = (places[np.minimum(index, places.size - 1)] - nodes[:, None])[inside]
    kernel = np.exp(-math.pi * (away / _WIDTH) ** 2)
    ends, shape = np.append(0, np.cumsum(count)), (nodes.size, places.size)
    return [
        sparse.csr_array((kernel * away**power, index[inside], ends), shape)
        for power in range(powers)
    ]


class _Regression:
    """Local regressions of second order at the nodes of a grid, interpolated by cubic splines."""

    def __init__(self, shape: tuple[int, ...], pixel: tuple[float, float], cutoff: float) -> None:
        self.is_profile = shape[0] == 1
        self.places: list[Floats] = []
        self.nodes: list[Floats] = []
        self.sums: list[list[sparse.csr_array]] = []
        for count, step in zip(shape[::-1], pixel, strict=True):
            places: Floats = np.arange(count, dtype=float) * (step / cutoff)
            parts = max(4, math.ceil(_NODES * float(places[-1]))) if count > 1 else 1
            # At most as many nodes as points, including both ends.
            nodes = places if parts >= count else np.linspace(0.0, float(places[-1]), parts)
            self.sums.append(_around(nodes, places, 5 if count > 1 else 1))
            self.places.append(places)
            self.nodes.append(nodes)
        terms = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)]
        self.terms = terms[:3] if self.is_profile else terms

    def __call__(self, values: Floats, weights: Floats) -> Floats:
        """Return the mean surface at all points."""
        weighted = weights * values
        sums = {
            (i, j): self._sum(weights, i, j)
            for i, j in {(a[0] + b[0], a[1] + b[1]) for a in self.terms for b in self.terms}
        }
        matrix = np.stack(
            [
                np.stack([sums[a[0] + b[0], a[1] + b[1]] for b in self.terms], axis=-1)
                for a in self.terms
            ],
            axis=-2,
        )
        right = np.stack([self._sum(weighted, *term) for term in self.terms], axis=-1)
        # Tikhonov term: singular systems get the smallest solution.
        size = len(self.terms)
        trace = np.trace(matrix, axis1=-2, axis2=-1)[..., None, None] + 1e-300
        middle = np.linalg.solve(matrix + 1e-12 * trace * np.eye(size), right[..., None])[..., 0, 0]
        return self._between(middle)

    def _sum(self, values: Floats, i: int, j: int) -> Floats:
        """Return the weighted sum of ``values`` x^i y^j for each node.

        x and y are distances from the node over the cut-off; the weights are Gaussian.
        """
        along_x, along_y = self.sums[0][i], self.sums[1][j]
        return np.asarray((along_x @ (along_y @ values).T).T)

    def _between(self, middle: Floats) -> Floats:
        x, y = self.nodes
        if self.is_profile:
            from scipy.interpolate import make_interp_spline

            if x.size == self.places[0].size:
                return middle
            return np.asarray(make_interp_spline(x, middle[0])(self.places[0]))[None]
        if (y.size, x.size) == (self.places[1].size, self.places[0].size):
            return middle
        degrees = {"kx": min(3, y.size - 1), "ky": min(3, x.size - 1)}
        spline = RectBivariateSpline(y, x, middle, **degrees)
        return np.asarray(spline(self.places[1], self.places[0]))


def spline_mean(heights: Floats, pixel: tuple[float, ...], cutoff: float) -> Floats:
    """Return the smoothing cubic spline with free ends through the points that are present.

    It minimises the sum of squared residuals and alpha^4 times the bending, alpha = 1/(2 sin(pi
    pixel/cutoff)), which transmits half at the cut-off: ISO 16610-22:2015 with tension 0. For areas
    the bending energy is that of an isotropic plate (ISO 16610-62). Planes pass unchanged,
    including their ends.
    """
    there = ~np.isnan(heights)
    values, weights = np.where(there, heights, 0.0), there.astype(float)
    alphas = [1.0 / (2.0 * math.sin(math.pi * step / cutoff)) for step in pixel]
    if heights.ndim == 1:
        return _spline_profile(values, weights, alphas[0])
    return _spline_area(values, weights, *alphas)


def _spline_profile(values: Floats, weights: Floats, alpha: float) -> Floats:
    """Solve (W + alpha^4 D^T D) z = W values, with weights W and second differences D."""
    count = values.size
    band = np.zeros((3, count))
    second = (1.0, -2.0, 1.0)
    for first in range(3):
        for other in range(first, 3):
            row = 2 - (other - first)
            band[row, other : count - 2 + other] += second[first] * second[other]
    band *= alpha**4
    band[2] += weights
    return np.asarray(solveh_banded(band, weights * values))


def _spline_area(values: Floats, weights: Floats, along_x: float, along_y: float) -> Floats:
    """Solve (W + K) z = W values, with weights W and the bending stiffness K of a plate.

    The plate is isotropic with free edges; ``along_x`` and ``along_y`` are alpha of both axes, the
    constant of the spline filter (ISO 16610-22); K is proportional to alpha^4. The
    conjugate gradients are preconditioned by a plate with guided edges, which a cosine transform
    solves.
    """
    rows, columns = values.shape
    x2, y2 = along_x**2, along_y**2
    waves = [2.0 - 2.0 * np.cos(math.pi * np.arange(n) / n) for n in (columns, rows)]
    share = float(weights.mean())
    plate = share + (x2 * waves[0] + y2 * waves[1][:, None]) ** 2

    def guided(right: Floats) -> Floats:
        return np.asarray(fft.idctn(fft.dctn(right, norm="ortho") / plate, norm="ortho"))

    def forces(shape: Floats) -> Floats:
        result = weights * shape
        for axis, stiff in ((1, x2 * x2), (0, y2 * y2)):
            bend = stiff * np.diff(shape, 2, axis=axis)
            ends = [(0, 0), (0, 0)]
            ends[axis] = (2, 2)
            result += np.diff(np.pad(bend, ends), 2, axis=axis)
        twist = 2.0 * x2 * y2 * np.diff(np.diff(shape, axis=0), axis=1)
        return np.asarray(result + np.diff(np.diff(np.pad(twist, 1), axis=0), axis=1))

    right = weights * values
    shape = guided(right)
    residual = right - forces(shape)
    target = _RESIDUAL * float(np.linalg.norm(right))
    direction, before = np.zeros_like(shape), 1.0
    for _ in range(_STEPS):
        if float(np.linalg.norm(residual)) <= target:
            break
        better = guided(residual)
        power = float((residual * better).sum())
        direction = better + (power / before) * direction
        force = forces(direction)
        step = power / float((direction * force).sum())
        shape = shape + step * direction
        residual = residual - step * force
        before = power
    else:
        raise InputError('`filter="spline"` did not converge on this scan; use filter="robust"')
    return shape
