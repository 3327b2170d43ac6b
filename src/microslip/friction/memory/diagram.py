"""Memory diagrams: exact memory of a contact with a varying normal load.

The state of shear of an interface at separation d is a function D(eta) of the separations eta >= d,
piecewise constant with |D| <= 1. D(eta) is the increase of displacement/kappa per decrease of
separation with which the contacts that first touch at separation eta were loaded; 1 or -1 means
that they have slipped since. Here kappa = mu E*/(4 G*) is the slip per indentation, and the place
is displacement/kappa [m]. Then

    T/mu = integral of D(eta) (-N'(eta)) over eta >= d,    place = integral of D(eta).

A decrease of d adds new contact, which sticks with D = (change of place)/(decrease of d). An
increase of d removes D below the new d. If the integral of D then differs from the place, contacts
slip: D becomes 1 or -1 from d up to a slip front at which the integral agrees. This is the
superposition of Jaeger (1998), DOI 10.1115/1.2833765, and Ciavarella (1998, J. Appl. Mech. 65, 998)
along a history, known as the method of memory diagrams (Aleshin and others 2020, DOI
10.3389/fmech.2020.00030). D is independent of the surface. A row is an interval of constant D; N(d)
enters only through its decrease over each row.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats, whole_number
from microslip._core.errors import InputError
from microslip._core.kernels.profile import Profile

if TYPE_CHECKING:
    from microslip.contact.load_curve import LoadCurve

_BLOCK = 1 << 12  # samples per call
_MAX_PENDING = 1024  # steps whose losses are computed together


ERROR_SIZE = 5
"""Size of the error state of merged rows: bound of the error of T/mu [N], inner and outer end of
these rows [m], 1 if a slip front has entered them, else 0, and the largest bound so far [N]."""


def checked_depth(depth: Any) -> int | None:
    """Check the largest number of rows of a diagram, None for unlimited."""
    return None if depth is None else whole_number("depth", depth, 4, 1_000_000)


def merging_profile(curve: LoadCurve, reach: float) -> Profile:
    """Return the load curve N(d) as polynomials, for the error bound when rows are merged.

    ``reach`` is the largest separation of the rows [m], relative to the origin of ``curve``.
    """
    profile = curve.profile(min(0.0, reach), max(0.0, reach))
    if profile is None:
        raise InputError(
            "`depth` must be None for a surface whose load curve has kinks, since its "
            "memory cannot be merged"
        )
    return profile


class Step(NamedTuple):
    """Outcome of a trial step: rows that remain, and the new row from d to the slip front."""

    separation: float
    place: float
    depth: int
    front: float
    density: float
    kind: int
    value: float
    outer: float  # part of the value from the rows that remain
    fall: float  # -N' at the front


class Diagram:
    """Memory diagram D(eta) of a contact, with its current separation, displacement/kappa and T/mu.

    T is the force, mu the coefficient of friction, and kappa the slip per indentation; the module
    docstring defines D. A row is an interval of eta with constant D; rows are stored from the
    largest eta on. There is one row per open reversal and one per step of new contact that has not
    slipped since. Separations are relative to that at the start, which avoids cancellation at a
    constant load.
    """

    __slots__ = ("depth", "errors", "limit", "place", "separation", "stack", "value", "values")

    def __init__(self, limit: int | None = None) -> None:
        self.limit, self.errors = (
            limit,
            np.zeros(ERROR_SIZE),
        )  # most rows, error of merged rows
        self.stack = np.empty((8, 3))  # end, density, integral of D beyond the end
        self.values = np.empty(8)  # integral of D (-N') from the start of each row
        self.depth = 0
        self.separation = 0.0
        self.place = 0.0
        self.value = 0.0

    def copy(self) -> Diagram:
        """Return an independent copy."""
        diagram = Diagram(self.limit)
        diagram.errors = self.errors.copy()
        diagram.stack, diagram.values = self.stack.copy(), self.values.copy()
        diagram.depth, diagram.separation = self.depth, self.separation
        diagram.place, diagram.value = self.place, self.value
        return diagram

    __copy__ = copy

    @property
    def _last(self) -> tuple[int, float, float]:
        return self.depth, self.separation, self.place

    def _reach(self, separation: Floats) -> tuple[float, float]:
        low, high = float(separation.min()), float(separation.max())
        return min(low, self.separation), max(high, self.separation)

    def respond(self, separation: Floats, place: Floats, curve: LoadCurve) -> Floats:
        """Update the diagram along separations and displacements/kappa [m]; return T/mu [N]."""
        arguments, result = curve.arguments(*self._reach(separation)), np.empty(separation.size)
        # A curve without a profile is evaluated once per call, which needs memory.
        step = _BLOCK if len(arguments) == 1 else separation.size
        d, x = np.ascontiguousarray(separation), np.ascontiguousarray(place)
        for start in range(0, separation.size, step):
            part = slice(start, start + step)
            stack, values = self._reserve(d[part].size)
            depth, self.separation, self.place = kernels.compiled.coupled(
                d[part], x[part], result[part], stack, values, *self._last, *arguments
            )
            self._store(stack, values, self._bound(stack, values, depth, curve))
        self.value = float(result[-1])
        return result

    def stored(self, curve: LoadCurve) -> float:
        """Return the elastic energy of all sliders [J], see :attr:`microslip.State.stored_energy`.

        The spring of the slider at separation eta is deflected by g, the integral of D from d to
        eta. The energy is mu kappa times the integral of N'' g^2/2. By parts this equals the
        integral of (-N') g D, in which g is linear on each row.
        """
        if not self.depth:
            return 0.0
        ends, density = self.stack[: self.depth, 0][::-1], self.stack[: self.depth, 1][::-1]
        begins = np.append(self.separation, ends[:-1])
        widths = np.maximum(ends - begins, 0.0)
        held = np.append(0.0, np.cumsum(density * widths)[:-1])
        drop = np.atleast_1d(curve.drop(begins, widths))
        moment = 0.5 * widths * drop - curve.excess("excess", begins, widths)
        total = float((density * (held * drop + density * moment)).sum())
        return curve.friction * curve.slip * max(total, 0.0)

    def _bound(self, stack: Floats, values: Floats, depth: int, curve: LoadCurve) -> int:
        if self.limit is None:
            return depth
        profile = merging_profile(curve, float(stack[:depth, 0].max(initial=self.separation)))
        rows: int = kernels.compiled.bound_rows(
            stack, values, depth, self.separation, self.limit, self.errors, *profile.arguments
        )
        return rows

    def hold(self, separation: Floats, value: Floats, curve: LoadCurve) -> Floats:
        """Return displacements/kappa [m] for a record of T/mu [N], and update the diagram."""
        result = np.empty(value.size)
        stack, values = self._reserve(value.size)
        profile = curve.profile(*self._reach(separation))
        depth, self.separation, self.place, self.value = kernels.compiled.hold(
            np.ascontiguousarray(separation), np.ascontiguousarray(value), result, stack, values,
            *self._last, self.value, *(profile.arguments if profile else (curve.scalar,)),
        )  # fmt: skip
        self._store(stack, values, depth)
        return result

    def _reserve(self, extra: int) -> tuple[Floats, Floats]:
        if len(self.values) >= self.depth + extra:
            return self.stack, self.values
        # Doubling gives amortised constant cost for chunks of one sample.
        room = max(self.depth + extra, 2 * self.depth)
        stack, values = np.empty((room, 3)), np.empty(room)
        stack[: self.depth] = self.stack[: self.depth]
        values[: self.depth] = self.values[: self.depth]
        return stack, values

    def _store(self, stack: Floats, values: Floats, depth: int) -> None:
        if len(values) > 4 * depth + 64 or len(values) < 8:
            rows, copies = np.empty((2 * depth + 8, 3)), np.empty(2 * depth + 8)
            rows[:depth], copies[:depth] = stack[:depth], values[:depth]
            stack, values = rows, copies
        self.stack, self.values, self.depth = stack, values, depth

    # -- one step at a time -------------------------------------------------------------------

    def probe(self, separation: float, place: float, curve: LoadCurve) -> Step:
        """Return the outcome of a trial step to a separation and displacement/kappa [m]."""
        last = self.separation
        outcome = kernels.compiled.coupled_step(
            separation, place, self.stack, self.values, self.depth, last, self.place,
            *curve.arguments(min(separation, last), max(separation, last)),
        )  # fmt: skip
        return Step(separation, place, *outcome)

    @property
    def slip(self) -> float:
        """Value of D left by the last step if it caused slip, 1 or -1; otherwise 0."""
        density = float(self.stack[self.depth - 1, 1]) if self.depth else 0.0
        return density if abs(density) == 1.0 else 0.0

    def move(self, step: Step, curve: LoadCurve) -> None:
        """Update the diagram by the outcome of :meth:`probe`."""
        stack, values = self._reserve(1)
        depth, beyond = step.depth, 0.0
        if depth:
            end, density, integral = stack[depth - 1].tolist()
            beyond = density * (end - step.front) + integral
            values[depth - 1] = step.outer
        if step.front > step.separation:
            stack[depth] = step.front, step.density, self.place if step.kind == 0 else beyond
            values[depth] = step.value
            depth += 1
        self.separation, self.place, self.value = step.separation, step.place, step.value
        self._store(stack, values, self._bound(stack, values, depth, curve))

    # -- slip -----------------------------------------------------------------------------------

    def runs(self, separation: Floats, places: Floats) -> Floats:
        """Return the advances of the slip front over rows of the diagram, one per column.

        Contacts that touch at separations between the current one d and the slip front q > d have
        slipped, and each advance of q dissipates energy. The samples of a record have the
        separations ``separation`` and displacements/kappa ``places`` [m]. The eight entries of a
        column are described at :meth:`microslip.contact.exact_curves.SlipLosses.of`.
        """
        count = room = 4 * separation.size + self.depth
        while count >= room:  # a step usually has few; else the kernel returns the number needed
            room = count + 1
            runs, rows = np.empty((room, 8)), np.empty((self.depth + separation.size, 3))
            rows[: self.depth] = self.stack[: self.depth]
            count = kernels.compiled.slips(
                np.ascontiguousarray(separation), np.ascontiguousarray(places), runs, rows,
                *self._last,
            )  # fmt: skip
        return runs[:count].T.copy()

    def losses(self, separation: Floats, displacement: Floats, curve: LoadCurve) -> Floats:
        """Return the energy dissipated in each step of a record [J]; the diagram is not changed."""
        places = displacement / curve.slip
        profile = curve.profile(*self._reach(separation))
        with np.errstate(over="ignore", invalid="ignore"):  # the front may be at infinity
            if profile is None:
                lost = curve.slip_losses.of(self.runs(separation, places), separation.size)
            else:
                stack, lost = np.empty((self.depth + separation.size, 3)), np.empty(places.size)
                stack[: self.depth] = self.stack[: self.depth]
                kernels.compiled.losses(
                    np.ascontiguousarray(separation), np.ascontiguousarray(places), lost, stack,
                    *self._last, profile.loss_rules, *profile.arguments,
                )  # fmt: skip
            return curve.friction * curve.slip * lost


class EnergyAccumulator:
    """Accumulator of the energy dissipated along a record [J].

    Up to 1024 steps are collected, since computing their losses together is far cheaper.
    """

    __slots__ = ("_begin", "_displacements", "_pending", "_separations", "total")

    def __init__(self, diagram: Diagram, total: float) -> None:
        self.total = total
        self._begin = diagram.copy()
        self._separations: list[Floats] = []
        self._displacements: list[Floats] = []
        self._pending = 0

    def copy(self) -> EnergyAccumulator:
        """Return an independent copy."""
        ledger = EnergyAccumulator(self._begin, self.total)
        ledger._separations, ledger._displacements = self._separations[:], self._displacements[:]
        ledger._pending = self._pending
        return ledger

    __copy__ = copy

    def note(
        self, separation: Floats, displacement: Floats, diagram: Diagram, curve: LoadCurve
    ) -> None:
        """Store the steps of a record for later; ``diagram`` is the state at its end."""
        self._separations.append(separation)
        self._displacements.append(displacement)
        self._pending += separation.size
        # Do not keep wiped-out rows for long.
        if self._pending >= _MAX_PENDING or self._begin.depth > 64 + 8 * diagram.depth:
            self.settle(diagram, curve)

    def settle(self, diagram: Diagram, curve: LoadCurve) -> float:
        """Return the total energy dissipated [J] up to the state ``diagram``.

        The losses of the collected steps, computed from the load curve ``curve``, are added to
        :attr:`total`, and the steps are cleared.
        """
        if self._pending:
            d, x = np.concatenate(self._separations), np.concatenate(self._displacements)
            self.total += float(self._begin.losses(d, x, curve).sum())
            self._begin = diagram.copy()
            self._separations, self._displacements, self._pending = [], [], 0
        return self.total
