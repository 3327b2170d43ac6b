"""Floor 8: what a study and its result are in tables of text, for a reader of the report."""

from __future__ import annotations

from typing import Any, NamedTuple

from pydantic import BaseModel

from microslip._core.units import engineering, significant
from microslip._core.verdicts import WORDS
from microslip.study.cells import (
    contact_count,
    force_ratio,
    is_by_force,
    pictures,
    ratio,
    standardised,
    verdict_limit,
    verdict_value,
)
from microslip.study.result import some
from microslip.study.scanned_surface import NO_CUTOFF
from microslip.study.surfaces import TableHeights
from microslip.study.varying import in_words

MOST_JOINTS = 20
MOST_CYCLES = 60

_KEYS = {
    "young_modulus": ("Young’s modulus", "Pa"),
    "poisson_ratio": ("Poisson’s ratio", ""),
    "hardness": ("Hardness (only for the plasticity index)", "Pa"),
    "heights": ("Summit heights", ""),
    "kind": ("Summit heights", ""),
    "std": ("Their standard deviation", "m"),
    "mean": ("Their mean", "m"),
    "values": ("Heights", "m"),
    "height": ("Tabulated heights", "m"),
    "distribution": ("Distribution of scipy.stats", ""),
    "parameters": ("Its shape parameters", ""),
    "location": ("Its location", "m"),
    "scale": ("Their scale", "m"),
    "radius": ("Radius", "m"),
    "density": ("Summits per apparent area", "1/m²"),
    "area": ("Apparent area", "m²"),
    "separation": ("Tabulated separations", "m"),
    "load": ("Their loads", "N"),
    "tail": ("Beyond the table", ""),
    "scan": ("Scan", ""),
    "cutoff": ("Short-wave cut-off", "m"),
    "long_cutoff": ("Long-wave cut-off", "m"),
    "level": ("Form removed", ""),
    "outliers": ("Outliers beyond, in robust standard deviations", ""),
    "fill": ("Missing points interpolated", ""),
    "method": ("Summits by", ""),
    "prominence": ("Least prominence of a summit", "m"),
    "estimate": ("Surface by", ""),
    "format": ("Format of the scan", ""),
    "pixel": ("Distance of neighbours in the scan", "m"),
    "key": ("Array of its file", ""),
    "channel": ("Channel of its file", ""),
    "valid": ("Possible heights in it", "m"),
    "friction_coefficient": ("Friction coefficient μ", ""),
    "normal_load": ("Normal load", "N"),
    "amplitudes": ("Displacement amplitudes", "m"),
    "force_amplitudes": ("Force amplitudes", "N"),
    "mass": ("Mass", "kg"),
    "stiffness": ("Stiffness beside the joint", "N/m"),
    "viscous_damping_ratio": ("Viscous damping ratio", ""),
}
"""What the keys of a study stand for, and the SI units of their values."""

# Powers of a length are not written with prefixes, but in the unit that suits them.
_POWERS = {
    "m²": ((1.0, "m²"), (1e-4, "cm²"), (1e-6, "mm²"), (1e-12, "µm²")),
    "1/m": ((1e9, "per nm"), (1e6, "per µm"), (1e3, "per mm"), (1.0, "per m")),
    "1/m²": ((1e12, "per µm²"), (1e6, "per mm²"), (1e4, "per cm²"), (1.0, "per m²")),
}
_LAWS = {
    "greenwood-williamson": "Greenwood–Williamson",
    "population": "given summits",
    "sphere": "one sphere on a flat",
    "table": "a table",
    "scan": "summits of a scan",
}
# What is said with something else, or in the notes.
_ELSEWHERE = ("rigid", "materials", "law", "file", "column", "unit", "start", "to", "points")
_MOST_VALUES = 8


class Table(NamedTuple):
    """A table of text."""

    head: tuple[str, ...]
    rows: list[tuple[str, ...]]
    left_out: int = 0
    """How many more rows there would be."""


class Group(NamedTuple):
    """One part of a study: its name, and what each of its keys stands for and holds."""

    name: str
    rows: list[tuple[str, str]]


class Judgement(NamedTuple):
    """One assumption of the model, held to its limit at all loads."""

    word: str
    """The worst verdict, ``ok``, ``watch`` or ``outside``."""
    name: str
    """What is judged."""
    value: str
    """Its value, or the smallest and the largest."""
    bound: str
    """Where it would be ok."""
    where: str
    """The loads at which it is so, if these are not all; where the load varies, in any case."""
    meaning: str
    """What is assumed."""


# -- the study -----------------------------------------------------------------------------------


def study_groups(study: Any) -> list[Group]:
    """A study in words and units.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    list of Group
        Materials, surface, joint, excitation and oscillator, with what is given of each.
    """
    groups = []
    for name, material in study.material.items():
        groups.append(Group(f"Material {name}", _rows(material) or [("Body", "rigid")]))
    surface = study.surface
    first, second = surface.materials
    bodies = [("Bodies", f"{first} on {second}"), ("Normal law", _LAWS[surface.law])]
    groups.append(Group("Surface", bodies + _rows(surface)))
    groups.append(Group("Joint", _rows(study.joint)))
    excitation = _rows(study.excitation)
    if excitation:
        groups.append(Group("Excitation", excitation))
    if study.oscillator is not None:
        groups.append(Group("Oscillator", _rows(study.oscillator)))
    return groups


def law_of(study: Any) -> str:
    """The law whose equation holds: a scan gives one of two."""
    if study.surface.law != "scan":
        return str(study.surface.law)
    return "population" if study.surface.estimate == "population" else "greenwood-williamson"


def _rows(part: BaseModel) -> list[tuple[str, str]]:
    """What the keys of a part stand for and hold, those of the parts in it included."""
    rows: list[tuple[str, str]] = []
    for name in type(part).model_fields:
        value = getattr(part, name)
        if name == "cutoff" and value is None:
            rows.append((_KEYS[name][0], NO_CUTOFF))
        if value is None or name in _ELSEWHERE:
            continue
        if name == "curve":
            ends = " to ".join(quantity(x, "m") for x in (value.start, value.to))
            rows.append(("Amplitudes of the curves", f"{ends}, {value.points} points"))
        elif name == "history":
            what = f'{len(value.values)} {value.quantity}s, column "{value.column}"'
            if value.normal_load is not None:
                what += f', normal loads, column "{value.normal_load.column}",'
            rows.append(("Own history", f"{what} of {value.file}"))
        elif name == "load_variation":
            rows.append(("Normal load varies by", in_words(value)))
        elif isinstance(value, BaseModel):
            rows += _rows(value)
        else:
            meaning, unit = _KEYS[name]
            if name == "density" and isinstance(part, TableHeights):
                meaning, unit = "Their density", "1/m"
            rows.append((meaning, quantity(value, unit)))
    return rows


def quantity(value: Any, unit: str) -> str:
    """Write a number with its unit, or several, or how many there are.

    Parameters
    ----------
    value : float, bool, str, dict or sequence of float
        What a study holds.
    unit : str
        Its unit, in SI without prefix.

    Returns
    -------
    str
        Such as "0.5 µm" or "3 values, 500 N to 5 kN".
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if isinstance(value, dict):
        return ", ".join(f"{key} = {number:g}" for key, number in value.items()) or "none"
    if isinstance(value, (tuple, list)):
        if len(value) <= _MOST_VALUES:
            return ", ".join(quantity(item, unit) for item in value)
        ends = " to ".join(quantity(end, unit) for end in (min(value), max(value)))
        return f"{len(value)} values, {ends}"
    if unit in _POWERS:
        factor, unit = next(
            ((f, u) for f, u in _POWERS[unit] if abs(value) >= 0.9999 * f), _POWERS[unit][-1]
        )
        return f"{value / factor:.6g} {unit}"
    return engineering(value, unit, 6, trim=True) if unit else f"{value:.6g}"


# -- the result ----------------------------------------------------------------------------------


def joint_table(summary: dict[str, Any]) -> Table:
    """What the joint is at rest, one row for each load."""
    joints = summary["joints"]
    shown = some(len(joints), MOST_JOINTS)
    head = ["Load", "Contacts", "Real area", "kₙ", "kₜ", "μN", "Slip scale", "h"]
    rows = [
        [
            _load(joint),
            contact_count(joint["contact_count"], summary["study"]["surface"]["law"]),
            _area(joint),
            engineering(joint["normal_stiffness"], "N/m"),
            engineering(joint["tangential_stiffness"], "N/m"),
            engineering(joint["force_limit"], "N"),
            engineering(joint["slip_scale"], "m"),
            _signed(standardised(joint["standardised_separation"])),
        ]
        for joint in (joints[i] for i in shown)
    ]
    return _known(head, rows, len(joints) - len(shown))


def cycle_table(summary: dict[str, Any]) -> Table:
    """What each cycle is, one row for each load and amplitude."""
    joints = summary["joints"]
    count = len(joints[0]["amplitudes"])
    kept = some(count, MOST_CYCLES // min(len(joints), 10))
    shown = some(len(joints), max(MOST_CYCLES // len(kept), 1))
    # What was chosen comes first.
    chosen = [("Amplitude", "amplitude", "m"), ("Force amplitude", "force_amplitude", "N")]
    if is_by_force(summary):
        chosen.reverse()
    head = [
        *("Load", *(name for name, _, _ in chosen), "T/μN", "Energy per cycle", "Loss factor η"),
        *("Damping ratio ζ", "Secant stiffness", "Exponent", "Sticking share"),
    ]
    rows = [
        [
            _load(joint),
            *(engineering(row[key], unit, 4, trim=True) for _, key, unit in chosen),
            force_ratio(row["force_ratio"]),
            engineering(row["dissipated_energy"], "J"),
            ratio(row["loss_factor"]),
            ratio(row["damping_ratio"]),
            engineering(row["secant_stiffness"], "N/m"),
            significant(row["dissipation_exponent"]),
            _percent(row.get("stick_share")),
        ]
        for joint in (joints[i] for i in shown)
        for row in (joint["amplitudes"][i] for i in kept)
    ]
    return _known(head, rows, len(joints) * count - len(rows))


def varying_table(summary: dict[str, Any]) -> Table:
    """What each cycle is as the normal load varies, one row for each load and amplitude."""
    joints = summary["joints"]
    count = len(joints[0]["amplitudes"])
    kept = some(count, MOST_CYCLES // min(len(joints), 10))
    shown = some(len(joints), max(MOST_CYCLES // len(kept), 1))
    head = (
        *("Load", "Amplitude", "Smallest load", "Largest load", "Force amplitude"),
        *("Energy per cycle", "Over that at constant load", "Loss factor η", "Damping ratio ζ"),
    )
    rows: list[tuple[str, ...]] = [
        (
            _load(joint),
            engineering(row["amplitude"], "m", 4, trim=True),
            engineering(row["smallest_normal_load"], "N", 4, trim=True),
            engineering(row["largest_normal_load"], "N", 4, trim=True),
            engineering(row["force_amplitude"], "N", 4, trim=True),
            engineering(row["dissipated_energy"], "J"),
            ratio(row["energy_share"]),
            ratio(row["loss_factor"]),
            ratio(row["damping_ratio"]),
        )
        for joint in (joints[i] for i in shown)
        for row in (joint["varying"][i] for i in kept)
    ]
    return Table(head, rows, len(joints) * count - len(rows))


def oscillator_table(summary: dict[str, Any]) -> Table:
    """Frequency and damping of the mode beside the interface's own, for each load and amplitude."""
    joints = summary["joints"]
    count = len(joints[0]["amplitudes"])
    kept = some(count, MOST_CYCLES // min(len(joints), 10))
    shown = some(len(joints), max(MOST_CYCLES // len(kept), 1))
    head = ("Load", "Amplitude", "Frequency", "Shift", "ζ of the mode", "ζ of the interface")
    rows: list[tuple[str, ...]] = []
    for joint in (joints[i] for i in shown):
        rest = joint["oscillator"]["frequency_at_rest"]
        for row in (joint["oscillator"]["amplitudes"][i] for i in kept):
            rows.append(
                (
                    _load(joint),
                    engineering(row["amplitude"], "m", 4, trim=True),
                    engineering(row["frequency"], "Hz", 5),
                    _percent(row["frequency"] / rest - 1.0),
                    ratio(row["damping_ratio"]),
                    ratio(row["interface_damping_ratio"]),
                )
            )
    return Table(head, rows, len(joints) * count - len(rows))


def history_table(summary: dict[str, Any]) -> Table:
    """How far the own history goes, one row for each load."""
    joints = summary["joints"]
    shown = some(len(joints), MOST_JOINTS)
    head = ("Load", "Largest displacement", "Largest force", "Dissipated energy")
    rows: list[tuple[str, ...]] = []
    for joint in (joints[i] for i in shown):
        found = joint["history"]
        rows.append(
            (
                _load(joint),
                engineering(found["largest_displacement"], "m"),
                engineering(found["largest_force"], "N"),
                engineering(found["dissipated_energy"], "J"),
            )
        )
    return Table(head, rows, len(joints) - len(shown))


def _known(head: list[str], rows: list[list[str]], left_out: int) -> Table:
    """A table without the columns of which nothing is known."""
    kept = [i for i in range(len(head)) if any(row[i] != "–" for row in rows)]
    return Table(
        tuple(head[i] for i in kept), [tuple(row[i] for i in kept) for row in rows], left_out
    )


def _load(joint: dict[str, Any]) -> str:
    return _newtons(joint["normal_load"])


def _newtons(load: float) -> str:
    return engineering(load, "N", 4, trim=True)


def _area(joint: dict[str, Any]) -> str:
    area, share = joint["contact_area"], joint["contact_area_fraction"]
    if area is None:
        return "–"
    return quantity(float(f"{area:.2e}"), "m²") if share is None else _percent(share)


def _percent(share: float | None) -> str:
    if share is None:
        return "–"
    if 0.0 < share < 1e-4:
        return "<0.01 %"
    return _signed(f"{significant(100.0 * share)} %")


def _signed(number: str) -> str:
    """A number with a minus sign in place of a hyphen."""
    return number.replace("-", "−", 1) if number.startswith("-") else number


# -- validity ------------------------------------------------------------------------------------


def judgements(summary: dict[str, Any]) -> list[Judgement]:
    """How far the assumptions hold, the worst first.

    Parameters
    ----------
    summary : dict
        Of a result.

    Returns
    -------
    list of Judgement
        One for each assumption; none where no limits are known.
    """
    joints = summary["joints"]
    found: dict[str, list[tuple[dict[str, Any], dict[str, Any]]]] = {}
    for joint in joints:
        for verdict in joint["validity"]:
            found.setdefault(verdict["name"], []).append((joint, verdict))
    judged = [_judged(name, pairs) for name, pairs in found.items()]
    return sorted(judged, key=lambda judgement: -WORDS.index(judgement.word))


def _judged(name: str, pairs: list[tuple[dict[str, Any], dict[str, Any]]]) -> Judgement:
    values = [verdict["value"] for _, verdict in pairs if verdict["value"] is not None]
    limit = pairs[0][1]["limit"]
    worst = max((verdict["word"] for _, verdict in pairs), key=WORDS.index)
    at = [(joint["normal_load"], v.get("normal_load")) for joint, v in pairs if v["word"] == worst]
    # Where the load varies a verdict names its own.
    loads = [_newtons(mean if own is None else own) for mean, own in at]
    somewhere = len(at) < len(pairs) or any(own is not None for _, own in at)
    where = _listed(list(dict.fromkeys(loads))) if somewhere else ""
    rising = any(v["word"] in ("watch", "outside") and v["value"] < limit for _, v in pairs) or (
        worst == "ok" and min(values) >= limit
    )
    ends = (min(values), max(values)) if values else ()
    texts = list(dict.fromkeys(verdict_value(name, end) for end in ends)) or ["not known"]
    bound = f"{'from' if rising else 'up to'} {verdict_limit(name, limit)}"
    shown = name.replace(" * ", " × ")
    return Judgement(worst, shown, " to ".join(texts), bound, where, pairs[0][1]["meaning"])


def _listed(loads: list[str]) -> str:
    if len(loads) <= 3:
        return "at " + " and ".join(filter(None, [", ".join(loads[:-1]), loads[-1]]))
    return f"at {len(loads)} loads, {loads[0]} to {loads[-1]}"


# -- files ---------------------------------------------------------------------------------------


def file_groups(names: list[str]) -> list[tuple[str, str]]:
    """Files of a result by what they hold; a figure once, whatever its formats."""
    drawn, kinds = pictures(names)
    groups = {
        "All of it": [name for name in names if name.endswith(".nc")],
        "Summary": [name for name in names if name.endswith(".json")],
        "Tables": [name for name in names if name.endswith(".csv")],
        f"Figures as {' and '.join(kinds)}": drawn,
        "Study": [name for name in names if name.endswith(".toml")],
    }
    return [(what, ", ".join(found)) for what, found in groups.items() if found]
