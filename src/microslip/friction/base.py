"""Base class of friction laws: all results follow from the first loading curve of the law.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, plain, record
from microslip._core.frozen import lock
from microslip._core.kernels.pieces import Pieces, backbone_pieces
from microslip._core.parameters import Parametric
from microslip.contact.load_curve import LoadCurve
from microslip.friction.cycle_measures import CycleMeasures
from microslip.friction.cycles import PeriodicResponse, Rest, settled_cycle
from microslip.friction.harmonics import HarmonicForce, harmonic_force
from microslip.friction.memory import Memory, State
from microslip.friction.sliders import Sliders


class BackboneLaw(CycleMeasures, Parametric):
    """Friction law that obeys Masing's rules, fully defined by its first loading curve T0.

    A subclass defines :meth:`_backbone`, :meth:`_slope` and :attr:`force_limit`. All other methods
    have defaults, which a subclass overrides if it has a closed form. The force T is positive if it
    acts in the direction of a positive displacement from rest.
    """

    _to_iwan: ClassVar[Callable[..., Any]]
    """Conversion to Iwan cells; the module `friction.conversions` sets it."""

    # -- defaults that a subclass may override ------------------------------------------------

    @property
    def _harmonic_parts(self) -> tuple[BackboneLaw, ...]:
        """Laws whose harmonics are integrated one by one and added; the law itself by default."""
        return (self,)

    @cached_property
    def _pieces(self) -> Pieces | None:
        """Force limit minus T0 [N], as polynomials of the displacement between kinks.

        The harmonics of a law without `_table` are integrated from them. None if the law is rigid
        at rest, or needs too many polynomials to reach its force limit.
        """
        stiffness = self.tangential_stiffness
        if not (math.isfinite(stiffness) and stiffness > 0.0):
            return None
        return backbone_pieces(
            self._backbone, self._slope, self._kinks, self.force_limit, stiffness
        )

    @property
    def _load_curve(self) -> LoadCurve | None:
        """Normal load N over separation d of the surface, or None for a law without a surface."""
        return None

    def _slider_density(self, u: Floats) -> Floats:
        """Density of sliders -T0'' [N/m^2], by default from central differences of T0'."""
        scale = self.force_limit / self.tangential_stiffness
        step = 1e-5 * np.maximum(u, scale)
        low = np.maximum(u - step, 0.0)
        return (self._slope(low) - self._slope(u + step)) / (u + step - low)

    # -- backbone -----------------------------------------------------------------------------

    def backbone(self, displacement: ArrayLike) -> Any:
        """Compute the first loading curve T0 from rest, odd in the displacement.

        For one asperity T0 is (19.10) and (19.15), for an interface their sum (19.28).

        Parameters
        ----------
        displacement : array_like
            Displacements [m], any shape.

        Returns
        -------
        float or ndarray
            Forces [N], shape of ``displacement``.
        """
        x = floats("displacement", displacement, "m")
        force = np.copysign(self._backbone(np.abs(x).reshape(-1)).reshape(x.shape), x)
        return plain(force, displacement)

    def backbone_stiffness(self, displacement: ArrayLike) -> Any:
        """Tangent stiffness T0' [N/m] of the backbone at displacements [m] of any shape."""
        x = floats("displacement", displacement, "m")
        return plain(self._slope(np.abs(x).reshape(-1)).reshape(x.shape), displacement)

    def backbone_displacement(self, force: ArrayLike) -> Any:
        """Invert the backbone: return the displacements [m] at given forces [N] of any shape."""
        f = self._below_limit("force", floats("force", force, "N"))
        displacement = np.copysign(self._inverse(np.abs(f).reshape(-1)).reshape(f.shape), f)
        return plain(displacement, force)

    # -- histories ------------------------------------------------------------------------------

    def start(self, *, depth: int | None = None) -> State:
        """Return a state at rest, which advances by single steps or by chunks of a record.

        Parameters
        ----------
        depth : int, optional
            Largest number of rows of the memory diagram [-], at least four; only for an interface.
            There is about one row for each reversal that still affects the force. Further rows are
            merged; ``State.error_bound`` bounds the resulting force error. Unlimited by default.
        """
        return State(self, depth)

    def force(self, displacement: ArrayLike) -> Any:
        """Compute the force along any displacement record, from rest, with exact memory.

        Parameters
        ----------
        displacement : array_like
            Displacements [m] in time order, one-dimensional.

        Returns
        -------
        ndarray or float
            Forces [N], one for each sample.

        Notes
        -----
        Chapter 19 (DOI 10.1007/978-3-319-56818-8_19) gives the branches: first loading (19.19),
        unloading (19.20), (19.23) and reloading (19.21), with sliding (19.15)-(19.17). Its
        misprints are corrected here. Inner loops, their closure and the return to the first loading
        curve, which the chapter omits, follow the rules of Masing and Madelung. The cost is O(1)
        per sample, independent of the number of asperities.
        """
        x = record("displacement", displacement, "m")
        # A state would also accumulate the dissipated energy, which costs 50 % more time.
        result = Memory().respond(x.reshape(-1), self._backbone, self._table)
        return plain(result.reshape(x.shape), displacement)

    def displacement(self, force: ArrayLike) -> Any:
        """Compute displacements [m] along any force record [N]: inverse of :meth:`force`.

        The record is one-dimensional, in time order, and begins at rest. InputError is raised
        unless the magnitudes of all forces are below the force limit.
        """
        f = self._below_limit("force", record("force", force, "N"))
        result = Memory().respond(f.reshape(-1), self._inverse, None)
        return plain(result.reshape(f.shape), force)

    def periodic(self, displacement_cycle: ArrayLike, rest: Rest = 0.0) -> PeriodicResponse:
        """Compute the settled cycle of a periodic displacement, reached after one period from rest.

        Parameters
        ----------
        displacement_cycle : array_like
            One period of displacements [m], one-dimensional, its first sample not repeated.
        rest : float or "mean", optional
            Displacement [m] at which the joint was free of force before the cycle, or "mean" for
            the mean of the cycle. The mean force of the settled cycle depends on it. The default 0
            agrees with :meth:`force` and with most codes.

        Returns
        -------
        PeriodicResponse
            ``force`` [N] and ``stiffness`` [N/m] of each sample; ``parent``, the index of the
            reversal at which the branch of each sample began; ``root``, the index of the sample
            farthest from rest; and the method ``derivative``.
        """
        return settled_cycle(self, displacement_cycle, rest)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        rest: Rest = 0.0,
        *,
        rtol: float = 1e-10,
    ) -> HarmonicForce:
        """Compute Fourier coefficients of the force in the settled cycle, with their Jacobian.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of the displacement [m] in the order of ``harmonics``, one-dimensional:
            [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        harmonics : sequence of int, optional
            Orders of the harmonics, increasing; 0 is the mean.
        rest : float or "mean", optional
            As for :meth:`periodic`.
        rtol : float, optional
            Tolerance of the coefficients relative to the largest force of the cycle [-]. That of
            the Jacobian, relative to the largest stiffness, is a hundred times larger.

        Returns
        -------
        HarmonicForce
            ``force`` [N] and ``jacobian`` [N/m]: rows are force coefficients, columns displacement
            coefficients.

        Notes
        -----
        For the harmonic balance method. The cycle is not sampled: it is cut at turning points, at
        closures of inner loops and at the kinks of the law, and each smooth piece is integrated.
        First loading ends at the displacement farthest from rest. If the largest and the smallest
        displacement are equally far from rest, the largest is chosen; the derivative with respect
        to the mean depends on this choice. For a constant displacement the Jacobian is the limit
        for cycles of vanishing amplitude.
        """
        parts = [
            harmonic_force(law, coefficients, harmonics, rest, rtol) for law in self._harmonic_parts
        ]
        if len(parts) == 1:
            return parts[0]
        force, jacobian = (np.asarray(sum(part)) for part in zip(*parts, strict=True))
        return HarmonicForce(force, jacobian)

    @property
    def _kinks(self) -> Floats:
        """Displacements [m], increasing, at which the backbone is not smooth."""
        return np.unique(self.sliders().yield_displacements)

    def sliders(self) -> Sliders:
        """Return the sliders of the equivalent Iwan model (Iwan 1966, DOI 10.1115/1.3625199).

        Sliders are continuous, with a density -T0'' [N/m^2] as a function of the yield displacement
        [m], or discrete, each with a stiffness [N/m], or both.
        """
        nothing = lock(np.zeros(0))
        return Sliders(nothing, nothing, self._slider_density)

    # -- other models of the same law -----------------------------------------------------------

    def to_iwan(
        self,
        cells: int,
        *,
        smallest_amplitude: float | None = None,
        largest_amplitude: float | None = None,
    ) -> Any:
        """Convert to a parallel Iwan model (Iwan 1966, DOI 10.1115/1.3625199) with given cells.

        Parameters
        ----------
        cells : int
            Number of cells [-], 1 to 10 million. A law with fewer sliders gives fewer cells.
        smallest_amplitude, largest_amplitude : float, optional
            Range of amplitudes [m] over which the relative error is made uniform. If only one end
            is given, the other defaults to 0.01 or 10 times the displacement force_limit /
            tangential_stiffness. With 50 cells over three decades the error of the energy is at
            most 1.5 %; it decreases with the inverse square of the number of cells. The attribute
            ``fit`` of the result holds the errors over the range.

        Returns
        -------
        Iwan
            Cells whose stiffness at rest and force limit equal those of the law. Their backbone is
            the polygon formed by the tangents of T0 at ``cells`` displacements, nowhere below T0.
            Cycles too small for the first cell to yield dissipate nothing. Without a range the
            force error is uniform over displacement.
        """
        return self._to_iwan(cells, smallest_amplitude, largest_amplitude)

    @classmethod
    def examples(cls) -> tuple[Self, ...]:
        """Return instances used by the shared tests; empty for an abstract class."""
        return ()
