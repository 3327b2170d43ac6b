"""Matrices of a structure from files, and into one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import show
from microslip._core.files import reason, sparse_of_either_kind, whole_file
from microslip._core.packages import needed_for
from microslip._core.wording import did_you_mean, shorten
from microslip.errors import InputError
from microslip.structures.matrices import is_sparse

# A superelement's, the free ones, the generalised and all degrees of freedom in Nastran.
_SETS = ("AAX", "AA", "XX", "GG")
_NAMES = {
    "mass": ("mass", "M", *(f"M{name}" for name in _SETS)),
    "stiffness": ("stiffness", "K", *(f"K{name}" for name in _SETS)),
    "damping": ("damping", "C", *(f"B{name}" for name in _SETS)),
}


def load_matrices(path: str | os.PathLike[str], names: Mapping[str, str]) -> tuple[Any, Any, Any]:
    """Mass, stiffness and, if there is one, damping; see :meth:`microslip.Structure.load`."""
    for name in names:
        if name not in _NAMES:
            raise InputError(
                f"{name} is no matrix of a structure; write mass=, stiffness=, damping="
            )
    file = Path(path)
    if not file.exists():
        raise InputError(f"{file.name}: there is no such file")
    if file.is_dir():
        content = _folder(file)
    else:
        kinds = {".npz": _npz, ".mat": _mat, **dict.fromkeys((".pch", ".op2", ".op4"), _nastran)}
        read = kinds.get(file.suffix.lower())
        if read is None:
            raise InputError(
                f"{file.name}: wanted an .npz, .mat, .pch, .op2 or .op4 file, or a folder of "
                f"mass.mtx, stiffness.mtx and damping.mtx, got {show(file.suffix)}"
            )
        try:
            content = read(file)
        except (InputError, MemoryError):
            raise
        except OSError as error:
            raise InputError(f"{file.name}: cannot be read: {reason(error)}") from None
        except Exception as error:  # damaged files break NumPy's and SciPy's readers in many ways
            raise _unreadable(file, error) from None
    matrices = {kind: _pick(file, content, kind, names.get(kind)) for kind in _NAMES}
    if any(hasattr(matrix, "index") for matrix in matrices.values()):
        matrices = _aligned(file, matrices)
    return matrices["mass"], matrices["stiffness"], matrices["damping"]


def _pick(file: Path, content: Mapping[str, Any], kind: str, name: str | None) -> Any:
    """One matrix by its name."""
    if name is not None:
        if name not in content:
            raise InputError(f"{file.name}: {_missing(name, content)}")
        return content[name]
    name = next((usual for usual in _NAMES[kind] if usual in content), None)
    if name is None and kind != "damping":
        raise InputError(f"{file.name}: {_missing(kind, content)}; write {kind}=... with its name")
    return None if name is None else content[name]


def _missing(name: str, content: Mapping[str, Any]) -> str:
    listed = ", ".join(shorten(h, 30) for h in list(content)[:12]) or "nothing"
    return f'has no "{shorten(name, 40)}"{did_you_mean(name, list(content))}; it has {listed}'


def _npz(file: Path) -> dict[str, Any]:
    """Arrays, and sparse matrices as their coordinates."""
    # Opened here: NumPy leaves a file that is no archive open.
    with file.open("rb") as stream, np.load(stream, allow_pickle=False) as content:
        arrays = {name: content[name] for name in content.files}
    result = {name: array for name, array in arrays.items() if "." not in name}
    for name in {name.partition(".")[0] for name in arrays if "." in name}:
        from scipy.sparse import csc_matrix

        parts = tuple(arrays[f"{name}.{part}"] for part in ("data", "indices", "indptr"))
        result[name] = csc_matrix(parts, shape=tuple(arrays[f"{name}.shape"]))
    return result


def _mat(file: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    with sparse_of_either_kind():
        content = loadmat(file)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _nastran(file: Path) -> dict[str, Any]:
    """DMIG cards of a punch file as pandas' data frames, matrices of OUTPUT2 and OUTPUT4 files."""
    with needed_for(f"{file.name}: Nastran's files are read by", "nastran"):
        from pyyeti.nastran import bulk, op2, op4
    kind, path = file.suffix.lower(), str(file)
    content: dict[str, Any] = {}
    if kind == ".op4":
        content = dict(op4.read(path))
    elif kind == ".op2":
        with op2.OP2(path) as output:
            content = output.rdop2mats()
    if kind == ".pch" or (kind == ".op2" and not content):
        options = {} if kind == ".op2" else {"follow_includes": False}
        content = dict(bulk.rddmig(path, **options))
    return {str(name).upper(): matrix for name, matrix in content.items()}


def _aligned(file: Path, matrices: dict[str, Any]) -> dict[str, Any]:
    """Matrices over all degrees of freedom that one of them has: by grid, then by component."""
    frames = {kind: matrix for kind, matrix in matrices.items() if matrix is not None}
    for kind, frame in frames.items():
        if frame.index.nlevels != 2 or not frame.index.equals(frame.columns):
            raise InputError(f"{file.name}: the {kind} matrix must be square, form 1 or 6 of DMIG")
    index = sorted({place for frame in frames.values() for place in frame.index})
    return {
        kind: None
        if matrix is None
        else matrix.reindex(index, columns=index, fill_value=0.0).values
        for kind, matrix in matrices.items()
    }


def _folder(folder: Path) -> dict[str, Any]:
    """Matrix Market files by their names."""
    from scipy.io import mmread

    result = {}
    for file in sorted(folder.glob("*.mtx")):
        try:
            with sparse_of_either_kind():
                result[file.stem] = mmread(file)
        except (OSError, ValueError) as error:
            raise _unreadable(file, error) from None
    return result


def _unreadable(file: Path, error: Exception) -> InputError:
    text = shorten(str(error) or type(error).__name__, 120)
    return InputError(f"{file.name}: cannot be read: {text}")


def save_matrices(
    path: str | os.PathLike[str], mass: Any, stiffness: Any, damping: Any, overwrite: bool
) -> None:
    """Write an ``.npz`` file, whole or not at all."""
    file = Path(path)
    if file.suffix.lower() != ".npz":
        raise InputError(f"path must end in .npz, got {show(file.name)}")
    arrays: dict[str, Any] = {}
    for name, matrix in (("mass", mass), ("stiffness", stiffness), ("damping", damping)):
        if is_sparse(matrix):
            for part in ("data", "indices", "indptr"):
                arrays[f"{name}.{part}"] = getattr(matrix, part)
            arrays[f"{name}.shape"] = np.array(matrix.shape)
        elif matrix is not None:
            arrays[name] = matrix
    with whole_file(file, overwrite) as stage, stage.open("wb") as stream:
        np.savez_compressed(stream, **arrays)
