"""Stretches of samples that follow each other."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def runs_of(mask: NDArray[Any]) -> NDArray[np.intp]:
    """First index and end (exclusive) of each run of true values (runs, 2)."""
    return np.flatnonzero(np.diff(mask, prepend=False, append=False)).reshape(-1, 2)
