"""The kernels in NumPy: the readable twin of ``_compiled.c``, used where that is not built.

Arrays are C-contiguous float64 (``parent`` and ``codes``: int64) and are written in place.
A *table* is passed as ``coefficients, inverse_width, power, limit, rate``: panels of equal width,
each with ``TERMS`` coefficients in s, -1 <= s <= 1, of a shape S, so that the value at u >= 0 is
u**power * S(u); past the last panel it is limit + rate * (u - end).

A *memory* is the stack of open reversals, oldest first, with the last displacement and the
direction (-1, 0 or 1) of the last move. Empty, it stands for the first loading curve.
"""

from microslip.kernels.layout import MOMENT_TERMS, PROFILE_TERMS, TERMS
from microslip.kernels.twin_diagram import coupled, coupled_step, diagram, step_front, trace
from microslip.kernels.twin_field import field_commit, field_losses, field_try
from microslip.kernels.twin_field_cycles import field_cycle, field_slopes
from microslip.kernels.twin_hold import hold
from microslip.kernels.twin_losses import losses
from microslip.kernels.twin_memory import accumulate, branches, closings, locate, respond
from microslip.kernels.twin_moments import gaussian_moment, gaussian_moment_at
from microslip.kernels.twin_profile import (
    cycle_energies,
    drops,
    excesses,
    loads,
    separations,
)
from microslip.kernels.twin_table import evaluate, evaluate_one
from microslip.kernels.twin_vector import vector_cycle, vector_try

__all__ = [
    "MOMENT_TERMS",
    "PROFILE_TERMS",
    "TERMS",
    "accumulate",
    "branches",
    "closings",
    "coupled",
    "coupled_step",
    "cycle_energies",
    "diagram",
    "drops",
    "evaluate",
    "evaluate_one",
    "excesses",
    "field_commit",
    "field_cycle",
    "field_losses",
    "field_slopes",
    "field_try",
    "gaussian_moment",
    "gaussian_moment_at",
    "hold",
    "loads",
    "locate",
    "losses",
    "respond",
    "separations",
    "step_front",
    "trace",
    "vector_cycle",
    "vector_try",
]
