"""Floor 8: whether SciPy has a distribution by that name, and takes its parameters."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from microslip._core.wording import did_you_mean, quoted, shorten, show
from microslip.errors import InputError
from microslip.heights import Statistical
from microslip.study.part import KeyedError

_KEY = "surface.heights"
_ALSO_CALLED = {
    "gaussian": "norm",
    "normal": "norm",
    "exponential": "expon",
    "lognormal": "lognorm",
    "weibull": "weibull_min",
}


def names() -> list[str]:
    """Names of the continuous distributions of scipy.stats."""
    from scipy import stats

    return [name for name in dir(stats) if isinstance(getattr(stats, name), stats.rv_continuous)]


def frozen(name: str, parameters: Mapping[str, float], location: float, scale: float) -> Any:
    """The frozen distribution of scipy.stats, heights in metres."""
    from scipy import stats

    return getattr(stats, name)(**parameters, loc=location, scale=scale)


def check(name: str, parameters: Mapping[str, float], location: float, scale: float) -> None:
    """Raise a KeyedError about heights of kind "scipy" that are none, or have no finite load."""
    from scipy import stats

    distribution = getattr(stats, name, None)
    if not isinstance(distribution, stats.rv_continuous):
        raise KeyedError(f"{_KEY}.distribution", f"wanted {_expected_name(name, distribution)}")
    shapes = distribution.shapes.replace(",", " ").split() if distribution.shapes else []
    _check_names(name, shapes, parameters)
    of = f"{name} with {_values(parameters)}" if parameters else name
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            heights = frozen(name, parameters, location, scale)
            # SciPy says no by a support that is no number.
            if any(map(math.isnan, heights.support())):
                raise ValueError("out of their range")
        except Exception as error:  # whatever its functions meet
            fault = f"wanted values that scipy.stats.{name} takes, got {_values(parameters)}"
            raise KeyedError(f"{_KEY}.parameters", f"{fault} ({_reason(error)})") from None
        try:
            Statistical(heights)
        except InputError as error:
            message = str(error).removeprefix("heights must have ")
            raise KeyedError(_KEY, f"wanted {message} ({of})") from None
        except Exception as error:
            raise KeyedError(_KEY, f"SciPy fails for {of}: {_reason(error)}") from None


def _expected_name(name: str, candidate: Any) -> str:
    from scipy import stats

    example = 'a continuous distribution of scipy.stats such as "weibull_min"'
    if isinstance(candidate, stats.rv_discrete):
        return f"{example}, got {show(name)} (a discrete one)"
    synonym = _ALSO_CALLED.get(name.casefold())
    return f"{example}, got {show(name)}{did_you_mean(synonym or name, names())}"


def _check_names(name: str, shapes: list[str], parameters: Mapping[str, float]) -> None:
    has = f'"{name}" has no shape parameters'
    if shapes:
        has = f'"{name}" has the shape parameter{"s" * (len(shapes) > 1)} {quoted(shapes, "and")}'
    for key in parameters:
        if key in ("loc", "scale"):
            study_key = "location" if key == "loc" else "scale"
            raise KeyedError(
                f"{_KEY}.parameters.{key}",
                f'wanted {study_key} = "1 um" beside distribution instead',
            )
        if key not in shapes:
            hint = did_you_mean(key, shapes) or f"; {has}"
            raise KeyedError(f"{_KEY}.parameters.{shorten(key, 40)}", f"unknown parameter{hint}")
    for key in shapes:
        if key not in parameters:
            raise KeyedError(f"{_KEY}.parameters.{key}", f"missing; {has}")


def _values(parameters: Mapping[str, float]) -> str:
    return ", ".join(f"{key} = {value:g}" for key, value in parameters.items())


def _reason(error: Exception) -> str:
    return shorten(" ".join(str(error).split()) or type(error).__name__, 120)
