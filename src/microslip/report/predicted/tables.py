"""Tables of a prediction: joints at rest, cycles, history."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, count
from microslip._core.units import engineering, significant
from microslip.friction import Interface
from microslip.report import cells
from microslip.report.document import Section, Table, Verdicts
from microslip.study.description import StudyDescription
from microslip.study.runs.rest import joint_verdicts

COUNTED = ("population", "sphere")
"""Normal laws with individually counted contacts."""
MOST_JOINTS = 20
MOST_CYCLE_ROWS = 60

_SCALES = {
    "slip_per_indentation * heights.std": "κ times the standard deviation of the heights",
    "slip_per_indentation * heights.scale": "κ times the mean height",
    "slip_per_indentation * spread of the heights": (
        "κ times the spread of the heights (the standard deviation, where that is finite)"
    ),
    "force_limit / tangential_stiffness": "the force limit over the stiffness at rest",
}

_INPUTS = {
    "friction_coefficient": "μ",
    "normal_load": "N",
    "young_modulus": "E",
    "heights": "spread of heights",
    "rms_slope": "rms slope",
    "copies": "number of summits",
    "cutoff": "short-wave cut-off",
    "hardness": "hardness",
    "tightening_pressure": "tightening pressure",
}
_MOST_INPUTS = 3

JointRows = Sequence[dict[str, Any]]


def _table(
    title: str,
    noun: str,
    data: DataSet,
    caption: str = "",
    hidden: tuple[str, ...] = (),
) -> Table:
    keys, limit = (1, MOST_JOINTS) if noun == "loads" else (2, MOST_CYCLE_ROWS)
    return Table(title, data, keys=keys, most=limit, caption=caption, noun=noun, hidden=hidden)


def joint_table(joints: JointRows, law: str, title: str = "Joint") -> Table:
    """Return the table of joints at rest, one row per load."""
    counts = "counted" if law in COUNTED else "expected"
    share_known = joints[0]["contact_area_fraction"] is not None
    at_rig = joints[0]["rig_tangential_stiffness"] is not None
    names = (
        "normal_load",
        "contact_count",
        "contact_area_fraction" if share_known else "contact_area",
        "mean_contact_pressure",
        "normal_stiffness",
        "first_loading_stiffness",
        "tangential_stiffness",
        *(("rig_normal_stiffness", "rig_tangential_stiffness") if at_rig else ()),
        "force_limit",
        "slip_scale",
        "standardised_separation",
    )
    hidden = ("mean_contact_pressure", *(name for name in names if "normal_stiffness" in name))
    hidden += ("first_loading_stiffness",)
    scale = joints[0]["slip_scale_meaning"]
    h = joints[0]["standardised_separation"] is not None
    caption = (
        "kₙ and kₜ are the stiffnesses of the contact alone, in full stick. "
        + "As a rig measures them next to a small contact, they include the compliance of two "
        "half-spaces behind the contact, round or as joint.pressure gives it (Johnson 1985). "
        * at_rig
        + (
            "kₙ is that of unloading, as ultrasound measures it; a load-deflection test measures "
            "first loading. "
            if joints[0]["first_loading_stiffness"] is not None
            else ""
        )
        + "μN is the force of gross slip. "
        f"The slip scale is {_SCALES.get(scale, scale)}"
        + ("; h is the separation of the surfaces over the spread of the heights." if h else ".")
    )
    data = cells.of_records(joints, names, contact_count={"form": counts})
    return _table(title, "loads", data, caption, hidden)


def rest_section(joints: JointRows, law: str) -> Section:
    """Return the section on the joint at rest, with its sensitivities to the inputs."""
    return Section("Joint at rest", (joint_table(joints, law), *sensitivity_table(joints)))


def sensitivity_table(joints: JointRows) -> tuple[Table, ...]:
    """Return the largest sensitivities of each joint to inputs; empty without a surface."""
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
    caption = (
        "d ln quantity/d ln input, the largest first: with 0.5 an error of 10 % in the input "
        "causes an error of 5 % in the quantity. Moduli change for both bodies, density and area "
        "for the whole joint."
    )
    if not rows:
        return ()
    loads, quantities, inputs = zip(*rows, strict=True)
    data = DataSet.of_rows(
        {
            "normal_load": (QUANTITIES["normal_load"], loads),
            "quantity": (count("Quantity"), quantities),
            "inputs": (count("Largest sensitivities"), inputs),
        }
    )
    table = Table(
        "Sensitivities", data, keys=2, most=MOST_JOINTS, caption=caption, brief=False,
        noun="quantities",
    )  # fmt: skip
    return (table,)


def cycle_table(joints: JointRows, *, by_force: bool) -> Table:
    """Return the table of cycles, one row per load and amplitude.

    The first amplitude column is that given in the study: force if ``by_force``, else displacement.
    """
    first = ("force_amplitude", "amplitude") if by_force else ("amplitude", "force_amplitude")
    more = ("secant_stiffness", "dissipation_exponent", "stick_share")
    names = (
        "normal_load", *first, "force_ratio", "dissipated_energy", "loss_factor", "damping_ratio",
        *more,
    )  # fmt: skip
    hidden = more if by_force else ("force_amplitude", *more)
    caption = (
        "T/μN is the force amplitude over the force limit. The exponent is the local exponent of "
        "the energy in the amplitude"
    )
    if joints[0]["amplitudes"][0].get("stick_share") is not None:
        caption += ", and the sticking fraction that of the contact area after first loading"
    rows = [{**joint, **row} for joint in joints for row in joint["amplitudes"]]
    data = cells.of_records(rows, names)
    return _table("Cycles", "loops", data, f"{caption}.", hidden)


def history_table(joints: JointRows) -> Table:
    """Return the extreme values of the response to a history, one row per load."""
    names = ("normal_load", "largest_displacement", "largest_force", "dissipated_energy")
    energy = {"label": "Dissipated energy", "symbol": ""}
    rows = [{**joint, **joint["history"]} for joint in joints]
    return _table("History", "loads", cells.of_records(rows, names, dissipated_energy=energy))


def validity_verdicts(study: StudyDescription, joints: Sequence[Interface]) -> Verdicts:
    """Return the verdicts on the joints, each with the load to which it refers."""
    judgements, places = [], []
    newtons = partial(engineering, unit="N", digits=4, trim=True)
    for joint in joints:
        for verdict in joint_verdicts(study, joint):
            judgements.append(verdict)
            places.append(newtons(getattr(joint, "normal_load", 0.0)))
    caption = (
        "The limits are conventions of contact mechanics (Greenwood and Williamson 1966). Watch: "
        "the result depends on the assumption. Outside: do not rely on it."
    )
    return Verdicts(
        tuple(judgements), tuple(places), frozenset({"real over apparent area"}), caption=caption
    )
