"""Identified joints: document and files of a fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from microslip._core.errors import InputError
from microslip._core.quantities import json_value
from microslip._core.units import significant
from microslip._core.wording import capital
from microslip._version import __version__
from microslip.identification import Comparison, Identification, figures, identify
from microslip.identification.caveats import HAS_VALUE, label
from microslip.identification.models import model_of
from microslip.laboratory import Measurement, Record, measure
from microslip.laboratory.campaign import Campaign
from microslip.laboratory.regimes import RegimeBorders, borders_of
from microslip.report import measured_campaign as together
from microslip.report.document import (
    Block,
    Column,
    Document,
    Items,
    Judged,
    Listing,
    Note,
    Section,
    Table,
    Verdicts,
)
from microslip.report.files import csv_text, header, text_cell, text_file
from microslip.report.identified import numbers
from microslip.report.identified.numbers import Summary, joint_text

if TYPE_CHECKING:
    from microslip.study.description import StudyDescription

KIND = "microslip-identification"
"""Kind of a folder of an identified joint in summary.json."""

Say = Callable[[str], str]
"""Puts messages into the words of who asked, such as the options of a command."""

_METHOD = (
    "The settled cycles of each record are folded on one; their scatter gives the noise of force "
    "and displacement. All records are fitted at once by weighted least squares with exact "
    "derivatives. The rig is a spring in series; force offsets and errors of the displacement are "
    "nuisances, which are taken out of the residuals. An interval is where the profile of the "
    "likelihood, all other parameters fitted again, stays above its limit at {level}; where it "
    "does not close, there is no interval, and the parameter is not identified."
)
_GIVEN_NUMBERS = (
    "Found minus given, in standard deviations of the given value; and by how many of them it "
    "contradicts the records and all else: the root of the decrease of χ² without it. Beyond 3 "
    "they disagree, and all that depends on the value is in doubt."
)
_RESIDUALS = (
    "χ² is the sum of the squared residuals over their noise, which is taken from the scatter of "
    "the cycles; reduced, it is 1 where model and noise explain the records. The residual is the "
    "root mean square of measured minus modelled force over the mean cycle. The noise is that of "
    "one sample; that of the mean cycle is smaller by the root of the number of samples averaged. "
    "The energy is that of a cycle, measured minus modelled over measured, with its standard error."
)
_LAWS = (
    "Smaller is better: the criteria of Akaike and of Schwarz penalise parameters. Held-back "
    "cycles were predicted, not fitted; their error is over the noise, and 1 is the best possible."
)


@dataclass(frozen=True)
class Identified:
    """Result of one run of ``identify``."""

    results: tuple[Identification, ...]
    """One for each law; the first is what the pictures and the study are of."""
    comparison: Comparison | None
    study: StudyDescription | None
    """The study that materials and start are from."""
    left_out: tuple[str, ...] = ()
    """Keys of the study that the fit does not follow."""
    skipped: tuple[tuple[str, str], ...] = ()
    """Files that could not be read, and why."""
    campaign: Campaign | None = None
    """The cycles of several records, measured."""

    @property
    def first(self) -> Identification:
        """The law that was asked for first."""
        return self.results[0]


def units_of(laws: Sequence[str]) -> dict[str, str]:
    """SI units of the parameters that some laws have, and of the rig's stiffness."""
    units = {
        parameter.name: parameter.unit for law in laws for parameter in model_of(law).parameters
    }
    return {**units, "rig_stiffness": "N/m"}


def identified(
    records: Sequence[Record],
    laws: Sequence[str],
    study: StudyDescription | None,
    options: Mapping[str, Any],
    progress: Callable[[float], None],
) -> Identified:
    """Identify laws from records: the first is reported, the others are compared with it.

    Materials, kind of heights and start of an interface are those of the study; ``options`` are
    as :func:`microslip.identify` takes them.
    """
    fits: dict[str, Identification] = {}
    failed: dict[str, str] = {}
    left_out: list[str] = []
    for index, law in enumerate(laws):
        keywords, names = dict(options), units_of([law])
        for key in ("fixed", "bounds"):
            keywords[key] = {name: value for name, value in options[key].items() if name in names}
        if law != "interface":
            keywords["contact_area"] = keywords["known"] = keywords["summits"] = None
        if index > 0:
            keywords["intervals"] = "curvature"  # of what is compared there are no profiles
        model: Any = law
        if law == "interface" and study is not None:
            from microslip.study.build import build_as_made  # all that reads studies

            model, left_out = build_as_made(study)

        def report(share: float, index: int = index) -> None:
            progress((index + share) / len(laws))

        try:
            fits[law] = identify(records, model, progress=report, **keywords)
        except InputError as error:
            if index == 0:
                raise
            failed[law] = str(error)
    comparison = None
    if len(laws) > 1:
        ordered = sorted(fits.items(), key=lambda item: (not item[1].converged, item[1].aic))
        comparison = Comparison(MappingProxyType(dict(ordered)), MappingProxyType(failed))
    return Identified(tuple(fits.values()), comparison, study, tuple(left_out))


def measured_together(
    records: Sequence[Record],
    confidence: float,
    cycles: slice | None,
    counted: Callable[[Measurement, int], Measurement],
    first: Identification,
    known: Callable[[list[int]], dict[str, Any]],
) -> Campaign | None:
    """Several records measured; those that cannot be are left to what is said of their fit.

    ``counted`` gives a record's cycles their numbers, ``known`` what else a campaign knows of some
    records; the borders of the regimes are those of the law that was found ``first``.
    """
    indices, measurements = [], []
    for index, record in enumerate(records if len(records) > 1 else ()):
        try:
            measured = measure(record, confidence=confidence, cycles=cycles)
        except InputError:
            continue
        measurements.append(counted(measured, index))
        indices.append(index)
    if len(measurements) < 2:
        return None
    loads = [load.value for m in measurements if (load := m.mean.get("normal_load")) is not None]
    borders = _borders(first, loads)
    return Campaign(tuple(measurements), borders=borders, **known(indices))


def _borders(first: Identification, loads: Sequence[float]) -> RegimeBorders | None:
    """Regime borders of the identified law, its rig in series; None without a rig."""
    rig = first.parameters.get("rig_stiffness")
    if first.law != "interface" or (rig is not None and rig.verdict not in HAS_VALUE):
        return None
    try:
        return borders_of(first.joint, loads, None if rig is None else rig.value)
    except InputError:  # the records do not tell the joint
        return None


# -- plain values ---------------------------------------------------------------------------------


def summarise(outcome: Identified, say: Say = str, *, labelled: bool = False) -> dict[str, Any]:
    """Content of summary.json: plain values in SI units, messages as ``say`` puts them.

    For people numbers are ``labelled`` in the messages.
    """
    first, *comparisons = (_spelt(result, say, labelled) for result in outcome.results)
    for record, values in zip(outcome.first.records, first["records"], strict=True):
        values["rms_residual"] = math.sqrt(float((record.residual**2).mean()))
    if outcome.left_out:
        first["notes"].append(
            f"{' and '.join(outcome.left_out)} of the study: left out, since a fit describes an "
            "evenly pressed surface; its heights are those in effect in the records."
        )
    title = "" if outcome.study is None else outcome.study.title
    return {
        **header(KIND, 1, f"{title}: identified" if title else "Identified joint"),
        "version": __version__,
        "skipped": [{"file": name, "reason": why} for name, why in outcome.skipped],
        "study": None if outcome.study is None else outcome.study.name,
        "identification": first,
        "others": comparisons,
        "comparison": None if outcome.comparison is None else _compared(outcome.comparison),
        "files": [],
    }


def _spelt(result: Identification, say: Say, labelled: bool) -> dict[str, Any]:
    """The summary of a fit with its messages as who asked puts them."""

    def named(name: str) -> str:
        number = result.parameters.get(name)
        return label(name, None if number is None else number.load)

    summary = result.summary(call=named) if labelled else result.summary()
    summary["message"] = say(summary["message"])
    summary["notes"] = [say(note) for note in summary["notes"]]
    for number in (*summary["parameters"].values(), *summary["derived"].values()):
        number["reason"], number["remedy"] = say(number["reason"]), say(number["remedy"])
    return summary


def _compared(comparison: Comparison) -> dict[str, Any]:
    """Laws side by side, the best first."""
    ends = ("value", "low", "high", "unit", "low_open", "high_open")
    data = {
        "best": comparison.best,
        "laws": comparison.rows(),
        "rigs": {
            name: {law: {end: getattr(fitted, end) for end in ends} for law, fitted in laws.items()}
            for name, laws in comparison.rigs().items()
        },
        "failed": comparison.failed,
    }
    return {key: json_value(value) for key, value in data.items()}


# -- the document ---------------------------------------------------------------------------------


def document(outcome: Identified, say: Say = str, files: bool = False) -> Document:
    """Identified and unidentified parameters; with ``files`` the reason for no joint.toml."""
    toml, why = joint_text(outcome.first, outcome.study, say)
    pictures = figures.pictures(outcome.first)
    tables = [text_file("residuals.csv", lambda: _residuals(outcome.first))]
    summary = summarise(outcome, say)
    fit = summarise(outcome, say, labelled=True)["identification"]
    comparison = summary["comparison"]
    if why and files:
        for fit_summary in (fit, summary["identification"]):
            fit_summary["notes"].append(why)
    level = f"{100.0 * fit['confidence']:g} %"
    sections = [
        Section("Parameters", tuple(_parameters(fit, summary["study"], level))),
        *_open_section(fit),
        Section("Validity", (Verdicts(numbers.verdicts_of(fit)),)),
        Section("Figures", pictures, brief=False),
        Section("Residuals", (_records(fit["records"]), Items(tuple(numbers.quality_of(fit))))),
    ]
    if (correlations := _correlations(fit)) is not None:
        sections.append(Section("Correlations", (correlations,)))
    if comparison is not None:
        sections.append(Section("Laws compared", tuple(_laws(comparison))))
    if (campaign := outcome.campaign) is not None:
        tables.append(text_file("campaign.csv", lambda: together.csv_of(campaign)))
        table, last = together.sections(campaign, (), fit["confidence"])
        sections += [replace(section, brief=False) for section in table]
        sections += last
        summary["campaign"] = together.data_of(campaign, (), fit["confidence"])
    if toml is not None:
        tables.append(text_file("joint.toml", lambda: toml))
        if (law := numbers.law_json(outcome.first)) is not None:
            tables.append(text_file(numbers.LAW_FILE, lambda: law))
        words = Note("In joint.toml, for: microslip predict joint.toml")
        sections.append(Section("The joint as a study", (words, Listing(toml)), brief=False))
    method = Note(_METHOD.format(level=level))
    sections.append(Section("Method", (method,), brief=False))
    if outcome.skipped:
        unreadable = tuple(f"{name}: {why}" for name, why in outcome.skipped)
        sections.append(
            Section("Left out", (Note("Files that cannot be read:"), Items(unreadable)))
        )
    if fit["notes"]:
        sections.append(Section("Notes", (Items(tuple(fit["notes"])),)))
    return Document(
        KIND,
        summary["title"],
        numbers.headline(fit),
        tuple(sections),
        summary,
        () if outcome.first.is_plain else (f"{capital(fit['message'])}.",),
        numbers.first_number(fit),
        "loops",
        tuple(tables),
    )


def _parameters(fit: Summary, study: str | None, level: str) -> list[Block]:
    blocks: list[Block] = [Note(numbers.sentence(fit))]
    for title, key, noun in (
        ("Parameters", "parameters", "parameter"),
        ("Derived quantities", "derived", "quantity"),
    ):
        columns = (
            Column(noun, noun.capitalize(), short=noun),
            Column("value", f"Value ({level} interval)", short=f"value ({level} interval)"),
            Column("verdict", "Verdict", short="verdict"),
        )
        rows = tuple(
            (
                label(name, number.get("normal_load")),
                numbers.value_and_interval(number),
                Judged(numbers.word_of(number), number["verdict"]),
            )
            for name, number in fit[key].items()
        )
        if rows:
            blocks.append(Table(title, columns, rows))
    blocks += [Note(hint, small=True) for hint in numbers.hints_of(fit, study)]
    if fit["given"]:
        blocks.append(_prior_table(fit))
    return blocks


def _open_section(fit: Summary) -> list[Section]:
    """Open questions of the records; no section where there are none."""
    texts = numbers.open_texts(fit)
    ways = tuple(f"{capital(way['text'])}." for way in fit["directions"])
    blocks: list[Block] = [Items(tuple(texts))]
    if ways:
        note = "Combinations of parameters that change the loops by less than their noise:"
        blocks += [Note(note), Items(ways)]
    return [Section("Not identified", tuple(blocks))] if texts or ways else []


def _prior_table(fit: Summary) -> Table:
    """Values given with an uncertainty beside the identified ones."""
    heads = ("Given values", "Value", "Found", "Deviations", "From other data", "Verdict")
    rows = tuple(
        (
            label(datum["name"]),
            " ± ".join(
                numbers.quantity(datum[key], datum["unit"]) for key in ("value", "uncertainty")
            ),
            numbers.quantity(datum["found"], datum["unit"]),
            numbers.signed(datum["residual"], 2),
            significant(abs(datum["disagreement"]), 2),
            Judged("ok", "agrees") if datum["agrees"] else Judged("outside", "disagrees"),
        )
        for datum in fit["given"]
    )
    return _texts("Given values", heads, rows, _GIVEN_NUMBERS)


def _texts(title: str, heads: Sequence[str], rows: tuple[Any, ...], caption: str = "") -> Table:
    columns = tuple(Column(head.lower().replace(" ", "_"), head, short=head) for head in heads)
    return Table(title, columns, rows, caption=caption)


def _records(records: Sequence[Summary]) -> Table:
    """Residual of each record, and the delay of its force where that was free."""
    columns = (
        Column("name", "Record"),
        Column("normal_load", "N", "N"),
        Column("amplitude", "Amplitude", "m"),
        Column("cycles", "Cycles"),
        Column("rms_residual", "Residual", "N", 3),
        Column("force_noise", "Noise of a sample", "N", 3),
        Column("energy_text", "Energy residual"),
        Column("delay_text", "Delay"),
    )
    late = any(record.get("delay") for record in records)
    rows = []
    for record in records:
        delay = numbers.delay_text(record["delay"]) if late else None
        cells = {**record, "energy_text": numbers.energy_text(record), "delay_text": delay}
        rows.append(tuple(cells[column.key] for column in columns))
    return Table("Residuals", columns, tuple(rows), caption=_RESIDUALS, noun="records")


def _correlations(fit: Summary) -> Table | None:
    """The correlations of the errors, each pair once; None for a single parameter."""
    names, matrix = fit["correlation"]["names"], fit["correlation"]["matrix"]
    if len(names) < 2:
        return None
    labels = [label(name, fit["parameters"][name].get("normal_load")) for name in names]
    places = range(len(names) - 1)
    rows = tuple(
        (labels[i], *(numbers.signed(matrix[i][j]) if j < i else "" for j in places))
        for i in range(1, len(names))
    )
    caption = (
        "Correlations of the errors of the fitted parameters: near 1 or −1 the records determine "
        "only a combination of the two."
    )
    return _texts("Correlations", ["", *labels[:-1]], rows, caption)


def _laws(comparison: Summary) -> list[Block]:
    heads = ("Law", "Status", "Parameters", "Reduced χ²", "AIC", "BIC", "Held back/noise")
    rows = tuple(
        (
            law["law"],
            law["status"],
            law["parameters"],
            significant(law["reduced_chi_squared"]),
            *("–" if law[key] is None else f"{law[key]:.1f}" for key in ("aic", "bic")),
            significant(law["held_back"]),
        )
        for law in comparison["laws"]
    )
    failed = (f"{law}: {why}" for law, why in comparison["failed"].items())
    return [
        _texts("Laws compared", heads, rows, _LAWS),
        Items((*numbers.rig_texts(comparison), *failed)),
    ]


def _residuals(result: Identification) -> str:
    """Measured and modelled force of every record over a cycle."""

    def rows() -> Iterator[tuple[Any, ...]]:
        for record in result.records:
            columns = (
                record.phase, record.displacement, record.measured, record.model, record.residual
            )  # fmt: skip
            for row in zip(*(column.tolist() for column in columns), strict=True):
                yield text_cell(record.name), record.normal_load, *row

    heads = ["record", "normal load [N]", "phase [rad]", "displacement [m]", "measured force [N]"]
    return csv_text([*heads, "model force [N]", "residual [N]"], rows())
