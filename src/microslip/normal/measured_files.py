"""Small files of solved faces: a law, or a solution known by its content."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import positive
from microslip._core.files import reason, whole_file
from microslip._core.wording import shorten
from microslip.errors import InputError
from microslip.materials import Material, MaterialPair
from microslip.normal.face_solution import FaceSolution, Progress
from microslip.normal.measured_face import ContactNumbers, Task, remember

_KIND = "microslip-measured-contact"
_FORMAT = 1
_LARGEST = 1 << 28  # bytes that a file may unpack to
_ARRAYS = {"separation": 1, "pressure": 2, "slope": 2, "contact": 1, "sliding": 2,
           "lighter_sliding": 2, "map": 2, "reach": 2, "lighter_tightenings": 2}  # fmt: skip


class StoredLaw(NamedTuple):
    """Stored parts of a law."""

    solution: FaceSolution
    numbers: ContactNumbers
    pair: MaterialPair
    area: float
    direction: float | None


def write_law(law: StoredLaw, path: str | os.PathLike[str], overwrite: bool) -> None:
    """Write a law."""
    bodies = [
        None if body.is_rigid else [body.young_modulus, body.poisson_ratio, body.hardness]
        for body in (law.pair.first, law.pair.second)
    ]
    about = {
        "numbers": dataclasses.asdict(law.numbers),
        "bodies": bodies,
        "area": law.area,
        "direction": law.direction,
    }
    _write(Path(path), law.solution, about, overwrite)


def read_law(path: str | os.PathLike[str]) -> StoredLaw:
    """Read a law."""
    solution, about = _read(Path(path))
    try:
        bodies = [Material.rigid() if body is None else Material(*body) for body in about["bodies"]]
        raw = about["numbers"]
        pairs = {name: tuple(raw[name]) for name in ("pixel", "stiffness_ratios")}
        numbers = ContactNumbers(**{**raw, **pairs})
        positive("area", about["area"], "m^2")
        for name in ("pressure", "rms", "slope"):
            positive(name, raw[name])
        positive("pixel", numbers.pixel[0], "m")
        return StoredLaw(
            solution, numbers, MaterialPair(*bodies), float(about["area"]), about["direction"]
        )
    except Exception as error:  # as above
        raise _damaged(path, error) from None


def cached(
    task: Task, folder: str | os.PathLike[str], workers: int, progress: Progress | None
) -> FaceSolution:
    """The solution of a task, from the folder if it is there, else solved and put there."""
    path = Path(folder) / f"{task.key}.npz"
    if path.is_file():
        solution, _ = _read(path)
        remember(task.key, solution)
        return solution
    solution = task.solved(workers, progress)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path.parent}: cannot be made: {reason(error)}") from None
    _write(path, solution, {}, True)
    return solution


def _write(path: Path, solution: FaceSolution, about: dict[str, Any], overwrite: bool) -> None:
    head = {"kind": _KIND, "format": _FORMAT, "hard": solution.hard, "pixels": solution.pixels}
    arrays = {name: getattr(solution, name) for name in _ARRAYS}
    arrays["map"] = arrays["map"].astype(np.float32)
    arrays["reach"] = arrays["reach"].astype(np.uint8)
    text = json.dumps({**head, **about}).encode()
    with whole_file(path, overwrite) as stage, stage.open("wb") as file:
        np.savez_compressed(file, about=np.frombuffer(text, dtype=np.uint8), **arrays)


def _read(path: Path) -> tuple[FaceSolution, dict[str, Any]]:
    try:
        with zipfile.ZipFile(path) as parts:
            if sum(part.file_size for part in parts.infolist()) > _LARGEST:
                raise ValueError("too large")
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(bytes(file["about"]))
            arrays = {name: np.asarray(file[name], dtype=float) for name in _ARRAYS if name in file}
        arrays.setdefault("reach", (arrays["map"] > 0.0).astype(float))  # files made before it
        arrays.setdefault("lighter_tightenings", np.zeros((0, 0)))
        if about["kind"] != _KIND or about["format"] != _FORMAT:
            raise ValueError(f"it says {about['kind']!s:.40}, {about['format']!s:.10}")
        solution = FaceSolution(**arrays, hard=float(about["hard"]), pixels=int(about["pixels"]))
        _check(arrays)
    except Exception as error:  # damaged archives break in many ways
        raise _damaged(path, error) from None
    return solution, about


def _check(arrays: dict[str, Any]) -> None:
    """Check the conditions that later steps need."""
    count = arrays["separation"].size
    for name, dimensions in _ARRAYS.items():
        array = arrays[name]
        if array.ndim != dimensions or not np.isfinite(array).all():
            raise ValueError(f"no {name}")
    if arrays["reach"].shape != arrays["map"].shape:
        raise ValueError("maps of two sizes")
    shapes = {arrays[name].shape[0] for name in ("pressure", "slope", "contact")}
    tensors = {arrays[name].shape for name in ("sliding", "lighter_sliding")}
    mean = arrays["pressure"].mean(axis=1)
    if not (
        shapes == {count}
        and count >= 2
        and arrays["pressure"].shape == arrays["slope"].shape
        and tensors == {(2, 2)}
        and np.all(np.diff(arrays["separation"]) > 0.0)
        and np.all(np.diff(mean) < 0.0)
        and mean[-1] > 0.0
        and np.all(arrays["slope"].mean(axis=1) > 0.0)
        and np.all(arrays["contact"] > 0.0)
        and math.isfinite(float(np.linalg.det(arrays["sliding"])))
        and np.all(np.linalg.eigvalsh(arrays["sliding"]) > 0.0)
    ):
        raise ValueError("values that no face has")


def _damaged(path: str | os.PathLike[str], error: Exception) -> InputError:
    return InputError(f"{path}: holds no measured contact: {shorten(reason(error), 160)}")
