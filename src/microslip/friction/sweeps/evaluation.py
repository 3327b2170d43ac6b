"""Vectorised evaluation of many joints: each point of the broadcast arguments is one joint.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, plain
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip.contact import GreenwoodWilliamson, NormalLaw
from microslip.contact.base import FAINTEST
from microslip.contact.grids import Pointwise, pointwise_of
from microslip.contact.heights import Gaussian, as_heights
from microslip.contact.materials import Material, MaterialPair
from microslip.friction.sweeps.arguments import (
    NO_ARRAYS,
    Arguments,
    check_names,
    checked,
    evaluate_labelled,
)

_BLOCK = 1 << 14  # points per block, sized for the cache
_RATIOS = {"energy_ratio": 1.0, "loss_factor": 4.0 / math.pi, "damping_ratio": 2.0 / math.pi}
_OF_POINTS = (
    "amplitude",
    "force_amplitude",
    "backbone",
    "dissipated_energy",
    *_RATIOS,
    "secant_stiffness",
    "tangent_stiffness",
    "dissipation_exponent",
    "stick_area",
)
_OF_JOINTS = (
    "normal_load",
    "separation",
    "standardised_separation",
    "slip_per_indentation",
    "normal_stiffness",
    "tangential_stiffness",
    "force_limit",
    "contact_count",
    "contact_area",
)
_COSTLY = (
    *("tangent_stiffness", "dissipation_exponent", "stick_area", "contact_count", "contact_area"),
)
"""Quantities computed only on request, since they cost as much as all others."""


def evaluate(
    *,
    young_modulus: ArrayLike | None = None,
    poisson_ratio: ArrayLike | None = None,
    other_young_modulus: ArrayLike | None = None,
    other_poisson_ratio: ArrayLike | None = None,
    std: ArrayLike | None = None,
    mean: ArrayLike | None = None,
    heights: Any = None,
    radius: ArrayLike | None = None,
    density: ArrayLike | None = None,
    area: ArrayLike | None = None,
    surface: NormalLaw | None = None,
    friction_coefficient: ArrayLike | None = None,
    normal_load: ArrayLike | None = None,
    separation: ArrayLike | None = None,
    amplitude: ArrayLike | None = None,
    force_amplitude: ArrayLike | None = None,
    quantities: Sequence[str] | None = None,
) -> Mapping[str, Any]:
    """Evaluate many joints at once; arguments are numbers or arrays that broadcast.

    Parameters
    ----------
    young_modulus, poisson_ratio : array_like
        Elastic constants [Pa], [-] of both bodies, or of the first if others are given.
    other_young_modulus, other_poisson_ratio : array_like, optional
        Elastic constants of the second body [Pa], [-], by default those of the first. Infinite for
        a rigid body.
    std : array_like
        Standard deviation of the heights [m]. Optional if ``heights`` are given.
    mean : array_like, optional
        Mean of Gaussian heights [m], 0 by default.
    heights : HeightDistribution, frozen scipy.stats distribution or array_like, optional
        Heights [m] common to all joints; with ``std`` only their shape is used.
    radius, density, area : array_like
        Summit radius [m], summits per apparent area [1/m^2], apparent area [m^2].
    surface : NormalLaw, optional
        Surface common to all joints, given instead of the arguments above.
    friction_coefficient : array_like
        Coefficients of friction [-].
    normal_load : array_like
        Normal loads [N].
    separation : array_like, optional
        Separations [m], given instead of the loads.
    amplitude : array_like, optional
        Displacement amplitudes [m], not negative. By default only quantities at rest are computed.
    force_amplitude : array_like, optional
        Force amplitudes [N], below the force limit of each joint, given instead.
    quantities : sequence of str, optional
        Names of the results: amplitude, force_amplitude (or backbone, the same), dissipated_energy,
        energy_ratio, loss_factor, damping_ratio, secant_stiffness, tangent_stiffness,
        dissipation_exponent, stick_area; normal_load, separation, standardised_separation,
        slip_per_indentation, normal_stiffness, tangential_stiffness, force_limit, contact_count,
        contact_area. By default all but tangent_stiffness, dissipation_exponent, stick_area,
        contact_count and contact_area.

    Returns
    -------
    mapping of str to float or ndarray
        Results by name in SI units, with the broadcast shape of the arguments. For
        ``xarray.DataArray`` arguments results have the same type, and are lazy if the arguments
        are.

    Notes
    -----
    Results agree with :class:`microslip.Interface` to 1e-13: (19.8), (19.15), (19.29) and (19.30),
    with the normal law of Greenwood and Williamson (1966), DOI 10.1098/rspa.1966.0242. A joint of
    Gaussian heights depends on d/sigma and delta/(kappa sigma) alone, so all share one load curve.
    """
    arguments = {name: value for name, value in locals().items() if value is not None}
    names = _quantity_names(arguments)
    arrays = {name: value for name, value in arguments.items() if name not in NO_ARRAYS}
    settings = {name: value for name, value in arguments.items() if name in NO_ARRAYS}
    if any(type(value).__module__.startswith("xarray") for value in arrays.values()):
        return evaluate_labelled(evaluate, arrays, settings, names)
    return evaluated(checked(arguments), names)


_ARRAYS = frozenset(evaluate.__kwdefaults__ or ()) - {*NO_ARRAYS}


def _quantity_names(args: Arguments) -> tuple[str, ...]:
    if "amplitude" in args and "force_amplitude" in args:
        raise InputError("`amplitude` [m] or `force_amplitude` [N] must be given, not both")
    cycles = "amplitude" in args or "force_amplitude" in args
    names = (*_OF_JOINTS, *(_OF_POINTS if cycles else ()))
    quantities = args.get("quantities")
    if quantities is None:
        return tuple(name for name in names if name not in _COSTLY)
    check_names(quantities, names, "loss_factor", _OF_POINTS)
    return tuple(dict.fromkeys(quantities))


@cache
def _unit_gaussian() -> GreenwoodWilliamson:
    return _unit(Gaussian(1.0))


def _unit(heights: Any) -> GreenwoodWilliamson:
    """Return a surface with these heights, and elastic moduli, radius, density and area of 1.

    At equal separation, the load of any surface with these heights is a constant times the load of
    this one.
    """
    metal = Material(1.0, 0.0)
    surface = GreenwoodWilliamson(MaterialPair(metal, metal), heights, 1.0, 1.0, 1.0)
    # The deepest separation depends on the true radius, so it is not limited here.
    surface.__dict__["_deepest"] = -math.inf
    return surface


class Joints:
    """Joints whose load curves differ by factors ``scale`` of load and ``length`` of separation."""

    def __init__(self, args: Arguments) -> None:
        self.surface: NormalLaw
        self.friction: Floats = args["friction_coefficient"]
        self.origin: Floats = np.zeros(())
        self.length: Floats = np.ones(())
        self.scale: Floats = np.ones(())
        self.count: Floats = np.ones(())
        self.disc: Floats = np.ones(())
        if "surface" in args:
            self.surface = args["surface"]
            ratio = np.asarray(self.surface.stiffness_ratio)
        else:
            composite, shear = _composite(args)
            ratio = composite / (4.0 * shear)
            self._of_summits(args, composite)
        self.ratio = ratio
        self.law: Pointwise = pointwise_of(self.surface)
        self.kappa = self.friction * ratio
        if "separation" in args:
            self.place = (args["separation"] - self.origin) / self.length
            self.unit_load, self.fall = self._at_places()
            self.load = args.get("normal_load", self.scale * self.unit_load)
            if float(self.load.min()) < FAINTEST:
                raise InputError(
                    "`separation` must be one at which the surface carries a load, got "
                    f"{float(np.max(args['separation'])):g} m, where there is no load"
                )
        else:
            self.load = args["normal_load"]
            unit = np.asarray(self.load / self.scale)
            flat = np.ascontiguousarray(unit).reshape(-1)
            place = [
                self.law.separations(flat[i : i + _BLOCK]) for i in range(0, flat.size, _BLOCK)
            ]
            self.place = np.concatenate(place).reshape(unit.shape)
            self.unit_load, self.fall = self._at_places()
        if "radius" in args:
            deepest = self.surface._span[0] - args["radius"] / self.length
            if np.any(self.place < deepest):
                name = "separation" if "separation" in args else "normal_load"
                raise InputError(
                    f"`{name}` must not press summits by more than their radius, got "
                    f"{np.max(args[name]):g}"
                )
        self.limit = self.friction * self.load
        # As in Interface, so that the limit is exactly mu N.
        self.factor = self.limit / self.unit_load

    def _of_summits(self, args: Arguments, composite: Floats) -> None:
        if "heights" in args:
            heights = as_heights(args["heights"])
            self.surface = _unit(heights)
            if "std" in args:
                self.length = args["std"] / heights.spread
        else:
            self.surface = _unit_gaussian()
            self.length = args["std"]
            self.origin = args.get("mean", self.origin)
        self.count = args["density"] * args["area"]
        self.disc = self.count * args["radius"] * self.length
        stiff = 4.0 / 3.0 * composite * np.sqrt(args["radius"])
        self.scale = (
            self.count * stiff * self.length * np.sqrt(self.length) / self.surface._constant
        )

    def _at_places(self) -> tuple[Floats, Floats]:
        flat = np.ascontiguousarray(self.place).reshape(-1)
        load, fall = self.law.load_and_fall(flat)
        return load.reshape(self.place.shape), fall.reshape(self.place.shape)

    @property
    def normal_stiffness(self) -> Floats:
        """Normal stiffness -N'(d) [N/m]."""
        return np.asarray(self.scale / self.length * self.fall)

    @property
    def tangential_stiffness(self) -> Floats:
        """Tangential stiffness at rest [N/m]."""
        return np.asarray(self.normal_stiffness / self.ratio)

    def joint(self, name: str) -> Floats:
        """Return a quantity of the joints at rest, in SI units, by name."""
        if name == "separation":
            return np.asarray(self.origin + self.length * self.place)
        if name in ("contact_count", "contact_area"):
            share = np.asarray(getattr(self.surface, name)(self.place))
            return np.asarray(share * (self.count if name == "contact_count" else self.disc))
        attributes = {
            "normal_load": "load",
            "standardised_separation": "place",
            "slip_per_indentation": "kappa",
            "force_limit": "limit",
        }
        return np.asarray(getattr(self, attributes.get(name, name)))


def _composite(args: Arguments) -> tuple[Floats, Floats]:
    """Return E* (19.4) and G* (19.11) [Pa]."""
    first: Floats = args["young_modulus"]
    ratio: Floats = args["poisson_ratio"]
    second: Floats = args.get("other_young_modulus", first)
    soft, shear = np.zeros(()), np.zeros(())
    for e, nu in ((first, ratio), (second, args.get("other_poisson_ratio", ratio))):
        soft = soft + (1.0 - nu * nu) / e
        shear = shear + (2.0 - nu) * 2.0 * (1.0 + nu) / e
    return np.asarray(1.0 / soft), np.asarray(1.0 / shear)


def evaluated(args: Arguments, names: tuple[str, ...]) -> Mapping[str, Any]:
    """Evaluate the quantities ``names`` for the arguments that :func:`checked` returned."""
    shape = args["shape"]
    arrays = {name: value for name, value in args.items() if name in _ARRAYS}
    driven = {"amplitude", "force_amplitude"}
    of_joints = [np.shape(value) for name, value in arrays.items() if name not in driven]
    count, size = math.prod(np.broadcast_shapes(*of_joints)), math.prod(shape)
    if count < size or size <= _BLOCK:
        results = _block(args, names, shape)
    else:
        # Every point is a different joint: process blocks from arguments to results.
        results = {name: np.empty(shape) for name in names}
        begin = 0
        for block in _blocks(list(arrays.values()), shape):
            here = slice(begin, begin + block[0].size)
            begin = here.stop
            part = {**args, **dict(zip(arrays, block, strict=True)), "shape": block[0].shape}
            for name, values in _block(part, names, part["shape"]).items():
                results[name].reshape(-1)[here] = values
    return MappingProxyType({name: plain(lock(np.asarray(results[name]))) for name in names})


def _blocks(arrays: Sequence[Floats], shape: tuple[int, ...]) -> Iterator[list[Floats]]:
    for block in np.nditer(  # type: ignore[call-overload]
        [np.broadcast_to(array, shape) for array in arrays],
        flags=["external_loop", "buffered"],
        op_flags=[["readonly", "contig"]] * len(arrays),
        order="C",
        buffersize=_BLOCK,
    ):
        # For a single array the iterator yields the array, not a tuple.
        yield [np.ascontiguousarray(part) for part in (block if len(arrays) > 1 else (block,))]


def _block(args: Arguments, names: tuple[str, ...], shape: tuple[int, ...]) -> dict[str, Any]:
    joints = Joints(args)
    points = tuple(name for name in names if name in _OF_POINTS)
    results = _points(joints, args, points, shape) if points else {}
    for name in names:
        if name in _OF_JOINTS:
            results[name] = np.broadcast_to(joints.joint(name), shape)
    return {name: results[name] for name in names}


def _points(
    joints: Joints, args: Arguments, names: tuple[str, ...], shape: tuple[int, ...]
) -> dict[str, Floats]:
    by_force = "force_amplitude" in args
    driven = args["force_amplitude" if by_force else "amplitude"]
    stretch = joints.kappa * joints.length
    stiffness = joints.tangential_stiffness
    inputs = (driven, joints.place, stretch, joints.factor, joints.limit, stiffness)
    results = {name: np.empty(shape) for name in names if name not in ("backbone", "stick_area")}
    for name, source in (("backbone", "force_amplitude"), ("stick_area", "amplitude")):
        if name in names:
            results.setdefault(source, np.empty(shape))
    flat = {name: array.reshape(-1) for name, array in results.items()}
    with_force = bool(results.keys() & {"force_amplitude", "secant_stiffness", *_RATIOS})
    begin = 0
    for value, place, unit, factor, limit, stiffness in _blocks(inputs, shape):
        here = slice(begin, begin + value.size)
        begin = here.stop
        if by_force:
            _check_below_limit(value, limit)
            step = _inverse(joints.law, place, value / factor)
            a, force = unit * step, value
        else:
            a, step, force = value, np.minimum(value, 1e200) / unit, value
            if with_force:
                force = np.minimum(factor * joints.law.sum("drop", place, step), limit)
        answers = _cycles(joints.law, flat, a, step, force, place, unit, factor, stiffness)
        for name, answer in answers.items():
            flat[name][here] = answer
    if "backbone" in names:
        results["backbone"] = results["force_amplitude"]
    if "stick_area" in names:
        steps = np.minimum(results["amplitude"], 1e200) / stretch
        area = joints.surface.contact_area(joints.place + steps)
        results["stick_area"] = np.asarray(area * joints.disc)
    return results


def _cycles(
    law: Pointwise,
    names: Mapping[str, Any],
    a: Floats,
    step: Floats,
    force: Floats,
    place: Floats,
    unit: Floats,
    factor: Floats,
    stiffness: Floats,
) -> dict[str, Floats]:
    results = {"amplitude": a, "force_amplitude": force}
    if names.keys() & {"dissipated_energy", "dissipation_exponent", *_RATIOS}:
        lost = results["dissipated_energy"] = 8.0 * factor * unit * law.sum("excess", place, step)
        if names.keys() & _RATIOS.keys():
            box = 4.0 * a * force
            ratio = np.divide(lost, box, out=np.zeros(a.size), where=box > 0.0)
            results |= {name: ratio * scale for name, scale in _RATIOS.items() if name in names}
    if "secant_stiffness" in names:
        results["secant_stiffness"] = np.divide(force, a, out=stiffness.copy(), where=a > 0.0)
    if "tangent_stiffness" in names:
        results["tangent_stiffness"] = factor / unit * law.sum("fall", place, step)
    if "dissipation_exponent" in names:
        slope = 8.0 * factor * law.sum("excess_slope", place, step)
        nothing = np.full(a.size, np.nan)
        exponent = np.divide(a * slope, lost, out=nothing, where=lost > 0.0)
        bends = law.law._derivative(place, 2) > 0.0
        results["dissipation_exponent"] = np.where(np.isnan(exponent) & bends, 3.0, exponent)
    return {name: results[name] for name in names if name in results}


def _check_below_limit(force: Floats, limit: Floats) -> None:
    worst = int(np.argmax(force - limit))
    if force[worst] >= limit[worst]:
        raise InputError(
            "`force_amplitude` must be below the force limit of each joint, got "
            f"{force[worst]:.10g} N for a limit of {limit[worst]:.10g} N"
        )


def _inverse(law: Pointwise, place: Floats, drop: Floats) -> Floats:
    """Solve N(d) - N(d + u) = ``drop`` for the increases u of separations d in ``place``."""
    step = drop / law.sum("fall", place, np.zeros(place.size))
    active = np.arange(place.size)
    for _ in range(200):
        at, u = place[active], step[active]
        miss = drop[active] - law.sum("drop", at, u)
        slope = law.sum("fall", at, u)
        gain = np.divide(miss, slope, out=np.zeros(u.size), where=(miss > 0.0) & (slope > 0.0))
        step[active] = u + gain
        active = active[(gain > 4e-16 * u) & (miss > 2e-16 * drop[active])]
        if not active.size:
            break
    return step
