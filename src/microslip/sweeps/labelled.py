"""Many joints at once on labelled and lazy arrays, by xarray and Dask."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

_SAMPLE_AXIS = "sample"  # the axis of loops


def evaluate_labelled(
    evaluate: Callable[..., Mapping[str, Any]],
    arrays: Mapping[str, Any],
    settings: Mapping[str, Any],
    outputs: tuple[str, ...],
) -> dict[str, Any]:
    """The results as DataArrays or Dask arrays, lazy where the arguments are."""
    names = tuple(arrays)
    keys = {**settings, "quantities": [name for name in outputs if not name.startswith("loop_")]}

    def blockwise(*values: Any) -> tuple[Any, ...]:
        shape = np.broadcast_shapes(*map(np.shape, values))
        if 0 in shape:  # Dask asks once for nothing
            return tuple(
                np.zeros((*shape, *(settings["samples"],) * n.startswith("loop_"))) for n in outputs
            )
        answers = evaluate(**dict(zip(names, values, strict=True)), **keys)
        return tuple(np.asarray(answers[name]) for name in outputs)

    sizes = {_SAMPLE_AXIS: settings["samples"]} if "samples" in settings else {}
    last = [(_SAMPLE_AXIS,) if name.startswith("loop_") else () for name in outputs]
    if any(type(value).__module__.startswith("xarray") for value in arrays.values()):
        import xarray

        results = xarray.apply_ufunc(
            blockwise,
            *arrays.values(),
            output_core_dims=last,
            dask="parallelized",
            output_dtypes=[float] * len(outputs),
            dask_gufunc_kwargs={"output_sizes": sizes},
        )
    else:
        import dask.array

        results = dask.array.apply_gufunc(  # type: ignore[no-untyped-call,unused-ignore]
            blockwise,
            ",".join("()" for _ in names) + "->" + ",".join(f"({','.join(d)})" for d in last),
            *arrays.values(),
            output_dtypes=[float] * len(outputs),
            output_sizes=sizes,
        )
    results = results if isinstance(results, tuple) else (results,)
    return dict(zip(outputs, results, strict=True))
