"""Friction laws, each defined by its backbone, from which everything else follows."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, plain, record
from microslip._core.frozen import lock
from microslip._core.inversion import adaptive, invert
from microslip._core.kernels.pieces import Pieces, backbone_pieces
from microslip._core.kernels.table import Table
from microslip._core.parameters import Parametric, parameters_of
from microslip._core.quadrature import gauss_legendre
from microslip.contact.load_curve import LoadCurve
from microslip.friction.cycle_measures import CycleMeasures
from microslip.friction.cycles import PeriodicResponse, Rest, settled_cycle
from microslip.friction.guesses import guessed_law
from microslip.friction.harmonics import HarmonicForce, harmonic_force
from microslip.friction.memory import Memory, State
from microslip.friction.parameter_derivatives import (
    DerivativeBackbone,
    derivatives_by_parameters,
)
from microslip.friction.sliders import Sliders

_NODES, _WEIGHTS = gauss_legendre(16)

Self = TypeVar("Self", bound="BackboneLaw")


class BackboneLaw(CycleMeasures, Parametric, ABC):
    """A tangential law that obeys Masing's rules, fully given by its first loading curve T0.

    A subclass gives :meth:`_backbone`, :meth:`_slope` and :attr:`force_limit`; all else has a
    default, which a subclass replaces where it knows better. ``T`` is the force needed to hold a
    positive displacement.
    """

    # Other models of the same law by their names; `friction.conversions` makes them.
    _conversions: ClassVar[dict[str, Callable[..., Any]]] = {}

    # -- what a law gives ---------------------------------------------------------------------

    @abstractmethod
    def _slope(self, u: Floats) -> Floats:
        """T0' [N/m] for displacements u >= 0 [m], one-dimensional."""

    # -- what a law may give better -----------------------------------------------------------

    @property
    def _table(self) -> Table | None:
        """The backbone as a table, where one pays."""
        return None

    @cached_property
    def _pieces(self) -> Pieces | None:
        """The backbone cut at its kinks, for harmonics of a law without a table.

        None of a law that is rigid at rest, or whose force limit lies too far out.
        """
        stiffness = self.tangential_stiffness
        if not (math.isfinite(stiffness) and stiffness > 0.0):
            return None
        return backbone_pieces(
            self._backbone, self._slope, self._kinks, self.force_limit, stiffness
        )

    @property
    def _coupling(self) -> LoadCurve | None:
        """The load curve on which a load may vary; None for a law without a surface."""
        return None

    def _backbone_and_slope(self, u: Floats) -> tuple[Floats, Floats]:
        """Both, the slope only as good as Newton's method needs it."""
        table = self._table
        if table is None:
            return self._backbone(u), self._slope(u)
        return table.value_and_slope(u)

    def _backbone_at(self, u: float) -> tuple[float, float]:
        """Both at one place, each as good as for many."""
        place = np.array([u])
        return float(self._backbone(place)[0]), float(self._slope(place)[0])

    def _inverse(self, force: Floats) -> Floats:
        """U >= 0 at which T0 has the values ``force``, 0 <= force < limit, one-dimensional."""
        low = force / self.tangential_stiffness
        # T0 is concave: it lies below its first tangent, so the answer is not below `low`.
        high = np.maximum(low, self.force_limit / self.tangential_stiffness)
        reached = np.zeros_like(high)
        for _ in range(1000):
            before, reached = reached, self._backbone(high)
            # A limit may round to a last place less than the force asked for: stop there, too.
            short = (reached < force) & (reached > before)
            if not short.any():
                break
            low = np.where(short, high, low)
            high = np.where(short, 2.0 * high, high)
        return invert(self._backbone_and_slope, force, low, high)

    def _energy(self, amplitude: Floats) -> Floats:
        """Energy of a closed cycle [J] for amplitudes >= 0, one-dimensional.

        The default integrates dE_d/da = 4 (T0 - a T0'), adaptively, since a law may have kinks.
        """

        # Finer than the rounding of T0 - a T0' nothing is found out: small amplitudes would be
        # halved for ever.
        def noise(low: Floats, high: Floats) -> Floats:
            return 4e-15 * self._backbone(high) * (high - low)

        return adaptive(lambda a, _: self._energy_slope(a), amplitude, 1e-14, 60, noise)

    def _energy_slope(self, amplitude: Floats) -> Floats:
        """Derivative of :meth:`_energy` [N]."""
        value, slope = self._backbone(amplitude), self._slope(amplitude)
        return 4.0 * np.maximum(value - amplitude * slope, 0.0)

    def _parameter_derivatives(self, u: Floats) -> Floats | None:
        """T0 by each parameter (parameters, places), u >= 0 [m]; None where differences must do."""
        return None

    def _derivative_backbones(self) -> Mapping[str, DerivativeBackbone]:
        """DT0/dp of each parameter that is known exactly; none where differences must do."""
        if self._parameter_derivatives(np.zeros(1)) is None:
            return {}
        names = [item.name for item in parameters_of(type(self))]

        def derivative_of(i: int) -> DerivativeBackbone:
            def backbone(u: Floats) -> Floats:
                by_values = self._parameter_derivatives(u)
                return np.asarray(by_values[i])  # type: ignore[index]

            def energy(a: Floats) -> Floats:
                area = np.zeros_like(a)
                cuts = np.concatenate(([0.0], self._kinks, [np.inf]))
                for low, high in itertools.pairwise(cuts.tolist()):
                    begin, end = np.minimum(low, a), np.minimum(high, a)
                    places = begin[:, None] + (end - begin)[:, None] * _NODES
                    values = backbone(places.reshape(-1)).reshape(places.shape)
                    area += (end - begin) * (values @ _WEIGHTS)
                return 8.0 * area - 4.0 * a * backbone(a)

            value = abs(float(getattr(self, names[i])))
            return DerivativeBackbone(backbone, energy, self._kinks, 1.0 / max(value, 1e-3))

        return {name: derivative_of(i) for i, name in enumerate(names)}

    _quantities: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Properties that follow from the parameters and are worth telling, with their units."""

    def _slider_density(self, u: Floats) -> Floats:
        """-T0'' [N/m^2]; the default by central differences of the slope."""
        scale = self.force_limit / self.tangential_stiffness
        step = 1e-5 * np.maximum(u, scale)
        low = np.maximum(u - step, 0.0)
        return (self._slope(low) - self._slope(u + step)) / (u + step - low)

    # -- backbone -----------------------------------------------------------------------------

    @cached_property
    def tangential_stiffness(self) -> float:
        """Stiffness at rest T0'(0) [N/m]."""
        return float(self._slope(np.zeros(1))[0])

    def backbone(self, displacement: ArrayLike) -> Any:
        """Compute the first loading curve T0 from rest, odd in the displacement.

        For one asperity it is (19.10) and (19.15), for an interface their sum (19.28).

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
        """Displacement [m] at which the backbone reaches forces [N] of any shape: its inverse."""
        f = self._below_limit("force", floats("force", force, "N"))
        displacement = np.copysign(self._inverse(np.abs(f).reshape(-1)).reshape(f.shape), f)
        return plain(displacement, force)

    # -- histories ------------------------------------------------------------------------------

    def start(
        self, arrays: Mapping[str, ArrayLike] | None = None, *, depth: int | None = None
    ) -> State:
        """A state at rest, to be advanced sample by sample or piece by piece.

        Parameters
        ----------
        arrays : mapping of str to array_like, optional
            What :meth:`microslip.State.to_arrays` gave [m, N, J], shapes there; or what
            ``numpy.load`` reads of it. The state goes on from there, with its depth.
        depth : int, optional
            Rows of memory [-] that are kept, four at least, of an interface: what is older is
            lumped, and ``error_bound`` says what it may cost. Without it all is remembered.
        """
        return State(self, depth) if arrays is None else State.from_arrays(self, arrays)

    def force(self, displacement: ArrayLike) -> Any:
        """Compute the force along any displacement record, from rest, with exact memory.

        First loading (19.19), unloading (19.20), (19.23), and reloading (19.21), with sliding
        (19.15)-(19.17), for any record and in their corrected form. Minor loops, wiping-out and
        the return to the first loading curve follow Masing's and Madelung's rules, so the cost is
        O(1) a sample, whatever the number of asperities.

        Parameters
        ----------
        displacement : array_like
            Displacements [m] in the order of time, one-dimensional.

        Returns
        -------
        ndarray or float
            Forces [N], one for each sample.
        """
        x = record("displacement", displacement, "m")
        # A state would also count what is lost on the way, which takes half as long again.
        result = Memory().respond(x.reshape(-1), self._backbone, self._table)
        return plain(result.reshape(x.shape), displacement)

    def displacement(self, force: ArrayLike) -> Any:
        """Displacement [m] along any force record [N], from rest: the inverse of :meth:`force`.

        The record is as :meth:`force` has it, but below the force limit in size.
        """
        f = self._below_limit("force", record("force", force, "N"))
        result = Memory().respond(f.reshape(-1), self._inverse, None)
        return plain(result.reshape(f.shape), force)

    def periodic(self, displacement_cycle: ArrayLike, rest: Rest = 0.0) -> PeriodicResponse:
        """The settled cycle of a periodic displacement: what it is after one pass from rest.

        Parameters
        ----------
        displacement_cycle : array_like
            One period of displacements [m], one-dimensional, its first sample not repeated.
        rest : float or "mean", optional
            Displacement [m] at which the joint began, without force; or the mean of the cycle. The
            settled mean force depends on it: codes differ, so say which. From zero is what most
            take, and what :meth:`force` does.

        Returns
        -------
        PeriodicResponse
            ``force`` [N], ``stiffness`` [N/m], ``parent`` and ``root``, and its ``derivative``.
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
        """Fourier coefficients of the settled force with their Jacobian: harmonic balance.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of the displacement [m] in the order of ``harmonics``, one-dimensional:
            [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        harmonics : sequence of int, optional
            Numbers of the harmonics, rising; 0 is the mean.
        rest : float or "mean", optional
            As for :meth:`periodic`.
        rtol : float, optional
            Error of the coefficients [-] over the largest force; the Jacobian's over the stiffness
            is a hundred times that.

        Returns
        -------
        HarmonicForce
            ``force`` [N] and ``jacobian`` [N/m], force coefficients (rows) by those of the
            displacement (columns).

        Notes
        -----
        There are no samples: the smooth pieces of the cycle are integrated one by one, between
        turning points and where inner loops close, and cut at the kinks of the law. Where two
        displacements of largest size tie, in a cycle about zero, the derivative by the mean is that
        of the positive one; a displacement that does not move has the tangents of small cycles.
        """
        return harmonic_force(self, coefficients, harmonics, rest, rtol)

    def parameter_derivatives(
        self,
        quantity: str,
        at: ArrayLike,
        names: Sequence[str] | None = None,
        *,
        harmonics: Any = (0, 1),
        rest: Rest = 0.0,
    ) -> dict[str, Any]:
        """Exact derivatives of what the law does by its parameters.

        Parameters
        ----------
        quantity : str
            ``backbone``, ``force`` (along a history), ``periodic`` (the settled force), or
            ``harmonics`` [N]; ``dissipated_energy`` [J], ``secant_stiffness`` [N/m],
            ``loss_factor`` or ``damping_ratio`` [-] of a closed cycle.
        at : array_like
            Displacements or amplitudes [m] of any shape; histories, cycles or coefficients [m]
            along the last axis, a row each of any number.
        names : sequence of str, optional
            Parameters; all without it. Those of an :class:`microslip.Interface` are
            friction_coefficient and normal_load, and of its Greenwood-Williamson surface std (all
            heights times a number), radius, density, area, young_modulus and poisson_ratio, of
            both bodies or of the first, with other_young_modulus and other_poisson_ratio.
        harmonics, rest
            As of :meth:`harmonics`.

        Returns
        -------
        dict of str to float or ndarray
            Derivatives a unit of each parameter, in the shape of ``at``. An interface keeps its
            load: its separation moves with what it is made of.

        Notes
        -----
        All of these are linear in the backbone, along branches that depend on the displacement
        alone (Masing's rules; Jaeger 1998, DOI 10.1115/1.2833765): they are those of the law whose
        backbone is dT0/dp.
        """
        return derivatives_by_parameters(self, quantity, at, names, harmonics, rest)

    @property
    def _kinks(self) -> Floats:
        """Displacements [m], rising, at which the backbone is not smooth."""
        return np.unique(self.sliders().yield_displacements)

    def sliders(self) -> Sliders:
        """The law as a parallel Iwan model (Iwan 1966, DOI 10.1115/1.3625199).

        A density of sliders -T0'' [N/m^2] over their yield displacement [m], discrete ones, or
        both.
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
    ) -> CellModel:
        """The law as a parallel Iwan model (Iwan 1966, DOI 10.1115/1.3625199) of some cells.

        Parameters
        ----------
        cells : int
            Number of cells [-], 1 to 10 million; fewer come back where the law has fewer sliders.
        smallest_amplitude, largest_amplitude : float, optional
            Range of amplitudes [m] that the cells are for. With it (one of them will do; the other
            is then 0.01 or 10 times the displacement at which the first tangent meets the force
            limit) small cycles are met as well as large ones: 50 cells over three decades err by
            up to 1.5 % of the energy, and by the inverse square of their number. The ``fit`` of
            what comes back has the errors over the range.

        Returns
        -------
        Iwan
            Cells that hold the stiffness at rest and the force limit exactly. Their backbone is
            the polygon of tangents at ``cells`` places: nowhere below the law, above it by an
            error that falls with the square of the number of cells. Cycles too small for the
            first cell to yield cost them nothing; without a range the places make the errors of
            the force even, and the first cell yields late.
        """
        model: CellModel = self._conversions["iwan"](
            self, cells, smallest_amplitude, largest_amplitude
        )
        return model

    def to_segalman(
        self, smallest_amplitude: float | None = None, largest_amplitude: float | None = None
    ) -> SegalmanFit:
        """The four-parameter model of Segalman (2005, DOI 10.1115/1.1989354) closest to the law.

        Its force limit and its stiffness at rest are those of the law. Its chi and beta make the
        dissipated energies agree best: least squares of their logarithms at 61 amplitudes [m],
        spread evenly on a logarithmic scale over a range: without one, from 0.01 to 10 times the
        displacement at which the first tangent meets the force limit. What comes back is the model,
        ``law``, and its ``misfit``.
        """
        fit: SegalmanFit = self._conversions["segalman"](
            self, smallest_amplitude, largest_amplitude
        )
        return fit

    @classmethod
    def guess(cls: type[Self], data: Any) -> Self:
        """A law to start a fit from.

        The default serves any law that says its parameters with units of newtons and metres: it
        draws the shapes of its examples through the branches, and settles what else there is by
        least squares.

        Parameters
        ----------
        data : Loop, Record or sequence of such
            Measured data: displacement [m] and force [N], at least one closed cycle each.

        Returns
        -------
        BackboneLaw
            An instance of the law.
        """
        law: Self = guessed_law(cls, data)
        return law

    @classmethod
    def examples(cls: type[Self]) -> tuple[Self, ...]:
        """Instances that stand for the class in the shared tests; none for an abstract one."""
        return ()


class CellModel(BackboneLaw):
    """A law of springs with sliders side by side, which :class:`Iwan` is."""

    if TYPE_CHECKING:

        @property
        def stiffnesses(self) -> ArrayLike:
            """Stiffness of the spring of each cell [N/m]."""

        @property
        def force_limits(self) -> ArrayLike:
            """Force at which each of them slips [N]."""

        @property
        def cell_count(self) -> int:
            """Number of cells."""

        @property
        def fit(self) -> Any:
            """Accuracy of the cells over a range of amplitudes; None where none was asked for."""


class PowerModel(BackboneLaw):
    """A law whose sliders are dense as a power, which :class:`SegalmanIwan` is."""

    if TYPE_CHECKING:

        @property
        def stiffness(self) -> float:
            """Stiffness at rest [N/m]."""

        @property
        def chi(self) -> float:
            """Exponent of the density."""

        @property
        def beta(self) -> float:
            """Stiffness of the last slider over that of all others."""


class SegalmanFit(NamedTuple):
    """The four-parameter model (DOI 10.1115/1.1989354) closest to a law, and how close that is."""

    law: PowerModel
    """The model, a :class:`SegalmanIwan`: force limit and stiffness at rest are those of the law
    fitted."""
    misfit: float
    """Root mean square of ln(E_d of the model / E_d of the law) over the amplitudes [-]."""
    largest_misfit: float
    """Largest size of that logarithm [-]."""
    force_misfit: float
    """Largest difference of the backbones over the amplitudes, of the force limit [-]."""
    smallest_amplitude: float
    """Smallest amplitude at which the energies were compared [m]."""
    largest_amplitude: float
    """Largest one [m]."""
