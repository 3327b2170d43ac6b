"""Fourier coefficients of the forces on an interface whose displacement and load both vary."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, is_whole, show
from microslip.errors import InputError
from microslip.friction.coupled import Joint
from microslip.friction.coupled_cycles import coupled_cycle
from microslip.friction.cycles import Rest
from microslip.friction.harmonics import Basis, coefficients_of

_MOST_SAMPLES = 1 << 20


class CoupledHarmonics(NamedTuple):
    """Fourier coefficients of the settled forces on an interface, and how they change.

    After Jaeger (1998), DOI 10.1115/1.2833765; see :meth:`microslip.Interface.harmonics`.
    """

    force: Floats
    """Coefficients of the tangential force [N], in the order of those of the displacement."""
    normal_load: Floats
    """Those of the normal load [N]."""
    jacobian: Floats
    """Derivatives of force and load (first axis) by displacement and by separation or load as it
    was given (second axis), coefficients by coefficients: shape (2, 2, n, n)."""


def coupled_harmonics(
    joint: Joint,
    coefficients: ArrayLike,
    harmonics: Any,
    rest: Rest,
    normal_load: ArrayLike | None,
    separation: ArrayLike | None,
    samples: int,
) -> CoupledHarmonics:
    """See :meth:`microslip.Interface.harmonics`."""
    if normal_load is not None and separation is not None:
        raise InputError("normal_load or separation must be given, not both")
    basis = Basis(harmonics)
    fewest = 2 * basis.orders[-1] + 1
    if not is_whole(samples) or not fewest <= samples <= _MOST_SAMPLES:
        raise InputError(
            f"samples must be a whole number from {fewest}, for harmonic {basis.orders[-1]}, to "
            f"{_MOST_SAMPLES}, got {show(samples)}"
        )
    size = int(samples)
    waves = basis.values(2.0 * math.pi * np.arange(size) / size)
    analysis = basis.factors[:, None] * waves.T * (2.0 * math.pi / size)
    x = waves @ coefficients_of("coefficients", coefficients, basis)
    name = "separation" if normal_load is None else "normal_load"
    varying_coefficients = separation if normal_load is None else normal_load
    varying: Floats = coefficients_of(name, varying_coefficients, basis)  # type: ignore[arg-type]
    varying_samples = waves @ varying
    cycle = coupled_cycle(
        joint,
        x,
        rest,
        None if normal_load is None else varying_samples,
        None if separation is None else varying_samples,
    )
    by_displacement = analysis @ cycle.derivative(waves)
    if normal_load is None:
        by_other = analysis @ cycle.derivative(separation=waves)
        load = -(analysis * cycle.normal_stiffness) @ waves
    else:
        by_other, load = analysis @ cycle.derivative(normal_load=waves), np.eye(basis.size)
    jacobian = np.array([[by_displacement, by_other], [np.zeros_like(load), load]])
    return CoupledHarmonics(analysis @ cycle.force, analysis @ cycle.normal_load, jacobian)
