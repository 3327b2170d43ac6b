"""SciPy's readers of MAT and Matrix Market files in a process of their own.

Damaged files make them write where no memory is theirs, or ask for all there is. So a child parses,
with bounded memory and time, and hands plain arrays over in an archive; its death is one line.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from microslip.readers.files import allowed_points, decoded

_BYTES_A_POINT: Final = 16  # as read, and as written for the parent
_BESIDE: Final = 1 << 30  # address space of Python, NumPy and SciPy with one thread
_SECONDS, _BYTES_A_SECOND = 10.0, 2e7
_SPARSE: Final = ("data", "row", "col", "shape")


def parsed(kind: str, path: Path, names: Sequence[str] | None = None) -> dict[str, Any]:
    """What a child reads of a file: numbers, texts, arrays and sparse matrices, nested by names.

    Parameters
    ----------
    kind : str
        "MAT-file" or "Matrix Market file".
    path : path
        The file.
    names : sequence of str, optional
        Variables to read; without them those that are no large arrays, and of large arrays their
        shapes as tuples.
    """
    with decoded(kind), tempfile.TemporaryDirectory(prefix="microslip-") as folder:
        answer = Path(folder) / "answer.npz"
        seconds = _SECONDS + path.stat().st_size / _BYTES_A_SECOND
        request = {
            "path": os.path.abspath(path),  # noqa: PTH100 - never raises
            "names": None if names is None else list(names),
            "points": allowed_points(),
        }
        command = [sys.executable, "-m", "microslip.readers.child", kind, str(answer)]
        here = os.fspath(Path(__file__).parents[2])
        try:
            child = subprocess.run(
                command,
                input=json.dumps(request).encode("ascii"),
                capture_output=True,
                timeout=seconds,
                check=False,
                env=os.environ
                | {
                    "OPENBLAS_NUM_THREADS": "1",
                    "PYTHONPATH": os.pathsep.join([here, os.environ.get("PYTHONPATH", "")]),
                },
            )
        except subprocess.TimeoutExpired:
            raise ValueError(f"its reader took more than {seconds:.0f} s") from None
        if child.returncode != 0 or not answer.is_file():
            raise ValueError(_cause(child))
        with np.load(answer, allow_pickle=False) as archive:
            tree = json.loads(str(archive["tree"]))
            content = _joined(tree, archive)
    assert isinstance(content, dict)
    return content


def _cause(child: subprocess.CompletedProcess[bytes]) -> str:
    """Why a child has no answer."""
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        return f"damaged, its reader crashed ({name})"
    lines = child.stderr.decode("utf-8", "replace").strip().splitlines()
    return lines[-1] if lines else "damaged, its reader gave no answer"


def _joined(node: Any, archive: Mapping[str, Any]) -> Any:
    """A tree with the arrays in their places again."""
    if isinstance(node, list):
        return [_joined(item, archive) for item in node]
    if not isinstance(node, dict):
        return node
    if "array" in node:
        return archive[node["array"]]
    if "shape" in node:
        return tuple(node["shape"])
    if "sparse" in node:
        from scipy.sparse import coo_matrix

        data, row, col, shape = (archive[f"{node['sparse']}.{part}"] for part in _SPARSE)
        return coo_matrix((data, (row, col)), shape=tuple(int(n) for n in shape))
    return {name: _joined(item, archive) for name, item in node["items"].items()}


# ------------------------------------------------------------------ what runs in the child


def _split(value: Any, arrays: dict[str, Any]) -> Any:
    """What SciPy made of a file as JSON, and beside it the arrays that it names."""
    name = f"a{len(arrays)}"
    if isinstance(value, dict):
        return {"items": {str(key): _split(item, arrays) for key, item in value.items()}}
    if isinstance(value, tuple):
        return {"shape": list(value)}
    if isinstance(value, list):
        return [_split(item, arrays) for item in value]
    if hasattr(value, "tocoo"):
        entries = value.tocoo()
        for part, content in zip(
            _SPARSE, (entries.data, entries.row, entries.col, np.array(value.shape)), strict=True
        ):
            arrays[f"{name}.{part}"] = content
        return {"sparse": name}
    if isinstance(value, np.ndarray):
        if value.dtype.kind in "iufcb":
            arrays[name] = value
            return {"array": name}
        if value.dtype == object:
            return [_split(item, arrays) for item in value.flat]
        return None
    if isinstance(value, np.generic):
        value = value.item()
    return value if isinstance(value, (str, int, float, bool)) else None


def _mat(path: str, names: list[str] | None, points: int) -> dict[str, Any]:
    from scipy.io import loadmat, whosmat

    sizes = {name: tuple(map(int, size)) for name, size, _ in whosmat(path)}
    if names is None:
        large = {name for name, size in sizes.items() if _count(size) > min(points, 1_000_000)}
        names = [name for name in sizes if name not in large]
    elif sum(_count(sizes[name]) for name in names if name in sizes) > points:
        raise ValueError(f"holds more than the limit of {points} points")
    else:
        large = set()
    content = loadmat(path, variable_names=names, simplify_cells=True) if names else {}
    by_name = {name: value for name, value in content.items() if not name.startswith("__")}
    for name, value in by_name.items():
        if isinstance(value, np.ndarray) and value.dtype.kind in "iufcb":
            by_name[name] = value.reshape(sizes.get(name, value.shape))
    return {
        name: by_name.get(name, sizes[name]) for name in sizes if name in by_name or name in large
    }


def _matrix(path: str, names: list[str] | None, points: int) -> dict[str, Any]:
    from scipy.io import mminfo, mmread

    rows, columns, entries = mminfo(path)[:3]
    # A sparse matrix takes memory for each of its columns as well.
    if entries + 10 * max(rows, columns) > points:
        raise ValueError(
            f"declares {rows} x {columns} with {entries} entries, more than the limit of {points}"
        )
    return {"matrix": mmread(path)}


def _count(size: tuple[int, ...]) -> int:
    total = 1
    for n in size:
        total *= n
    return total


def main() -> None:
    """Read what the parent asks for; any error is its last line of output."""
    kind, answer = sys.argv[1:]
    request = json.load(sys.stdin)
    points = request["points"]
    try:
        import resource
    except ImportError:  # Windows bounds the time only
        pass
    else:
        memory = _BESIDE + _BYTES_A_POINT * points
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    read = {"MAT-file": _mat, "Matrix Market file": _matrix}[kind]
    arrays: dict[str, Any] = {}
    try:
        import warnings

        warnings.simplefilter("ignore")
        tree = _split(read(request["path"], request["names"], points), arrays)
        arrays["tree"] = np.array(json.dumps(tree))
        np.savez(answer, **arrays)
    except MemoryError:
        sys.exit(f"unpacks to more than the limit of {points} points can need")
    except Exception as error:  # damaged files break SciPy's readers in many ways
        sys.exit(str(error).strip().partition("\n")[0] or type(error).__name__)


if __name__ == "__main__":
    main()
