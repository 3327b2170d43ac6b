"""Validation of the arguments of :func:`microslip.evaluate`, and labelled results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from microslip._core.checks import LARGEST, check_one_of, exact, floats, positives, show
from microslip._core.errors import InputError
from microslip.contact import NormalLaw

Arguments = dict[str, Any]

NO_ARRAYS = ("heights", "surface", "quantities")
"""Arguments common to all joints."""
_OTHER_BODY = ("other_young_modulus", "other_poisson_ratio")


def checked(args: Arguments) -> Arguments:
    """Validate arguments; return float arrays by name, and their broadcast shape as "shape"."""
    needs = ["friction_coefficient"]
    of_surface = ("young_modulus", "poisson_ratio", "radius", "density", "area", "std")
    if "surface" in args:
        if not isinstance(args["surface"], NormalLaw):
            raise InputError(f"`surface` must be a normal load law, got {show(args['surface'])}")
        extra = [name for name in (*of_surface, "mean", "heights", *_OTHER_BODY) if name in args]
        if extra:
            raise InputError(f"`{extra[0]}` must not be given with a surface")
    else:
        needs += of_surface[: 5 if "heights" in args else 6]
    for name in needs:
        if name not in args:
            raise InputError(
                f"`{name}` must be given" + ("" if name == "std" else "; it is missing")
            )
    load, separation = (args.get(name) for name in ("normal_load", "separation"))
    check_one_of("normal_load [N] or separation [m]", load, separation)
    if "mean" in args and "heights" in args:
        raise InputError("`mean` must not be given with heights")
    result: Arguments = {k: v for k, v in args.items() if k in ("surface", "heights")}
    for name, value in args.items():
        if name in NO_ARRAYS:
            continue
        if name in ("separation", "mean"):
            length = result[name] = floats(name, value, "m")
            if (largest := np.abs(length).max()) > LARGEST:
                raise InputError(f"`{name}` must be at most {LARGEST:g} m, got {largest:g}")
        elif name in ("poisson_ratio", "other_poisson_ratio"):
            ratio = result[name] = floats(name, value)
            bad = ratio[(ratio <= -1.0) | (ratio > 0.5)]
            if bad.size:
                raise InputError(f"`{name}` must be in (-1, 0.5], got {exact(bad[0])}")
        elif name in ("amplitude", "force_amplitude"):
            a = floats(name, value, _UNITS[name])
            if a.min() < 0.0:
                raise InputError(f"`{name}` must not be negative, got {a.min():g}")
            if a.max() > LARGEST:
                raise InputError(f"`{name}` must be at most {LARGEST:g}, got {a.max():g}")
            result[name] = np.abs(a)
        elif name == "other_young_modulus":
            modulus = floats(name, value, "Pa", endless=True)
            rigid = np.isposinf(modulus)
            elastic = positives(name, np.where(rigid, 1.0, modulus), "Pa")
            result[name] = np.where(rigid, np.inf, elastic)
        else:
            result[name] = positives(name, value, _UNITS.get(name, ""))
    shapes = {k: np.shape(v) for k, v in result.items() if isinstance(v, np.ndarray)}
    shapes.pop("heights", None)
    try:
        result["shape"] = np.broadcast_shapes(*shapes.values())
    except ValueError:
        listing = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise InputError(f"arguments must have shapes that broadcast, got {listing}") from None
    return result


def check_names(
    quantities: Any, available: Sequence[str], example: str, of_amplitudes: Sequence[str] = ()
) -> None:
    """Check that ``quantities`` is a list of ``available`` names.

    The names ``of_amplitudes`` need amplitudes; ``example`` is shown in the message.
    """
    if isinstance(quantities, str) or not isinstance(quantities, Sequence) or not quantities:
        raise InputError(
            f"`quantities` must be a list of names, got {show(quantities)}; for example "
            f'quantities=["{example}"]'
        )
    for name in quantities:
        if name not in available:
            hint = ", which needs amplitude" if name in of_amplitudes else ""
            raise InputError(
                f"`quantities` must be among {', '.join(available)}, got {show(name)}{hint}"
            )


_UNITS = {
    "young_modulus": "Pa", "std": "m", "radius": "m", "density": "1/m^2", "area": "m^2",
    "normal_load": "N", "amplitude": "m", "force_amplitude": "N",
}  # fmt: skip


def evaluate_labelled(
    evaluate: Callable[..., Mapping[str, Any]],
    arrays: Mapping[str, Any],
    settings: Mapping[str, Any],
    outputs: tuple[str, ...],
) -> dict[str, Any]:
    """Call ``evaluate`` with arguments that are DataArrays of xarray, lazy ones of Dask included.

    The other arguments, ``settings``, are passed unchanged. Return the results named in ``outputs``
    as DataArrays.
    """
    names = tuple(arrays)
    keys = {**settings, "quantities": list(outputs)}

    def blockwise(*values: Any) -> Any:
        shape = np.broadcast_shapes(*map(np.shape, values))
        if 0 in shape:  # Dask calls the function once with empty arrays
            found = [np.zeros(shape) for _ in outputs]
        else:
            answers = evaluate(**dict(zip(names, values, strict=True)), **keys)
            found = [np.asarray(answers[name]) for name in outputs]
        return tuple(found) if len(found) > 1 else found[0]

    import xarray

    results = xarray.apply_ufunc(
        blockwise,
        *arrays.values(),
        output_core_dims=[()] * len(outputs),
        dask="parallelized",
        output_dtypes=[float] * len(outputs),
    )
    results = results if isinstance(results, tuple) else (results,)
    return dict(zip(outputs, results, strict=True))
