"""Numbers of a joint at rest: stiffness, contact, sensitivities and verdicts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.quantities import json_value
from microslip.contact import Verdict
from microslip.contact.half_space import in_series, solid_stiffness
from microslip.contact.materials import MaterialPair
from microslip.friction import Interface
from microslip.friction.input_slopes import input_slopes
from microslip.study.description import StudyDescription


def joint_entry(study: StudyDescription, joint: Interface) -> dict[str, Any]:
    """Return the numbers of the joint at rest and its verdicts, for the summary."""
    return {
        "normal_load": json_value(getattr(joint, "normal_load", None)),
        **{name: json_value(value) for name, value in scalars(study, joint).items()},
        "slip_scale_meaning": joint._slip_scale[1],
        "sensitivities": leading_inputs(study, joint),
        "validity": [json_value(verdict._asdict()) for verdict in joint_verdicts(study, joint)],
    }


def joint_verdicts(study: StudyDescription, joint: Interface) -> list[Verdict]:
    """Return the verdicts on a joint; none for a law without a normal load."""
    return [*joint.validity] if study.joint.loads else []


def scalars(study: StudyDescription, joint: Interface) -> dict[str, float | None]:
    """Return the numbers of a joint at rest by name; None for those that are unknown."""
    contact = getattr(joint, "contact_area", None)
    area = None if study.surface is None else study.surface.apparent_area
    return {
        "separation": getattr(joint, "separation", None),
        "standardised_separation": getattr(joint, "standardised_separation", None),
        "contact_count": getattr(joint, "contact_count", None),
        "contact_area": contact,
        "contact_area_fraction": contact / area if contact is not None and area else None,
        "mean_contact_pressure": joint.normal_load / contact if contact else None,
        "normal_stiffness": getattr(joint, "normal_stiffness", None),
        "first_loading_stiffness": _on_first_loading(joint),
        "tangential_stiffness": joint.tangential_stiffness,
        **_at_rig(study, joint, area),
        "force_limit": joint.force_limit,
        "slip_per_indentation": getattr(joint, "slip_per_indentation", None),
        "slip_scale": joint._slip_scale[0],
    }


def _on_first_loading(joint: Interface) -> float | None:
    """Return the normal stiffness [N/m] on first loading of a face that yields."""
    surface = getattr(joint, "surface", None)
    loading = getattr(surface, "first_loading", None)
    if surface is None or loading is None:
        return None
    pressure = joint.normal_load / surface.area
    lowest, highest = loading.pressure[[0, -1]]
    if not lowest <= pressure <= highest * (1.0 + 1e-9):
        return None
    logs = np.log(loading.pressure), np.log(loading.stiffness)
    return math.exp(np.interp(math.log(pressure), *logs))


def _at_rig(
    study: StudyDescription, joint: Interface, area: float | None
) -> dict[str, float | None]:
    """Return the stiffnesses [N/m] that a test rig measures: joint and bodies in series.

    The bodies are half-spaces. The stiffnesses are None in a study with a structure, whose finite
    elements contain the bodies.
    """
    names = ("rig_normal_stiffness", "rig_tangential_stiffness")
    pair = getattr(getattr(joint, "surface", None), "pair", None)
    if area is None or study.structure is not None or not isinstance(pair, MaterialPair):
        return dict.fromkeys(names)
    alone = joint.normal_stiffness, joint.tangential_stiffness
    pressure = getattr(study.joint, "pressure", None)
    behind = solid_stiffness if pressure is None else pressure.solid_stiffness
    return {
        name: in_series(stiff, solid)
        for name, stiff, solid in zip(names, alone, behind(pair, area), strict=True)
    }


def leading_inputs(study: StudyDescription, joint: Any) -> dict[str, Any] | None:
    """Return sensitivities d ln(result)/d ln(input) [-] as ``[result][input]``, largest first.

    Results are the stiffness at rest, and the loss factor at one displacement amplitude [m], which
    is returned under the key "amplitude". None for joints without a surface.
    """
    if not isinstance(joint, Interface):
        return None
    amplitudes = study.excitation.amplitudes
    amplitude = joint._slip_scale[0]
    if amplitudes:
        amplitude = math.exp(math.fsum(map(math.log, amplitudes)) / len(amplitudes))
    return {"amplitude": amplitude, **input_slopes(joint, amplitude)}
