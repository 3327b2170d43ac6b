"""From the values of a study to the surface and the joints that it describes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, cast

from microslip.errors import InputError, StudyError, said
from microslip.friction import Interface
from microslip.materials import MaterialPair
from microslip.normal import NormalLaw
from microslip.report.document import Progress
from microslip.study.consistency import lifting
from microslip.study.description import StudyDescription
from microslip.study.joints import Joint
from microslip.study.measured_face import MeasuredFace
from microslip.study.readers import KeyedError, as_key

_MOST_SURFACES = 1000


def build_surface(study: StudyDescription, progress: Progress | None = None) -> NormalLaw:
    """Normal law of a study, tightened if its joint was; a face point by point takes its time."""
    law = study._law or build_summits(study, progress)
    if not isinstance(study.joint, Joint):
        return law
    with blame(study, "joint", study.joint.keys):
        return study.joint.tightened(law)


def build_summits(study: StudyDescription, progress: Progress | None = None) -> NormalLaw:
    """Normal law of the surface as it was made."""
    materials = {}
    for name, material in study.material.items():
        with blame(study, f"material.{name}", material.keys):
            materials[name] = material.build()
    surface = study.surface
    assert surface is not None  # an interface has one
    with blame(study, "surface.materials"):
        first, second = surface.materials
        pair = MaterialPair(materials[first], materials[second])
    how: dict[str, Any] = {}
    if isinstance(surface, MeasuredFace):
        how = {"progress": progress}
        if study.structure is not None:
            surface._patch = study.structure.patch_size
    with blame(study, "surface", surface.keys):
        law: NormalLaw = surface.build(pair, **how)
        return law


def surface_inputs(study: StudyDescription) -> str:
    """Inputs that determine the normal law of a study, as text: equal texts are one law."""
    joint = study.joint
    bolted = None if joint.pressure is None else (joint.pressure.load, joint.pressure.tightening)
    yielding = (joint.tightening_load, joint.yield_stress, joint.tightening_model, bolted)
    materials = {name: part.by_keys() for name, part in study.material.items()}
    return repr((materials, study.surface.by_keys(), yielding))


def build_joints(
    study: StudyDescription,
    surfaces: dict[str, NormalLaw] | None = None,
    progress: Progress | None = None,
) -> list[Interface]:
    """Joints of a study: one for each normal load, or the law that it gives by its parameters.

    Of studies that are alike in their surface its law is made once, and kept in ``surfaces``.
    """
    if not isinstance(study.joint, Joint):
        return [cast(Interface, study.joint.build())]
    if surfaces is None or study._law is not None:
        surface = build_surface(study, progress)
    else:
        inputs = surface_inputs(study)
        surface = surfaces[inputs] if inputs in surfaces else build_surface(study)
        if len(surfaces) < _MOST_SURFACES:
            surfaces[inputs] = surface
    joints: list[Interface] = []
    loads = study.joint.normal_load
    largest = [max(study.excitation.extremes(load)) for load in loads]
    known = getattr(surface, "tightening_load", math.inf)
    # Of faces that a load tightens anew each load has its own, whatever stands before it.
    alike = known is not None and max(largest, default=0.0) <= known
    for index, (load, top) in enumerate(zip(loads, largest, strict=True), start=1):
        item = f", item {index}" if len(loads) > 1 else ""
        with blame(study, f"joint.normal_load{item}"):
            if joints and alike:
                joint: Any = joints[0].at(normal_load=load)
            else:
                joint = study.joint.build(surface if alike else surface._under(top), load)
            joints.append(cast(Interface, joint))
    return joints


def build_as_made(study: StudyDescription) -> tuple[Interface, list[str]]:
    """The joint under its first load on the surface as it was made, and keys that this leaves out.

    What tightening and an uneven pressure made of the surface is no length that a fit can scale.
    """
    without = [key for key in ("tightening_load", "pressure") if getattr(study.joint, key, None)]
    if not without:
        return build_joints(study)[0], []
    assert isinstance(study.joint, Joint)  # only an interface has them
    pressed_evenly = study.joint.copy(**dict.fromkeys(without))
    joint = cast(Interface, pressed_evenly.build(build_summits(study), study.joint.normal_load[0]))
    return joint, [f"joint.{key}" for key in without]


def check_loads(study: StudyDescription, joints: Sequence[Interface]) -> None:
    """See that the surface can carry the loads that vary; the others its joints have."""
    first = joints[0]
    if not study.joint.loads or math.isfinite(first.surface._top):
        return
    try:
        lifting(study, min(study.joint.loads))
    except KeyedError as error:
        raise StudyError(f"{study.name}: {error.key}: {error}") from None


@contextmanager
def blame(study: StudyDescription, key: str, names: Iterable[str] = ()) -> Iterator[None]:
    """Say of which key an error of the physics speaks."""
    try:
        yield
    except InputError as error:
        text, name = error.text, error.argument
        if name is not None and (name in names or key.split(",")[0].endswith(name)):
            text = error.statement
            key = f"{key}.{name}" if name in names else key
        message = " ".join(said(text, as_key).split())
        raise StudyError(f"{study.name}: {key}: {message}") from error
