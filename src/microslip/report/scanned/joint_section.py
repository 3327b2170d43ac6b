"""The joint that a scan makes under a load: by each law of the heights, against both cut-offs."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from typing import Any

import numpy as np

from microslip._core.quantities import json_value, named
from microslip._core.units import engineering, prefix, significant
from microslip.errors import InputError
from microslip.figures.kit import EDGE, Family, families, length_prefix, look_of
from microslip.figures.picture import Picture
from microslip.figures.plot import (
    COLORS,
    DASHED,
    DOTTED,
    Axis,
    Band,
    Entry,
    Panel,
    Plot,
    Rule,
    beside,
)
from microslip.friction import Interface
from microslip.heights import Gaussian
from microslip.normal import NormalLaw, PerssonCurve
from microslip.normal.figures import face_plot
from microslip.report.document import Block, Column, Note, Section, Table
from microslip.report.files import csv_text
from microslip.scans.findings import ESTIMATES, Findings
from microslip.scans.height_laws import HeightLaws
from microslip.scans.joint_over_cutoffs import JOINT_UNITS, JointOverCutoffs
from microslip.scans.joints import PointByPoint, ProfileJoint

_LABELS = {
    "tangential_stiffness": "tangential stiffness",
    "real_area": "real/apparent area",
    "plasticity_index": "plasticity index",
    "contact_radius_over_cutoff": "contact radius/cut-off",
    "loss_factor": "loss factor η",
}


_COLUMNS = (
    Column("separation", "separation", "m", 3),
    Column("contacts", "contacts", "", 3),
    Column("real_area", "real/apparent", "", 3),
    Column("tangential_stiffness", "stiffness", "N/m", 3),
    Column("loss_factor", "η", "", 3),
    Column("above", "load above highest", "", 2),
)
"""Numbers of a joint at rest by one law."""


def sections(findings: Findings, say: Callable[[str], str] = str) -> list[Section]:
    """Both sections of the joint; none where no joint was asked for."""
    if findings.of_profile is not None:
        return [_of_profile(findings.of_profile)]
    if findings.laws is None or findings.joint_table is None:
        return []
    return [
        Section(
            f"The joint at {engineering(findings.laws.normal_load, 'N', 4)}",
            _by_law(findings.laws, findings.contact, say),
        ),
        Section(
            "The joint against both cut-offs", _against_cutoffs(findings.joint_table), brief=False
        ),
    ]


def summary(findings: Findings) -> dict[str, Any] | None:
    """The same as plain values."""
    laws, table, contact = findings.laws, findings.joint_table, findings.contact
    if (profile := findings.of_profile) is not None:
        found = {
            **named(profile, "normal_load", "area", "scatter"),
            **named(profile.surface, "roll_off", "shortest"),
            "recommended": "rough",
            "laws": {name: vars(law) for name, law in profile.laws.items()},
        }
        return {key: json_value(value) for key, value in found.items()}
    if laws is None or table is None:
        return None
    slopes = ("cutoff", "long_cutoff")
    data = {
        "materials": findings.request.materials or (),
        **named(laws, "normal_load", "area"),
        **named(findings.request, "friction_coefficient", "amplitude"),
        **named(laws, "measured_contacts", "scatter", "recommended", "reason"),
        "laws": {name: vars(law) for name, law in laws.laws.items()},
        "point_by_point": None if contact is None else _contact_data(contact),
        "heights": table.heights,
        "over_both_cutoffs": rows(table),
        "slopes": {name: {key: table.slope(name, key) for key in slopes} for name in JOINT_UNITS},
        "patches": {
            name: {"bias": table.bias(name), "values": values}
            for name, values in table.patches.items()
        },
    }
    return {key: json_value(value) for key, value in data.items()}


def _of_profile(joint: ProfileJoint) -> Section:
    """The joint of a profile by each law, and what it rests on."""
    names = {"rough": "its spectrum *"} | {name: ESTIMATES[name] for name in ("mccool", "nayak")}
    columns = Column("law", "by"), *_COLUMNS[:-1]
    rows = tuple(
        (names[name], *(getattr(law, column.key) for column in columns[1:]))
        for name, law in joint.laws.items()
    )
    surface = joint.surface
    scatter = "" if joint.scatter is None else f" Pieces of it scatter by {joint.scatter:.1%}."
    note = (
        f'* law = "rough" with waves from {engineering(surface.roll_off, "m")} to '
        f"{engineering(surface.shortest, 'm')} and Rq {engineering(surface.rms, 'm')}: that of "
        f"boundary elements to about 20 % if the face is isotropic, which a profile cannot "
        f"show.{scatter} "
        "Summits from moments alone do not interact."
    )
    title = f"The joint at {engineering(joint.normal_load, 'N', 4)}"
    return Section(title, (Table("", columns, rows), Note(note)))


def _contact_data(contact: PointByPoint) -> dict[str, Any]:
    if contact.law is None:
        return {"missing": contact.missing}
    return {**vars(contact.at_load), **asdict(contact.law.numbers)}


def rows(table: JointOverCutoffs) -> list[dict[str, float]]:
    """A row for each pair of cut-offs; none is not a number."""
    return [
        {
            "cutoff": float(short) or math.nan,
            "long_cutoff": float(long) if math.isfinite(long) else math.nan,
            **{name: float(values[row, column]) for name, values in table.values.items()},
        }
        for row, long in enumerate(table.long_cutoff)
        for column, short in enumerate(table.cutoff)
    ]


def as_csv(table: JointOverCutoffs) -> str:
    """The table as CSV; empty where there is no cut-off or no value."""
    units = {"cutoff": "m", "long_cutoff": "m", **JOINT_UNITS}
    heads = (f"{name} [{unit}]" for name, unit in units.items())
    return csv_text(heads, (row.values() for row in rows(table)))


def pictures(findings: Findings) -> tuple[Picture, ...]:
    """The figure over both cut-offs; none where no joint was asked for."""
    table = findings.joint_table
    if table is None:
        return ()
    caption = (
        "The joint against both cut-offs of the scan, a line for each long-wave one, at "
        f"{engineering(table.normal_load, 'N', 4)} on {table.area * 1e6:.4g} mm², heights as "
        f"{table.heights}. A line that is not level depends on the short-wave cut-off, lines "
        "that are apart on the long-wave one."
    )
    alternative = (
        "Stiffness, real area, plasticity index, contact radius and loss factor over cut-offs"
    )
    over_cutoffs = Picture("joint_cutoffs", caption, lambda: _plot(findings, table), alternative)
    return over_cutoffs, *_contact_pictures(findings)


def _contact_pictures(findings: Findings) -> tuple[Picture, ...]:
    """The face point by point, and its loop, beside those of other laws; none if not solved."""
    contact = findings.contact
    if contact is None or contact.joint is None or contact.law is None:
        return ()
    joint, law = contact.joint, contact.law

    def other_laws() -> dict[str, NormalLaw]:
        pair, summits = findings.request.pair(), findings.summits
        assert pair is not None
        assert summits is not None
        one_by_one = summits.to_surface(pair, law.area, heights="population")
        laws: dict[str, NormalLaw] = {"summits one by one": one_by_one}
        with suppress(InputError):
            hardness = law.numbers.hardness
            laws["summits that yielded"] = one_by_one.tightened(
                joint.normal_load, hardness=hardness
            )
        with suppress(InputError):
            laws["Gaussian summits"] = summits.to_surface(pair, law.area)
        with suppress(InputError):
            spectrum = PerssonCurve.from_spectrum(findings.spectrum, pair, law.area)
            laws["Persson"] = spectrum.to_surface()
        return laws

    def loops() -> Plot:
        amplitude = 1.5 * joint.force_limit / joint.tangential_stiffness
        unit, letter = length_prefix(amplitude)
        panel = Panel(Axis(f"Displacement [{letter}m]"), Axis("Force over normal load, T/N"))
        entries = []
        every_joint = {"point by point": joint}
        for name, other in other_laws().items():
            with suppress(InputError):
                every_joint[name] = Interface(other, joint.friction_coefficient, joint.normal_load)
        for color, (name, by_law) in zip(COLORS, every_joint.items(), strict=False):
            loop = by_law.loop(amplitude)
            panel.line(loop.displacement / unit, loop.force / joint.normal_load, color)
            entries.append(Entry(name, color))
        panel.cross()
        return Plot([panel], 3.8, findings.title("Loops by every law"), legend=tuple(entries))

    return (
        Picture(
            "contact",
            "The scan point by point: pressures of its first piece under the load, its contacts "
            "under this load and two lighter ones, and the load against the separation beside "
            "that of other laws, from the separation at which each carries the load.",
            lambda: face_plot(law, other_laws()),
            "Pressures, contacts and loads of the scan solved point by point",
        ),
        Picture(
            "contact_loops",
            "A loop of the joint by every law, with an amplitude of 1.5 times the displacement at "
            "which the first tangent meets the force limit.",
            loops,
            "Hysteresis loops by every law of the scan",
        ),
    )


def _by_law(
    laws: HeightLaws, contact: PointByPoint | None, say: Callable[[str], str]
) -> tuple[Block, ...]:
    at_load: dict[str, Any] = dict(laws.laws)
    words: tuple[Note, ...] = ()
    if contact is not None:
        words = (Note(say(contact.words())),)
        if contact.at_load is not None:
            at_load["point by point"] = contact.at_load
    values = tuple(
        (
            name + " *" * (name == laws.recommended),
            *(getattr(law, column.key) for column in _COLUMNS),
        )
        for name, law in at_load.items()
    )
    scatter = f"{significant(100.0 * laws.scatter, 2)} %" if laws.scatter < 10.0 else "all of it"
    note = (
        f'* heights = "{laws.recommended}" is recommended for this load: {laws.reason}. '
        f"{laws.measured_contacts} summits of the scan carry the load; were they independent, "
        f"their stiffness would scatter by {scatter} from scan to scan; correlated, they "
        "scatter more."
    )
    return Table("", (Column("heights", "heights"), *_COLUMNS), values), *words, Note(note)


def _against_cutoffs(table: JointOverCutoffs) -> tuple[Block, ...]:
    place = table.chosen[0] * table.cutoff.size + table.chosen[1]
    pairs = tuple(
        (
            _length(row["long_cutoff"]) + " *" * (number == place),
            _length(row["cutoff"]),
            *(json_value(row[name]) for name in table.values),
        )
        for number, row in enumerate(rows(table))
    )
    columns = (
        Column("long_cutoff", "long-wave"),
        Column("cutoff", "short-wave"),
        *(
            Column(name, _LABELS[name], "" if unit == "-" else unit, 3)
            for name, unit in JOINT_UNITS.items()
        ),
    )
    heads = (
        Column("quantity", "quantity"),
        Column("cutoff", "short-wave", "", 2),
        Column("long_cutoff", "long-wave", "", 2),
        Column("patches", "× on patches", "", 3),
    )
    slopes = tuple(
        (
            _LABELS[name],
            *(json_value(table.slope(name, key)) for key in ("cutoff", "long_cutoff")),
            json_value(table.bias(name)),
        )
        for name, values in table.values.items()
        if np.isfinite(values[table.chosen])
    )
    return (
        Table("", columns, pairs, keys=2, noun="pairs of cut-offs"),
        Table("Slopes d ln/d ln at *", heads, slopes),
        Note(
            f"* chosen cut-offs, heights as {table.heights}. A slope of 0.5 is 41 % for a "
            "cut-off twice as long; with no long-wave cut-off, the size of the scan is one. On "
            "patches: the mean of two by two patches, each levelled like the scan, over the value "
            "of the whole scan."
        ),
    )


def _length(cutoff: float) -> str:
    return "none" if math.isnan(cutoff) else engineering(cutoff, "m")


def _plot(findings: Findings, table: JointOverCutoffs) -> Plot:
    """A panel for each quantity, a line for each long-wave cut-off."""
    places = table.cutoff.copy()
    places[places == 0.0] = min(findings.scan.pixel)
    unit, letter = length_prefix(float(places[-1]), float(places[0]))
    ticks = [
        (float(at) / unit, "none" if label == 0.0 else f"{at / unit:.3g}")
        for at, label in zip(places, table.cutoff, strict=True)
    ]

    def axis(below: bool) -> Axis:
        label = "" if below else f"Short-wave cut-off [{letter}m]"
        ends = 0.75 * float(places[0]) / unit, 1.33 * float(places[-1]) / unit
        return Axis(label, *ends, log=True, ticks=ticks, bare=below)

    contents = [
        Family(
            _LABELS[name].capitalize(),
            JOINT_UNITS[name],
            [(look_of(i), line) for i, line in enumerate(values)],
        )
        for name, values in table.values.items()
        if np.isfinite(values).any()
    ]
    asked_cutoff = float(places[table.chosen[1]]) / unit
    plot = families(contents, places / unit, axis, asked_cutoff, 2.9, 0.6)
    texts = (
        "no long-wave cut-off" if math.isinf(long) else engineering(float(long), "m")
        for long in table.long_cutoff
    )
    plot.title = findings.title("The joint against both cut-offs")
    plot.legend_title = "Long-wave cut-off"
    plot.legend = tuple(look_of(index).entry(text) for index, text in enumerate(texts))
    return plot


# -- the heights of the summits -------------------------------------------------------------------


def tail_picture(findings: Findings) -> tuple[Picture, ...]:
    """Summit heights against their distribution; none where there are no summits."""
    if findings.summits is None or findings.summits.count < 2 or not findings.summits.std > 0.0:
        return ()
    caption = (
        "Number of summits above a height: counted, and by the Gaussian with their mean and "
        "standard deviation, which continues above the highest measured summit (dotted)."
    )
    if findings.laws is not None:
        caption += (
            " Grey: in contact at the load, by the counted summits. Beside it the share of the "
            "load that is carried above a height: the share of the Gaussian above the dotted line "
            "is carried by summits higher than any measured one."
        )
    alternative = "Number of summits above a height, counted and Gaussian, and the loaded tail"
    return (Picture("summit_heights", caption, lambda: _tail_plot(findings), alternative),)


def _tail_plot(findings: Findings) -> Plot:
    summits, laws = findings.summits, findings.laws
    assert summits is not None
    ordered = np.sort(summits.heights)[::-1]
    gaussian = Gaussian(summits.std, summits.mean_height)
    low, high = float(ordered[-1]), float(ordered[0])
    reach = max(high, summits.mean_height + 4.5 * summits.std)
    if laws is not None and "gaussian" in laws.laws:
        reach = max(reach, laws.laws["gaussian"].separation + 2.0 * summits.std)
    low = max(low, summits.mean_height - 4.0 * summits.std)
    unit, letter = prefix(max(abs(low), abs(reach)))
    places = np.linspace(low, reach, 400)
    count = float(summits.count)
    ends = low / unit, (reach + 0.02 * (reach - low)) / unit
    first = Panel(
        Axis(f"Height above the mean [{letter}m]", *ends),
        Axis("Summits above the height", 0.01, 2.0 * count, log=True),
        note="(a) summits, counted and Gaussian",
    )
    panels = [first]
    if laws is not None:
        first.add(Band(laws.laws["population"].separation / unit, ends[1], "x"))
    steps = np.repeat(ordered, 2) / unit
    first.line(steps, np.repeat(np.arange(ordered.size + 1.0), 2)[1:-1], COLORS[1])
    above = count * np.asarray(gaussian.probability_above(places))
    first.line(places / unit, above, COLORS[2], dash=DASHED)
    first.add(Rule(high / unit, "x", EDGE, 0.9, DOTTED))
    legend = [
        Entry("counted", COLORS[1]),
        Entry("Gaussian", COLORS[2], DASHED),
        Entry("highest measured summit", EDGE, DOTTED),
    ]
    if laws is not None:
        second = Panel(
            Axis(f"Height above the mean [{letter}m]", *ends),
            Axis("Share of the load above the height", 0.0, 1.05),
            note=f"(b) load of {engineering(laws.normal_load, 'N', 4)}",
        )
        depth = np.maximum(ordered - laws.laws["population"].separation, 0.0)
        order = np.argsort(-summits.heights, kind="stable")
        part = np.sqrt(summits.radii[order]) * depth**1.5
        shares = np.concatenate([[0.0], np.cumsum(part) / part.sum()])
        second.line(steps, np.repeat(shares, 2)[1:-1], COLORS[1])
        if "gaussian" in laws.laws:
            surface = findings.gaussian_surface()
            at = laws.laws["gaussian"].separation
            load_shares = [surface.load_share_above(float(z), at) for z in places]
            second.line(places / unit, np.array(load_shares), COLORS[2], dash=DASHED)
        second.add(Rule(high / unit, "x", EDGE, 0.9, DOTTED))
        panels.append(second)
        legend.append(Entry("in contact, by the counted", "#e8e8e8"))
    return beside(panels, 3.7, findings.title("Summit heights"), legend)
