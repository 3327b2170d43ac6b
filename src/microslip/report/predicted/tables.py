"""The tables of a prediction: joints at rest, their cycles, the history."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from microslip._core.units import engineering, significant
from microslip.friction import Interface
from microslip.report import cells
from microslip.report.document import Column, Section, Table, Verdicts
from microslip.report.predicted.numbers import verdicts
from microslip.study.description import StudyDescription

COUNTED = ("population", "sphere")
"""Normal laws whose contacts are counted, one by one."""
MOST_JOINTS = 20
MOST_CYCLES = 60

_N, _M = cells.trimmed("N"), cells.trimmed("m")
_SCALES = {
    "slip_per_indentation * heights.std": "κ times the standard deviation of the heights",
    "slip_per_indentation * heights.scale": "κ times the mean height",
    "slip_per_indentation * spread of the heights": (
        "κ times the spread of the heights (the standard deviation, where that is finite)"
    ),
    "force_limit / tangential_stiffness": "the force limit over the stiffness at rest",
}

_LOAD = Column("normal_load", "Load", "N", write=_N, short="load")
_AMPLITUDE = Column("amplitude", "Amplitude", "m", write=_M, short="amplitude")
_FORCE = Column("force_amplitude", "Force amplitude", "N", write=_N, short="force", brief=False)
_ENERGY = Column("dissipated_energy", "Energy per cycle", "J", 3, short="energy/cycle")
_LOSS = Column("loss_factor", "Loss factor η", "", write=cells.ratio, short="η")
_INPUTS = {
    "friction_coefficient": "μ",
    "normal_load": "N",
    "young_modulus": "E",
    "heights": "spread of heights",
    "copies": "number of summits",
    "cutoff": "short-wave cut-off",
    "yield_stress": "yield stress",
    "tightening_load": "tightening load",
    "roll_off": "longest wave",
    "shortest": "shortest wave",
    "hurst": "Hurst exponent",
}
_MOST_INPUTS = 3
_DAMPING = Column("damping_ratio", "Damping ratio ζ", "", write=cells.ratio, short="ζ")

Rows = Sequence[dict[str, Any]]


def _table(
    title: str, noun: str, columns: Sequence[Column], rows: Rows, caption: str = ""
) -> Table:
    """A table of loads or of their loops, whose cells are looked up by key."""
    keys, limit = (1, MOST_JOINTS) if noun == "loads" else (2, MOST_CYCLES)
    values = tuple(tuple(row.get(column.key) for column in columns) for row in rows)
    return Table(title, tuple(columns), values, keys, limit, caption, noun=noun)


def joint_table(joints: Rows, law: str) -> Table:
    """Joint at rest, one row for each load."""
    counts = cells.counted if law in COUNTED else cells.expected
    real = Column("contact_area", "Real area", "m^2", write=cells.area, short="real area")
    if joints[0]["contact_area_fraction"] is not None:
        real = replace(real, key="contact_area_fraction", unit="", write=cells.percent)
    columns = (
        _LOAD,
        Column("contact_count", "Contacts", "", write=counts, short="contacts"),
        real,
        Column("mean_contact_pressure", "Mean pressure", "Pa", 3, short="N/real area", brief=False),
        Column("normal_stiffness", "kₙ", "N/m", 3, brief=False),
        Column("tangential_stiffness", "kₜ", "N/m", 3),
        Column("force_limit", "μN", "N", 3),
        Column("slip_scale", "Slip scale", "m", 3, short="slip scale"),
        Column("standardised_separation", "h", "", write=cells.decimals),
    )
    scale = joints[0]["slip_scale_meaning"]
    h = joints[0]["standardised_separation"] is not None
    caption = (
        "kₙ and kₜ are the normal and the tangential stiffness with all contacts sticking, μN is "
        f"the force of gross slip. The slip scale is {_SCALES.get(scale, scale)}"
        + ("; h is the separation of the surfaces over the spread of the heights." if h else ".")
    )
    return _table("Joint", "loads", columns, joints, caption)


def rest_section(joints: Rows, law: str) -> Section:
    """The joint at rest, its Hertz numbers, and what its answers hang on."""
    tables = (joint_table(joints, law), *hertz_table(joints), *hanging_table(joints))
    return Section("Joint at rest", tables)


def hanging_table(joints: Rows) -> tuple[Table, ...]:
    """The steepest slopes of each joint; nothing for laws without a surface."""
    rows = []
    for joint in joints:
        if not (slopes := joint.get("sensitivities")):
            continue
        amplitude = engineering(slopes["amplitude"], "m", 3, trim=True)
        labels = {"tangential_stiffness": "kₜ", "loss_factor": f"η at {amplitude}"}
        for name, label in labels.items():
            steepest = [
                f"{_INPUTS.get(key, key)}: {significant(slope, 2)}"
                for key, slope in list(slopes[name].items())[:_MOST_INPUTS]
                if abs(slope) >= 0.01
            ]
            rows.append((joint["normal_load"], label, ", ".join(steepest) or "none"))
    columns = (_LOAD, Column("quantity", "Quantity"), Column("inputs", "Largest sensitivities"))
    caption = (
        "d ln quantity/d ln input, the largest first: at 0.5 an error of 10 % in the input makes "
        "one of 5 % in the quantity. Moduli, density and area change for both bodies and the "
        "whole joint."
    )
    title = "Sensitivities"
    table = Table(title, columns, tuple(rows), 2, MOST_JOINTS, caption, noun="quantities")
    return (table,) if rows else ()


def hertz_table(joints: Rows) -> tuple[Table, ...]:
    """Hertz's and Cattaneo's numbers of a sphere, a row for each load and amplitude."""
    rows = [
        {**joint, **joint["hertz"], **cycle}
        for joint in joints
        if "hertz" in joint
        for cycle in joint["hertz"]["sticking"] or [{}]
    ]
    if not rows:
        return ()
    share = "stick_radius_over_contact_radius"
    columns = (
        _LOAD,
        Column("largest_pressure", "p₀", "Pa"),
        Column("contact_radius", "Contact radius a", "m", short="a"),
        Column("approach", "Approach", "m", short="approach"),
        Column("slip_limit", "Slip limit", "m", short="slip limit"),
        _AMPLITUDE,
        Column(share, "Stick radius c/a", "", write=cells.ratio, short="c/a"),
        Column("edge_traction", "Traction at c", "Pa", short="traction at c"),
    )
    caption = (
        "Hertz's pressure p₀ is the largest, in the middle. At the largest force of a cycle a "
        "circle of radius c sticks; the tangential traction is largest at its edge."
    )
    return (_table("Hertz and Cattaneo", "loads", columns, rows, caption),)


def cycle_table(joints: Rows, *, by_force: bool) -> Table:
    """Cycles, one row for each load and amplitude; chosen columns come first."""
    amplitudes = (replace(_FORCE, brief=True), _AMPLITUDE) if by_force else (_AMPLITUDE, _FORCE)
    columns = (
        _LOAD,
        *amplitudes,
        Column("force_ratio", "T/μN", "", write=cells.saturating),
        _ENERGY,
        _LOSS,
        _DAMPING,
        Column("secant_stiffness", "Secant stiffness", "N/m", 3, brief=False),
        Column("dissipation_exponent", "Exponent", "", write=significant, brief=False),
        Column("stick_share", "Sticking share", "", write=cells.percent, brief=False),
    )
    caption = (
        "T/μN is the force amplitude over the force limit. The exponent is the local power of the "
        "amplitude in the energy"
    )
    if joints[0]["amplitudes"][0].get("stick_share") is not None:
        caption += ", the sticking share that of the contact area at the end of first loading"
    rows = [{**joint, **row} for joint in joints for row in joint["amplitudes"]]
    return _table("Cycles", "loops", columns, rows, f"{caption}.")


def history_table(joints: Rows) -> Table:
    """Extremes of the time history, one row for each load."""
    label = "Largest displacement"
    columns = (
        _LOAD,
        Column("largest_displacement", label, "m", 3, short=label.lower()),
        Column("largest_force", "Largest force", "N", 3),
        Column("dissipated_energy", "Dissipated energy", "J", 3),
    )
    return _table("History", "loads", columns, [{**j, **j["history"]} for j in joints])


def validity(study: StudyDescription, joints: Sequence[Interface]) -> Verdicts:
    """Return the verdicts of the joints at all loads, each with its load."""
    judgements, places = [], []
    newtons = partial(engineering, unit="N", digits=4, trim=True)
    for joint in joints:
        for verdict in verdicts(study, joint):
            judgements.append(verdict)
            places.append(newtons(getattr(joint, "normal_load", 0.0)))
    caption = (
        "The limits are conventions of contact mechanics (Greenwood and Williamson 1966). Watch: "
        "the result depends on the assumption. Outside: do not rely on it."
    )
    return Verdicts(
        tuple(judgements), tuple(places), frozenset({"real over apparent area"}), caption=caption
    )
