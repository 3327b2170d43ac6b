"""Sensitivities of the answers of each joint of a study to its inputs."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

from microslip.errors import InputError
from microslip.friction import Interface
from microslip.friction.input_slopes import input_slopes
from microslip.study.description import StudyDescription
from microslip.study.scanned_surface import ScanSurface

_STEP = 0.2
"""Half of the logarithm over which cut-offs are varied: summits come and go one by one."""


def leading_inputs(study: StudyDescription, joint: Any) -> dict[str, Any] | None:
    """Slopes of stiffness and loss factor over all inputs; None of a law without a surface."""
    if not isinstance(joint, Interface):
        return None
    amplitudes = study.excitation.amplitudes
    amplitude = joint._slip_scale[0]
    if amplitudes:
        amplitude = math.exp(math.fsum(map(math.log, amplitudes)) / len(amplitudes))
    slopes = input_slopes(joint, amplitude)
    if isinstance(study.surface, ScanSurface):
        for quantity, slope in _over_cutoff(study.surface, joint, amplitude).items():
            slopes[quantity]["cutoff"] = slope
    return {
        "amplitude": amplitude,
        **{
            name: dict(sorted(slopes_of_answer.items(), key=lambda pair: -abs(pair[1])))
            for name, slopes_of_answer in slopes.items()
        },
    }


def _over_cutoff(surface: ScanSurface, joint: Interface, amplitude: float) -> dict[str, float]:
    with suppress(InputError):  # a cut-off that leaves no summit, or none that carries the load
        ends = []
        for sign in (-1.0, 1.0):
            law = surface.law_at(joint.surface.pair, math.exp(sign * _STEP))
            if law is None or hasattr(joint.surface, "tightening_load"):
                return {}
            ends.append(Interface(law, joint.friction_coefficient, normal_load=joint.normal_load))
        pairs = {
            "tangential_stiffness": [end.tangential_stiffness for end in ends],
            "loss_factor": [float(end.loss_factor(amplitude)) for end in ends],
        }
        return {name: math.log(high / low) / (2.0 * _STEP) for name, (low, high) in pairs.items()}
    return {}
