"""Base class of the height distributions."""

from __future__ import annotations

import math
import numbers
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, plain, show, sized
from microslip._core.errors import InputError
from microslip._core.parameters import Parametric, is_fully_declared, parameters_of

ORDERS = (-0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5)
"""Available orders of the partial moments."""


class HeightDistribution(Parametric, ABC):
    """Distribution of summit heights y [m]; heights are used as given, without removing their mean.

    A subclass defines ``_moment``, ``_density``, ``spread`` and ``span``; also ``edge`` if its
    density ends with a jump.
    """

    edge: float = -math.inf
    """Height [m] of the lower end of a bounded distribution, where the moments are not smooth."""

    def _scaled(self, factor: float) -> HeightDistribution:
        kind, factors = type(self), {"": 1.0, "m": factor, "1/m": factor**-1}
        declared = parameters_of(kind)
        if not is_fully_declared(kind) or any(item.unit not in factors for item in declared):
            raise InputError(
                f"{kind.__name__} must declare the units of all its parameters to be scaled, with "
                "field(metadata=parameter(...)), or give _scaled(factor)"
            )
        scaled = {item.name: getattr(self, item.name) * factors[item.unit] for item in declared}
        return replace(self, **scaled)  # type: ignore[type-var]

    @property
    def top(self) -> float:
        """Height [m] of the highest possible summit; infinite if unbounded."""
        return math.inf

    @property
    def _breaks(self) -> Floats:
        """Heights [m], increasing: kinks of moments and points near them, to split integrals."""
        return np.zeros(0)

    @property
    @abstractmethod
    def spread(self) -> float:
        """Standard deviation of the heights [m]; another measure of width if it is infinite."""

    _spread_name: ClassVar[str] = "spread of the heights"
    """Name of the spread if it is not the standard deviation; empty otherwise."""

    def _standardised(self, height: float) -> float | None:
        """Height above the mean or the lower end, over :attr:`spread` [-]; None by default."""
        return None

    @property
    @abstractmethod
    def span(self) -> tuple[float, float]:
        """Heights [m] between which practically all summits lie."""

    @abstractmethod
    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        """Partial moment of order ``twice_order/2`` at thresholds [m] of any shape."""

    def _moment_at(self, twice_order: int, threshold: float) -> float:
        return float(self._moment(twice_order, np.array([threshold]))[0])

    @abstractmethod
    def _density(self, height: Floats) -> Floats:
        """Probability density [1/m]."""

    def _below(self, height: Floats) -> Floats:
        """Probability that a summit height is at most ``height`` [m]."""
        return np.asarray(1.0 - self._moment(0, height))

    def partial_moment(self, order: float, threshold: ArrayLike) -> Any:
        """Partial moment: the integral of (y - threshold)^order pdf(y) over y > threshold.

        Divided by std^order it is F_n of Greenwood and Williamson (1966), DOI
        10.1098/rspa.1966.0242, with n the order. Orders 0, 1 and 3/2 occur in (19.5), (19.7) and
        (19.8) of chapter 19, DOI 10.1007/978-3-319-56818-8_19.

        Parameters
        ----------
        order : float
            One of -1/2, 0, 1/2, 1, 3/2, 2, 5/2.
        threshold : array_like
            Heights [m], any shape.

        Returns
        -------
        float or ndarray
            Moments [m^order], shape of ``threshold``.
        """
        if not isinstance(order, numbers.Real) or order not in ORDERS:
            raise InputError(
                f"`order` must be one of {', '.join(f'{n:g}' for n in ORDERS)}, got {show(order)}"
            )
        return plain(self._moment(int(2 * order), sized("threshold", threshold)))

    def probability_above(self, height: ArrayLike) -> Any:
        """Probability of a height above ``height`` [m] (19.5), for heights of any shape."""
        return plain(np.clip(self._moment(0, sized("height", height)), 0.0, 1.0))

    def cdf(self, height: ArrayLike) -> Any:
        """Probability that a summit height is at most ``height`` [m], any shape.

        For Gaussian heights it is (1 + erf((y - m)/(sigma sqrt(2))))/2; (19.26) has a misprint.
        """
        return plain(np.clip(self._below(sized("height", height)), 0.0, 1.0))

    def pdf(self, height: ArrayLike) -> Any:
        """Probability density [1/m] at ``height`` [m], any shape; (19.25) for Gaussian heights.

        Raises InputError for individually given heights, which have no density.
        """
        return plain(self._density(sized("height", height)))

    @classmethod
    def examples(cls) -> tuple[HeightDistribution, ...]:
        """Instances of the class for the shared tests; empty for an abstract class."""
        return ()
