"""What both kernels and their callers agree on: kinds of arrays, lengths of rows, rules."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

TERMS = 12
"""Coefficients of a panel of a table."""
PROFILE_TERMS = 14
"""Coefficients of a panel of a load curve."""
MOMENT_TERMS = 30
"""Coefficients of a panel of a moment of the Gaussian."""
RULES = ((0.05, 4), (1.0, 8), (16.0, 16))
"""Rules for what slip loses: for pieces of so many panels at most, so many nodes each."""
