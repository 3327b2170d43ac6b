"""Floor 8: numbers of an identification as people read them, on a terminal and on a page."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from microslip._core.units import engineering, prefix, significant
from microslip.identification.verdicts import AT_A_LOAD, shown, shown_interval

_LABELS = {
    "friction_coefficient": "friction coefficient μ",
    "slip_scale": "slip scale κσ",
    "standardised_separation": "separation h = d/σ",
    "rig_stiffness": "stiffness of the rig",
    "delay": "delay of the force",
    "force_limit": "force limit μN",
    "tangential_stiffness": "stiffness at rest kₜ",
    "load_scale": "load scale of the surface",
    "std": "spread of the heights σ",
    "density_root_radius": "density × √radius",
    "density_radius": "density × radius",
    "density": "density of the summits",
    "radius": "radius of the summits",
    "contact_area": "real contact area",
    "yield_displacement": "yield displacement",
}
_WORDS = {
    "identified": "ok",
    "fixed": "ok",
    "in doubt": "watch",
    "bounded above": "watch",
    "bounded below": "watch",
    "not identified": "outside",
}
UNEXPLAINED = 2.0
"""Reduced chi-squared beyond which the page says that the law does not explain all."""


class Row(NamedTuple):
    """One number with what is known of it."""

    name: str
    value: str
    interval: str
    verdict: str
    word: str
    """"ok", "watch" or "outside"."""


class Table(NamedTuple):
    """A table as texts."""

    head: list[str]
    rows: list[list[str]]
    left_out: int = 0
    """Rows that are in summary.json alone."""


class Open(NamedTuple):
    """Something that the records do not tell."""

    name: str
    verdict: str
    reason: str
    remedy: str


def label(name: str, load: float | None = None) -> str:
    """A name as people read it: "slip_scale at 500 N" is "slip scale κσ at 500 N".

    ``load`` [N] is that of the number: named with one that belongs to a load without saying so.
    """
    key, _, rest = name.partition(" ")
    text = _LABELS.get(key, key.replace("_", " "))
    if load is not None and not rest and key in AT_A_LOAD:
        rest = f"at {engineering(load, 'N', 4, trim=True)}"
    return f"{text} {rest}" if rest else text


def quantity(value: float | None, unit: str, digits: int = 4) -> str:
    """A value with its unit."""
    return "–" if value is None else shown(value, unit, digits)


def interval(number: Mapping[str, Any]) -> str:
    """The interval of a number, without an end that is open."""
    digits = _digits(number)
    if number["verdict"] == "fixed":
        return "–"
    low, high = (quantity(number[end], number["unit"], digits) for end in ("low", "high"))
    return shown_interval((low, high), number["low_open"], number["high_open"])


def _digits(number: Mapping[str, Any]) -> int:
    """So many digits that both ends of the interval differ in the last two."""
    low, high, value = number["low"], number["high"], number["value"]
    if None in (low, high, value) or not high > low or value == 0.0:
        return 4
    return min(max(1 + math.ceil(math.log10(abs(value) / (high - low))), 3), 8)


def rows_of(numbers: Mapping[str, Mapping[str, Any]]) -> list[Row]:
    """Parameters, or what follows from them, of a summary; no value where none is known."""
    found = []
    for name, number in numbers.items():
        known = number["verdict"] in ("identified", "in doubt", "fixed")
        value = quantity(number["value"], number["unit"], _digits(number)) if known else "–"
        word = _WORDS.get(number["verdict"], "watch")
        found.append(
            Row(
                label(name, number.get("normal_load")),
                value,
                interval(number),
                number["verdict"],
                word,
            )
        )
    return found


def status_word(found: Mapping[str, Any]) -> str:
    """Word for the whole: "ok" if all is identified, "watch" if not, "outside" if nothing."""
    if not found["converged"]:
        return "outside"
    return "ok" if found["status"] == "converged" and not open_of(found) else "watch"


def headline(found: Mapping[str, Any]) -> str:
    """What came out, in a line."""
    free = [n for n in found["parameters"].values() if n["verdict"] != "fixed"]
    known = sum(number["verdict"] == "identified" for number in free)
    return f"{found['law']}: {known} of {len(free)} parameters identified ({found['status']})"


def sentence(found: Mapping[str, Any]) -> str:
    """What was fitted to what."""
    records = found["records"]
    count = "one record" if len(records) == 1 else f"{len(records)} records"
    text = f"The law {found['law']}, fitted to the settled cycles of {count}"
    for key, unit, word in (("normal_load", "N", "normal load"), ("amplitude", "m", "amplitude")):
        ends = [engineering(v, unit, 3, trim=True) for v in _ends(records, key)]
        if ends:
            several = (
                f"{word}s {ends[0]} to {ends[-1]}" if ends[0] != ends[-1] else f"{word} {ends[0]}"
            )
            text += f", {several}"
    return f"{text}."


def _ends(records: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    values = [record[key] for record in records if record[key] is not None]
    return [min(values), max(values)] if values else []


def hints_of(found: Mapping[str, Any], study: str | None) -> list[str]:
    """How more could come out of the same records."""
    hints = []
    if found["law"] == "interface" and "std" not in found["derived"]:
        hints.append(
            "The spread of the heights is not reported: the loops know κσ, and κ needs the "
            "materials. Name a study that has them: --study STUDY.toml"
        )
    elif found["law"] == "interface" and study is not None and not knows_radius(found):
        hints.append(
            "Loops know density and radius of the summits only as density × √radius. A measured "
            'real contact area tells them apart, --contact-area "AREA, UNCERTAINTY, LOAD", or what '
            'a scan says of either: --known radius="1±0.1 mm"'
        )
    return hints


def knows_radius(found: Mapping[str, Any]) -> bool:
    """Whether radius and density of the summits are told apart."""
    return "radius" in found["derived"] or "radius" in found["parameters"]


def quality_of(found: Mapping[str, Any]) -> list[str]:
    """How well the law answers."""
    texts = [
        f"Reduced χ² {significant(found['reduced_chi_squared'])} "
        f"over {found['degrees_of_freedom']} degrees of freedom."
    ]
    if (found["reduced_chi_squared"] or 0.0) > UNEXPLAINED:
        texts.append(
            "That is far above 1: the law leaves more than noise, as the residuals show. It is the "
            "best fit of this law, not its proof; compare other laws, or see what the rig did."
        )
    if found["held_back"] is not None:
        texts.append(
            "Cycles that were held back are predicted to "
            f"{significant(found['held_back'])} times their noise."
        )
    widest = max(found["widened"].values(), default=1.0)
    if widest > 1.005:
        texts.append(
            f"Intervals are wider by up to a factor {significant(widest)} than white noise alone "
            "would make them, for what the law or the scatter of whole cycles adds to it."
        )
    return texts


def law_table(comparison: Mapping[str, Any]) -> Table:
    """Laws side by side."""
    rows = [
        [
            law["law"],
            law["status"],
            str(law["parameters"]),
            significant(law["reduced_chi_squared"]),
            f"{law['aic']:.1f}" if law["aic"] is not None else "–",
            f"{law['bic']:.1f}" if law["bic"] is not None else "–",
            significant(law["held_back"]),
        ]
        for law in comparison["laws"]
    ]
    head = ["law", "status", "parameters", "reduced χ²", "AIC", "BIC", "held back/noise"]
    return Table(head, rows)


def open_of(found: Mapping[str, Any]) -> list[Open]:
    """What the records do not tell, with reason and remedy; not a cell of a law that is none."""
    return [
        Open(
            label(name, number.get("normal_load")),
            number["verdict"],
            _labelled(number["reason"], found),
            number["remedy"],
        )
        for name, number in found["parameters"].items()
        if number["verdict"] not in ("identified", "fixed") and not _is_none(number)
    ]


def _is_none(number: Mapping[str, Any]) -> bool:
    """Whether a number lies at a bound that joints have, so that there is nothing to settle."""
    at_bound = number.get("at_bound", False)
    return bool(at_bound and number["verdict"] == "bounded above" and not number["remedy"])


def directions_of(found: Mapping[str, Any]) -> list[str]:
    """Ways through parameter space that the loops do not feel, in words."""
    return [f"{_upper(_labelled(one['text'], found))}." for one in found["directions"]]


def message_of(found: Mapping[str, Any]) -> str:
    """What the status means, the names as people read them."""
    return f"{_upper(_labelled(found['message'], found))}."


def _labelled(text: str, found: Mapping[str, Any]) -> str:
    """A text with labels instead of names; longer names first, which hold the shorter ones."""
    names = sorted(found["parameters"], key=len, reverse=True)
    pattern = "|".join(map(re.escape, names))
    if not names:
        return text
    loads = _loads(found)
    return re.sub(pattern, lambda match: label(match[0], loads[match[0]]), text)


def _loads(found: Mapping[str, Any]) -> dict[str, float | None]:
    """Loads of the parameters by their names."""
    return {name: number.get("normal_load") for name, number in found["parameters"].items()}


def _upper(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"


def correlation_table(found: Mapping[str, Any]) -> Table | None:
    """The correlations, each pair once; None for a single parameter."""
    names, matrix = found["correlation"]["names"], found["correlation"]["matrix"]
    if len(names) < 2:
        return None
    loads = _loads(found)
    rows = [
        [
            label(name, loads[name]),
            *(_share(matrix[i][j]) if j < i else "" for j in range(len(names) - 1)),
        ]
        for i, name in enumerate(names)
        if i > 0
    ]
    return Table(["", *(label(name, loads[name]) for name in names[:-1])], rows)


def _share(value: float | None) -> str:
    return "–" if value is None else f"{value:+.3f}".replace("-", "−")


def record_table(records: Sequence[Mapping[str, Any]]) -> Table:
    """What is left of each record, and how late its force is where that was free."""
    rows = []
    late = any(record.get("delay") for record in records)
    for record in records:
        energy, error = record["energy_residual"], record["energy_error"]
        rows.append(
            [
                record["name"],
                quantity(record["normal_load"], "N"),
                quantity(record["amplitude"], "m"),
                str(record["cycles"]),
                quantity(record["rms_residual"], "N", 3),
                quantity(record["force_noise"], "N", 3),
                "–"
                if energy is None
                else f"{100.0 * energy:+.3f} ± {100.0 * (error or 0.0):.3f} %",
                *((_delay(record["delay"]),) if late else ()),
            ]
        )
    head = [
        "record",
        "N",
        "amplitude",
        "cycles",
        "residual",
        "noise of a sample",
        "energy residual",
        *(("delay",) if late else ()),
    ]
    return Table(head, rows)


def _delay(number: Mapping[str, Any] | None) -> str:
    """A delay and half the width of its interval, both in the unit that suits them."""
    if number is None or number["verdict"] == "not identified":
        return "–"
    value, half = number["value"], 0.5 * (number["high"] - number["low"])
    factor, letter = prefix(max(abs(value), half))
    width = float(f"{half / factor:.1e}")  # two digits are enough
    places = min(max(1 - math.floor(math.log10(width)), 0), 6) if width > 0.0 else 3
    middle = round(value / factor, places) + 0.0  # no minus before nothing
    return f"{middle:.{places}f} ± {width:.{places}f} {letter}{number['unit']}"
