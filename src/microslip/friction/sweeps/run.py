"""Sweep of one joint over loads, amplitudes and coefficients of friction.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import LARGEST, Floats, check_one_of, exact, floats, positives, show
from microslip._core.dataset import Variable
from microslip._core.errors import InputError
from microslip._core.quantities import QUANTITIES, Quantity
from microslip._version import __version__
from microslip.friction import BackboneLaw, Interface
from microslip.friction.sweeps.arguments import Arguments, check_names
from microslip.friction.sweeps.arrays import Sweep
from microslip.friction.sweeps.evaluation import evaluated

_GRID = ("friction_coefficient", "normal_load", "amplitude")
_POINTS = 1 << 13  # points between progress reports; a thirtieth of a large grid
_MANY = 10_000  # amplitudes from which the tables of an interface are faster
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
"""Dimensions of each quantity."""

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
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Evaluate a joint at many loads, amplitudes and coefficients of friction.

    Parameters
    ----------
    joint : BackboneLaw
        An :class:`microslip.Interface`, or another law, for which only amplitudes may be given.
    normal_load : array_like, optional
        Normal loads [N], above zero, one-dimensional, by default that of the joint.
    amplitude : array_like, optional
        Displacement amplitudes [m], not negative, one-dimensional.
    force_amplitude : array_like, optional
        Force amplitudes [N], below the force limit at every load, given instead.
    friction_coefficient : array_like, optional
        Coefficients of friction [-], above zero, one-dimensional, by default that of the joint.
    quantities : sequence of str, optional
        Names of the results: force_amplitude (or amplitude), dissipated_energy, energy_ratio,
        loss_factor, damping_ratio, secant_stiffness, tangent_stiffness, dissipation_exponent,
        stick_area, and, independent of amplitude, separation, normal_stiffness,
        tangential_stiffness, contact_count, contact_area, force_limit, slip_per_indentation. The
        default is dissipated_energy, loss_factor, damping_ratio, secant_stiffness, and
        force_amplitude if ``amplitude`` is given, otherwise amplitude.
    progress : callable, optional
        Called with the completed fraction, from 0 to 1.

    Returns
    -------
    Sweep
        Labelled arrays. Each array argument is a dimension, in the order friction_coefficient,
        normal_load, amplitude; a number or a default is a scalar coordinate.

    Notes
    -----
    Computed by (19.15) and (19.29) at once, like :func:`microslip.evaluate`; results agree with
    :class:`microslip.Interface` to 1e-13.
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
    along = _axis(name, values_along, "m" if name == "amplitude" else "N")
    if along.min() < 0.0:
        raise InputError(f"`{name}` must not be negative, got {along.min():g}")
    if name == "amplitude" and along.max() > LARGEST:
        raise InputError(f"`{name}` must be at most {LARGEST:g} m, got {along.max():g} m")
    names = _quantity_names(quantities, name)
    if progress is not None and not callable(progress):
        raise InputError(
            f"`progress` must be a function of the completed fraction, got {show(progress)}"
        )
    axes = {name: np.abs(along)}  # -0.0 becomes 0.0
    if not isinstance(joint, Interface):
        for key, value in (
            ("friction_coefficient", friction_coefficient),
            ("normal_load", normal_load),
        ):
            if value is not None:
                raise InputError(
                    f"`{key}` must be None for {type(joint).__name__}, since only an Interface "
                    "has one; sweep its amplitudes alone"
                )
        values = _of_law(joint, axes, names)
        if progress is not None:
            progress(1.0)
        return _labelled(joint, axes, values, name)
    friction = joint.friction_coefficient if friction_coefficient is None else friction_coefficient
    load = joint.normal_load if normal_load is None else normal_load
    inputs = (("friction_coefficient", friction, ""), ("normal_load", load, "N"))
    positive_axes = {
        n: positives(n, _axis(n, value, unit), unit).copy() for n, value, unit in inputs
    }
    axes = positive_axes | axes
    return _labelled(joint, axes, _of_interface(joint, axes, names, progress), name)


def _axis(name: str, value: Any, unit: str) -> Floats:
    array = floats(name, value, unit)
    if array.ndim > 1:
        raise InputError(f"`{name}` must be a number or one-dimensional, got shape {array.shape}")
    return array


def _quantity_names(quantities: Any, name: str) -> tuple[str, ...]:
    converse = "force_amplitude" if name == "amplitude" else "amplitude"
    if quantities is None:
        return (converse, *_DEFAULT_QUANTITIES)
    available = [quantity for quantity in DIMENSIONS if quantity != name]
    if isinstance(quantities, (list, tuple)) and name in quantities:
        raise InputError(f"`quantities` must not include {name}, which is a coordinate")
    check_names(quantities, available, "dissipated_energy")
    if len(set(quantities)) < len(quantities):
        twice = next(q for q in quantities if list(quantities).count(q) > 1)
        raise InputError(f"`quantities` must be unique, got {twice} twice")
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
        # An axis that is a number has no dimension.
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
    amplitudes = {name: axis.reshape(-1) for name, axis in axes.items()}
    force = amplitudes.get("force_amplitude")
    a = amplitudes["amplitude"] if force is None else joint._amplitudes(None, force)
    calls: dict[str, Callable[[], Any]] = {
        "amplitude": lambda: a,
        "force_amplitude": lambda: joint._backbone(a),
        "force_limit": lambda: joint.force_limit,
        "tangential_stiffness": lambda: joint.tangential_stiffness,
    }
    for name in _OF_CYCLES:
        method = "backbone_stiffness" if name == "tangent_stiffness" else name
        calls[name] = partial(getattr(joint, method), a)
    calls["dissipated_energy"] = lambda: joint._energy(a)
    if isinstance(joint, Interface):
        calls["stick_area"] = partial(joint.stick_area, a)
    for name in names:
        if name not in calls:
            raise InputError(
                f"`quantities` must be available for {type(joint).__name__}, which has no {name}"
            )
    return {name: np.asarray(calls[name](), dtype=float) for name in names}


def _of_interface(
    joint: Interface,
    axes: Mapping[str, Floats],
    names: Sequence[str],
    progress: Callable[[float], None] | None,
) -> dict[str, Floats]:
    friction, load, given = (axis.reshape(-1) for axis in axes.values())
    along = tuple(axes)[-1]
    args: Arguments = {"surface": joint.surface, "normal_load": load}
    if np.all(load == joint.normal_load):
        # Keep the exact separation of a joint that was given by its separation.
        args["separation"] = np.full(load.size, joint.separation)
    if along == "force_amplitude":
        limits, largest = friction.min() * load, float(given.max())
        if largest >= limits.min():
            raise InputError(
                "`force_amplitude` must be below the force limit at every load, "
                f"{limits.min():.10g} N at {exact(load[np.argmin(limits)])} N, got "
                f"{largest:.10g} N"
            )
    at_rest = tuple(name for name in names if DIMENSIONS[name] != _GRID)
    shape = friction.size, load.size
    values = {}
    if at_rest:
        fixed = evaluated(
            {**args, "friction_coefficient": friction[:, None], "shape": shape}, at_rest
        )
        places = {_GRID[:2]: ..., _GRID[:1]: (slice(None), 0), _GRID[1:2]: 0}
        values = {name: np.asarray(fixed[name][places[DIMENSIONS[name]]]) for name in at_rest}
    cyclic = tuple(name for name in names if name not in values)
    values |= {name: np.empty((*shape, given.size)) for name in cyclic}
    # For many amplitudes the tables of single interfaces are faster.
    alone = along == "amplitude" and given.size >= _MANY
    row = friction.size * given.size
    step = 1 if alone else max(1, _POINTS // row, load.size // 30) if cyclic else load.size
    for start in range(0, load.size, step):
        part = slice(start, min(start + step, load.size))
        if alone:
            for i, mu in enumerate(friction.tolist()):
                place = {name: float(args[name][start]) for name in list(args)[-1:]}
                each = Interface(joint.surface, mu, **place)
                for name, found in _of_law(each, {along: given}, cyclic).items():
                    if shape == (1, 1):
                        values[name] = found.reshape(1, 1, -1)
                    else:
                        values[name][i, start] = found
        else:
            here = {name: args[name][part, None] for name in args if name != "surface"}
            here |= {"surface": joint.surface, "friction_coefficient": friction[:, None, None]}
            shape_here = friction.size, part.stop - start, given.size
            answers = evaluated({**here, along: given, "shape": shape_here}, cyclic)
            for name in cyclic:
                values[name][:, part] = answers[name]
        if progress is not None:
            progress(part.stop / load.size)
    return {name: values[name] for name in names}
