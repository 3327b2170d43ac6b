"""MATLAB's files: a matrix of heights under its name. Sizes are checked before they are read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from microslip.scans.readers.base import Raw, Reader, Wishes, few, first_line, one_of

# Names by which a table of the gaps between two surfaces is known, as of the Brake-Reuss beam.
_GAPS = {"normzinterp", "pzinterp", "z_max"}
_CLASSES = {"double", "single"} | {f"{sign}int{n}" for sign in ("", "u") for n in (8, 16, 32, 64)}


class Mat(Reader):
    """Version 4 to 7 by SciPy, version 7.3 by h5py."""

    names = ("mat",)
    takes = ("key",)

    def knows(self, head: bytes, suffix: str) -> bool:
        """By its header; version 4 has none."""
        return head.startswith(b"MATLAB ") or suffix == ".mat"

    def read(self, path: Path, wishes: Wishes) -> Raw:
        """The matrix that is meant."""
        with path.open("rb") as file:
            new = file.read(19) == b"MATLAB 7.3 MAT-file"
        arrays = _hdf_shapes(path) if new else _shapes(path)
        if wishes.key is None and arrays.keys() >= _GAPS:
            raise ValueError(
                "holds no scan but a table of gap densities; a study takes such heights of kind "
                '"table", from columns of a CSV file, and in Python '
                "ms.read_gap_table(path).to_surface(pair, area=...) makes a surface of it"
            )
        name = one_of(arrays, wishes, "this MAT-file")
        few(arrays[name], wishes.limit)
        values = _hdf_values(path, name) if new else _values(path, name)
        if 1 in values.shape:  # MATLAB has no vectors
            values = values.ravel()
        return Raw(f'MAT-file, variable "{name}"', values)


def _shapes(path: Path) -> dict[str, tuple[int, ...]]:
    from scipy.io import whosmat

    try:
        with path.open("rb") as file:
            return {name: tuple(size) for name, size, kind in whosmat(file) if kind in _CLASSES}
    except MemoryError:
        raise
    except Exception as error:  # SciPy raises many kinds on what is no MAT-file
        raise ValueError(f"not a usable MAT-file: {first_line(error)}") from None


def _values(path: Path, name: str) -> np.ndarray:
    from scipy.io import loadmat

    try:
        with path.open("rb") as file:
            return np.asarray(loadmat(file, variable_names=[name])[name])
    except MemoryError:
        raise
    except Exception as error:
        raise ValueError(f"not a usable MAT-file: {first_line(error)}") from None


def _hdf_shapes(path: Path) -> dict[str, tuple[int, ...]]:
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return {
                name: tuple(item.shape[::-1])
                for name, item in file.items()
                if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf"
            }
    except OSError as error:
        raise ValueError(f"not a usable MAT-file: {first_line(error)}") from None


def _hdf_values(path: Path, name: str) -> np.ndarray:
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return np.asarray(file[name][()]).T  # MATLAB's order is the other one
    except OSError as error:
        raise ValueError(f"not a usable MAT-file: {first_line(error)}") from None
