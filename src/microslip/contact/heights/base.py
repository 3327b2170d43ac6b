"""Interface of a height distribution to the laws that use it."""

from __future__ import annotations

import math
import numbers
from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, plain, show, sized
from microslip._core.errors import InputError
from microslip._core.parameters import Parametric, is_fully_declared, rescaled, values_of

TWICE_ORDERS: Mapping[float, int] = MappingProxyType({k / 2: k for k in range(-1, 6)})
"""Orders n of the partial moments that exist here, with twice their value."""


class HeightDistribution(Parametric, ABC):
    """Distribution of summit heights y about a zero of its own, which is never recentred.

    A subclass gives ``_moment``, ``_density``, ``spread`` and ``span``; where its density ends
    abruptly, also ``edge``.
    """

    edge: float = -math.inf
    """Height [m] of the lower end of a bounded distribution: the moments are not smooth there."""

    def _scaled(self, factor: float) -> HeightDistribution:
        """The distribution of ``factor`` times the heights, by the units of its parameters."""
        kind = type(self)
        if not is_fully_declared(kind):
            raise InputError(
                f"{kind.__name__} must say the units of all its parameters to be scaled, with "
                "field(metadata=parameter(...)), or give _scaled(factor)"
            )
        scaled: HeightDistribution = kind(**rescaled(kind, values_of(self), 1.0, factor))
        return scaled

    @property
    def top(self) -> float:
        """Height [m] of the highest summit there can be; infinite where there is no such end."""
        return math.inf

    @property
    def _breaks(self) -> Floats:
        """Heights [m], rising, at which the moments are not smooth, the edge among them."""
        return np.zeros(0)

    @property
    @abstractmethod
    def spread(self) -> float:
        """Standard deviation of the heights [m], or what stands for it where that is infinite."""

    _spread_name: ClassVar[str] = "spread of the heights"
    """Name of the spread where it scales something else; empty where it never does."""

    def _standardised(self, height: float) -> float | None:
        """A height over the spread, from where that counts; None where nobody counts so."""
        return None

    @property
    @abstractmethod
    def span(self) -> tuple[float, float]:
        """Heights [m] below and above which there is next to nothing."""

    @abstractmethod
    def _moment(self, twice_order: int, threshold: Floats) -> Floats:
        """Partial moment of the order ``twice_order/2`` at thresholds of any shape."""

    def _moment_at(self, twice_order: int, threshold: float) -> float:
        """The same at one threshold."""
        return float(self._moment(twice_order, np.array([threshold]))[0])

    @abstractmethod
    def _density(self, height: Floats) -> Floats:
        """Probability density [1/m]."""

    def _below(self, height: Floats) -> Floats:
        """Probability of a summit that is not higher."""
        return np.asarray(1.0 - self._moment(0, height))

    def partial_moment(self, order: float, threshold: ArrayLike) -> Any:
        """Partial moment: the mean of (y - threshold)^order over the heights above ``threshold``.

        Divided by std^order it is the F_n of Greenwood and Williamson (1966),
        DOI 10.1098/rspa.1966.0242; order 0 gives (19.5), 1 gives (19.7), 3/2 gives (19.8).

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
        if not isinstance(order, numbers.Real) or order not in TWICE_ORDERS:
            raise InputError(
                f"`order` must be one of {', '.join(f'{n:g}' for n in TWICE_ORDERS)}, got "
                f"{show(order)}"
            )
        return plain(self._moment(TWICE_ORDERS[order], sized("threshold", threshold)))

    def probability_above(self, height: ArrayLike) -> Any:
        """Probability of a summit above ``height`` [m] (19.5), any shape; errors as :meth:`cdf`."""
        return plain(np.clip(self._moment(0, sized("height", height)), 0.0, 1.0))

    def cdf(self, height: ArrayLike) -> Any:
        """Probability that a summit is not higher than ``height`` [m], any shape.

        For Gaussian heights it is (19.26), corrected: (1 + erf((y - m)/(sigma sqrt(2))))/2.
        """
        return plain(np.clip(self._below(sized("height", height)), 0.0, 1.0))

    def pdf(self, height: ArrayLike) -> Any:
        """Probability density [1/m] at ``height`` [m], any shape; Gaussian heights: (19.25).

        Errors as :meth:`cdf`; heights given one by one have none.
        """
        return plain(self._density(sized("height", height)))

    @classmethod
    def examples(cls) -> tuple[HeightDistribution, ...]:
        """Instances that stand for the class in the shared tests; none for an abstract one."""
        return ()
