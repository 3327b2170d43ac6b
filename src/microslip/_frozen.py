"""Arrays that stay as they are, in objects that are frozen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def lock(array: NDArray[Any]) -> NDArray[Any]:
    """The array, from now on read-only."""
    array.setflags(write=False)
    return array


class Locked:
    """A frozen object whose arrays stay read-only in its copies: NumPy forgets to pickle that."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                lock(value)
        self.__dict__.update(state)
