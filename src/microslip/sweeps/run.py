"""The sweep: request, computation and labels."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import LARGEST, Floats, check_one_of, exact, floats, positives, show
from microslip._core.netcdf import Variable
from microslip._core.quantities import QUANTITIES, Quantity
from microslip._version import __version__
from microslip.errors import InputError
from microslip.friction import BackboneLaw, Interface
from microslip.normal.grids import inverse_on_grid, on_grid, separations
from microslip.sweeps.arguments import check_names
from microslip.sweeps.arrays import Sweep

_GRID = ("friction_coefficient", "normal_load", "amplitude")
_OF_CYCLES = (
    "dissipated_energy",
    "energy_ratio",
    "loss_factor",
    "damping_ratio",
    "secant_stiffness",
    "tangent_stiffness",
    "dissipation_exponent",
)
_OF_LOADS = (
    "separation",
    "normal_stiffness",
    "tangential_stiffness",
    "contact_count",
    "contact_area",
)
DIMENSIONS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("amplitude", "force_amplitude", *_OF_CYCLES, "stick_area"), _GRID),
    **dict.fromkeys(_OF_LOADS, _GRID[1:2]),
    "force_limit": _GRID[:2],
    "slip_per_indentation": _GRID[:1],
}
"""Arguments on which each quantity depends."""

_MEANINGS = {**QUANTITIES, "friction_coefficient": Quantity("-", "coefficient of friction")}
_DEFAULT_QUANTITIES = ("dissipated_energy", "loss_factor", "damping_ratio", "secant_stiffness")


def sweep(
    joint: BackboneLaw,
    *,
    normal_load: ArrayLike | None = None,
    amplitude: ArrayLike | None = None,
    force_amplitude: ArrayLike | None = None,
    friction_coefficient: ArrayLike | None = None,
    quantities: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """One joint at many loads, amplitudes and coefficients of friction, as labelled arrays.

    Parameters
    ----------
    joint : BackboneLaw
        An :class:`microslip.Interface`; any other law has amplitudes only.
    normal_load : array_like, optional
        Normal loads [N], above zero, one-dimensional; without them that of the joint.
    amplitude : array_like, optional
        Displacement amplitudes [m], not negative, one-dimensional.
    force_amplitude : array_like, optional
        Force amplitudes [N] instead, below the force limit at every load.
    friction_coefficient : array_like, optional
        Coefficients of friction [-], above zero, one-dimensional; without them that of the joint.
    quantities : sequence of str, optional
        Quantities wanted, by their names on an interface: force_amplitude (or amplitude),
        dissipated_energy, energy_ratio, loss_factor, damping_ratio, secant_stiffness,
        tangent_stiffness, dissipation_exponent, stick_area; and, without amplitudes, separation,
        normal_stiffness, tangential_stiffness, contact_count, contact_area, force_limit,
        slip_per_indentation. Without it the other amplitude, dissipated_energy, loss_factor,
        damping_ratio and secant_stiffness.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.

    Returns
    -------
    Sweep
        Each list is a dimension, in the order friction_coefficient, normal_load, amplitude; a
        number, or what was not given, is a coordinate without one.

    Notes
    -----
    The same numbers as of one interface after the other, to rounding (1e-13), but not one after
    the other: separations are found together, and (19.29) is integrated for many loads at once, or
    tabulated along whichever of loads and amplitudes there is more of.
    """
    if not isinstance(joint, BackboneLaw):
        raise InputError(
            f"`joint` must be an Interface or another backbone law, got {show(joint)}; write "
            "sweep(joint, normal_load=[...], amplitude=[...])"
        )
    wording = "amplitude=[...] [m] or force_amplitude=[...] [N]"
    check_one_of(wording, amplitude, force_amplitude)
    name, values_along = "amplitude", amplitude
    if values_along is None:
        name, values_along = "force_amplitude", force_amplitude
    along = _axis(name, values_along)
    if along.min() < 0.0:
        raise InputError(f"`{name}` must not be negative, got {along.min():g}")
    if name == "amplitude" and along.max() > LARGEST:
        raise InputError(f"`{name}` must be at most {LARGEST:g} m, got {along.max():g} m")
    names = _quantity_names(quantities, name)
    if progress is not None and not callable(progress):
        raise InputError(f"`progress` must be a function of the share done, got {show(progress)}")
    axes = {name: np.abs(along)}  # -0.0 is 0.0 here
    if not isinstance(joint, Interface):
        for key, value in (
            ("friction_coefficient", friction_coefficient),
            ("normal_load", normal_load),
        ):
            if value is not None:
                raise InputError(
                    f"{key} has no meaning for {type(joint).__name__}, "
                    "only an Interface has one; sweep its amplitudes alone"
                )
        values = _of_law(joint, axes, names)
        if progress is not None:
            progress(1.0)
        return _labelled(joint, axes, values, name)
    friction = joint.friction_coefficient if friction_coefficient is None else friction_coefficient
    load = joint.normal_load if normal_load is None else normal_load
    axes = {
        "friction_coefficient": _positive_axis("friction_coefficient", friction, ""),
        "normal_load": _positive_axis("normal_load", load, "N"),
        **axes,
    }
    return _labelled(joint, axes, Grid(joint, axes, name, progress).values(names), name)


def _axis(name: str, value: Any) -> Floats:
    array = floats(name, value)
    if array.ndim > 1:
        raise InputError(f"`{name}` must be a number or one-dimensional, got shape {array.shape}")
    return array.copy()


def _positive_axis(name: str, value: Any, unit: str) -> Floats:
    return positives(name, _axis(name, value), unit)


def _quantity_names(quantities: Any, name: str) -> tuple[str, ...]:
    converse = "force_amplitude" if name == "amplitude" else "amplitude"
    if quantities is None:
        return (converse, *_DEFAULT_QUANTITIES)
    available = [quantity for quantity in DIMENSIONS if quantity != name]
    if isinstance(quantities, (list, tuple)) and name in quantities:
        raise InputError(f"`quantities` must not name {name}: it is a coordinate already")
    check_names(quantities, available, "dissipated_energy")
    if len(set(quantities)) < len(quantities):
        twice = next(q for q in quantities if list(quantities).count(q) > 1)
        raise InputError(f"`quantities` must name each once, got {twice} twice")
    return tuple(quantities)


def _labelled(
    joint: BackboneLaw, axes: Mapping[str, Floats], values: Mapping[str, Floats], along: str
) -> Sweep:
    coords = {}
    for name, axis in axes.items():
        dims: tuple[str, ...] = (name,) if axis.ndim else ()
        coords[name] = Variable(dims, axis, _MEANINGS[name].attributes)
    variables = {}
    for name, array in values.items():
        over = [along if dim == "amplitude" else dim for dim in DIMENSIONS[name]]
        dims = tuple(dim for dim in over if dim in axes and axes[dim].ndim)
        # Of an axis that was one number there is no dimension.
        shape = tuple(axes[dim].size for dim in dims)
        variables[name] = Variable(
            dims, np.ascontiguousarray(array).reshape(shape), _MEANINGS[name].attributes
        )
    about = {
        "Conventions": "CF-1.11",
        "title": "Sweep of a joint",
        "source": f"microslip {__version__}",
        "joint": repr(joint),
    }
    return Sweep(coords, variables, about)


def _of_law(
    joint: BackboneLaw, axes: Mapping[str, Floats], names: Sequence[str]
) -> dict[str, Floats]:
    """Results of a law without a load at its amplitudes."""
    amplitudes = {name: axis.reshape(-1) for name, axis in axes.items()}
    a = joint._amplitudes(amplitudes.get("amplitude"), amplitudes.get("force_amplitude"))
    calls: dict[str, Callable[[], Any]] = {
        "amplitude": lambda: a,
        "force_amplitude": lambda: joint.backbone(a),
        "force_limit": lambda: joint.force_limit,
        "tangential_stiffness": lambda: joint.tangential_stiffness,
    }
    for name in _OF_CYCLES:
        method = "backbone_stiffness" if name == "tangent_stiffness" else name
        calls[name] = partial(getattr(joint, method), a)
    for name in names:
        if name not in calls:
            raise InputError(
                f"`quantities` must be what {type(joint).__name__} knows, which has no {name}"
            )
    return {name: np.asarray(calls[name](), dtype=float) for name in names}


Progress = Callable[[float], None]


class Grid:
    """An interface on the grid of coefficients, loads and amplitudes (i, j, k)."""

    def __init__(
        self, joint: Interface, axes: Mapping[str, Floats], name: str, progress: Progress | None
    ) -> None:
        self.surface = joint.surface
        self.friction = axes["friction_coefficient"].reshape(-1)
        self.load = axes["normal_load"].reshape(-1)
        self.given = axes[name].reshape(-1)
        self.by_force = name == "force_amplitude"
        if np.all(self.load == joint.normal_load):
            # Of a joint that was given by its separation that very one.
            self.separation = np.full(self.load.size, joint.separation)
        else:
            self.separation = separations(self.surface, self.load)
        self.kappa = self.friction * self.surface.stiffness_ratio
        self.limit = self.friction[:, None] * self.load
        # As in an interface: with it the limit is met exactly.
        self.factor = self.limit / self.surface._derivative(self.separation, 0)
        self.done = 0
        self.passes = 1
        self.progress = progress

    def values(self, names: Sequence[str]) -> dict[str, Floats]:
        """The quantities of these names."""
        needed = set(names)
        ratios = needed & {"energy_ratio", "loss_factor", "damping_ratio"}
        backbone = bool(ratios or needed & {"force_amplitude", "secant_stiffness"})
        energy = bool(ratios or needed & {"dissipated_energy", "dissipation_exponent"})
        self.passes = (
            self.by_force
            + (backbone and not self.by_force)
            + energy
            + len(needed & {"dissipation_exponent", "tangent_stiffness"})
        ) or 1
        if self.by_force:
            self.amplitude = self._amplitudes()
            force = np.broadcast_to(self.given, self.amplitude.shape)
        else:
            shape = self.friction.size, self.load.size, self.given.size
            self.amplitude = np.broadcast_to(self.given, shape)
            if backbone:
                force = np.minimum(
                    self.factor[..., None] * self._sum("drop"), self.limit[..., None]
                )
        a = self.amplitude
        if energy:
            lost = 8.0 * (self.factor * self.kappa[:, None])[..., None] * self._sum("excess")
        result: dict[str, Floats] = {}
        for name in names:
            if name == "amplitude":
                result[name] = a
            elif name == "force_amplitude":
                result[name] = force
            elif name == "dissipated_energy":
                result[name] = lost
            elif name in ratios:
                box = 4.0 * a * force
                ratio = np.divide(lost, box, out=np.zeros(a.shape), where=box > 0.0)
                scale = {"energy_ratio": 1.0, "loss_factor": 4.0, "damping_ratio": 2.0}[name]
                result[name] = ratio if scale == 1.0 else scale / math.pi * ratio
            elif name == "secant_stiffness":
                stiffness = np.broadcast_to(self._stiffness()[:, None], a.shape).copy()
                result[name] = np.divide(force, a, out=stiffness, where=a > 0.0)
            elif name == "dissipation_exponent":
                result[name] = self._exponent(lost)
            elif name == "tangent_stiffness":
                slope = (self.factor / self.kappa[:, None])[..., None]
                result[name] = slope * self._sum("fall")
            else:
                result[name] = self._scalar(name)
        if self.progress is not None:
            self.progress(1.0)
        return result

    def _scalar(self, name: str) -> Floats:
        if name == "separation":
            return self.separation
        if name == "normal_stiffness":
            return np.asarray(self.surface.stiffness(self.separation))
        if name == "tangential_stiffness":
            return self._stiffness()
        if name == "force_limit":
            return self.limit
        if name == "slip_per_indentation":
            return self.kappa
        if name == "stick_area":
            steps = np.minimum(self.amplitude, 1e200) / self.kappa[:, None, None]
            return np.asarray(self.surface.contact_area(self.separation[:, None] + steps))
        return np.asarray(getattr(self.surface, name)(self.separation))

    def _stiffness(self) -> Floats:
        return np.asarray(self.surface.stiffness(self.separation) / self.surface.stiffness_ratio)

    def _report(self, share: float) -> None:
        if self.progress is not None:
            self.progress(min((self.done + share) / self.passes, 1.0))

    def _sum(self, kind: Any) -> Floats:
        """A sum of the normal law over the whole grid."""
        if self.by_force:
            steps = np.minimum(self.amplitude, 1e200) / self.kappa[:, None, None]
            rows = np.tile(self.separation, self.friction.size)
            flat = on_grid(self.surface, kind, rows, steps.reshape(rows.size, -1), self._report)
            result = flat.reshape(self.amplitude.shape)
        else:
            # All loads share the steps, those of every coefficient of friction side by side.
            steps = np.minimum(self.given, 1e200) / self.kappa[:, None]
            flat = on_grid(self.surface, kind, self.separation, steps.reshape(-1), self._report)
            result = np.moveaxis(flat.reshape(self.load.size, *steps.shape), 0, 1)
        self.done += 1
        return result

    def _amplitudes(self) -> Floats:
        """Displacement amplitudes that belong to the given forces."""
        i, j = np.unravel_index(int(np.argmin(self.limit)), self.limit.shape)
        largest = float(self.given.max())
        if largest >= self.limit[i, j]:
            raise InputError(
                "`force_amplitude` must stay below the force limit at every load, and at "
                f"{exact(self.load[j])} N it is {self.limit[i, j]:.10g} N; got {largest:.10g} N"
            )
        drops = self.given / self.factor[..., None]
        rows = np.tile(self.separation, self.friction.size)
        steps = inverse_on_grid(self.surface, drops.reshape(rows.size, -1), rows, self._report)
        self.done += 1
        return np.asarray(self.kappa[:, None, None] * steps.reshape(drops.shape))

    def _exponent(self, lost: Floats) -> Floats:
        slope = 8.0 * self.factor[..., None] * self._sum("excess_slope")
        nothing = np.full(lost.shape, np.nan)
        exponent = np.divide(self.amplitude * slope, lost, out=nothing, where=lost > 0.0)
        # Where the energy underflows the limit of small amplitudes holds, if there is one.
        bends = self.surface._derivative(self.separation, 2) > 0.0
        return np.where(np.isnan(exponent) & bends[:, None], 3.0, exponent)
