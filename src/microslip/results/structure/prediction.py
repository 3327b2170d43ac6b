"""The numbers of a bolted structure: its rest, its modes, their bands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microslip._core.checks import Floats
from microslip.structures import (
    Convergence,
    ModalCurve,
    ModalIdentification,
    ModalTest,
    Preload,
    ReducedJoint,
)
from microslip.study.structure import StructurePart

SHARES = (0.05, 0.5, 0.95)
"""Quantiles of the bands."""


@dataclass(frozen=True)
class Bands:
    """What a mode does over the samples of what is not known exactly.

    Parameters
    ----------
    frequency, damping_ratio : ndarray
        Quantiles at each amplitude [Hz], [-], shape (3, amplitudes).
    ranking : tuple of (str, float)
        Share of each input in the scatter of ln(damping ratio) [-], the largest first.
    """

    frequency: Floats
    damping_ratio: Floats
    ranking: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Mode:
    """One mode along the amplitudes at the sensor.

    Parameters
    ----------
    number : int
        Counted from 1.
    curve : ModalCurve
        By balance of harmonics.
    quick : ModalCurve
        Quasi-static.
    bands : Bands or None
        None where everything is given as one number.
    """

    number: int
    curve: ModalCurve
    quick: ModalCurve
    bands: Bands | None

    def slip(self, joint: ReducedJoint) -> Floats:
        """Relative tangential amplitude of each patch at the largest solved amplitude [m]."""
        last = int(np.flatnonzero(self.curve.converged)[-1])
        moved = abs(self.curve.shape[last] * self.curve.modal_amplitude[last])
        relative = moved[: 3 * joint.patches].reshape(-1, 3)
        return np.asarray(np.hypot(relative[:, 0], relative[:, 1]))

    def loss(self) -> Floats:
        """Share of each patch in the loss at the largest solved amplitude [-]."""
        last = int(np.flatnonzero(self.curve.converged)[-1])
        return np.asarray(self.curve.loss_share[last])


@dataclass(frozen=True)
class StructurePrediction:
    """All numbers of the structure of a study.

    Parameters
    ----------
    part : StructurePart
        What was asked for.
    joint : ReducedJoint
        The reduced model.
    state : Preload
        The tightened state, everything uncertain at its middle.
    modes : tuple of Mode
        In the order of the study.
    inputs : tuple of (str, str)
        What is not known exactly, and how far it is known.
    identified : ModalIdentification or None
        What the tests say of the joint, where the study asks for a fit.
    tests : tuple of ModalTest
        The tests of the study.
    convergence : Convergence or None
        How good the model is for the first mode, where the study asks for it.
    """

    part: StructurePart
    joint: ReducedJoint
    state: Preload
    modes: tuple[Mode, ...]
    inputs: tuple[tuple[str, str], ...]
    identified: ModalIdentification | None = None
    tests: tuple[ModalTest, ...] = ()
    convergence: Convergence | None = None
