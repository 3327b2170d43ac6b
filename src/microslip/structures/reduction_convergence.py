"""Convergence of a reduced joint in its patches, mesh, kept modes and harmonics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip.contact import NormalLaw
from microslip.structures.mesh import SIDE, JointMesh
from microslip.structures.modal_curve import ModalCurve
from microslip.structures.mode_equations import NO_LOSS
from microslip.structures.reduction import Reducer
from microslip.structures.reduction_model import ReducedJoint

_SHARE = 0.8  # of the loss, whose patches are halved in one step
_TRIALS = 9  # of a model that two rounds of finer patches make good enough
_HALVED = 4.0 / 3.0
"""Change by infinite refinement over the change by halving, for second order. Measured on a bolted
beam: 1.06 for patches; for elements 1.20 in frequency, 0.97 in damping."""
NARROWEST = 0.9
"""Least patch width over element width: elements are quadratic, narrower patches add nothing."""


class Change(NamedTuple):
    """Relative changes of frequency and damping ratio by one refinement of the model."""

    what: str
    """Change of the model, such as "patches halved along"."""
    coarse: str
    fine: str
    frequency: float
    """Largest change of the frequency over the amplitudes, relative to the coarser model [-]."""
    damping_ratio: float
    """Relative change of the damping ratio [-]."""
    frequency_left: float
    """Extrapolated relative change of the frequency by infinite refinement [-]."""
    damping_left: float
    """Extrapolated relative change of the damping ratio by infinite refinement [-]."""


@dataclass(frozen=True, eq=False)
class Convergence(Locked):
    """Reduced joint with patches refined where most energy is dissipated, and its estimated error.

    Result of :meth:`LapJoint.converge`. Patches are refined by their fraction of the loss, as
    finite elements are by Babuska and Rheinboldt (1978), DOI 10.1137/0715049; errors are
    extrapolated after Richardson (1911), DOI 10.1098/rsta.1911.0009.
    """

    joint: ReducedJoint
    """Model with the patches of the last refinement."""
    curve: ModalCurve
    """Mode of the model at the amplitudes."""
    changes: tuple[Change, ...]
    """Changes by finer patches, a finer mesh, more kept modes and more harmonics [-]."""
    steps: tuple[tuple[int, float, float], ...]
    """Number of patches, frequency [Hz] and damping ratio [-] at the middle amplitude, at first and
    after each refinement."""
    tolerance: float
    """Tolerance of the damping ratio [-]."""
    requested: tuple[float, float]
    """Relative changes of frequency and damping ratio [-], the largest over the amplitudes, from
    the requested patches to infinite refinement."""
    untried: tuple[str, ...] = ()
    """Parts of the model that could not be refined or coarsened with this element size."""

    @property
    def largest(self) -> Change:
        """Refinement (of ``changes``) with the largest remaining change of the damping."""
        return max(self.changes, key=lambda change: abs(change.damping_left))

    @property
    def converged(self) -> bool:
        """Whether no refinement changes the damping by more than the tolerance."""
        return not self.untried and abs(self.largest.damping_left) <= self.tolerance

    @property
    def error(self) -> tuple[float, float]:
        """Estimated relative errors of frequency and damping ratio of ``joint`` [-].

        Root of the sum of squares of the changes that further refinement of each parameter would
        cause. If the elements are too large to halve the patches, the change from the requested to
        the final patches is taken as that by finer patches.
        """
        left = np.array([(c.frequency_left, c.damping_left) for c in self.changes])
        if self._patches_untried and len(self.steps) > 1:
            first, last = np.array(self.steps)[[0, -1], 1:]
            left = np.vstack([left, last / first - 1.0])
        frequency, damping = np.sqrt((left**2).sum(axis=0))
        return float(frequency), float(damping)

    @property
    def _patches_untried(self) -> bool:
        return any(what.startswith("patches") for what in self.untried)

    @property
    def message(self) -> str:
        """Outcome in a sentence: change by the refinement, and largest remaining change."""
        worst, first, (frequency, damping) = self.largest, self.steps[0][0], self.requested
        within = abs(worst.damping_left) <= self.tolerance
        sentences = [
            f"from the {first} requested patches to "
            f"{self.joint.patches if self._patches_untried else 'the limit'} the damping changes "
            f"by {100.0 * damping:+.1f} % and the frequency by {100.0 * frequency:+.2f} %"
            + ("; these elements are too large for finer patches" if self._patches_untried else ""),
            f"refined to {self.joint.patches} patches: of {len(self.changes)} refinements tried, "
            f"{worst.what} ({worst.coarse} to {worst.fine}) still changes the damping most, by "
            f"{100.0 * worst.damping_left:+.2f} %",
            f"{'within' if within else 'outside'} the tolerance {self.tolerance:.2g}",
        ]
        if self.untried:
            words = ", ".join(self.untried)
            sentences.append(
                f"not tried: {words}, for which the elements are too large; take a smaller "
                "element_size"
            )
        return "; ".join(sentences)


class _Trial(NamedTuple):
    joint: ReducedJoint
    curve: ModalCurve


def converge(
    mesh_of: Callable[..., JointMesh],
    element_size: float,
    along: Floats,
    surface: NormalLaw,
    friction_coefficient: ArrayLike,
    *,
    mode: int,
    amplitudes: Floats,
    patches: Any,
    tolerance: float,
    most_patches: int,
    masses: Any,
    form: Any,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> Convergence:
    """Refine patches by their fraction of the loss, then change one property at a time.

    ``mesh_of(size, side)`` returns the mesh with elements of a size [m], and ``side`` cells along
    each side of the block around a bolt; ``options`` are the constant arguments of
    :meth:`Reducer.reduce`.
    """
    reducer, done = Reducer(mesh_of(element_size), masses, along), 0

    def trial(boxes: Any, refined: Reducer = reducer, kept_modes: int = 14) -> _Trial:
        nonlocal done
        joint = refined.reduce(patches=boxes, kept_modes=kept_modes, **options)
        joint = joint if form is None else joint.with_form(form)
        curve = joint.tightened(surface, friction_coefficient).modes(mode, amplitudes)
        done += 1
        if progress is not None:  # of two steps, or with two trials to go
            progress(done / max(_TRIALS, done + 2))
        return _Trial(joint, curve)

    def finer(coarse: _Trial, selected: Any, axis: int) -> _Trial:
        """Return the model with halved patches; ``coarse`` itself if the elements are too large."""
        if not selected.any():
            return coarse
        try:
            fine = trial(halved_boxes(coarse.joint.layout, selected, axis))
        except InputError:  # more patches than there may be
            return coarse
        # Patches that the elements cannot resolve were merged: no refinement.
        wanted = coarse.joint.patches + np.count_nonzero(selected)
        return fine if fine.joint.patches == wanted else coarse

    narrowest = NARROWEST * element_size
    current = first = trial(patches)
    steps = [_step(current)]
    while True:
        boxes = current.joint.layout
        wide = {axis: np.diff(boxes)[:, 2 * axis + 1] > narrowest for axis in (0, 1)}
        halved = {axis: finer(current, wide[axis], axis) for axis in (0, 1)}
        moved = {axis: _change(current.curve, fine.curve) for axis, fine in halved.items()}
        worse = max(moved, key=lambda axis: abs(moved[axis][1]))
        losers = dissipating_patches(current.curve.loss) & wide[worse]
        if not losers.any():  # those are as fine as the elements: then the others
            losers = wide[worse]
        enough = abs(moved[worse][1]) <= tolerance
        if enough or not losers.any() or len(boxes) + losers.sum() > most_patches:
            break
        current, last = finer(current, losers, worse), current
        if current is last:
            break
        steps.append(_step(current))
    count = current.joint.patches
    changes, untried = [], []

    def tell(what: str, coarse: str, fine: str, moved: tuple[float, float], share: float) -> None:
        changes.append(Change(what, coarse, fine, *moved, *(share * part for part in moved)))

    for axis, word in ((0, "along"), (1, "across")):
        fine_count, aspect = halved[axis].joint.patches, f"patches halved {word}"
        if fine_count > count:
            tell(aspect, str(count), str(fine_count), moved[axis], _HALVED)
        else:
            untried.append(aspect)
    richer = trial(boxes, kept_modes=28)
    tell("kept modes", "14", "28", _change(current.curve, richer.curve), 1.0)
    try:
        coarse = trial(boxes, Reducer(mesh_of(2.0 * element_size, SIDE // 2), masses, along))
    except InputError:
        untried.append("finite elements")
    else:
        sizes = (f"{coarse.joint.full_size} degrees of freedom", str(current.joint.full_size))
        change = _change(coarse.curve, current.curve)
        tell("finite elements", *sizes, change, _HALVED - 1.0)
    by_harmonics = _largest(*current.curve.harmonic_changes.T)
    tell("harmonics", "0, 1, 2, 3", "0 … 5", by_harmonics, 1.0)
    left = np.prod([(1.0 + c.frequency_left, 1.0 + c.damping_left) for c in changes], axis=0)
    to_last = np.add(_change(first.curve, current.curve), 1.0)
    asked = to_last * left - 1.0
    return Convergence(
        current.joint, current.curve, tuple(changes), tuple(steps), tolerance,
        (float(asked[0]), float(asked[1])), tuple(untried),
    )  # fmt: skip


def patch_error(
    joint: ReducedJoint, solve: Callable[[ReducedJoint], tuple[Floats, Floats]]
) -> tuple[float, float] | None:
    """Estimate relative errors of frequency and damping ratio due to the size of the patches [-].

    Solutions with patches merged in pairs along, and in pairs across, are compared with that of
    ``joint``; the changes are extrapolated for second order. ``solve`` returns the frequencies and
    the damping ratios, by friction alone, of a joint. None if no patches can be merged; errors of
    mesh and modes are not included.
    """
    trials = [coarse for axis in (0, 1) if (coarse := merged(joint, axis)).patches < joint.patches]
    if not trials:
        return None
    fine = solve(joint)
    scales = fine[0], np.maximum(abs(fine[1]), NO_LOSS)
    changes = [
        [
            float((abs(a - b) / scale).max())
            for a, b, scale in zip(solve(coarse), fine, scales, strict=True)
        ]
        for coarse in trials
    ]
    frequency, damping = (_HALVED - 1.0) * np.sqrt((np.array(changes) ** 2).sum(axis=0))
    return float(frequency), float(damping)


def merged(joint: ReducedJoint, axis: int) -> ReducedJoint:
    """Return the joint with neighbouring patches merged in pairs along an axis.

    A merged patch has the mean displacement of both; their difference remains a coordinate of the
    bodies, free of contact. The result has no surface motion, base or geometry.
    """
    count, areas, layout = joint.patches, joint.patch_areas, joint.layout
    low, high = 1 + 2 * axis, 2 + 2 * axis
    row = [0, 3 - 2 * axis, 4 - 2 * axis]  # contact and bounds across the axis
    order = np.lexsort(layout[:, [low, *row]].T)
    groups: list[list[int]] = []
    for i in order.tolist():
        last = groups[-1] if groups else [i, i]
        beside = np.allclose(layout[last[0], row], layout[i, row]) and np.isclose(
            layout[last[0], high], layout[i, low]
        )
        if len(last) == 1 and beside:
            last.append(i)
        else:
            groups.append([i])
    turn, owner = np.eye(joint.size), np.empty(count, dtype=np.int64)
    first = [group[0] for group in groups]
    for number, group in enumerate(groups):
        owner[group] = number
        if len(group) == 2:
            i, j = group
            share = areas[[i, j]] / areas[group].sum()
            for k in range(3):
                a, b = 3 * i + k, 3 * j + k
                turn[a, [a, b]], turn[b, [a, b]] = (1.0, -share[1]), (1.0, share[0])
    kept = (3 * np.array(first)[:, None] + np.arange(3)).ravel()
    rest = np.arange(3 * count, joint.size)
    differences = np.setdiff1d(np.arange(3 * count), kept)
    turn = turn[:, np.concatenate([kept, rest, differences])]
    total = np.bincount(owner, areas).astype(np.float64)
    boxes = joint.patch_boxes[first].copy()
    boxes[:, 2 * axis + 1] = [joint.patch_boxes[group[-1], 2 * axis + 1] for group in groups]
    return replace(
        joint,
        mass=turn.T @ joint.mass @ turn,
        stiffness=turn.T @ joint.stiffness @ turn,
        patch_areas=total,
        patch_gaps=np.bincount(owner, areas * joint.patch_gaps) / total,
        patch_boxes=boxes,
        patch_contacts=joint.patch_contacts[first],
        sensor_rows=joint.sensor_rows @ turn,
        samples=joint.samples._replace(patches=owner[joint.samples.patches]),
        base_inertia=np.zeros((0, 3)),
        sensor_base=np.zeros((0, 3)),
        geometry=None,
    )


def _step(trial: _Trial) -> tuple[int, float, float]:
    curve, middle = trial.curve, len(trial.curve.frequency) // 2
    return trial.joint.patches, float(curve.frequency[middle]), float(curve.damping_ratio[middle])


def _change(coarse: ModalCurve, fine: ModalCurve) -> tuple[float, float]:
    pairs = (fine.frequency, coarse.frequency), (fine.damping_ratio, coarse.damping_ratio)
    return _largest(*(finer / coarser - 1.0 for finer, coarser in pairs))


def _largest(frequency: Floats, damping: Floats) -> tuple[float, float]:
    largest = (float(change[np.argmax(abs(change))]) for change in (frequency, damping))
    return next(largest), next(largest)


def dissipating_patches(loss: Floats) -> Any:
    """Return a mask of the patches that dissipate 80 % of the loss, at any of the amplitudes."""
    selected = np.zeros(loss.shape[1], dtype=bool)
    for row in loss[np.isfinite(loss).all(axis=1)]:
        order = np.argsort(-row)
        until = np.searchsorted(np.cumsum(row[order]), _SHARE * row.sum()) + 1
        selected[order[:until]] = True
    return selected


def halved_boxes(boxes: Floats, selected: Any, axis: int) -> Floats:
    """Return boxes, rows (contact, four bounds), with the selected ones halved along an axis."""
    low, high = 2 * axis + 1, 2 * axis + 2
    first, second = boxes[selected].copy(), boxes[selected].copy()
    first[:, high] = second[:, low] = 0.5 * (boxes[selected, low] + boxes[selected, high])
    return np.concatenate([boxes[~selected], first, second])
