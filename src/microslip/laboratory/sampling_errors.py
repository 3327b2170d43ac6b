"""Errors of the quantities of cycles due to the spacing of the samples."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from microslip._core.checks import Floats
from microslip.laboratory.blocks import Block
from microslip.laboratory.cycle_columns import STIFFNESS, block_columns
from microslip.laboratory.record import Record

_MOST_SAMPLES, _MOST_CYCLES, _FEWEST = 400.0, 64, 16.0
"""Samples per cycle above which the error is bounded by that of a polygon, number of compared
cycles, and samples per cycle from which on half of them suffice for a loop."""
_ORDER = 2.0
"""Change from all samples to half of them over the error of all: 3 at a kink of the branch, 15
where it is smooth; less, since the position of the kink between samples is random."""
_NO_LENGTH = (
    "cycle_number", "start", "period", "frequency", "displacement_offset", "force_offset",
    "normal_load", "closure_error",
)  # fmt: skip
_ENCLOSED = (
    "dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio", "fouvry_ratio",
    "friction_energy",
)  # fmt: skip
"""Columns in proportion to the enclosed area."""


def sampling_errors(
    record: Record, block: Block, columns: Mapping[str, Floats], compliance: float
) -> dict[str, float]:
    """Estimate the half-widths of errors of means due to sample spacing, relative to the means.

    The columns of a block are evaluated again from its even and from its odd samples. Errors of
    stiffnesses include the difference between the results of three shapes of the branch.
    """
    names = [name for name in columns if name not in _NO_LENGTH]
    period = block.cycles.period
    polygon = (2.0 * math.pi / period) ** 2 / 6.0
    errors = dict.fromkeys(names, polygon)
    if _FEWEST <= period <= _MOST_SAMPLES:
        errors = dict.fromkeys(names, 0.0)
        x, force = record.displacement[block.samples], record.force[block.samples]
        load = record.normal_load
        pressed = load[block.samples] if isinstance(load, np.ndarray) else load
        few = block.cycles.selected(0, min(_MOST_CYCLES, block.cycle_count))
        whole = block_columns(x, force, pressed, few, compliance)
        for parity in (0, 1):
            last, half = x[parity::2].size - 1, few._replace(period=0.5 * period)
            for name in ("cuts", "peaks", "troughs"):
                places = np.clip((getattr(few, name) - parity + 1) // 2, 0, last)
                half = half._replace(**{name: places})
            load_part = pressed[parity::2] if isinstance(pressed, np.ndarray) else pressed
            part = block_columns(x[parity::2], force[parity::2], load_part, half, compliance)
            for name in names:
                change = _relative(whole[name], part[name], name == STIFFNESS)
                errors[name] = max(errors[name], change / _ORDER)
    # The reversal is extrapolated from samples beside it: an error of the next order remains.
    errors = {name: max(error, 2.0 * polygon**2) for name, error in errors.items()}
    for name in errors.keys() & set(_ENCLOSED):
        # A kink of the branch between two samples costs up to three times the mean of a polygon.
        errors[name] = max(errors[name], 0.5 * polygon)
    doubt = columns["chord_doubt"]
    fine = doubt[np.isfinite(doubt)]
    chord_doubt = float(np.median(fine)) if fine.size else 0.0
    errors[STIFFNESS] = math.hypot(errors[STIFFNESS], chord_doubt)
    return errors


def _relative(whole: Floats, half: Floats, is_stiffness: bool) -> float:
    """Return the median relative change of a column if only every other sample is used [-].

    The median ignores cycles of other amplitudes, in which the divisor may be almost zero.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        change = (whole / half if is_stiffness else half / whole) - 1.0
    fine = change[np.isfinite(change)]
    return abs(float(np.median(fine))) if fine.size else 0.0
