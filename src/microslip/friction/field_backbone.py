"""Law of a field whose nodes all have the same displacement."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock
from microslip._core.kernels.table import PolynomialTable
from microslip._core.quadrature import gauss_legendre
from microslip.contact.load_curve import LoadCurve
from microslip.friction.base import BackboneLaw
from microslip.friction.sliders import Sliders

_NODES, _WEIGHTS = gauss_legendre(8)  # exact for u^2 times a polynomial of degree 11


@dataclass(frozen=True, eq=False, repr=False)
class FieldBackbone(Locked, BackboneLaw):
    """Backbone of a field whose nodes share the displacement, returned by ``JointField.rigid``.

    T0(delta) is the sum of mu_i [N_i(d_i) - N_i(d_i + delta/kappa_i)] over the nodes i (Jaeger
    1998, DOI 10.1115/1.2833765), with the coefficient of friction mu_i, the load N_i, the
    separation d_i at rest and the slip per indentation kappa_i of each node.
    """

    _curve: LoadCurve
    _weights: Floats  # mu_i A_i/A
    _slips: Floats  # kappa_i
    _steps: Floats
    force_limit: float

    def _exact_backbone(self, u: Floats) -> Floats:
        drop = self._curve.drop
        forces = [self._weights @ drop(self._steps, np.minimum(v, 1e200) / self._slips) for v in u]
        return np.minimum(np.array(forces), self.force_limit)

    def _slope(self, u: Floats) -> Floats:
        weights = self._weights / self._slips
        load = self._curve.load
        return np.array(
            [weights @ load(self._steps + np.minimum(v, 1e200) / self._slips)[1] for v in u]
        )

    def _exact_energy(self, amplitude: Floats) -> Floats:
        weights, excess = 8.0 * self._weights * self._slips, self._curve.excess
        steps = [v / self._slips for v in amplitude]
        return np.array([weights @ excess("excess", self._steps, u) for u in steps])

    def _exact_energy_slope(self, amplitude: Floats) -> Floats:
        weights, excess = 8.0 * self._weights, self._curve.excess
        steps = [v / self._slips for v in amplitude]
        return np.array([weights @ excess("excess_slope", self._steps, u) for u in steps])

    @cached_property
    def _full_slip(self) -> float:
        return float(np.max((self._curve.parting() - self._steps) * self._slips))

    @cached_property
    def _table(self) -> PolynomialTable | None:
        if self._curve.profile(float(self._steps.min()), 0.0) is None:
            return None
        return PolynomialTable.sample(
            lambda u: self._exact_backbone(u) / u, self._full_slip, 1, self.force_limit
        )

    @cached_property
    def _energy_tables(self) -> tuple[PolynomialTable, Floats] | None:
        """Piecewise polynomial dE_d/da [N] of amplitude a [m], and E_d [J] where pieces begin."""
        if self._table is None:
            return None
        table = PolynomialTable.sample(
            lambda u: self._exact_energy_slope(u) / u**2,
            self._full_slip,
            2,
            4.0 * self.force_limit,
            tolerance=1e-12,
        )
        if table is None:
            return None
        edges = np.arange(len(table.coefficients) + 1) / table.inverse_width
        return table, np.append(0.0, np.cumsum(_between(table, edges[:-1], edges[1:])))

    def _backbone(self, u: Floats) -> Floats:
        return self._exact_backbone(u) if self._table is None else self._table.value(u)

    def _energy(self, amplitude: Floats) -> Floats:
        if self._energy_tables is None:
            return self._exact_energy(amplitude)
        table, starts = self._energy_tables
        panel = np.minimum(amplitude * table.inverse_width, len(starts) - 1.0).astype(np.int64)
        begin = panel / table.inverse_width
        return starts[panel] + _between(table, np.minimum(begin, amplitude), amplitude)

    def _energy_slope(self, amplitude: Floats) -> Floats:
        if self._energy_tables is None:
            return self._exact_energy_slope(amplitude)
        return self._energy_tables[0].value(amplitude)

    def _slider_density(self, u: Floats) -> Floats:
        weights = self._weights / self._slips**2
        surface, places = self._curve.surface, self._steps + self._curve.origin
        return np.array([weights @ surface._derivative(places + v / self._slips, 2) for v in u])

    def sliders(self) -> Sliders:
        """Return the sliders of all nodes: continuous, and discrete where the slope N' jumps."""
        places, stiffnesses = [np.zeros(0)], [np.zeros(0)]
        nodes = zip(self._steps, self._slips, self._weights, strict=True)
        for step, slip, weight in nodes if self._table is None else ():
            steps, jumps = self._curve.surface._corners(float(step) + self._curve.origin)
            places.append(slip * steps)
            stiffnesses.append(weight / slip * jumps)
        place, stiffness = np.concatenate(places), np.concatenate(stiffnesses)
        order = np.argsort(place, kind="stable")
        return Sliders(lock(place[order]), lock(stiffness[order]), self._slider_density)

    def __repr__(self) -> str:
        return (
            f"FieldBackbone({self._steps.size} nodes, "
            f"stiffness={self.tangential_stiffness:g}, force_limit={self.force_limit:g})"
        )


def _between(table: PolynomialTable, low: Floats, high: Floats) -> Floats:
    places = low[:, None] + (high - low)[:, None] * _NODES
    return np.asarray((high - low) * (table.value(places) @ _WEIGHTS))
