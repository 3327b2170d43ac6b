"""Numbers of an identification as people read them, from the plain values of its summary."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from microslip._core.errors import InputError
from microslip._core.units import engineering, interval_digits, prefix, significant
from microslip._core.verdicts import Verdict, Word
from microslip._core.wording import joined, shorten
from microslip._version import __version__
from microslip.friction.law_files import law_content, law_text
from microslip.identification import Identification
from microslip.identification.caveats import HAS_VALUE, ends_text, label, number_text
from microslip.identification.result import law_study
from microslip.identification.verdicts import verdicts
from microslip.report.document import Number
from microslip.study.toml_text import dump

if TYPE_CHECKING:
    from microslip.study.description import StudyDescription


Summary = Mapping[str, Any]

_WORDS: Mapping[str, Word] = {
    "identified": "ok",
    "fixed": "ok",
    "in doubt": "watch",
    "apparent": "watch",
    "extrapolated": "watch",
    "bounded above": "watch",
    "bounded below": "watch",
    "not identified": "outside",
}


def quantity(value: float | None, unit: str, digits: int = 4) -> str:
    """A value with its unit."""
    return "–" if value is None else number_text(value, unit, digits)


def word_of(number: Summary) -> Word:
    """Word of the verdict on a number."""
    return _WORDS.get(number["verdict"], "watch")


def value_text(number: Summary) -> str:
    """The value of a number; none where none is known."""
    if number["verdict"] not in HAS_VALUE:
        return "–"
    return quantity(number["value"], number["unit"], _digits(number))


def interval_text(number: Summary) -> str:
    """The interval of a number, without an end that is open."""
    if number["verdict"] == "fixed":
        return "–"
    return _between(number, _digits(number))


def value_and_interval(number: Summary) -> str:
    """Both in one cell, so that no terminal is too narrow for them to stand beside each other."""
    value, interval = value_text(number), interval_text(number)
    if value == "–":
        return interval
    return value if interval in ("", "–") else f"{value} ({interval})"


def _between(number: Summary, digits: int) -> str:
    low, high = (quantity(number[end], number["unit"], digits) for end in ("low", "high"))
    return ends_text((low, high), number["low_open"], number["high_open"])


def _digits(number: Summary) -> int:
    return interval_digits(number["low"], number["high"], number["value"])


def _free(fit: Summary) -> list[Summary]:
    return [number for number in fit["parameters"].values() if number["verdict"] != "fixed"]


def verdicts_of(fit: Summary) -> tuple[Verdict, ...]:
    """Verdicts on a fit."""
    # Derived quantities count where they are in doubt at best, such as past all forces.
    follows = [n for n in fit["derived"].values() if n["verdict"] in HAS_VALUE[1:-1]]
    identified = (n["verdict"] == "identified" or is_at_bound(n) for n in _free(fit) + follows)
    return verdicts(fit["stake"], identified, fit["converged"])


def headline(fit: Summary) -> str:
    """Result in a line."""
    free = _free(fit)
    identified = sum(number["verdict"] == "identified" for number in free)
    return f"{fit['law']}: {identified} of {len(free)} parameters identified ({fit['status']})"


def first_number(fit: Summary) -> Number | None:
    """The first parameter that was identified, with its interval; None where none was."""
    every = {**fit["parameters"], **fit["derived"]}
    identified = (name for name, number in every.items() if number["verdict"] == "identified")
    name = next(identified, None)
    if name is None:
        return None
    level = f"{100.0 * fit['confidence']:g} % interval"
    text = label(name, every[name].get("normal_load"))
    return Number(text, value_text(every[name]), f"{interval_text(every[name])} ({level})")


def sentence(fit: Summary) -> str:
    """The fitted law and its records, in a sentence."""
    records = fit["records"]
    count = "one record" if len(records) == 1 else f"{len(records)} records"
    text = f"The law {fit['law']}, fitted to the settled cycles of {count}"
    for key, unit, noun in (("normal_load", "N", "normal load"), ("amplitude", "m", "amplitude")):
        values = [record[key] for record in records if record[key] is not None]
        if values:
            first, last = (engineering(v, unit, 3, trim=True) for v in (min(values), max(values)))
            text += f", {noun}s {first} to {last}" if first != last else f", {noun} {first}"
    return f"{text}."


def hints_of(fit: Summary, study: str | None) -> list[str]:
    """Hints on how the same records could tell more."""
    if fit["law"] != "interface":
        return []
    if "std" not in fit["derived"]:
        return [
            "The spread of the heights is not reported: loops determine κσ, and κ needs the "
            "materials. Name a study that has them: --study STUDY.toml"
        ]
    if study is not None and not knows_radius(fit):
        return [
            "Loops determine only density·√radius of the summits. A measured "
            'real contact area separates them, --contact-area "AREA, UNCERTAINTY, LOAD", or '
            'either of them from a scan: --known radius="1±0.1 mm"'
        ]
    return []


def knows_radius(fit: Summary) -> bool:
    """Whether radius and density of the summits are identified separately."""
    return "radius" in fit["derived"] or "radius" in fit["parameters"]


def quality_of(fit: Summary) -> list[str]:
    """Quality of the fit."""
    texts = [
        f"Reduced χ² {significant(fit['reduced_chi_squared'])} "
        f"over {fit['degrees_of_freedom']} degrees of freedom."
    ]
    if fit["held_back"] is not None:
        texts.append(
            "The error of predicted cycles, which were held back from the fit, is "
            f"{significant(fit['held_back'])} times their noise."
        )
    widest = max(fit["widened"].values(), default=1.0)
    if widest > 1.005:
        texts.append(
            f"Intervals are wider by up to a factor {significant(widest)} than white noise alone "
            "would make them, because of the misfit of the law or the scatter of whole cycles."
        )
    return texts


def open_parameters(fit: Summary) -> list[tuple[str, Summary]]:
    """Labels and numbers of what is not identified; not a cell of a law that is none."""
    return [
        (label(name, number.get("normal_load")), number)
        for name, number in fit["parameters"].items()
        if number["verdict"] not in ("identified", "fixed") and not is_at_bound(number)
    ]


def open_texts(fit: Summary) -> list[str]:
    """The same as sentences, one for all parameters of which it is the same."""
    names: dict[tuple[str, ...], list[str]] = {}
    for name, number in open_parameters(fit):
        same = number["verdict"], number["reason"], number["remedy"]
        names.setdefault(same, []).append(name)
    return [
        f"{joined(of)}, {verdict}: {reason}." + (f" To determine it: {remedy}." if remedy else "")
        for (verdict, reason, remedy), of in names.items()
    ]


def is_at_bound(number: Summary) -> bool:
    """Whether a number lies at a bound that joints have, so that there is nothing to settle."""
    at_bound = number.get("at_bound", False)
    return bool(at_bound and number["verdict"] == "bounded above" and not number["remedy"])


def signed(value: float | None, digits: int = 3) -> str:
    """A number with its sign."""
    return "–" if value is None else f"{value:+.{digits}f}".replace("-", "−")


def delay_text(number: Summary | None) -> str:
    """A delay and half the width of its interval, both in the unit that suits them."""
    if number is None or number["verdict"] == "not identified":
        return "–"
    value, half = number["value"], 0.5 * (number["high"] - number["low"])
    factor, letter = prefix(max(abs(value), half))
    width = float(f"{half / factor:.1e}")  # two digits are enough
    places = min(max(1 - math.floor(math.log10(width)), 0), 6) if width > 0.0 else 3
    middle = round(value / factor, places) + 0.0  # no minus before nothing
    return f"{middle:.{places}f} ± {width:.{places}f} {letter}{number['unit']}"


def rig_texts(comparison: Summary) -> list[str]:
    """The stiffness of each rig as several laws find it; none where it is known."""
    texts = []
    for name, laws in comparison["rigs"].items():
        by_law = ", ".join(f"{_between(number, 3)} by {law}" for law, number in laws.items())
        texts.append(
            f"The {label(name)} over the laws: {by_law}. Where none of them fits within the noise, "
            "it compensates the error of each, and this spread says more than one interval."
        )
    return texts


def energy_text(record: Summary) -> str:
    """Energy of a cycle that the law leaves, in percent with its error."""
    energy, error = record["energy_residual"], record["energy_error"]
    if energy is None:
        return "–"
    return f"{100.0 * energy:+.3f} ± {100.0 * (error or 0.0):.3f} %".replace("-", "−", 1)


LAW_FILE = "law.json"


def joint_text(
    result: Identification, source_study: StudyDescription | None, say: Callable[[str], str] = str
) -> tuple[str | None, str]:
    """The identified joint as TOML that `microslip predict` takes, or None and why there is none.

    Its materials are of the study; remarks say what in it is no result, as ``say`` puts it.
    """
    if result.law != "interface":
        text = law_json(result)
        if text is None:
            return None, f"no joint.toml: a study describes no joint of this fit of {result.law}"
        return f"{_remarks(result.summary(), say)}\n{dump(law_study(result.records, LAW_FILE))}", ""
    if source_study is None:
        return None, "no joint.toml: the materials are not known; name a study that has them"
    try:
        study: dict[str, Any] = result.study()
    except InputError as error:
        return None, f"no joint.toml: {say(f'{error.text}')}"
    source, summary = tomllib.loads(source_study.text), result.summary()
    surface: Any = result.joint().surface
    # The materials by the names that the study has for them.
    study["surface"]["materials"] = source["surface"]["materials"]
    study.pop("material", None)
    if "material" in source:
        study["material"] = source["material"]
    title = source.get("title", "")
    study["title"] = f"{title}: identified"[:200] if title else "Identified joint"
    for key, unit in (("radius", "m"), ("area", "m^2"), ("density", "1/m^2")):
        study["surface"][key] = f"{getattr(surface, key):.6g} {unit}"
    if unknown := _unknown(summary):
        study["not_identified"] = unknown
    order = ("schema", "title", "not_identified", "material", "surface", "joint", "excitation")
    study = {key: study[key] for key in (*order, *study) if key in study}
    return f"{_remarks(summary, say)}\n{dump(study)}", ""


def law_json(result: Identification) -> str | None:
    """Return the content of law.json, or None for an interface and for laws that have no file."""
    if result.law == "interface":
        return None
    try:
        return law_text(law_content(result.joint()))
    except InputError:
        return None


_KEYS = {
    "friction_coefficient": "joint.friction_coefficient",
    "slip_scale": "surface.heights",
    "standardised_separation": "surface.density",
}


def _unknown(summary: dict[str, Any]) -> list[str]:
    """Keys of the study whose numbers the loops do not tell, not even within an interval."""
    keys = [
        _KEYS[name]
        for name, number in summary["parameters"].items()
        if name in _KEYS
        and number["verdict"] not in ("identified", "fixed", *HAS_VALUE)
        and not is_at_bound(number)
    ]
    return keys if knows_radius(summary) else list(dict.fromkeys([*keys, "surface.radius"]))


def _remarks(summary: Summary, say: Callable[[str], str]) -> str:
    """Measured and assumed values of the file, as comments."""
    lines = [f"Identified by microslip {__version__} from:"]
    lines += [
        f"  {shorten(record['name'], 60)}, N = {quantity(record['normal_load'], 'N')}, "
        f"amplitude {quantity(record['amplitude'], 'm')}, {record['cycles']} cycles"
        for record in summary["records"]
    ]
    left = open_parameters(summary)
    doubtful = [f"{name} ({n['verdict']})" for name, n in left if n["verdict"] in HAS_VALUE]
    if summary["status"] != "converged" or doubtful:
        lines += wrap(f"{summary['status'].upper()}: {say(summary['message'])}.", 96)
    if doubtful:
        lines += wrap(f"IN DOUBT: {', '.join(doubtful)}.", 96)
    if open_ones := [name for name, n in left if n["verdict"] not in HAS_VALUE]:
        lines.append(
            f"NOT identified, one of many values that fit the loops: {', '.join(open_ones)}."
        )
    if summary["law"] != "interface":
        lines.append(f"The law itself is in {LAW_FILE}.")
    elif knows_radius(summary):
        lines += [
            "radius and density: separated by the contact area, radius or density that was given."
        ]
    else:
        lines += [
            "radius: not identified, that of the study at the start of the fit. Loops determine",
            "density * sqrt(radius) alone; contact counts and areas depend on the radius, too.",
        ]
    lines.append("amplitudes: of the joint itself, without the displacement of the rig.")
    for name, number in summary["parameters"].items():
        if name.startswith("rig_stiffness") and number["value"] is not None:
            lines.append(f"{label(name)}: {quantity(number['value'], 'N/m')}, not in this study.")
    return "\n".join(f"# {line}" for line in lines)
