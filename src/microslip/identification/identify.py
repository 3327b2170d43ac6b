"""Entrance of the identification: from records to what their loops determine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import members, number, positive, show
from microslip._core.errors import InputError
from microslip._core.threads import single_threaded
from microslip.identification.coordinates import groups_of
from microslip.identification.found import Identification, result_of
from microslip.identification.free_form import FreeForm, Rows
from microslip.laboratory.cycles import check_direction
from microslip.laboratory.folding import MOST_BINS, Folded, averaged, fold, stated_noise
from microslip.laboratory.record import Record

_MOST_FORCES = 1 << 14
"""Most bins of all records together."""
_GAINS = {
    "force_gain": "force",
    "displacement_gain": "displacement",
    "normal_load_gain": "normal_load",
}


@single_threaded
def identify(
    records: Record | Iterable[Record],
    *,
    normal_load: float | Sequence[float] | None = None,
    rig_stiffness: float | tuple[float, float] | None = None,
    noise: tuple[float, float] | None = None,
    known: Mapping[str, tuple[float, float]] | None = None,
) -> Identification:
    """Find the friction law that measured loops determine, with intervals.

    Parameters
    ----------
    records : Record or iterable of Record
        One or many, at several loads and amplitudes; each with at least three settled cycles.
    normal_load : float or sequence of float, optional
        Normal load [N] of the records that have none, one for all or one for each.
    rig_stiffness : float or (float, float), optional
        Measured stiffness of the rig [N/m] in series with the joint, and its standard error. With
        it results are those of the joint alone; without it those of joint and rig in series,
        because loops cannot tell the two apart.
    noise : (float, float), optional
        Standard deviations of each force [N] and each displacement [m]: then every record is one
        cycle that was averaged already, whose scatter does not tell the noise.
    known : mapping, optional
        Data from elsewhere as (value, standard deviation): "force_gain", "displacement_gain" and
        "normal_load_gain", relative gains of the sensors such as ``(1.0, 0.01)``.

    Returns
    -------
    Identification
        Friction law, forces, energies and damping with intervals.

    Raises
    ------
    InputError
        For records without settled cycles, or a rig softer than the loops.

    Notes
    -----
    The force of a law that obeys Masing's rules is linear in its density of sliders (Iwan 1966,
    DOI 10.1115/1.3625199). The density is found by least squares with stiffnesses that are not
    negative, on the mean cycle of each record: one convex problem without start values. At a lower
    load all thresholds are less by one shift. Intervals hold all densities whose sum of squares is
    within a calibrated quantile of the minimum.
    """
    gains = _gains(known)
    rig = _rig(rig_stiffness)
    folded = folded_records(records, normal_load, noise)
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
        rows.append(Rows(one, level))
    fit = FreeForm(rows, means)
    return result_of([fit], rows, rig, gains, [])


def _rig(given: Any) -> tuple[float, float] | None:
    if given is None:
        return None
    parts = given if isinstance(given, (tuple, list)) else (given, 0.0)
    if len(parts) != 2:
        raise InputError(
            "`rig_stiffness` must be a stiffness or (stiffness, standard error) [N/m], such as "
            f"(5e8, 1e7), got {show(given)}"
        )
    value = positive("rig_stiffness", parts[0], "N/m", 5e8)
    error = number("rig_stiffness", parts[1], "N/m", 1e7)
    if not 0.0 <= error < value:
        raise InputError(
            f"the standard error of `rig_stiffness` must be from zero to below its value, got "
            f"{error:g} N/m"
        )
    return (value, error)


def _gains(known: Mapping[str, Any] | None) -> dict[str, float]:
    gains = {}
    for name, datum in (known or {}).items():
        if name in _GAINS:
            gains[_GAINS[name]] = float(datum[1]) / float(datum[0])
    return gains


def folded_records(
    records: Any,
    normal_load: float | Sequence[float] | None,
    noise: tuple[float, float] | None,
) -> list[Folded]:
    """Return each record folded on one cycle, with names of their own."""
    expected = "a Record or a list of them; write Record(displacement, force) or Record.read(path)"
    listed = members(
        "records", [records] if isinstance(records, Record) else records, Record, expected
    )
    if normal_load is not None:
        given = np.broadcast_to(np.asarray(normal_load, dtype=float), (len(listed),))
        listed = [
            one
            if one.normal_load is not None
            else replace(one, normal_load=positive("normal_load", float(load), "N", 500.0))
            for one, load in zip(listed, given, strict=True)
        ]
    bins = max(64, min(MOST_BINS, _MOST_FORCES // len(listed)))
    stated = None if noise is None else stated_noise(noise)
    folded = []
    for record in listed:
        one = fold(record, None, bins) if stated is None else averaged(record, stated, bins)
        x, force, way = one.displacement(one.phase), one.force, one.way
        error = one.force_noise * float(np.linalg.norm(way / np.sqrt(one.count)))
        check_direction(one.name, float(force @ way), error, x, force)
        folded.append(one)
    names = [one.name for one in folded]
    if len(set(names)) < len(names):
        folded = [replace(one, name=f"{one.name} {i + 1}") for i, one in enumerate(folded)]
    return folded
