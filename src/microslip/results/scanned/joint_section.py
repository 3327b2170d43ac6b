"""The joint that a scan makes under a load: by each law of the heights, against both cut-offs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering, prefix, significant
from microslip.friction import Interface
from microslip.report.document import Block, Column, Note, Picture, Section, Table
from microslip.report.plot import COLORS, DASHED, DASHES, MARKERS, Axis, Entry, Panel, Plot, Rule
from microslip.report.scales import length_prefix
from microslip.results.scanned.findings import Findings
from microslip.scans.ellipses import elliptic_surface
from microslip.scans.height_laws import HeightLaws
from microslip.scans.joint_over_cutoffs import WANTED, JointOverCutoffs

_LABELS = {
    "tangential_stiffness": "tangential stiffness",
    "real_area": "real/apparent area",
    "plasticity_index": "plasticity index",
    "contact_radius_over_cutoff": "contact radius/cut-off",
    "loss_factor": "loss factor η",
}


def sections(found: Findings) -> list[Section]:
    """Both sections of the joint; none where no joint was asked for."""
    if found.laws is None or found.joint_table is None:
        return []
    return [
        Section(
            f"The joint at {engineering(found.laws.normal_load, 'N', 4)}",
            (*_by_law(found.laws), *_elliptic_note(found)),
        ),
        Section(
            "The joint against both cut-offs", _against_cutoffs(found.joint_table), brief=False
        ),
    ]


def summary(found: Findings) -> dict[str, Any] | None:
    """The same as plain values."""
    laws, table = found.laws, found.joint_table
    if laws is None or table is None:
        return None
    return {
        "materials": list(found.request.materials or ()),
        "normal_load": laws.normal_load,
        "area": laws.area,
        "friction_coefficient": found.request.friction_coefficient,
        "amplitude": found.request.amplitude,
        "measured_contacts": laws.measured_contacts,
        "scatter": _plain(laws.scatter),
        "recommended": laws.recommended,
        "reason": laws.reason,
        "laws": {
            name: {key: _plain(value) for key, value in vars(law).items()}
            for name, law in laws.laws.items()
        },
        "elliptic": _elliptic(found),
        "heights": table.heights,
        "over_both_cutoffs": [
            {key: _plain(value) for key, value in row.items()} for row in rows(table)
        ],
        "slopes": {
            name: {which: _plain(table.slope(name, which)) for which in ("cutoff", "long_cutoff")}
            for name in WANTED
        },
        "patches": {
            name: {"bias": _plain(table.bias(name)), "values": [_plain(v) for v in values]}
            for name, values in table.patches.items()
        },
    }


def _elliptic(found: Findings) -> dict[str, float] | None:
    """The joint of elliptic summits in the direction of motion; None where none is given."""
    pair, laws, request = found.request.pair(), found.laws, found.request
    if request.direction is None or pair is None or laws is None or found.summits is None:
        return None
    surface = elliptic_surface(found.summits, pair, laws.area, direction=request.direction)
    joint = Interface(surface, request.friction_coefficient, laws.normal_load)
    return {
        "direction": request.direction,
        "curvature_ratio": surface.curvature_ratio,
        "angle_to_lay": surface.direction,
        "tangential_stiffness": joint.tangential_stiffness,
        "round_stiffness": joint.normal_stiffness / pair.stiffness_ratio,
    }


def _elliptic_note(found: Findings) -> tuple[Note, ...]:
    known = _elliptic(found)
    if known is None:
        return ()
    share = known["tangential_stiffness"] / known["round_stiffness"]
    return (
        Note(
            f"Elliptic summits of Gaussian heights, moved at "
            f"{math.degrees(known['direction']):.4g}° from the x of the scan and "
            f"{math.degrees(known['angle_to_lay']):.3g}° from the lay, curvature along it "
            f"{significant(known['curvature_ratio'])} of that across: stiffness "
            f"{engineering(known['tangential_stiffness'], 'N/m')}, {significant(share)} times "
            "that of the same contacts moved as circles are."
        ),
    )


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
    units = {"cutoff": "m", "long_cutoff": "m", **WANTED}
    lines = [",".join(f"{name} [{unit}]" for name, unit in units.items())]
    for row in rows(table):
        lines.append(",".join("" if value != value else repr(value) for value in row.values()))
    return "\n".join(lines) + "\n"


def pictures(found: Findings) -> tuple[Picture, ...]:
    """The figure over both cut-offs; none where no joint was asked for."""
    table = found.joint_table
    if table is None:
        return ()
    return (
        Picture(
            "joint_cutoffs",
            "The joint against both cut-offs of the scan, a line for each long-wave one, at "
            f"{engineering(table.normal_load, 'N', 4)} on {table.area * 1e6:.4g} mm², heights as "
            f"{table.heights}. A line that is not level hangs on the short-wave cut-off, lines "
            "that are apart on the long-wave one.",
            lambda: _plot(found, table),
            "Stiffness, real area, plasticity index, contact radius and loss factor over cut-offs",
        ),
    )


def _by_law(laws: HeightLaws) -> tuple[Block, ...]:
    columns = (
        Column("heights", "heights"),
        Column("separation", "separation", "m", 3),
        Column("contacts", "contacts", "", 3),
        Column("real_area", "real/apparent", "", 3),
        Column("tangential_stiffness", "stiffness", "N/m", 3),
        Column("loss_factor", "η", "", 3),
        Column("above", "load above highest", "", 2),
    )
    table = Table(
        "",
        columns,
        tuple(
            (
                name + " *" * (name == laws.recommended),
                law.separation,
                law.contacts,
                law.real_area,
                law.tangential_stiffness,
                law.loss_factor,
                law.above,
            )
            for name, law in laws.laws.items()
        ),
    )
    scatter = f"{significant(100.0 * laws.scatter, 2)} %" if laws.scatter < 10.0 else "all of it"
    return (
        table,
        Note(
            f'* heights = "{laws.recommended}" is what the loaded tail bears: {laws.reason}. '
            f"{laws.measured_contacts} summits of the scan carry the load; were they independent, "
            f"their stiffness would scatter by {scatter} from scan to scan, and by more as they "
            "are not."
        ),
    )


def _against_cutoffs(table: JointOverCutoffs) -> tuple[Block, ...]:
    chosen = table.chosen
    told = []
    for row, long in enumerate(table.long_cutoff):
        for column, short in enumerate(table.cutoff):
            mark = " *" if (row, column) == chosen else ""
            told.append(
                (
                    ("none" if math.isinf(long) else engineering(float(long), "m")) + mark,
                    "none" if short == 0.0 else engineering(float(short), "m"),
                    *(_known(values[row, column]) for values in table.values.values()),
                )
            )
    columns = (
        Column("long_cutoff", "long-wave"),
        Column("cutoff", "short-wave"),
        *(
            Column(name, _LABELS[name], "" if unit == "-" else unit, 3)
            for name, unit in WANTED.items()
        ),
    )
    slopes = Table(
        "Slopes d ln/d ln at *",
        (
            Column("quantity", "quantity"),
            Column("cutoff", "short-wave", "", 2),
            Column("long_cutoff", "long-wave", "", 2),
            Column("patches", "× on patches", "", 3),
        ),
        tuple(
            (
                _LABELS[name],
                *(_known(table.slope(name, key)) for key in ("cutoff", "long_cutoff")),
                _known(table.bias(name)),
            )
            for name, values in table.values.items()
            if np.isfinite(values[chosen])
        ),
    )
    return (
        Table("", columns, tuple(told), keys=2, noun="pairs of cut-offs"),
        slopes,
        Note(
            f"* what was asked for, heights as {table.heights}. A slope of 0.5 is 41 % for a "
            "cut-off twice as long; with no long-wave cut-off, the size of the scan is one. On "
            "patches: the mean of two by two of them, each levelled as if it were the scan, over "
            "the whole."
        ),
    )


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _plain(value: Any) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _plot(found: Findings, table: JointOverCutoffs) -> Plot:
    """A panel for each quantity, a line for each long-wave cut-off."""
    shown = [name for name, values in table.values.items() if np.isfinite(values).any()]
    places = table.cutoff.copy()
    pixel = min(found.scan.pixel)
    places[places == 0.0] = pixel
    unit, letter = length_prefix(float(places[-1]), float(places[0]))
    ticks = [
        (float(at) / unit, "none" if own == 0.0 else f"{at / unit:.3g}")
        for at, own in zip(places, table.cutoff, strict=True)
    ]
    panels = []
    rows_of_panels = 1 if len(shown) <= 3 else 2
    for number, name in enumerate(shown):
        row, column = divmod(number, 3)
        values = table.values[name]
        scale, own = _scale(values, WANTED[name])
        below = number + 3 < len(shown)
        panel = Panel(
            Axis(
                "" if below else f"Short-wave cut-off [{letter}m]",
                0.75 * float(places[0]) / unit,
                1.33 * float(places[-1]) / unit,
                log=True,
                ticks=ticks,
                bare=below,
            ),
            Axis(log=_wide(values)),
            note=f"{_LABELS[name].capitalize()} [{own}]",
            cell=(row, row, column, column),
        )
        panel.add(Rule(float(places[table.chosen[1]]) / unit, "x", "#444444", 0.9, (1.0, 1.0)))
        for index, line in enumerate(values):
            color, dash = _look(index)
            panel.line(places / unit, line / scale, color, dash=dash)
            panel.marks(places / unit, line / scale, color, marker=MARKERS[index % len(MARKERS)])
        panels.append(panel)
    legend = []
    for index, long in enumerate(table.long_cutoff):
        color, dash = _look(index)
        text = "no long-wave cut-off" if math.isinf(long) else engineering(float(long), "m")
        legend.append(Entry(text, color, dash, MARKERS[index % len(MARKERS)]))
    return Plot(
        panels,
        2.9 * rows_of_panels + 0.6,
        found.title("The joint against both cut-offs"),
        heights=(1.0,) * rows_of_panels,
        widths=(1.0, 1.0, 1.0)[: max(1, min(3, len(shown)))],
        legend=tuple(legend),
        legend_title="Long-wave cut-off",
    )


def _look(index: int) -> tuple[str, tuple[float, ...]]:
    return COLORS[index % len(COLORS)], DASHES[index % len(DASHES)]


def _wide(values: Floats) -> bool:
    good = values[np.isfinite(values) & (values > 0.0)]
    return bool(good.size and good.max() > 3.0 * good.min())


def _scale(values: Floats, unit: str) -> tuple[float, str]:
    if unit == "-":
        return 1.0, "–"
    good = values[np.isfinite(values) & (values > 0.0)]
    factor, letter = prefix(float(np.sqrt(good.min() * good.max())) if good.size else 1.0)
    return factor, f"{letter}{unit}"


# -- the heights of the summits -------------------------------------------------------------------


def tail_picture(found: Findings) -> tuple[Picture, ...]:
    """Summit heights against their distribution; none where there are no summits."""
    if found.summits is None or found.summits.count < 2 or not found.summits.std > 0.0:
        return ()
    loaded = found.laws is not None
    caption = (
        "Summits higher than a height: counted, and by the Gaussian with their mean and standard "
        "deviation, which goes on above the highest that was measured (dotted)."
    )
    if loaded:
        caption += (
            " Grey is what touches at the load, by the counted summits. Beside it the share of the "
            "load that is carried above a height: what the Gaussian puts above the dotted line is "
            "carried by summits that nobody has measured."
        )
    return (
        Picture(
            "summit_heights",
            caption,
            lambda: _tail_plot(found),
            "Number of summits above a height, counted and Gaussian, and the loaded tail",
        ),
    )


def _tail_plot(found: Findings) -> Plot:
    from microslip.heights import Gaussian
    from microslip.report.plot import Band

    summits, laws = found.summits, found.laws
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
        cell=(0, 0, 0, 0),
    )
    panels = [first]
    if laws is not None:
        first.add(Band(laws.laws["population"].separation / unit, ends[1], "x"))
    steps = np.repeat(ordered, 2) / unit
    first.line(steps, np.repeat(np.arange(ordered.size + 1.0), 2)[1:-1], COLORS[1])
    above = count * np.asarray(gaussian.probability_above(places))
    first.line(places / unit, above, COLORS[2], dash=DASHED)
    first.add(Rule(high / unit, "x", "#444444", 0.9, (1.0, 2.0)))
    legend = [
        Entry("counted", COLORS[1]),
        Entry("Gaussian", COLORS[2], DASHED),
        Entry("highest measured summit", "#444444", (1.0, 2.0)),
    ]
    if laws is not None:
        second = Panel(
            Axis(f"Height above the mean [{letter}m]", *ends),
            Axis("Share of the load above the height", 0.0, 1.05),
            note=f"(b) load of {engineering(laws.normal_load, 'N', 4)}",
            cell=(0, 0, 1, 1),
        )
        depth = np.maximum(ordered - laws.laws["population"].separation, 0.0)
        order = np.argsort(-summits.heights, kind="stable")
        part = np.sqrt(summits.radii[order]) * depth**1.5
        shares = np.concatenate([[0.0], np.cumsum(part) / part.sum()])
        second.line(steps, np.repeat(shares, 2)[1:-1], COLORS[1])
        if "gaussian" in laws.laws:
            surface = found.gaussian_surface()
            at = laws.laws["gaussian"].separation
            own = [surface.load_share_above(float(z), at) for z in places]
            second.line(places / unit, np.array(own), COLORS[2], dash=DASHED)
        second.add(Rule(high / unit, "x", "#444444", 0.9, (1.0, 2.0)))
        panels.append(second)
        legend.append(Entry("in contact, by the counted", "#e8e8e8"))
    return Plot(
        panels,
        3.7,
        found.title("Summit heights"),
        widths=(1.0,) * len(panels),
        legend=tuple(legend),
    )
