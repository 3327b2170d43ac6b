"""Sweeps larger than memory, streamed to a Zarr store region by region."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, show, whole_number
from microslip._core.packages import needed_for
from microslip._core.quantities import QUANTITIES, Quantity
from microslip._version import __version__
from microslip.errors import InputError
from microslip.sweeps.evaluation import evaluate

_FINISHED = "done"
_REGION = 1 << 20  # points


def evaluate_to_zarr(
    path: str | Path,
    axes: Mapping[str, ArrayLike],
    quantities: Sequence[str],
    *,
    region: int = _REGION,
    progress: Callable[[float], None] | None = None,
    **arguments: Any,
) -> Path:
    """A grid of joints of any size as a Zarr store, in bounded memory; a second call goes on.

    Parameters
    ----------
    path : str or pathlib.Path
        The store to make, or one that an earlier call of the same arguments left unfinished.
    axes : mapping of str to array_like
        Arguments of :func:`evaluate` that are dimensions, one-dimensional, in their order, such as
        normal loads [N].
    quantities : sequence of str
        Quantities wanted, by the names of :func:`evaluate`.
    region : int, optional
        Points at a time.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.
    **arguments : object
        The other arguments of :func:`evaluate`, numbers.

    Returns
    -------
    pathlib.Path
        The store, which ``xarray.open_zarr`` reads.

    Notes
    -----
    Equal to :func:`evaluate` on the whole grid, (19.15), (19.29), (19.30). Each region is written
    at once and marked as done after it, so that a stop loses one region.
    """
    with needed_for("evaluate_to_zarr needs", "zarr"):
        import zarr
    size = whole_number("region", region, 1)
    lines = _lines(axes)
    shape = tuple(line.size for line in lines.values())
    blocks = _blocks(shape, size)
    # Refused before anything is written.
    first = tuple(slice(0, 1) for _ in lines)
    evaluate(**arguments, **_spread(lines, first), quantities=quantities)
    store = _opened(zarr, Path(path), lines, shape, tuple(quantities), arguments, blocks)
    finished_regions: Any = store[_FINISHED]
    finished = np.asarray(finished_regions[:])
    counts = [math.ceil(n / b) for n, b in zip(shape, blocks, strict=True)]
    places = list(itertools.product(*map(range, counts)))
    for number, place in enumerate(places):
        if not finished[number]:
            part = tuple(
                slice(i * b, min((i + 1) * b, n))
                for i, b, n in zip(place, blocks, shape, strict=True)
            )
            results = evaluate(**arguments, **_spread(lines, part), quantities=quantities)
            for name in quantities:
                store[name][part] = np.asarray(results[name])
            finished_regions[number] = True
        if progress is not None:
            progress((number + 1) / len(places))
    return Path(path)


def _lines(axes: Mapping[str, ArrayLike]) -> dict[str, Floats]:
    if not isinstance(axes, Mapping) or not axes:
        raise InputError(f"`axes` must be a mapping of names to arrays, got {show(axes)}")
    lines = {name: floats(name, values) for name, values in axes.items()}
    for name, line in lines.items():
        if line.ndim != 1:
            raise InputError(f"`{name}` must be one-dimensional, got shape {line.shape}")
    return lines


def _blocks(shape: tuple[int, ...], limit: int) -> tuple[int, ...]:
    """Lengths of a region: whole along the last axes, as far as they fit."""
    blocks, room = [], limit
    for length in reversed(shape):
        blocks.append(max(1, min(length, room)))
        room //= blocks[-1]
    return tuple(reversed(blocks))


def _spread(lines: Mapping[str, Floats], part: tuple[slice, ...]) -> dict[str, Any]:
    """The axes of a region, each along its own dimension."""
    arguments = {}
    for index, (name, line) in enumerate(lines.items()):
        shape = [1] * len(lines)
        shape[index] = -1
        arguments[name] = line[part[index]].reshape(shape)
    return arguments


def _opened(
    zarr: Any,
    path: Path,
    lines: Mapping[str, Floats],
    shape: tuple[int, ...],
    quantities: tuple[str, ...],
    arguments: Mapping[str, Any],
    blocks: tuple[int, ...],
) -> Any:
    """The store, made anew or gone on with."""
    about = {
        "source": f"microslip {__version__}",
        "arguments": {name: repr(value) for name, value in arguments.items()},
        "axes": {
            name: [line.size, float(line[0]), float(line[-1])] for name, line in lines.items()
        },
        "quantities": list(quantities),
        "region": list(blocks),
    }
    if path.exists():
        try:
            store = zarr.open_group(str(path), mode="r+")
            continues = dict(store.attrs).get("sweep") == about
        except Exception:  # whatever else lies there
            continues = False
        if not continues:
            raise InputError(f"{path}: exists, and is no unfinished sweep of these arguments")
        return store
    store = zarr.open_group(str(path), mode="w")
    for name, line in lines.items():
        unit = QUANTITIES.get(name, Quantity("-", name)).attributes
        axis = store.create_array(name, data=line, dimension_names=(name,))
        axis.attrs.update(unit)
    for name in quantities:
        array = store.create_array(
            name, shape=shape, chunks=blocks, dtype="float64", dimension_names=tuple(lines)
        )
        array.attrs.update(QUANTITIES.get(name, Quantity("-", name)).attributes)
    regions = math.prod(math.ceil(n / b) for n, b in zip(shape, blocks, strict=True))
    store.create_array(_FINISHED, data=np.zeros(regions, dtype=bool), dimension_names=("region",))
    store.attrs["sweep"] = about  # last, so that a store that has it is whole
    return store
