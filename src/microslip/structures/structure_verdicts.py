"""What can be told of a structure before it is solved: its units, its joints in rigid motion."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.verdicts import Rule, Verdict
from microslip.structures.joint_groups import Attachment, all_columns
from microslip.structures.matrices import LARGEST_DENSE, linear_modes, rigid_count

_MOST_RIGID = 12  # two free bodies

FREQUENCY = Rule(
    "first elastic frequency",
    watch=3e4,
    outside=1e6,
    meaning="Matrices in kg and N/m give the frequencies of a real structure [Hz].",
    reason="Matrices in t, mm and N are 31.6 times off in frequency where they are mixed with SI.",
    remedy="Give the mass in kg and the stiffness in N/m.",
    missing="Without an elastic mode there is no frequency to judge.",
)
SLOWNESS = replace(FREQUENCY, name="first elastic frequency, from below", watch=0.5, outside=0.01)
GROUNDED = Rule(
    "joint motion in rigid motion",
    watch=1e-8,
    outside=1e-8,
    meaning=(
        "A joint between two faces does not move when the structure moves as a whole "
        "(largest b^T r, beside the motion of the degrees of freedom it ties)."
    ),
    reason="Centroids 0.4 mm apart turned 169 Hz into 317 Hz.",
    remedy=(
        "Average both faces over the same sample points; "
        "where the joint is to ground or holds a loose part this is as it should be."
    ),
    missing="K leaves no motion free.",
)


def judge(mass: Any, stiffness: Any, attachments: tuple[Attachment, ...]) -> tuple[Verdict, ...]:
    """Verdicts on a structure without its joints."""
    count = None if mass.shape[0] <= LARGEST_DENSE else _MOST_RIGID + 1
    squares, shapes = linear_modes(stiffness, mass, count)
    rigid = rigid_count(squares, stiffness, mass)
    first = math.sqrt(squares[rigid]) / (2.0 * math.pi) if rigid < squares.size else None
    columns = all_columns(attachments, mass.shape[0])
    motion = None
    if rigid and columns.size:
        free = shapes[:, :rigid]
        moved = np.abs(columns.T @ free)
        # What the two sides of a joint move by, each, is what their difference stands beside.
        sides = np.abs(columns).T @ np.abs(free)
        scale = np.where(sides > 0.0, sides, 1.0)
        motion = float((moved / scale).max())
    return FREQUENCY.judge(first), SLOWNESS.judge(first), GROUNDED.judge(motion)
