"""Comparison of named friction laws on the same records, with the free form as reference."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.threads import single_threaded
from microslip._core.units import significant
from microslip.friction import Jenkins, SegalmanIwan
from microslip.identification.bands import Bands
from microslip.identification.found import Identification
from microslip.identification.free_form import FreeForm
from microslip.identification.interface_step import interface_law, interface_starts
from microslip.identification.nonnegative import cone_of, minimum
from microslip.identification.rows import DesignRows
from microslip.identification.run import fitted_records
from microslip.identification.second_step import Law, SufficientStatistics, Unknown, fit_law
from microslip.laboratory.record import Record

COMPARED_LAWS = ("interface", "jenkins", "segalman", "iwan")
_CELLS = 8
_HELD = 4
"""Every fourth cycle is excluded from the fit."""
_CONTRADICTED = 2.0
"""Reduced chi-squared, over that of the free form, above which the loops contradict a law."""
_DECIDED = 6.0
"""Difference of Akaike's criteria from which on a law is preferred."""


class ComparedLaw(NamedTuple):
    """Fit of one named law, with the criteria by which laws are compared."""

    parameters: int
    """Number of free parameters."""
    chi_squared: float
    """Sum of squares of the residuals over their noise [-]."""
    reduced_chi_squared: float
    """Sum of squares over degrees of freedom [-]."""
    aic: float
    """Akaike's criterion (DOI 10.1109/TAC.1974.1100705)."""
    bic: float
    """Schwarz's criterion (DOI 10.1214/aos/1176344136)."""
    held_back: float | None
    """RMS error over noise [-] of the excluded cycles, as predicted by a fit of the others."""
    values: Mapping[str, float]
    """Best values of the parameters, in SI units."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Locked):
    """Several named laws fitted to the same records.

    Made by :func:`microslip.compare`, after Akaike (DOI 10.1109/TAC.1974.1100705). The free form
    contains every law that obeys Masing's rules, and gives the smallest possible sum of squares.
    """

    found: Identification
    """Fit of free form, the reference for all laws."""
    laws: Mapping[str, ComparedLaw]
    """The laws by name, in increasing order of Akaike's criterion."""
    failed: Mapping[str, str]
    """Laws that do not suit the records, and why."""

    @property
    def best(self) -> str:
        """Law that AIC and BIC prefer and that predicts excluded cycles best, or "undecided".

        A law whose reduced chi-squared is over twice that of the free form, or of the noise, is not
        preferred: the loops contradict it.
        """
        by_aic = list(self.laws)
        if not by_aic or self._is_contradicted(by_aic[0]):
            return "undecided"
        by_bic = min(self.laws, key=lambda name: self.laws[name].bic)
        held = {n: law.held_back for n, law in self.laws.items() if law.held_back is not None}
        agree = by_bic == by_aic[0]
        if held:
            agree &= held[by_aic[0]] <= min(held.values()) * (1.0 + 1e-3)
        if len(by_aic) > 1:
            agree &= self.laws[by_aic[1]].aic - self.laws[by_aic[0]].aic >= _DECIDED
        return by_aic[0] if agree else "undecided"

    def _is_contradicted(self, name: str) -> bool:
        limit = max(self.found.reduced_chi_squared, self.found.masing.high)
        return self.laws[name].reduced_chi_squared > _CONTRADICTED * limit

    def table(self) -> str:
        """Return the table of laws as text, with one law in each line."""
        head = f"{'law':<12}{'parameters':>11}{'chi^2/dof':>12}{'AIC':>12}{'BIC':>12}"
        lines = [f"{head}{'held back':>12}"]
        for name, law in self.laws.items():
            numbers = (law.reduced_chi_squared, law.aic, law.bic, law.held_back)
            texts = "".join(
                f"{'–' if number is None else significant(number, 5):>12}" for number in numbers
            )
            lines.append(f"{name:<12}{law.parameters:>11}{texts}")
        lines.append(f"preferred: {self.best}")
        bad = [name for name in self.laws if self._is_contradicted(name)]
        if bad:
            lines.append(f"contradicted by the loops: {', '.join(bad)}")
        lines.append(self.found.masing.text)
        lines += [f"{name}: {why}" for name, why in self.failed.items()]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"Comparison({', '.join(self.laws)}; preferred: {self.best})"


class _Fit(NamedTuple):
    misfit: float
    parameters: int
    x: Floats
    values: dict[str, float]
    about: FreeForm


@single_threaded
def compare(
    records: Record | Iterable[Record], laws: Sequence[str] = COMPARED_LAWS, **options: Any
) -> Comparison:
    """Compare named laws on the same records.

    Parameters
    ----------
    records : Record or iterable of Record
        As for :func:`microslip.identify`.
    laws : sequence of str, optional
        Among "interface", "jenkins", "segalman" and "iwan" (eight cells).
    options : optional
        ``rig_stiffness``, ``noise`` and ``heights`` of :func:`microslip.identify`, the same for all
        laws.

    Returns
    -------
    Comparison
        The laws with the criteria of Akaike (DOI 10.1109/TAC.1974.1100705) and Schwarz (DOI
        10.1214/aos/1176344136), and the error for cycles excluded from the fit.

    Raises
    ------
    InputError
        For an unknown law or option.
    """
    if isinstance(laws, str) or not isinstance(laws, Sequence) or not laws:
        raise InputError(
            f"`laws` must be a list such as ['interface', 'jenkins'], got {show(laws)}"
        )
    for name in laws:
        if name not in COMPARED_LAWS:
            raise InputError(f"`laws` must be among {', '.join(COMPARED_LAWS)}, got {show(name)}")
    heights = options.pop("heights", None)
    found, rows = fitted_records(records, **options)
    fits = {name: _fits_of(name, found, found.fits, heights) for name in laws}
    failed = {name: fit for name, fit in fits.items() if isinstance(fit, str)}
    held = _excluded_cycle_errors(
        found, rows, [name for name in laws if name not in failed], heights
    )
    compared: dict[str, ComparedLaw] = {}
    forces = sum(fit.measured.size for fit in found.fits)
    for name, parts in fits.items():
        if isinstance(parts, str):
            continue
        pairs = list(zip(_parts(name, found.fits), parts, strict=True))
        count = sum(part.parameters for part in parts)
        chi = sum(fit.chi_squared + part.misfit for fit, part in pairs)
        values: dict[str, float] = {}
        for fit, part in pairs:
            label = "" if len(parts) == 1 else f" at {fit.loads[0]:.4g} N"
            values |= {key + label: value for key, value in part.values.items()}
        compared[name] = ComparedLaw(
            count,
            chi,
            chi / max(forces - len(rows) - count, 1),
            chi + 2.0 * count,
            chi + count * math.log(forces),
            held.get(name),
            MappingProxyType(values),
        )
    ordered = sorted(compared.items(), key=lambda item: item[1].aic)
    return Comparison(found, MappingProxyType(dict(ordered)), MappingProxyType(failed))


def _parts(name: str, fits: Sequence[FreeForm]) -> list[FreeForm]:
    """Return the fits of all loads together for "interface", of each load for other laws."""
    if name == "interface":
        return list(fits)
    return [part for fit in fits for part in (fit.separate or [fit])]


def _fits_of(
    name: str, found: Identification, fits: Sequence[FreeForm], heights: Any
) -> list[_Fit] | str:
    try:
        return [_fit(name, found, fit, heights) for fit in _parts(name, fits)]
    except InputError as error:
        return str(error)


def _fit(name: str, found: Identification, fit: FreeForm, heights: Any) -> _Fit:
    if name == "iwan":
        return _cells(fit)
    rig = found.rig_stiffness
    statistics = SufficientStatistics(fit, Bands(fit), rig, rig is None and name == "interface")
    force = float(fit.k @ np.minimum(fit.largest, fit.thresholds()))
    stiffness = float(fit.k.sum())
    starts: Sequence[dict[str, float]] = []
    if name == "interface":
        loads = [load for load in fit.loads if load is not None]
        law, model = interface_law(loads, heights, force, stiffness)
        starts = interface_starts(statistics, law, model, force, stiffness)
    elif name == "jenkins":
        law = Law(
            (Unknown("stiffness", "N/m", stiffness), Unknown("force_limit", "N", force)),
            lambda u, v, _: Jenkins(v["stiffness"], v["force_limit"])._backbone(u),
        )
    else:
        law = Law(
            (
                Unknown("stiffness", "N/m", stiffness),
                Unknown("force_limit", "N", 1.2 * force),
                Unknown("chi", "", -0.3, False, -0.99, 3.0),
                Unknown("beta", "", 0.3, False, 0.0, 100.0),
            ),
            lambda u, v, _: np.asarray(
                SegalmanIwan(v["force_limit"], v["stiffness"], v["chi"], v["beta"])._backbone(u)
            ),
        )
    problem, q, least, _ = fit_law(statistics, law, starts=starts)
    values, about = problem.values(q), problem.statistics.fit
    rise = least - problem.statistics.least + about.chi_squared - fit.chi_squared
    x = problem.coefficients(values) / about.scale
    return _Fit(max(rise, 0.0), q.size, x, values, about)


def _cells(fit: FreeForm) -> _Fit:
    y = fit.y[:-1]
    wanted = np.geomspace(max(y[0], 0.02 * fit.largest), fit.largest, _CELLS)
    columns = np.unique([int(np.argmin(np.abs(y - one))) for one in wanted])
    columns = np.append(columns, y.size)
    gram = fit.cone.gram[np.ix_(columns, columns)]
    g = minimum(cone_of(gram, fit.free[columns]), fit.h[columns])
    whole = np.zeros(fit.g.size)
    whole[columns] = g
    rest = fit.measured - fit.design @ whole
    values = {
        f"cell of {fit.y[i]:.3g} m": float(k / fit.scale[i])
        for i, k in zip(columns, g, strict=True)
        if k > 0.0
    }
    rise = max(float(rest @ rest) - fit.chi_squared, 0.0)
    return _Fit(rise, int(np.count_nonzero(g)), whole / fit.scale, values, fit)


def _excluded_cycle_errors(
    found: Identification, rows: Sequence[DesignRows], laws: Sequence[str], heights: Any
) -> dict[str, float]:
    """Return the RMS error of each law over noise [-], for the cycles excluded from its fit."""
    if any(one.folded.cycles < _HELD for one in rows):
        return {}
    seen, back = {}, {}
    for one in rows:
        mask = np.arange(one.folded.cycles) % _HELD == _HELD - 1
        seen[id(one)] = DesignRows(one.folded.part(~mask), one.load)
        back[id(seen[id(one)])] = one.folded.part(mask)
    fits = [FreeForm([seen[id(one)] for one in fit.rows], fit.loads) for fit in found.fits]
    result = {}
    for name in laws:
        parts = _fits_of(name, found, fits, heights)
        if isinstance(parts, str):
            continue
        total, count = 0.0, 0
        for fit, part in zip(_parts(name, fits), parts, strict=True):
            for one in fit.rows:
                held = DesignRows(back[id(one)], one.load)
                miss = held.folded.force - part.about.force_of(held, part.x)
                miss = (miss - np.average(miss, weights=held.folded.count)) * held.weight
                total += float(miss @ miss)
                count += miss.size
        result[name] = math.sqrt(total / max(count, 1))
    return result
