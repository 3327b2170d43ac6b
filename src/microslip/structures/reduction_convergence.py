"""How far a reduced joint has converged in its patches, mesh, kept modes and harmonics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip._core.frozen import Locked
from microslip.errors import InputError
from microslip.normal import NormalLaw
from microslip.structures.mesh import JointMesh
from microslip.structures.modal_curve import ModalCurve
from microslip.structures.reduction import Reducer
from microslip.structures.reduction_model import ReducedJoint

_SHARE = 0.8  # of the loss, whose patches are halved in one step


class Change(NamedTuple):
    """What one finer model changes."""

    what: str
    """Of the model, such as "patches halved along"."""
    coarse: str
    fine: str
    frequency: float
    """Largest change of the frequency over the amplitudes, relative to the coarser model [-]."""
    damping_ratio: float
    """That of the damping ratio [-]."""


@dataclass(frozen=True, eq=False)
class Convergence(Locked):
    """A reduced joint whose patches were refined where it loses energy, and how good it is.

    :meth:`LapJoint.converge` makes it.

    After the refinement by share of loss, as for finite elements after Babuska and Rheinboldt
    (1978), DOI 10.1137/0715049.
    """

    joint: ReducedJoint
    """The model with the last patches."""
    curve: ModalCurve
    """Its mode at the amplitudes."""
    changes: tuple[Change, ...]
    """What finer patches, a finer mesh, more kept modes and more harmonics change [-]."""
    steps: tuple[tuple[int, float, float], ...]
    """Number of patches, frequency [Hz] and damping ratio [-] at the middle amplitude, step by
    step."""
    tolerance: float
    """The change of damping that was wanted [-]."""
    untried: tuple[str, ...] = ()
    """What of the model could not be made finer, or coarser, with elements of this size."""

    @property
    def largest(self) -> Change:
        """The change that moves the damping most."""
        return max(self.changes, key=lambda change: abs(change.damping_ratio))

    @property
    def converged(self) -> bool:
        """Whether all was tried, and nothing moves the damping by more than the tolerance."""
        return not self.untried and abs(self.largest.damping_ratio) <= self.tolerance

    @property
    def message(self) -> str:
        """What came of it, in a sentence."""
        worst = self.largest
        within = abs(worst.damping_ratio) <= self.tolerance
        sentences = [
            f"{self.joint.patches} patches",
            f"{worst.what} ({worst.coarse} to {worst.fine}) moves the damping by "
            f"{worst.damping_ratio:+.2%} and the frequency by {worst.frequency:+.3%}, the most of "
            f"{len(self.changes)} changes tried",
            f"that is within {self.tolerance:.2g}"
            if within
            else f"{self.tolerance:.2g} was wanted",
        ]
        if self.untried:
            words = ", ".join(self.untried)
            sentences.append(f"not tried: {words}, for which the elements are too large")
        return "; ".join(sentences)


class _Trial(NamedTuple):
    joint: ReducedJoint
    curve: ModalCurve


def converge(
    mesh_of: Callable[[float], JointMesh],
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
    **options: Any,
) -> Convergence:
    """Refine patches by their share of the loss, then change one thing at a time.

    ``options`` are those of :meth:`Reducer.reduce` that stay as they are.
    """
    reducer = Reducer(mesh_of(element_size), masses, along)

    def trial(boxes: Any, refined: Reducer = reducer, kept_modes: int = 14) -> _Trial:
        joint = refined.reduce(patches=boxes, kept_modes=kept_modes, **options)
        state = joint.tightened(surface, friction_coefficient)
        return _Trial(joint, state.modes(mode, amplitudes))

    # Elements are quadratic: more than two patches in a row in each of them say nothing new.
    narrowest = 0.9 * element_size
    current = trial(patches)
    steps = [_step(current)]
    while True:
        boxes = current.joint.patch_boxes
        wide = {axis: np.diff(boxes)[:, 2 * axis] > narrowest for axis in (0, 1)}
        halved = {axis: trial(halved_boxes(boxes, wide[axis], axis)) for axis in (0, 1)}
        moved = {axis: _change(current.curve, fine.curve) for axis, fine in halved.items()}
        worse = max(moved, key=lambda axis: abs(moved[axis][1]))
        losers = losing_patches(current.curve.loss, _SHARE) & wide[worse]
        if not losers.any():  # those are as fine as the elements: then the others
            losers = wide[worse]
        enough = abs(moved[worse][1]) <= tolerance
        if enough or not losers.any() or len(boxes) + losers.sum() > most_patches:
            break
        current = trial(halved_boxes(boxes, losers, worse))
        steps.append(_step(current))
    count = current.joint.patches
    changes, untried = [], []
    for axis, word in ((0, "along"), (1, "across")):
        finer, aspect = halved[axis].joint.patches, f"patches halved {word}"
        if finer > count:
            changes.append(Change(aspect, str(count), str(finer), *moved[axis]))
        else:
            untried.append(aspect)
    richer = trial(boxes, kept_modes=28)
    changes.append(Change("kept modes", "14", "28", *_change(current.curve, richer.curve)))
    coarse = _coarser(
        current, lambda factor: trial(boxes, Reducer(mesh_of(factor * element_size), masses, along))
    )
    if coarse is None:
        untried.append("finite elements")
    else:
        sizes = (f"{coarse.joint.full_size} degrees of freedom", str(current.joint.full_size))
        changes.append(Change("finite elements", *sizes, *_change(coarse.curve, current.curve)))
    by_harmonics = _largest(*current.curve.harmonic_changes.T)
    changes.append(Change("harmonics", "0, 1, 2, 3", "0 … 5", *by_harmonics))
    return Convergence(
        current.joint, current.curve, tuple(changes), tuple(steps), tolerance, tuple(untried)
    )


def _coarser(current: _Trial, trial: Callable[[float], _Trial]) -> _Trial | None:
    """The model on a mesh that is coarser, where there is one that the patches bear."""
    for factor in (1.4, 2.0, 2.8):
        try:
            coarse = trial(factor)
        except InputError:
            return None
        if coarse.joint.full_size < current.joint.full_size:
            return coarse
    return None


def _step(trial: _Trial) -> tuple[int, float, float]:
    curve, middle = trial.curve, len(trial.curve.frequency) // 2
    return trial.joint.patches, float(curve.frequency[middle]), float(curve.damping_ratio[middle])


def _change(coarse: ModalCurve, fine: ModalCurve) -> tuple[float, float]:
    """Relative changes of frequency and damping from a coarser model to a finer one."""
    pairs = (fine.frequency, coarse.frequency), (fine.damping_ratio, coarse.damping_ratio)
    return _largest(*(finer / coarser - 1.0 for finer, coarser in pairs))


def _largest(frequency: Floats, damping: Floats) -> tuple[float, float]:
    """The largest of the changes over the amplitudes by size, with its sign."""
    largest = (float(change[np.argmax(abs(change))]) for change in (frequency, damping))
    return next(largest), next(largest)


def losing_patches(loss: Floats, share: float) -> Any:
    """The patches that lose most, together this share at any of the amplitudes."""
    selected = np.zeros(loss.shape[1], dtype=bool)
    for row in loss:
        order = np.argsort(-row)
        until = np.searchsorted(np.cumsum(row[order]), share * row.sum()) + 1
        selected[order[:until]] = True
    return selected


def halved_boxes(boxes: Floats, selected: Any, axis: int) -> Floats:
    """Boxes with the chosen ones cut in two along an axis."""
    low, high = 2 * axis, 2 * axis + 1
    first, second = boxes[selected].copy(), boxes[selected].copy()
    first[:, high] = second[:, low] = 0.5 * (boxes[selected, low] + boxes[selected, high])
    return np.concatenate([boxes[~selected], first, second])
