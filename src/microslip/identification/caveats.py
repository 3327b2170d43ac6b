"""Caveats of a fit and of its numbers, the one table of their words, and names of the numbers."""

from __future__ import annotations

import math
import string
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from microslip._core.units import engineering, significant
from microslip._core.wording import joined

IDENTIFIED, IN_DOUBT, APPARENT, BEYOND, ABOVE, BELOW, NOT, FIXED = (
    "identified",
    "in doubt",
    "apparent",
    "extrapolated",
    "bounded above",
    "bounded below",
    "not identified",
    "fixed",
)
HAS_VALUE = (IDENTIFIED, IN_DOUBT, APPARENT, BEYOND, FIXED)
"""Verdicts on numbers of which a value can be told."""

Call = Callable[[str], str]
"""Spelling of a number of the fit: by its name, or as people read it."""


class Row(NamedTuple):
    """Words and effect of the caveats of one kind."""

    words: str | tuple[str, ...]
    """The sentence, or clauses of it of which those are left out that name what is None. Fields:
    "{x:3 m}" is a number with a unit, "{x:2%}" a share, "{x!n}" the name of a number of the fit."""
    remedy: str = ""
    """Remedy."""
    verdict: str = ""
    """Verdict on the numbers that it concerns."""
    in_message: bool = False
    """Whether the message of the fit says it."""
    noted: bool = True
    """Whether it is a note."""


_EVERY = "every value "
_ANSWERS = " fits the loops within their noise ({confidence:%})"
_NAME_RIGS = "name the rig of each record: `rigs=...`"

TABLE: Mapping[str, Row] = {
    # -- how the fit ended ----------------------------------------------------------------------
    "used up": Row(
        "the fit did not end at a minimum: it reached its limit of evaluations while the sum of "
        "squares still fell",
        in_message=True,
        noted=False,
    ),
    "unsettled": Row(
        "the fit did not end at a minimum: the weights of the displacement's errors, which follow "
        "the law's own tangents, do not converge: the law does not fit these records",
        in_message=True,
        noted=False,
    ),
    "broken off": Row(
        "the fit did not end at a minimum: it stopped early: {why}", in_message=True, noted=False
    ),
    "at a bound": Row(
        (
            "{places:s}",
            " (and {more} more)",
            "; identified all the same: {names:s}",
            "; nothing{none} is identified",
        ),
        in_message=True,
        noted=False,
    ),
    "a bound": Row("the best value of {name!n} lies at a bound of the search, {value:3 {unit}}"),
    "one rig": Row(
        (
            "one rig for all does not fit the records, and one for each does, with compliances "
            "that differ",
            " by {spread:2%}",
            " (most: {record!r}); if they are of different rigs, name the rig of each record: "
            "`rigs=...`",
        ),
        in_message=True,
        noted=False,
    ),
    "several rigs": Row(
        (
            "a rig for each record, with compliances that differ",
            " by {spread:2%}",
            ", would remove most of the misfit, though not all (most: {record!r}); if the records "
            "are of different rigs, name the rig of each record: `rigs=...`",
        ),
        in_message=True,
        noted=False,
    ),
    "misfit": Row(
        "the law does not fit the records: the misfit is {over_noise:2} times their noise, "
        "{share:2%} of the force",
        in_message=True,
    ),
    "contradiction": Row("given values and the loops disagree: {data:s}", in_message=True),
    "datum": Row(
        "{name!n} was given as {value:3 {unit}} ± {error:3 {unit}}, without that "
        "{without:3 {unit}} is found, {deviations:2} standard deviations apart"
    ),
    # -- of one number: its interval ------------------------------------------------------------
    ABOVE: Row("the loops only show that it is not above {high:3 {unit}} ({confidence:%})"),
    BELOW: Row("the loops only show that it is not below {low:3 {unit}} ({confidence:%})"),
    "open": Row(
        (_EVERY + "that was tried", ", from {first:3 {unit}} to {last:3 {unit}},", _ANSWERS)
    ),
    "open below": Row(_EVERY + "up to {high:3 {unit}}" + _ANSWERS),
    "open above": Row(_EVERY + "from {low:3 {unit}} on" + _ANSWERS),
    "wide": Row(
        (
            _EVERY + "from {low:3 {unit}} to {high:3 {unit}}" + _ANSWERS + ": ",
            "wider than {width:g}",
            "more than a factor {factor:g}",
        )
    ),
    "no delay": Row(
        "the loops do not determine a delay within half a period",
        "more cycles, or less noise of the force",
    ),
    # -- of numbers whose intervals close, under what does not hold -----------------------------
    "leans": Row(
        (
            "it depends on the limit of the search of {end!n}: with that limit twice as far out it "
            "would be ",
            "{share:2%}",
            "{size:2}",
            " {way}",
        ),
        "take other heights, or records that determine {parameter!n}; set the limits of its search "
        'by `bounds={{"{parameter}": ...}}`',
        IN_DOUBT,
    ),
    "other heights": Row(
        "with exponential heights, which fit the loops as well, it would be {value:3 {unit}}",
        "take other heights, or records that determine standardised_separation",
        IN_DOUBT,
    ),
    "same law": Row(
        "rig and contact are in series, and this law in series with a spring is the same law with "
        "other values: no record separates them",
        verdict=NOT,
    ),
    "no minimum": Row(
        "of a fit that did not end at a minimum: its interval surrounds no best value",
        "begin elsewhere with `start=...`, fix or bound what the records do not determine, or take "
        "another law",
        IN_DOUBT,
    ),
    "apparent": Row(
        (
            "of a law that does not fit the records: it holds for loops of {amplitudes}",
            " at {loads}",
            " in the mean",
            "; the misfit may hide an error of {stake:2%} in a number",
        ),
        "free or correct fixed values, or compare laws: their spread says more than an interval",
        APPARENT,
    ),
    "beyond": Row(
        (
            "no record reaches gross slip: the loops reach {reached:2%} of this limit, and the "
            "rest is an extrapolation by the law",
            "; laws that fit these loops as well find {laws:s}",
            "; of other laws (exponential heights, one sphere) none{none} fits these loops as well",
        ),
        "a record that reaches gross slip",
        BEYOND,
    ),
    "doubted record": Row(
        "{doubt}", "take settled cycles within the range of the sensors", IN_DOUBT
    ),
    "contradicted": Row(
        "the value given for {names:s} and the loops disagree",
        "check the given value, or leave it out",
        IN_DOUBT,
    ),
    "far area": Row(
        "the contact area was measured at {load:3 N}, far from the loads of the records, "
        "{loads}: results that use it depend on the law between these loads",
        verdict=IN_DOUBT,
    ),
    "as one rig": Row(
        "found with one rig for all records, which the loops contradict",
        _NAME_RIGS,
        IN_DOUBT,
    ),
    # -- of the whole fit -----------------------------------------------------------------------
    "continuum": Row(
        "found with a continuous height distribution: the sampling scatter of the summits in "
        "contact moves slip scale, separation and rig, by more than noise where they are few, and "
        "is not in the intervals without their number, `summits={count}`",
        "give the number of all summits, infinity for a continuous distribution",
        APPARENT,
    ),
    "summits taken": Row(
        "the number of summits is that of {source}, {count}: the sampling scatter of their heights "
        "is included in the intervals; `summits=inf` leaves it out (a continuous distribution)"
    ),
    "no play": Row("the loops show no play between joint and transducer"),
    "play": Row("play of {play:3 m} ± {error:3 m} between joint and transducer is subtracted"),
    "noisy load": Row(
        "the noise of the measured load makes the interval of {name!n} {times:3} times as wide: "
        "more cycles, or a better-known load, would narrow it"
    ),
    "too smooth": Row(
        "the mean loops are smoother than the scatter of the forces suggests (reduced "
        "chi-squared {reduced:2}): that scatter is not white noise, for example a force that "
        "drifts; the intervals may be wider than necessary"
    ),
    "play explains": Row(
        "play of {play:3 m} between joint and transducer would explain {share:2%} of the misfit; "
        "write `nuisances=['play']`"
    ),
    "effect explains": Row(
        "{effect} would explain {share:2%} of the misfit; write `nuisances=['{name}']`"
    ),
    "delay explains": Row(
        "a force{another} {delay:2 {unit}} {way} the displacement would explain {share:2%} of the "
        'misfit; write `delay="free"`'
    ),
    "wrong delay": Row('the given delay may not be that of these records; write `delay="free"`'),
    "soft rig": Row(
        "the loops are stiffer ({stiffness:3 N/m} after a reversal) than the {rig!n} given, "
        "{given:3 N/m}: no joint on such a rig has such loops; check its unit and that of the "
        "force, or leave the rig free"
    ),
    "widened": Row(
        (
            "intervals are up to {times:3} times as wide as by noise alone: ",
            "the misfit is larger than the noise (reduced chi-squared {reduced:3})",
            "whole cycles scatter more than white noise{cycles} does",
        )
    ),
    "in series": Row(
        "after a reversal rig and contact are springs in series: a softer contact on a stiffer rig "
        "fits nearly as well, so the loops do not determine the stiffness of the contact alone"
    ),
    "one load": Row(
        "all records have one normal load: loops at one load determine only the friction "
        "coefficient, the length κσ and, weakly, the separation h"
    ),
    "of the record": Row("{record}: {note}"),
    "many minima": Row(
        "the sum of squares has many minima, and the profiles found lower ones than that of the "
        "best values: this law does not suit these records"
    ),
    "straight": Row(
        (
            "all intervals{every}",
            "intervals of {names:s}",
            " are from the curvature at the best value (linearised)",
        )
    ),
}
"""Every kind of caveat; what of a clause is "" or None is said by its place alone."""


@dataclass(frozen=True)
class Caveat:
    """One thing that must be known of a fit or of a number of it."""

    kind: str
    """Row of :data:`TABLE` that says it."""
    data: Mapping[str, Any] = field(default_factory=dict)
    """Data of the words: numbers in SI units, names, and further caveats."""
    remedies: tuple[str, ...] = ()
    """Remedy, where it is not the same for all of the kind."""

    @property
    def row(self) -> Row:
        """Words and effect of its kind."""
        return TABLE[self.kind]

    def words(self, call: Call = str) -> str:
        """The sentence; arguments of functions stand between backticks."""
        clauses = self.row.words
        if isinstance(clauses, str):
            return self._filled(clauses, call)
        return "".join(self._filled(clause, call) for clause in clauses if self._has(clause))

    def remedy(self, call: Call = str) -> str:
        """The measurement that would settle it; empty where none is known."""
        return "; ".join((*self.remedies, *filter(None, [self._filled(self.row.remedy, call)])))

    def _has(self, clause: str) -> bool:
        fields = (name for _, name, _, _ in string.Formatter().parse(clause) if name)
        return all(self.data.get(name) is not None for name in fields)

    def _filled(self, text: str, call: Call) -> str:
        return _Writer(call).vformat(text, (), self.data)


class _Writer(string.Formatter):
    """Fills in numbers with their digits and units, names as an edge calls them, and lists."""

    def __init__(self, call: Call) -> None:
        self._call = call

    def convert_field(self, value: Any, conversion: str | None) -> Any:
        return self._call(value) if conversion == "n" else super().convert_field(value, conversion)

    def format_field(self, value: Any, spec: str) -> str:
        if spec == "s":  # several things, caveats among them
            return joined([self._part_text(part) for part in value])
        if spec == "%":
            return f"{100.0 * value:g} %"
        if spec.endswith("%"):
            return f"{significant(100.0 * value, int(spec[:-1]))} %"
        if spec[:1].isdigit():
            digits, _, unit = spec.partition(" ")
            return number_text(value, unit, int(digits))
        return str(super().format_field(value, spec))

    def _part_text(self, part: Any) -> str:
        return part.words(self._call) if isinstance(part, Caveat) else self._call(str(part))


# -- numbers and their names ----------------------------------------------------------------------

AT_A_LOAD = ("standardised_separation", "contact_area")
"""Parameters that all records share, but as they are at one load."""

_POWERS = {
    "m^-1.5": "m⁻¹·⁵",
    "m^-1": "m⁻¹",
    "m^-2": "m⁻²",
    "m^2": "m²",
    "1/m^2": "m⁻²",
    "1/m": "m⁻¹",
}
_WITH_PREFIX = ("m", "N", "N/m", "J", "s", "Hz", "Pa")


def number_text(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, with a prefix where that has the power one."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "infinite"
    if unit in ("", "-"):
        return significant(value, digits)
    if unit in _WITH_PREFIX:
        return engineering(value, unit, digits)
    return f"{significant(value, digits)} {_POWERS.get(unit, unit)}"


def ends_text(ends: tuple[str, str], low_open: bool, high_open: bool) -> str:
    """The ends of an interval, of which those are left out that are open."""
    if low_open and high_open:
        return "open"
    if low_open:
        return f"up to {ends[1]}"
    return f"from {ends[0]}" if high_open else f"{ends[0]} … {ends[1]}"


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
_SYMBOLS = {
    "friction_coefficient": "μ",
    "slip_scale": "κσ",
    "standardised_separation": "h",
    "rig_stiffness": "rig",
    "force_limit": "μN",
    "contact_area": "area",
}


def label(name: str, load: float | None = None) -> str:
    """A name as people read it, such as "slip scale κσ at 500 N", with the load [N] it is of."""
    return _at_load(name, load, _LABELS)


def short_symbol(name: str, load: float | None) -> str:
    """Symbol of a parameter, or its words, with the load [N] it belongs to."""
    return _at_load(name, load, _LABELS | _SYMBOLS)


def _at_load(name: str, load: float | None, texts: Mapping[str, str]) -> str:
    key, _, place = name.partition(" ")
    if load is not None and not place and key in AT_A_LOAD:
        place = f"at {engineering(load, 'N', 4, trim=True)}"
    return f"{texts.get(key, key.replace('_', ' '))} {place}".rstrip()
