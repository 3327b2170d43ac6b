"""Confidence intervals of an identified law over amplitude, as stored in a law file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, number, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip.friction.base import BackboneLaw

BANDED = ("force", "dissipated_energy", "damping_ratio")
"""Quantities with a confidence interval."""
_MOST = 10_000
_ROUNDED = 5.1e-6
"""Largest relative rounding of an amplitude written with six digits."""


@dataclass(frozen=True, eq=False)
class LawBand(Locked):
    """Confidence intervals of force, energy and damping of an identified law over its amplitudes.

    Parameters
    ----------
    amplitude : array_like
        Displacement amplitudes [m], increasing, at least two.
    ends : mapping
        Arrays of shape (2, amplitudes) for "force" [N], "dissipated_energy" [J] and "damping_ratio"
        [-]: lower and upper end of the interval at each amplitude.
    confidence : float
        Confidence level of each single interval [-], between 0 and 1.
    """

    amplitude: NDArray[np.float64]
    ends: Mapping[str, NDArray[np.float64]]
    confidence: float

    def __init__(self, amplitude: ArrayLike, ends: Mapping[str, Any], confidence: float) -> None:
        a = floats("amplitude", amplitude, "m")
        if a.ndim != 1 or not 2 <= a.size <= _MOST or not np.all(np.diff(a, prepend=0.0) > 0.0):
            raise InputError(
                f"`amplitude` must hold 2 to {_MOST} amplitudes above zero [m], increasing, got "
                f"{show(amplitude)}"
            )
        if set(ends) != set(BANDED):
            raise InputError(f"`ends` must have {', '.join(BANDED)}, got {show(sorted(ends))}")
        arrays = {name: floats("ends", ends[name], endless=True) for name in BANDED}
        for name, values in arrays.items():
            if values.shape != (2, a.size) or not np.all(values[0] <= values[1]):
                raise InputError(
                    f"`ends` of {name} must be a lower and an upper end at each of the {a.size} "
                    f"amplitudes, got an array of shape {values.shape}"
                )
        level = number("confidence", confidence, "", 0.95)
        if not 0.0 < level < 1.0:
            raise InputError(f"`confidence` must be between 0 and 1, got {level:g}")
        locked = MappingProxyType({name: lock(values.copy()) for name, values in arrays.items()})
        assign(self, amplitude=lock(a.copy()), ends=locked, confidence=level)

    def of(self, law: BackboneLaw, amplitude: ArrayLike) -> dict[str, Floats]:
        """Interpolate the intervals to other amplitudes; NaN outside the range of the band.

        The distances of both ends from the value of the law are interpolated over the logarithm of
        the amplitude, so the interval always contains the value of the law.

        Parameters
        ----------
        law : BackboneLaw
            The law of this band.
        amplitude : array_like
            Displacement amplitudes [m], one-dimensional.

        Returns
        -------
        dict of ndarray
            Array of shape (2, amplitudes) for each quantity, in its unit.
        """
        at = np.asarray(amplitude, dtype=float)
        known, wanted = (_values(law, a) for a in (self.amplitude, at))
        inside = (at >= self.amplitude[0] * (1 - _ROUNDED)) & (
            at <= self.amplitude[-1] * (1 + _ROUNDED)
        )
        result = {}
        for name, ends in self.ends.items():
            # Relative to scales that are never zero; an energy may be zero.
            distance = np.abs(ends - known[name]) / known[f"{name} scale"]
            apart = np.array([np.interp(np.log(at), np.log(self.amplitude), d) for d in distance])
            apart *= wanted[f"{name} scale"] * np.array([[-1.0], [1.0]])
            result[name] = np.where(inside, wanted[name] + apart, np.nan)
            np.maximum(result[name], 0.0, out=result[name], where=inside)
        return result

    @property
    def content(self) -> dict[str, Any]:
        """Entries of the band in a law file, as lists and numbers."""
        ends = {name: values.tolist() for name, values in self.ends.items()}
        return {"confidence": self.confidence, "amplitude": self.amplitude.tolist(), **ends}

    @classmethod
    def of_content(cls, content: Any) -> LawBand:
        """Create a band from its entries in a law file."""
        wanted = {"confidence", "amplitude", *BANDED}
        if not isinstance(content, dict) or set(content) != wanted:
            raise InputError(f"band must have {', '.join(sorted(wanted))}, got {show(content)}")
        ends = {name: content[name] for name in BANDED}
        return cls(content["amplitude"], ends, content["confidence"])


def _values(law: BackboneLaw, a: Floats) -> dict[str, Floats]:
    force = np.asarray(law.backbone(a))
    return {
        "force": force,
        "force scale": force,
        "dissipated_energy": np.asarray(law.dissipated_energy(a)),
        "dissipated_energy scale": a * force,
        "damping_ratio": np.asarray(law.damping_ratio(a)),
        "damping_ratio scale": np.ones_like(a),
    }
