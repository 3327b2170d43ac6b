"""Floor 8: from a study to joints, loops and curves."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

import microslip as ms
from microslip.errors import InputError, StudyError
from microslip.study import surfaces as u
from microslip.study.part import KeyedError
from microslip.study.result import (
    AmplitudeCurve,
    Floats,
    HistoryResponse,
    Limits,
    OscillatorCurve,
    Progress,
    Result,
    blocks,
)
from microslip.study.schema import LoadVariation, Study
from microslip.study.sense import lifting
from microslip.study.summary import Defaults, oscillator_of, slip_scale, summarise
from microslip.study.varying import VaryingCycles, VaryingLoop

if TYPE_CHECKING:
    from microslip.normal import NormalLaw

DEFAULT_AMPLITUDES = (0.1, 0.3, 1.0, 10.0)
DEFAULT_RANGE = (1e-3, 1e2)
DEFAULT_POINTS = 200


def run(study: Study, progress: Progress | None = None) -> Result:
    """Compute a study; see :meth:`microslip.study.schema.Study.run`."""
    joints = build_joints(study)
    check_loads(study, joints)
    defaults = defaults_of(study, joints)
    amplitudes, grid = _amplitudes(study, defaults), _grid(study, defaults)
    history = study.excitation.history
    record = None if history is None else history.values
    loops: list[tuple[ms.Loop, ...]] = []
    rows, curves, limits = [], [], []
    histories, oscillators, varying = [], [], []
    for index, joint in enumerate(joints):
        steps = _Steps(progress, index, len(joints))
        row = _row(study, joint, amplitudes)
        rows.append(row)
        if (variation := study.excitation.load_variation) is None:
            loops.append(_loops(study, joint, row, steps.of(0.0, 0.1)))
        else:
            settled = _varying_loops(study, variation, joint, row, steps.of(0.0, 0.1))
            loops.append(settled)
            varying.append(VaryingCycles.of(settled, row))
        with _blame(study, "excitation.curve"):
            curves.append(AmplitudeCurve.of(joint, grid, steps.of(0.1, 0.7)))
        if study.oscillator is not None:
            with _blame(study, "oscillator"):
                held = oscillator_of(study.oscillator, joint)
                oscillators.append(OscillatorCurve.of(held, grid, steps.of(0.7, 0.8)))
        if history is not None and record is not None:
            with _blame(study, "excitation.history"):
                histories.append(HistoryResponse.of(joint, record, history.quantity, history.loads))
        limits.append(_limits(joint, slip_scale(study, joint)[0]))
        steps.of(0.0, 1.0)(1.0)
    result = Result(
        study=study,
        joints=tuple(joints),
        loops=tuple(loops),
        rows=tuple(rows),
        curves=tuple(curves),
        limits=tuple(limits),
        summary={},
        histories=tuple(histories),
        oscillators=tuple(oscillators),
        varying=tuple(varying),
    )
    return replace(result, summary=summarise(result, defaults))


class _Steps:
    """Turns the shares of the parts of one load into shares of the whole."""

    def __init__(self, progress: Progress | None, index: int, count: int) -> None:
        self._report = progress or (lambda share: None)
        self._index, self._count = index, count

    def of(self, begin: float, end: float) -> Progress:
        """Progress of a part that takes the load from one share to another."""

        def report(share: float) -> None:
            here = begin + (end - begin) * share
            self._report((self._index + here) / self._count)

        return report


def _row(study: Study, joint: ms.Interface, amplitudes: Floats) -> AmplitudeCurve:
    if study.excitation.force_amplitudes is None:
        with _blame(study, "excitation.amplitudes"):
            return AmplitudeCurve.of(joint, amplitudes)
    with _blame(study, "excitation.force_amplitudes"):
        return AmplitudeCurve.of_forces(joint, amplitudes)


def _loops(
    study: Study, joint: ms.Interface, row: AmplitudeCurve, progress: Progress
) -> tuple[ms.Loop, ...]:
    loops: list[ms.Loop] = []
    with _blame(study, "excitation.amplitudes"):
        for piece in blocks(row.amplitude.size, progress):
            loops += [joint.loop(amplitude) for amplitude in row.amplitude[piece].tolist()]
    return tuple(loops)


def _varying_loops(
    study: Study,
    variation: LoadVariation,
    joint: ms.Interface,
    row: AmplitudeCurve,
    progress: Progress,
) -> tuple[VaryingLoop, ...]:
    loops: list[VaryingLoop] = []
    with _blame(study, "excitation.load_variation"):
        for amplitude in row.amplitude.tolist():
            loops.append(VaryingLoop.of(joint, amplitude, variation))
            progress(len(loops) / row.amplitude.size)
    return tuple(loops)


def build_surface(study: Study) -> NormalLaw:
    """Normal law of a study.

    Parameters
    ----------
    study : Study
        A validated study.

    Returns
    -------
    NormalLaw
        Its surface.

    Raises
    ------
    StudyError
        If the physics refuses what the schema lets pass.
    """
    materials = {}
    for name, material in study.material.items():
        with _blame(study, f"material.{name}", type(material).model_fields):
            materials[name] = (
                ms.Material.rigid()
                if isinstance(material, u.Rigid)
                else ms.Material(
                    young_modulus=material.young_modulus,
                    poisson_ratio=material.poisson_ratio,
                    hardness=material.hardness,
                )
            )
    with _blame(study, "surface.materials"):
        first, second = study.surface.materials
        pair = ms.MaterialPair(materials[first], materials[second])
    surface = study.surface
    with _blame(study, "surface", type(surface).model_fields):
        if isinstance(surface, u.GreenwoodWilliamsonSurface):
            return ms.GreenwoodWilliamson(
                pair,
                heights=_heights(surface.heights),
                radius=surface.radius,
                density=surface.density,
                area=surface.area,
            )
        if isinstance(surface, u.PopulationSurface):
            radii = surface.radius
            return ms.AsperityPopulation(
                pair,
                heights=np.array(surface.heights.values),
                radii=radii[0] if len(radii) == 1 else np.array(radii),
            )
        if isinstance(surface, u.SphereSurface):
            return ms.SphereOnFlat(pair, radius=surface.radius)
        if isinstance(surface, u.ScanSurface):
            return surface.build(pair)
        return ms.TabulatedNormalLaw(
            pair,
            separation=np.array(surface.separation),
            load=np.array(surface.load),
            tail=surface.tail,
        )


def _heights(
    heights: u.GaussianHeights
    | u.ExponentialHeights
    | u.GivenHeights
    | u.ScipyHeights
    | u.TableHeights,
) -> Any:
    """What a surface takes for heights: a distribution of its own or SciPy's, or an array."""
    if isinstance(heights, u.GaussianHeights):
        return ms.Gaussian(std=heights.std, mean=heights.mean)
    if isinstance(heights, u.ExponentialHeights):
        return ms.Exponential(scale=heights.scale)
    if isinstance(heights, (u.ScipyHeights, u.TableHeights)):
        return heights.frozen()
    return np.array(heights.values)


def build_joints(study: Study) -> list[ms.Interface]:
    """Joints of a study, one for each normal load.

    Parameters
    ----------
    study : Study
        A validated study.

    Returns
    -------
    list of Interface
        In the order of the loads.

    Raises
    ------
    StudyError
        If the physics refuses what the schema lets pass, such as a load that cannot be carried.
    """
    surface = build_surface(study)
    joints: list[ms.Interface] = []
    loads = study.joint.normal_load
    for index, load in enumerate(loads, start=1):
        item = f", item {index}" if len(loads) > 1 else ""
        with _blame(study, f"joint.normal_load{item}"):
            if joints:
                joints.append(joints[0].at(normal_load=load))
            else:
                joints.append(
                    ms.Interface(
                        surface,
                        friction_coefficient=study.joint.friction_coefficient,
                        normal_load=load,
                    )
                )
    return joints


def check_loads(study: Study, joints: list[ms.Interface]) -> None:
    """See that the surface can carry the loads that vary; the others its joints have.

    Parameters
    ----------
    study : Study
        A validated study.
    joints : list of Interface
        Its joints.

    Raises
    ------
    StudyError
        If contact is lost on a surface without an end.
    """
    if math.isfinite(joints[0].surface._top):
        return
    try:
        lifting(study, min(study.joint.normal_load))
    except KeyedError as error:
        raise StudyError(f"{study.name}: {error.key}: {error}") from None


@contextmanager
def _blame(study: Study, key: str, names: Iterable[str] = ()) -> Iterator[None]:
    """Say of which key an error of the physics speaks."""
    try:
        yield
    except InputError as error:
        message = " ".join(str(error).split())
        first = re.match(r"(\w+) (?=must\b)", message)
        if first and first[1] in names:
            key, message = f"{key}.{first[1]}", message[first.end() :]
        elif first and key.split(",")[0].endswith(first[1]):
            message = message[first.end() :]
        raise StudyError(f"{study.name}: {key}: {message}") from error


def defaults_of(study: Study, joints: list[ms.Interface]) -> Defaults:
    """Scale of the amplitudes that are not given: the largest slip scale, to two digits."""
    scales = [slip_scale(study, joint) for joint in joints]
    largest = max(scales)
    return Defaults(
        scale=float(f"{largest[0]:.1e}"),
        meaning=largest[1],
        amplitudes=study.excitation.amplitudes is None
        and study.excitation.force_amplitudes is None,
        curve=study.excitation.curve is None,
        factors=DEFAULT_AMPLITUDES,
        range=DEFAULT_RANGE,
    )


def _amplitudes(study: Study, defaults: Defaults) -> Floats:
    """Displacement amplitudes of the loops [m]; force amplitudes [N] where the study gives them."""
    given = study.excitation.amplitudes or study.excitation.force_amplitudes
    if given is not None:
        return np.array(given)
    return np.array([float(f"{factor * defaults.scale:.3g}") for factor in DEFAULT_AMPLITUDES])


def _grid(study: Study, defaults: Defaults) -> Floats:
    curve = study.excitation.curve
    if curve is not None:
        grid = np.geomspace(curve.start, curve.to, curve.points)
    else:
        low, high = (float(f"{factor * defaults.scale:.3g}") for factor in DEFAULT_RANGE)
        grid = np.geomspace(low, high, DEFAULT_POINTS)
    return grid


def _limits(joint: ms.Interface, scale: float) -> Limits:
    """Asymptotes of the dissipated energy, from the energy far out on either side."""
    cubic = linear = None
    small = 1e-9 * scale
    # Once all slides the energy is on its asymptote, so its offset is read off exactly.
    large = 100.0 * max(scale, joint.force_limit / joint.tangential_stiffness)
    # Only a law whose second derivative is finite at rest has the cubic limit.
    if small**3 > 1e-280 and abs(float(joint.dissipation_exponent(small)) - 3.0) < 1e-3:
        cubic = float(joint.dissipated_energy(small)) / small**3
    if float(joint.backbone(large)) >= (1.0 - 1e-12) * joint.force_limit:
        linear = large - float(joint.dissipated_energy(large)) / (4.0 * joint.force_limit)
    return Limits(
        cubic_coefficient=cubic if cubic and math.isfinite(cubic) else None,
        linear_offset=linear,
    )
