"""Exact derivatives of joint quantities by its parameters, for many joints at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.sweeps.arguments import checked
from microslip.sweeps.evaluation import Joints

QUANTITIES = ("damping_ratio", "loss_factor", "dissipated_energy", "secant_stiffness")
"""Quantities that are differentiated."""


def log_derivatives(
    quantity: str, args: Mapping[str, Any], names: Sequence[str]
) -> dict[str, Floats]:
    """D ln q / d ln p of a quantity at an amplitude, for arguments of :func:`microslip.evaluate`.

    With N = C sigma^(3/2) F(h) and x = a/(kappa sigma) the force is mu N [F(h) - F(h + x)]/F(h)
    (19.15) and the energy 8 mu N kappa sigma X(h, x)/F(h), X half the integral of v (x - v) F''.
    """
    args = checked(dict(args))
    joints = Joints(args)
    shape = args["shape"]
    place, unit, amplitude = (
        np.ascontiguousarray(np.broadcast_to(v, shape), dtype=float).reshape(-1)
        for v in (joints.place, joints.kappa * joints.length, args["amplitude"])
    )
    step = amplitude / unit
    law = joints.law
    load, fall = law.load_and_fall(place)
    drop, excess = law.sum("drop", place, step), law.sum("excess", place, step)
    far, slope = law.sum("fall", place, step), law.sum("excess_slope", place, step)
    # By h and by ln x; N F/F(h) itself counts through F(h).
    force_h, force_x = (far - fall) / drop + fall / load, step * far / drop
    energy_h = (2.0 * slope - 0.5 * step * (fall - far)) / excess + fall / load
    energy_x = step * slope / excess
    # h moves with N over C sigma^(3/2).
    h = dict.fromkeys(("normal_load",), -load / fall)
    h |= dict.fromkeys(("density", "area"), load / fall)
    h |= {"radius": 0.5 * load / fall, "std": 1.5 * load / fall}
    derivatives = {}
    for name in names:
        by_h = h.get(name, np.zeros_like(place))
        by_x = -1.0 if name in ("friction_coefficient", "std") else 0.0
        direct = 1.0 if name in ("friction_coefficient", "normal_load") else 0.0
        longer = 1.0 if name in ("friction_coefficient", "std") else 0.0
        force = direct + force_h * by_h + force_x * by_x
        energy = direct + longer + energy_h * by_h + energy_x * by_x
        answers = {
            "dissipated_energy": energy,
            "secant_stiffness": force,
            "damping_ratio": energy - force,
            "loss_factor": energy - force,
        }
        derivatives[name] = np.asarray(answers[quantity].reshape(shape))
    return derivatives
