"""Floor 10: from what a study says to the surface and the joints that it describes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from microslip.errors import InputError, StudyError
from microslip.friction import Interface
from microslip.heights import Exponential, Gaussian
from microslip.materials import Material, MaterialPair
from microslip.normal import (
    AsperityPopulation,
    GreenwoodWilliamson,
    NormalLaw,
    SphereOnFlat,
    TabulatedNormalLaw,
)
from microslip.study import surfaces as u
from microslip.study.part import KeyedError, as_key
from microslip.study.schema import Study
from microslip.study.sense import lifting


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
        with blame(study, f"material.{name}", type(material).model_fields):
            materials[name] = (
                Material.rigid()
                if isinstance(material, u.Rigid)
                else Material(
                    young_modulus=material.young_modulus,
                    poisson_ratio=material.poisson_ratio,
                    hardness=material.hardness,
                )
            )
    with blame(study, "surface.materials"):
        first, second = study.surface.materials
        pair = MaterialPair(materials[first], materials[second])
    surface = study.surface
    with blame(study, "surface", type(surface).model_fields):
        if isinstance(surface, u.GreenwoodWilliamsonSurface):
            return GreenwoodWilliamson(
                pair,
                heights=_heights(surface.heights),
                radius=surface.radius,
                density=surface.density,
                area=surface.area,
            )
        if isinstance(surface, u.PopulationSurface):
            radii = surface.radius
            return AsperityPopulation(
                pair,
                heights=np.array(surface.heights.values),
                radii=radii[0] if len(radii) == 1 else np.array(radii),
            )
        if isinstance(surface, u.SphereSurface):
            return SphereOnFlat(pair, radius=surface.radius)
        if isinstance(surface, u.ScanSurface):
            return surface.build(pair)
        return TabulatedNormalLaw(
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
        return Gaussian(std=heights.std, mean=heights.mean)
    if isinstance(heights, u.ExponentialHeights):
        return Exponential(scale=heights.scale)
    if isinstance(heights, (u.ScipyHeights, u.TableHeights)):
        return heights.frozen()
    return np.array(heights.values)


def build_joints(study: Study) -> list[Interface]:
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
    joints: list[Interface] = []
    loads = study.joint.normal_load
    for index, load in enumerate(loads, start=1):
        item = f", item {index}" if len(loads) > 1 else ""
        with blame(study, f"joint.normal_load{item}"):
            if joints:
                joints.append(joints[0].at(normal_load=load))
            else:
                joints.append(
                    Interface(
                        surface,
                        friction_coefficient=study.joint.friction_coefficient,
                        normal_load=load,
                    )
                )
    return joints


def check_loads(study: Study, joints: list[Interface]) -> None:
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
def blame(study: Study, key: str, names: Iterable[str] = ()) -> Iterator[None]:
    """Say of which key an error of the physics speaks."""
    try:
        yield
    except InputError as error:
        parts, name = error.parts, error.argument
        if name is not None and (name in names or key.split(",")[0].endswith(name)):
            parts = parts[1:]
            key = f"{key}.{name}" if name in names else key
        message = " ".join(InputError(*parts).said(as_key).split())
        raise StudyError(f"{study.name}: {key}: {message}") from error
