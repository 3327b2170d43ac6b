"""Inputs, reported numbers and cached solutions of a measured face."""

from __future__ import annotations

import dataclasses
import math
import os
import warnings
from collections import OrderedDict
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, floats, positive, show
from microslip._core.errors import InputError
from microslip._core.files import atomic_file, reason
from microslip._core.frozen import lock
from microslip._core.wording import shorten
from microslip.contact.base import LARGEST_PRESSURE
from microslip.contact.face_solution import (
    NEAR_REST,
    FaceSolution,
    OnPiece,
    cycle_energies,
    solve_face,
    stiffness_scatter,
)

_USUAL = 0.05  # of E* h': the heaviest pressure of an elastic face where none is given
_SLOPES = (1e-6, 3.0)  # rms slopes that faces have
ENERGY_AMPLITUDES = (0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)
"""Amplitudes over mu N/k_t at which the effect of the pixel on the energy is reported."""
_UNRESOLVED = 1.25  # factor of the energy for twice the pixel
_REMEMBERED = 16  # solutions of this process
_remembered: OrderedDict[str, FaceSolution] = OrderedDict()


class Face(NamedTuple):
    """Heights of a face above its mean plane [m], and the distances of its points [m]."""

    heights: Floats
    pixel: tuple[float, float]
    """Pixel along x and y [m]."""

    @property
    def area(self) -> float:
        """Area of all points [m^2]."""
        return self.heights.size * self.pixel[0] * self.pixel[1]

    @property
    def rms(self) -> float:
        """Rms height [m]."""
        return float(self.heights.std())

    @property
    def slope(self) -> float:
        """Rms gradient h' from differences between neighbouring points [-]."""
        squares = (
            float(np.mean(np.diff(self.heights, axis=axis) ** 2)) / step**2
            for axis, step in ((1, self.pixel[0]), (0, self.pixel[1]))
        )
        return math.sqrt(math.fsum(squares))

    @property
    def coarser(self) -> Face:
        """Face with only every second point along x and y."""
        dx, dy = self.pixel
        heights = self.heights[::2, ::2]
        return Face(lock(heights - heights.mean()), (2.0 * dx, 2.0 * dy))

    @property
    def smoother(self) -> tuple[Face, float]:
        """Face without the shortest waves, and the wavelength below which they are removed [m].

        The removed waves contribute half of the mean square slope. Waves are cosines, as in the
        solution by boundary elements.
        """
        from scipy import fft

        waves = np.asarray(fft.dctn(self.heights, norm="ortho"))
        qy, qx = (
            np.pi * np.arange(n) / (n * step)
            for n, step in zip(self.heights.shape, self.pixel[::-1], strict=True)
        )
        q = np.hypot(qy[:, None], qx)
        order = np.argsort(q, axis=None)
        squares = np.cumsum(((q * waves) ** 2).ravel()[order])
        edge = float(q.ravel()[order][int(np.searchsorted(squares, 0.5 * squares[-1]))])
        heights = np.asarray(fft.idctn(np.where(q <= edge, waves, 0.0), norm="ortho"))
        return Face(lock(heights), self.pixel), 2.0 * math.pi / edge

    def pieces(self, points: int | None) -> list[Floats]:
        """Divide the face into equal parts, not levelled, with about ``points`` points per side."""
        parts = [1 if points is None else max(round(n / points), 1) for n in self.heights.shape]
        rows, columns = (n // k for n, k in zip(self.heights.shape, parts, strict=True))
        return [
            self.heights[i * rows : (i + 1) * rows, j * columns : (j + 1) * columns]
            for i in range(parts[0])
            for j in range(parts[1])
        ]


def face_of(heights: Any, pixel: Any) -> Face:
    """Return the face of a scan, or of heights on a grid, without its least-squares plane.

    Any object with attributes `heights` and `pixel` is accepted as a scan.
    """
    if hasattr(heights, "heights") and hasattr(heights, "pixel"):
        if pixel is not None:
            raise InputError("`pixel` must be omitted for a scan, which has its own")
        pixel, heights = heights.pixel, heights.heights
    z = floats("heights", heights, "m", missing=True)
    if z.ndim != 2:
        raise InputError(
            f"`heights` must be an area, two-dimensional, got shape {z.shape}; contacts of a "
            "profile cannot be solved point by point"
        )
    if min(z.shape) < 16:
        raise InputError(
            f"`heights` must have at least 16 points along each side, got shape {z.shape}"
        )
    holes = int(np.count_nonzero(np.isnan(z)))
    if holes:
        raise InputError(
            f"`heights` must have no missing points, got {holes} of {z.size}; fill them "
            'before: scan.condition(fill="interpolate")'
        )
    if pixel is None:
        raise InputError("`pixel` [m] must be given with heights; write `pixel=2e-06`")
    steps = pixel if isinstance(pixel, (tuple, list)) else (pixel, pixel)
    if len(steps) != 2:
        raise InputError(f"`pixel` must be one length or two, along x and y, got {show(pixel)}")
    dx, dy = (positive("pixel", step, "m", 2e-6) for step in steps)
    face = Face(_levelled(z), (dx, dy))
    low, high = _SLOPES
    if not low <= face.slope <= high:
        raise InputError(
            f"`heights` and `pixel` must be in metres: the rms slope would be {face.slope:.3g}, "
            f"wanted {low:g} to {high:g}"
        )
    return face


def _levelled(z: Floats) -> Floats:
    y, x = (np.arange(n) - 0.5 * (n - 1) for n in z.shape)
    tilt_x = float(z.mean(axis=0) @ x) / float(x @ x)
    tilt_y = float(z.mean(axis=1) @ y) / float(y @ y)
    return lock(z - z.mean() - tilt_x * x - tilt_y * y[:, None])


def check_pressure(pressure: float | None, hardness: float, modulus: float, face: Face) -> float:
    """Return the checked tightening pressure [Pa]; by default 0.05 E* times the rms gradient."""
    if pressure is None:
        return _USUAL * modulus * face.slope
    pressure = positive("tightening_pressure", pressure, "Pa", 1e8)
    if pressure > LARGEST_PRESSURE * hardness:
        raise InputError(
            f"`tightening_pressure` must be at most {LARGEST_PRESSURE:g} of the hardness "
            f"{hardness:.4g} Pa, beyond which the whole face yields, got {pressure:.4g} Pa"
        )
    return pressure


@dataclasses.dataclass(frozen=True)
class ContactNumbers:
    """Inputs of the solution of a measured face, and its results at the tightening pressure."""

    pressure: float
    """Tightening pressure, or the largest pressure of an elastic face [Pa]."""
    hardness: float | None
    """Hardness, the largest local pressure [Pa]; None for an elastic face."""
    pixel: tuple[float, float]
    """Distance between neighbouring points along x and y [m]."""
    rms: float
    """Rms height of the face about its plane [m]."""
    slope: float
    """Rms gradient h' between neighbouring points [-], which depends on the pixel."""
    relative_pressure: float
    """Pressure over E* h' [-]."""
    contact_share: float
    """Fraction of the points in contact [-]."""
    hard_share: float
    """Fraction of the contact at the hardness after tightening [-]."""
    points: int
    """Number of points in contact."""
    pieces: int
    """Number of solved pieces."""
    scatter: float | None
    """Standard deviation of ln(stiffness) between pieces [-]; None for one piece."""
    between_pieces: float
    """Fraction of the height variance between the means of the pieces [-]."""
    stiffness_ratios: tuple[float, float]
    """Smallest and largest ratio of normal to tangential stiffness over all directions [-]."""
    stiffest_direction: float
    """Direction of the largest tangential stiffness, from x of the scan [rad]."""
    coarser: float | None
    """Stiffness for twice the pixel, relative to that for the pixel [-]; None if not solved."""
    smoother: float | None = None
    """Stiffness without the short waves, relative to that with them [-]; None if not solved."""
    cutoff: float | None = None
    """Cut-off [m] for ``smoother``: waves below it carry half of the squared slope."""
    coarser_energies: tuple[float, ...] | None = None
    """Energies of cycles for twice the pixel, relative to those for the pixel [-], at the
    amplitudes ENERGY_AMPLITUDES; None if not solved."""

    @property
    def unresolved_amplitude(self) -> float | None:
        """Largest amplitude over mu N/k_t where doubling the pixel changes the energy by 25 %."""
        ratios = self.coarser_energies or ()
        changed = [
            a
            for a, ratio in zip(ENERGY_AMPLITUDES, ratios, strict=False)
            if not 1.0 / _UNRESOLVED < ratio < _UNRESOLVED
        ]
        return max(changed, default=None)


class Task(NamedTuple):
    """Inputs that determine the solution of a face."""

    face: Face
    pressure: float  # over E*
    hardness: float  # over E*
    stiffness_ratio: float
    piece: int | None
    loads: int
    lightest: float

    @property
    def key(self) -> str:
        """Hash of the inputs, used as the name of the solution."""
        z = np.ascontiguousarray(self.face.heights)
        words = repr((z.shape, self.face.pixel, *self[1:], NEAR_REST, "lighter tightenings"))
        return sha256(z.tobytes() + words.encode()).hexdigest()[:32]

    def solved(self, progress: OnPiece | None) -> FaceSolution:
        """Return separations, pressures and slopes on unloading; recent solutions are cached."""
        key = self.key
        known = _remembered.get(key)
        if known is not None:
            _remembered.move_to_end(key)
            return known
        dx, dy = self.face.pixel
        solution = solve_face(
            [np.asarray(piece / dx) for piece in self.face.pieces(self.piece)],
            pressure=self.pressure,
            hardness=self.hardness,
            stiffness_ratio=self.stiffness_ratio,
            aspect=dy / dx,
            loads=self.loads,
            lightest=self.lightest,
            progress=progress,
        )
        remember(key, solution)
        return solution


def remember(key: str, solution: FaceSolution) -> None:
    """Add a solution to the cache under its key, and remove the oldest ones."""
    _remembered[key] = solution
    while len(_remembered) > _REMEMBERED:
        _remembered.popitem(last=False)


def contact_numbers(
    task: Task, solution: FaceSolution, pressure: float, bound: float
) -> ContactNumbers:
    """Return the reported numbers; tightening ``pressure`` and hardness ``bound`` are in Pa."""
    face = task.face
    pieces = face.pieces(task.piece)
    spread = float(np.var([piece.mean() for piece in pieces])) / face.rms**2
    shares, directions = np.linalg.eigh(solution.sliding)
    stiffest = directions[:, 1]
    return ContactNumbers(
        pressure=pressure,
        hardness=None if math.isinf(bound) else bound,
        pixel=face.pixel,
        rms=face.rms,
        slope=face.slope,
        relative_pressure=task.pressure / face.slope,
        contact_share=float(solution.contact[0]),
        hard_share=solution.hard,
        points=solution.pixels,
        pieces=len(pieces),
        scatter=stiffness_scatter(solution),
        between_pieces=spread,
        stiffness_ratios=(1.0 / float(shares[1]), 1.0 / float(shares[0])),
        stiffest_direction=math.atan2(stiffest[1], stiffest[0]) % math.pi,
        coarser=None,
    )


def progress_halves(
    progress: OnPiece | None,
) -> tuple[OnPiece | None, OnPiece | None]:
    """Return one progress callback for the first half of the work and one for the second."""
    if progress is None:
        return None, None
    return (
        lambda done, total: progress(done, 2 * total),
        lambda done, total: progress(total + done, 2 * total),
    )


def resolution_changes(
    task: Task, solution: FaceSolution, progress: OnPiece | None
) -> dict[str, Any]:
    """Return the last fields of :class:`ContactNumbers` from ``coarser`` on, by name.

    The first two are the stiffness with every second point along x and y, and without the shortest
    waves, over that of ``solution``; None if such a face cannot carry the pressure. ``cutoff`` is
    the shortest wavelength of the smoothed face [m].
    """
    smooth, cutoff = task.face.smoother
    half = None if task.piece is None else max(task.piece // 2, 8)
    changes: dict[str, Any] = {"cutoff": cutoff}
    for name, face, piece in (
        ("coarser", task.face.coarser, half),
        ("smoother", smooth, task.piece),
    ):
        scale = task.face.pixel[0] / face.pixel[0]  # slopes are pressures over E* a pixel
        try:
            last = progress if name == "smoother" else None  # the other has a quarter of the points
            other = task._replace(face=face, piece=piece).solved(last)
        except InputError:
            changes[name] = None
        else:
            slopes = (float(found.slope[0].mean()) for found in (other, solution))
            changes[name] = scale * next(slopes) / next(slopes)
            if name == "coarser":
                unit = float(solution.pressure[0].mean() / solution.slope[0].mean())
                amplitudes = unit * np.array(ENERGY_AMPLITUDES)
                ratios = cycle_energies(other, amplitudes * scale) / scale
                ratios /= cycle_energies(solution, amplitudes)
                changes["coarser_energies"] = tuple(ratios.tolist())
    return changes


def cached(task: Task, folder: str | os.PathLike[str], progress: OnPiece | None) -> FaceSolution:
    """Return a solution from the cache folder, or solve and store it; replace a damaged file."""
    path = Path(folder) / f"{task.key}.npz"
    names = [item.name for item in dataclasses.fields(FaceSolution)]
    if path.exists():
        try:
            with path.open("rb") as raw, np.load(raw, allow_pickle=False) as file:
                values = {name: np.asarray(file[name], dtype=float) for name in names}
            numbers: Any = {"hard": float(values["hard"]), "pixels": int(values["pixels"])}
            solution = FaceSolution(**{**values, **numbers})
        except Exception as error:  # damaged archives break in many ways
            words = f"{path}: holds no solution of a face: {shorten(reason(error), 160)}"
            warnings.warn(f"{words}; the face is solved again", stacklevel=3)
        else:
            remember(task.key, solution)
            return solution
    solution = task.solved(progress)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path.parent}: cannot be made: {reason(error)}") from None
    arrays = {name: getattr(solution, name) for name in names}
    arrays["map"] = solution.map.astype(np.float32)
    arrays["reach"] = solution.reach.astype(np.uint8)
    with atomic_file(path, overwrite=True) as stage, stage.open("wb") as file:
        np.savez_compressed(file, **arrays)
    return solution
