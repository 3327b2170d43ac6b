"""Identification of a friction law from records."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.special import chdtri

from microslip._core.checks import members, number, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.threads import single_threaded
from microslip._core.units import engineering
from microslip._core.wording import plural
from microslip.contact.materials import MaterialPair
from microslip.identification.found import Identification
from microslip.identification.free_form import FreeForm
from microslip.identification.interface_step import as_pair, pair_of
from microslip.identification.loads import groups_of
from microslip.identification.pieces import loop_of, stretches_of
from microslip.identification.record_fit import RecordFit
from microslip.identification.rows import DesignRows
from microslip.laboratory.cycles import check_direction
from microslip.laboratory.folding import Folded as Folded
from microslip.laboratory.folding import fold as fold
from microslip.laboratory.folding import stated_noise
from microslip.laboratory.measurement import beyond_all_rigs
from microslip.laboratory.record import Record

_MOST_FORCES = 1 << 13
"""Largest number of phase bins of all records together."""
_MOST_BINS = 256
"""Largest number of phase bins of one record."""
_UNLIKELY = 1e-3
"""Significance level of the rise of chi-squared at which each load gets its own slider density."""
_SLIGHTLY, _WIDELY = 1.1, 2.0
"""Ratios of the amplitudes of the cycles above which a note is given and an error is raised."""
_GAINS = ("force_gain", "displacement_gain")


@single_threaded
def identify(
    records: Record | Iterable[Record],
    *,
    rig_stiffness: float | tuple[float, float] | None = None,
    noise: tuple[float, float] | None = None,
    law: str | None = None,
    pair: MaterialPair | None = None,
    area: float | None = None,
    heights: Any = None,
    known: Mapping[str, Any] | None = None,
    contact_area: tuple[float, float, float] | None = None,
) -> Identification:
    """Identify the friction law that measured loops determine, with confidence intervals.

    Parameters
    ----------
    records : Record or iterable of Record
        Records at one or more loads and amplitudes, each with at least three settled cycles.
    rig_stiffness : float, (float, float) or ufloat, optional
        Measured stiffness of the rig [N/m] in series with the joint, and its standard error.
        With it, results are those of the joint alone; without it those of joint and rig in series,
        because loops cannot separate them. Infinity means a rigid rig.
    noise : (float, float), optional
        Standard deviations of each force [N] and each displacement [m]. If given, every record is
        one averaged cycle, whose scatter does not determine the noise.
    law : str, optional
        "interface" fits the Greenwood interface in a second step; giving ``pair`` does the same.
    pair, area, heights, contact_area : optional
        Materials, apparent area [m^2] and other data for the second step, as
        :meth:`Identification.interface` takes them.
    known : mapping, optional
        Measured values as (value, standard deviation), or as numbers of the package uncertainties.
        "force_gain" and "displacement_gain" are gains of the sensors relative to those used in the
        records, such as ``(1.0, 0.01)``. Others are parameters of the interface for the second
        step, such as ``{"std": (5e-7, 2e-8)}``.

    Returns
    -------
    Identification
        Friction law, forces, energies and damping with intervals.

    Raises
    ------
    InputError
        For records without settled cycles, or a rig softer than joint and rig in series.

    Notes
    -----
    The force of a law that obeys Masing's rules is linear in its density of sliders (Iwan 1966,
    DOI 10.1115/1.3625199). The density is found by least squares with non-negative stiffnesses, on
    the mean cycle of each record: a convex problem without initial guesses. At a lower load all
    yield displacements of the sliders are smaller by the same length. Intervals contain all
    densities whose sum of squares exceeds the minimum by at most a calibrated quantile.
    """
    if law not in (None, "interface"):
        raise InputError(
            f'`law` must be "interface" or left out, got {show(law)}; ms.compare fits other laws'
        )
    _gains(known)
    further = {name: datum for name, datum in (known or {}).items() if name not in _GAINS}
    is_free = law is None and pair is None
    if is_free:
        given = {"area": area, "heights": heights, "contact_area": contact_area, **further}
        unused = [name for name, datum in given.items() if datum is not None]
        if unused:
            raise InputError(
                f"{', '.join(unused)}: used for the parameters of an interface only; also give the "
                'two materials, `pair=...`, or `law="interface"`'
            )
    result, _ = fitted_records(records, rig_stiffness=rig_stiffness, noise=noise, known=known)
    if is_free:
        return result
    step = result.interface(
        pair, area=area, heights=heights, known=further, contact_area=contact_area
    )
    return replace(result, step=step)


def fitted_records(
    records: Any,
    *,
    rig_stiffness: float | tuple[float, float] | None = None,
    noise: tuple[float, float] | None = None,
    known: Mapping[str, Any] | None = None,
) -> tuple[Identification, list[DesignRows]]:
    """Return the free-form fit of records, and the design matrix of each record."""
    gains = _gains(known)
    rig = _rig(rig_stiffness)
    folded = _folded_records(records, noise)
    loads = [one.normal_load for one in folded]
    groups = groups_of(load for load in loads if load is not None)[::-1]
    means: list[float | None] = [float(np.mean(group)) for group in groups]
    if any(load is None for load in loads):
        if means:
            missing = next(one.name for one in folded if one.normal_load is None)
            raise InputError(
                f"{missing}: some records have a normal load and this one has none; write "
                "Record(..., normal_load=500.0)"
            )
        means = [None]
    rows = []
    for one in folded:
        level = 0
        if one.normal_load is not None:
            level = next(i for i, group in enumerate(groups) if one.normal_load in group)
        rows.append(DesignRows(one, level))
    fits, notes = _fitted(rows, means)
    for one in folded:
        notes += [f"{one.name}: {text}" for text in one.notes]
    fitted = []
    for row in rows:
        force = next(fit for fit in fits if row in fit.rows).force_of(row)
        # The half of a loop that is completed by symmetry has the offset of the other, reversed.
        offset = float(np.average(row.folded.force - force, weights=row.weight**2))
        sense = np.where(row.folded.completed, -1.0, 1.0) if row.folded.completed.size else 1.0
        fitted.append(RecordFit(row.folded, lock(force + sense * offset)))
    result = Identification(tuple(fits), tuple(fitted), rig, gains, tuple(notes))
    return _check_rig(result), rows


def _fitted(rows: list[DesignRows], loads: list[float | None]) -> tuple[list[FreeForm], list[str]]:
    """Return one fit for all loads, or one for each if a single density does not fit all."""
    fit = FreeForm(rows, loads)
    if len(loads) == 1:
        return [fit], []
    alone = fit.separate
    apart = fit.chi_squared - sum(one.chi_squared for one in alone)
    used = sum(one.used for one in alone) - fit.used
    noise = max(1.0, sum(one.chi_squared for one in alone) / sum(one.freedom for one in alone))
    if apart <= noise * float(chdtri(max(used, 1) + len(loads), _UNLIKELY)):
        return [fit], []
    note = (
        "a single slider density does not fit all normal loads (chi-squared rises by "
        f"{apart:.3g}, by noise alone about {used:.3g}), so each load gets its own density: "
        "tightening, wear or the rig differ between the loads"
    )
    return list(alone), [note]


def _rig(given: Any) -> tuple[float, float] | None:
    if given is None:
        return None
    given = as_pair(given)
    parts = given if isinstance(given, (tuple, list)) else (given, 0.0)
    if len(parts) != 2:
        raise InputError(
            "`rig_stiffness` must be a stiffness or (stiffness, standard error) [N/m], such as "
            f"(5e8, 1e7), got {show(given)}"
        )
    if isinstance(parts[0], float) and parts[0] == math.inf:
        return (math.inf, 0.0)
    value = positive("rig_stiffness", parts[0], "N/m", 5e8)
    error = number("rig_stiffness", parts[1], "N/m", 1e7)
    if not 0.0 <= error < value:
        raise InputError(
            f"the standard error of `rig_stiffness` must be from zero to below its value, got "
            f"{error:g} N/m"
        )
    return (value, error)


def _check_rig(result: Identification) -> Identification:
    if result.rig_stiffness is None:
        return result
    rig, error = result.rig_stiffness
    fit = result.fits[0]
    if float(fit.k @ (fit.thresholds() > 0.0)) <= rig + 3.0 * error:
        return result  # the lower end is below this, and needs a calibration
    both = replace(result, rig_stiffness=None).stiffness.low
    if both > rig + 3.0 * error:
        raise InputError(
            f"`rig_stiffness` must be above the stiffness of the loops, {both:.4g} N/m or more, "
            f"got {rig:.4g} N/m; the rig is in series with the joint and cannot be softer than both"
        )
    return result


def _gains(known: Mapping[str, Any] | None) -> dict[str, float]:
    gains = {}
    if known is not None and not isinstance(known, Mapping):
        raise InputError(
            f"`known` must be a dict such as {{'std': (5e-7, 5e-8)}}, got {show(known)}"
        )
    for name, datum in (known or {}).items():
        if name in _GAINS:
            value, error = pair_of(name, datum)
            gains[name.removesuffix("_gain")] = error / value
    return gains


def _parts_of(records: Sequence[Record]) -> list[tuple[Record, str]]:
    parts = []
    for record in records:
        pieces, omitted = stretches_of(record)
        note = ""
        if omitted > len(pieces):  # some are lost at each change of amplitude
            note = (
                f"{plural(omitted, 'cycle')} of the record are not used: they are not part of at "
                "least 4 successive cycles of equal amplitude and frequency"
            )
        parts += [(piece, note if i == 0 else "") for i, piece in enumerate(pieces)]
    return parts


def _unlike_amplitudes(folded: Folded) -> str:
    """Return a note if the cycles of a record differ in amplitude; raise InputError if widely."""
    if not folded.cycle_amplitude.size:
        return ""
    low, high = (float(np.quantile(folded.cycle_amplitude, p)) for p in (0.05, 0.95))
    words = f"the amplitude of its cycles varies from {engineering(low, 'm', 3)} to "
    words += engineering(high, "m", 3)
    if high > _WIDELY * low:
        raise InputError(
            f"{folded.name}: {words}, but must be nearly constant for a mean cycle; use records or "
            "steps of at least 4 cycles each, or part of the record, such as `rows=slice(0, 5000)`"
        )
    return f"{words}; the law is identified from their mean loop" if high > _SLIGHTLY * low else ""


def _implausible(folded: Folded, noise: tuple[float, float] | None) -> list[str]:
    """Return notes on values beyond the range of any rig; raise InputError for too much noise."""
    force = 0.5 * float(np.ptp(folded.force))
    sizes = (force, folded.amplitude)
    for size, error, unit in zip(sizes, noise or (0.0, 0.0), ("N", "m"), strict=True):
        if error > size:
            raise InputError(
                f"{folded.name}: `noise` must be below the amplitude of the loop, "
                f"{engineering(size, unit)}, got {engineering(error, unit)}"
            )
    columns = {"amplitude": folded.amplitude, "force_amplitude": force}
    if folded.normal_load is not None:
        columns["friction_peak"] = force / folded.normal_load
    return beyond_all_rigs(columns)


def _folded_records(records: Any, noise: tuple[float, float] | None) -> list[Folded]:
    """Return the records, cut into parts of one amplitude each, folded into one cycle."""
    expected = "a Record or a list of them; write Record(displacement, force) or Record.read(path)"
    listed = members(
        "records", [records] if isinstance(records, Record) else records, Record, expected
    )
    bins = max(64, min(_MOST_BINS, _MOST_FORCES // len(listed)))
    stated = None if noise is None else stated_noise(noise)
    folded = []
    for record, note in _parts_of(listed) if stated is None else [(one, "") for one in listed]:
        one = fold(record, bins) if stated is None else loop_of(record, stated, bins)
        texts = (note, _unlike_amplitudes(one), *_implausible(one, stated))
        one = replace(one, notes=(*one.notes, *filter(None, texts)))
        x, force, way = one.displacement(one.phase), one.force, one.way
        error = one.force_noise * float(np.linalg.norm(way / np.sqrt(one.count)))
        check_direction(one.name, float(force @ way), error, x, force)
        folded.append(one)
    names = [one.name for one in folded]
    if len(set(names)) < len(names):
        folded = [replace(one, name=f"{one.name} {i + 1}") for i, one in enumerate(folded)]
    return folded
