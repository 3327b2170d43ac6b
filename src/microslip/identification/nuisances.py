"""Floor 6: what else is unknown of a record: its load, and the drift of its force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from microslip import kernels
from microslip._core.checks import Floats
from microslip.identification.models.base import BackboneModel

if TYPE_CHECKING:
    from microslip.identification.problem import Problem

_STEP = 1e-4  # of the load, for differences


def has_load(problem: Problem, record: int) -> bool:
    """Whether the load of a record counts and is not certain."""
    return problem.model.scales_with_load and problem.folded[record].load_error > 0.0


def by_load(problem: Problem, q: Floats) -> Floats:
    """Change of the force in all bins by the logarithm of the load of its record [N].

    The displacement is as measured, so that a rig gives way in turn: with v + c T0(v) = y the
    derivative of T is that of T0 at v over 1 + c T0'(v).
    """
    model = problem.model
    problem.respond(q)
    outer = problem.physical(q)
    rise = np.zeros_like(problem.half)
    for number, group in enumerate(problem.groups):
        if not isinstance(model, BackboneModel) or group.load is None:
            continue
        values = {n: outer[j] for n, j in zip(model.names, group.columns, strict=True)}
        compliance = 0.0 if group.rig is None else 1.0 / outer[group.rig]
        force, stiffness = problem.branch_of(number)
        v = np.maximum(problem.half[group.places] - compliance * force, 0.0)
        less, more = (
            model.curve(v, values, group.load * (1.0 + way * _STEP))[0] for way in (-1.0, 1.0)
        )
        # The stiffness is that of both in series: 1/(1 + c T0') is what it lets through.
        rise[group.places] = (more - less) * (1.0 - compliance * stiffness) / (2.0 * _STEP)
    rise *= problem.sign
    kernels.active.accumulate(problem.parent, rise, np.zeros(1))
    return problem.to_bins(rise)


def uncertain_of(problem: Problem, at: int, loads: bool = True) -> Floats:
    """What nuisances of variance 1 do to the weighted residuals of a record: columns.

    The errors of its displacement, of the drift that was taken off its force, and of its load.
    """
    folded = problem.folded[problem.order[at]]
    weight, felt = problem.weight[problem.bins[at]], problem.felt[at]
    size = folded.coefficients.size
    root = np.linalg.cholesky(folded.covariance)
    rows = [root.T @ felt[:size]]
    if folded.drifted.size:
        rows.append(folded.drifted[None])
    if loads and felt.shape[0] > size:
        assert folded.normal_load is not None
        rows.append(felt[size:] * (folded.load_error / folded.normal_load))
    return np.asarray((np.vstack(rows) * weight).T)
