"""Result of an identification, with its uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.quantities import json_value
from microslip._core.units import engineering, interval_digits
from microslip._core.wording import plural
from microslip.contact import GreenwoodWilliamson
from microslip.contact.heights import Discrete, Exponential, Gaussian
from microslip.contact.materials import Material
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.friction import Interface
from microslip.identification.caveats import (
    AT_A_LOAD,
    FIXED,
    HAS_VALUE,
    NOT,
    Call,
    Caveat,
    number_text,
)
from microslip.identification.coordinates import groups_of, labels_of, levels_of
from microslip.identification.fit_quality import RecordFit
from microslip.identification.models.base import Materials, Model
from microslip.identification.quantities import GivenDatum
from microslip.identification.verdicts import Direction, Fitted, interval_text

CONVERGED = "converged"
NOT_CONVERGED = "not converged"
AT_BOUND = "at a bound"
DIFFER = "records differ: rigs"

_SUMMARY = (
    *("law", "status", "converged", "message", "evaluations", "confidence", "parameters"),
    *("derived", "correlation", "given", "directions", "chi_squared", "degrees_of_freedom"),
    *("reduced_chi_squared", "stake", "widened", "aic", "bic", "held_back", "records", "notes"),
)
_OF_FOLDED = (
    *("cycles", "left_out", "normal_load", "amplitude", "force_noise", "displacement_noise"),
)
_OF_NUMBER = (
    *("value", "unit", "low", "high", "low_open", "high_open", "standard_error", "verdict"),
    "at_bound",
)


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Locked, Plottable):
    """A law that was fitted to records, with what they can tell of it and what not.

    Made by :func:`microslip.identify`: the comparison of Fig. 19.22 of the chapter
    (DOI 10.1007/978-3-319-56818-8_19), measured.
    """

    law: str
    """Name of the law."""
    status: str
    """"converged", "at a bound", "records differ: rigs" or "not converged"."""
    evaluations: int
    """Number of evaluations of the law."""
    parameters: Mapping[str, Fitted]
    """The law's parameters and the rig's stiffness, by name."""
    derived: Mapping[str, Fitted]
    """Derived quantities."""
    names: tuple[str, ...]
    """Names of the parameters that were free, in the order of ``correlation``."""
    correlation: NDArray[np.float64]
    """Correlations of the free parameters as they were fitted [-]."""
    directions: tuple[Direction, ...]
    """Combinations of parameters that the loops do not determine."""
    confidence: float
    """Level of the intervals [-]."""
    chi_squared: float
    """Sum of squares of the residuals over their noise [-], by the weights of the loss."""
    degrees_of_freedom: int
    """Number of forces and data less what was fitted."""
    widened: Mapping[str, float]
    """Factor on the width of each interval, for what white noise does not explain [-]."""
    records: tuple[RecordFit, ...]
    """Each record, folded, beside the answer of the law."""
    aic: float
    """Akaike's information criterion: chi-squared, the logarithm of the determinant of the
    covariance by which it was weighed over that of the force's noise, and twice the number of
    parameters."""
    bic: float
    """Schwarz's information criterion, as Akaike's with the logarithm of the number of forces."""
    held_back: float | None
    """RMS error over noise [-] with which a fit of the others predicts the cycles held back."""
    columns: tuple[Mapping[str, str], ...]
    """For each record: name of each parameter of the law as ``parameters`` has it."""
    caveats: tuple[Caveat, ...]
    """Caveats of the fit as a whole, as data for its message and its notes."""
    _model: Model
    _materials: Materials
    delays: Mapping[str, Fitted] = field(default_factory=lambda: MappingProxyType({}))
    """Time [s] by which the force of each record lags behind, by the names of the records, where it
    was free; of a record without a time base the phase [rad]."""
    given: tuple[GivenDatum, ...] = ()
    """Each datum that was given with an uncertainty, and whether the loops bear it out."""

    stake: float | None = None
    """Largest share of a number [-] that may hide behind what the law leaves beside noise, which
    its interval holds; above 5 % they are called apparent. None where there is no number."""

    def _figure(self) -> Plot:
        from microslip.identification.figures import loops

        return loops(self)

    @property
    def converged(self) -> bool:
        """Whether the fit found its minimum."""
        return self.status != NOT_CONVERGED

    @property
    def reduced_chi_squared(self) -> float:
        """Sum of squares over degrees of freedom [-]: 1 if the law explains all but the noise.

        A robust loss gives less weight to noise, too: then it is less than 1 for such a law, down
        to about 0.65 with "cauchy".
        """
        return self.chi_squared / max(self.degrees_of_freedom, 1)

    @property
    def not_identified(self) -> tuple[str, ...]:
        """Names of parameters that the records do not tell."""
        return tuple(name for name, fitted in self.parameters.items() if fitted.verdict == NOT)

    # -- the joint ------------------------------------------------------------------------------

    def _values(self, load: float | None) -> tuple[Model, dict[str, float], float | None]:
        """The law and its parameters' values for a load; those of the nearest load fitted."""
        loads = [record.normal_load for record in self.records]
        pick = 0
        if load is not None:
            distances = [
                math.inf if x is None or x <= 0.0 else abs(math.log(x / load)) for x in loads
            ]
            pick = int(np.argmin(distances))
        names = self.columns[pick]
        values = {name: self.parameters[full].value for name, full in names.items()}
        model = self._model
        own_loads = [self.parameters[names[name]].load for name in model.at_reference]
        if own_loads:
            model = model.split(model.at_reference, [at for at in own_loads if at is not None])
        return model, values, loads[pick] if load is None else load

    def joint(self, normal_load: float | None = None, *, even_if: tuple[str, ...] = ()) -> Any:
        """The law with the values found.

        Parameters
        ----------
        normal_load : float, optional
            Normal load [N] of the joint; without it that of the first record.
        even_if : tuple of str, optional
            What is accepted: "not converged", "not identified". Without "not identified" a law
            whose values the loops leave open is made all the same of the best ones, but not one of
            a fit that did not converge.

        Returns
        -------
        Interface, Jenkins, Iwan or SegalmanIwan
            Without its rig.
        """
        self._check_accepted(even_if)
        load = None
        if normal_load is not None:
            load = positive("normal_load", normal_load, "N", 500.0)
        model, values, at = self._values(load)
        if load is not None and not self._model.scales_with_load:
            self._check_measured(load)
        fitted = self.derived.get("radius") or self.parameters.get("radius")
        is_known = fitted is not None and math.isfinite(fitted.value)
        radius = fitted.value if fitted is not None and is_known else None
        return model.build(values, at, self._materials._replace(radius=radius))

    def _check_accepted(self, even_if: tuple[str, ...]) -> None:
        accepted = (even_if,) if isinstance(even_if, str) else tuple(even_if)
        for word in accepted:
            if word not in (NOT_CONVERGED, NOT):
                raise InputError(
                    f"`even_if` must be among {NOT_CONVERGED!r} and {NOT!r}, got {show(word)}"
                )
        if not self.converged and NOT_CONVERGED not in accepted:
            raise InputError(
                f"the fit did not converge ({self.message}); its values are no result; give "
                "other `start=...` or `bounds=...`, or take them all the same: "
                f'`even_if="{NOT_CONVERGED}"`'
            )

    def _check_measured(self, load: float) -> None:
        loads = [record.normal_load for record in self.records if record.normal_load]
        folded = [record.folded for record in self.records]
        load_texts = labels_of(
            folded, levels_of([record.normal_load for record in folded])
        ).values()
        if (
            loads
            and len({tuple(c.items()) for c in self.columns}) > 1
            and not any(abs(load / other_load - 1.0) <= 0.02 for other_load in loads)
        ):
            raise InputError(
                f"`normal_load` must be one of those measured, {', '.join(load_texts)} N: "
                f"{self.law!r} has values of its own for each, got {load:g} N"
            )

    def study(self, *, even_if: tuple[str, ...] = ()) -> dict[str, Any]:
        """A study of the joint, as a study file has it, for ``predict``.

        Parameters
        ----------
        even_if : tuple of str, optional
            As for :meth:`joint`.

        Returns
        -------
        dict
            Tables of text with units and of numbers.
        """
        loads = loads_of(self.records)
        joint = self.joint(loads[0] if loads else None, even_if=even_if)
        if not isinstance(joint, Interface):
            raise InputError(
                f"a study describes an interface, and this is a fit of {self.law!r}; "
                "identify with law='interface' and pair=..."
            )
        return study_of(joint, loads, amplitudes_of(self.records), self._materials.area is not None)

    # -- as values and as text --------------------------------------------------------------------

    @property
    def message(self) -> str:
        """Meaning of the status for this fit, in sentences."""
        return self._message()

    @property
    def notes(self) -> tuple[str, ...]:
        """Further notes on the fit, a sentence each."""
        return self._notes()

    @property
    def is_plain(self) -> bool:
        """Whether the fit ended at a minimum and nothing speaks against it."""
        return self.converged and not any(caveat.row.in_message for caveat in self.caveats)

    def _message(self, call: Call = str) -> str:
        sentences = [caveat.words(call) for caveat in self.caveats if caveat.row.in_message]
        if self.status == CONVERGED:
            sentences.insert(0, "the fit ended at a minimum within the bounds")
        return "; ".join(sentences)

    def _notes(self, call: Call = str) -> tuple[str, ...]:
        return tuple(caveat.words(call) for caveat in self.caveats if caveat.row.noted)

    def summary(self, *, call: Call = str) -> dict[str, Any]:
        """All but the arrays as plain values, what is not finite as None.

        In its sentences numbers are named as ``call`` calls them, a function of their names.
        """
        records = [
            {
                "name": record.name,
                **{key: getattr(record.folded, key) for key in _OF_FOLDED},
                "rig_stiffness": record.rig_stiffness,
                "slip_share": record.slip_share,
                "energy": record.measured_energy,
                "energy_residual": record.energy_residual,
                "energy_error": record.energy_error,
                "delay": self.delays.get(record.name),
            }
            for record in self.records
        ]
        values = {key: getattr(self, key) for key in _SUMMARY} | {"records": records}
        values |= {"message": self._message(call), "notes": self._notes(call)}
        values["correlation"] = {"names": self.names, "matrix": self.correlation}
        summary: dict[str, Any] = json_value(_as_mappings(values, call))
        return summary

    def table(self) -> str:
        """The parameters as text: name, value, interval and verdict; then what is left open."""
        lines = [
            f"{self.law}: {self.status}; {plural(len(self.records), 'record')}, reduced "
            f"chi-squared {self.reduced_chi_squared:.3g}"
        ]
        numbers = (self.parameters, self.derived, self.delays)
        for number in (fitted for kind in numbers for fitted in kind.values()):
            has_value = number.verdict in HAS_VALUE
            digits = interval_digits(number.low, number.high, number.value)
            value = number_text(number.value, number.unit, digits) if has_value else "–"
            ends = "" if number.verdict == FIXED else interval_text(number)
            lines.append(f"{_name_with_load(number):<36} {value:>14}  {ends:<30} {number.verdict}")
        for number in self.parameters.values():
            if number.reason:
                lines.append(f"{number.name}: {number.reason}; {number.remedy}")
        for datum in self.given:
            lines.append(datum.text)
        lines += [direction.text for direction in self.directions]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return (
            f"Identification({self.law!r}, {self.status}, "
            f"{plural(len(self.records), 'record')}, "
            f"reduced_chi_squared={self.reduced_chi_squared:.3g})"
        )


def _name_with_load(fitted: Fitted) -> str:
    """Name of a number, with the load of what belongs to one load though its name has none."""
    if fitted.load is None or fitted.name not in AT_A_LOAD:
        return fitted.name
    return f"{fitted.name} at {fitted.load:.4g} N"


def _as_mappings(value: Any, call: Call) -> Any:
    """Numbers, data and directions of a fit as mappings, wherever they stand."""
    if isinstance(value, Fitted):
        said = dict.fromkeys(("reason", "remedy"), "")
        if value.caveat is not None:
            said = {"reason": value.caveat.words(call), "remedy": value.caveat.remedy(call)}
        numbers = {key: getattr(value, key) for key in _OF_NUMBER}
        return numbers | said | {"normal_load": value.load}
    if isinstance(value, Direction):
        return {"text": value.words(call), "change": value.change, "remedy": value.remedy}
    if isinstance(value, GivenDatum):
        return asdict(value)
    if isinstance(value, Mapping):
        return {name: _as_mappings(part, call) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_as_mappings(part, call) for part in value]
    return value


# -- the joint as keys of a study file ------------------------------------------------------------


def loads_of(records: Sequence[RecordFit]) -> list[float]:
    """Different normal loads of the records [N], rising."""
    return _means(record.normal_load for record in records if record.normal_load)


def amplitudes_of(records: Sequence[RecordFit]) -> list[float]:
    """Different amplitudes of the joint itself [m]: those of the records less the rig's part."""
    amplitudes = []
    for record in records:
        rig = float(np.ptp(record.model)) / (record.rig_stiffness or math.inf)
        amplitudes.append(0.5 * (float(np.ptp(record.displacement)) - rig))
    return _means(amplitude for amplitude in amplitudes if amplitude > 0.0)


def _means(values: Iterable[float]) -> list[float]:
    return [float(np.mean(group)) for group in groups_of(values)]


def _written(value: float, unit: str) -> str:
    return engineering(value, unit, 4, trim=True).replace("µ", "u")


def law_study(records: Sequence[RecordFit], law_file: str) -> dict[str, Any]:
    """Return a study of a law in a file, at the amplitudes of the records."""
    return {
        "schema": 1,
        "title": "Identified joint",
        "joint": {"law_file": law_file},
        "excitation": {"amplitudes": [_written(a, "m") for a in amplitudes_of(records)]},
    }


def study_of(
    joint: Interface, loads: Sequence[float], amplitudes: Sequence[float], area_known: bool
) -> dict[str, Any]:
    """A study of a joint at loads [N] and amplitudes [m]; quantities are text with their unit."""
    surface = joint.surface
    if not isinstance(surface, GreenwoodWilliamson):
        raise InputError(
            f"a study is made of a surface with a distribution of heights, got {show(surface)}"
        )
    first, second = _material(surface.pair.first), _material(surface.pair.second)
    materials = {"first": first} if first == second else {"first": first, "second": second}
    names = ["first", "first"] if first == second else ["first", "second"]
    title = "Identified joint" if area_known else "Identified joint, its area a convention"
    return {
        "schema": 1,
        "title": title,
        "material": materials,
        "surface": {
            "materials": names,
            "law": "greenwood-williamson",
            "heights": _heights(surface.heights),
            "radius": f"{surface.radius!r} m",
            "density": f"{surface.density!r} 1/m^2",
            "area": f"{surface.area!r} m^2",
        },
        "joint": {
            "friction_coefficient": float(joint.friction_coefficient),
            "normal_load": [_written(load, "N") for load in loads or [joint.normal_load]],
        },
        "excitation": {"amplitudes": [_written(a, "m") for a in amplitudes]},
    }


def _material(body: Material) -> dict[str, Any]:
    if not np.isfinite(body.young_modulus):
        return {"rigid": True}
    keys: dict[str, Any] = {
        "young_modulus": f"{body.young_modulus!r} Pa",
        "poisson_ratio": float(body.poisson_ratio),
    }
    if body.hardness is not None:
        keys["hardness"] = f"{body.hardness!r} Pa"
    return keys


def _heights(heights: Any) -> dict[str, Any]:
    if isinstance(heights, Gaussian):
        keys: dict[str, Any] = {"kind": "gaussian", "std": f"{heights.std!r} m"}
        if heights.mean:
            keys["mean"] = f"{heights.mean!r} m"
        return keys
    if isinstance(heights, Exponential):
        return {"kind": "exponential", "scale": f"{heights.scale!r} m"}
    if isinstance(heights, Discrete):
        values = [f"{float(value)!r} m" for value in np.asarray(heights.values)]
        return {"kind": "values", "values": values}
    raise InputError(
        "a study is made of Gaussian, exponential or given heights, got "
        f"{show(heights)}; joint() gives the interface itself"
    )
