"""Unit and meaning of every quantity in results."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple


def named(source: Any, *names: str) -> dict[str, Any]:
    """Return attributes of ``source`` by name: ``names``, or all fields of a NamedTuple."""
    return {name: getattr(source, name) for name in names or source._fields}


def json_value(value: Any) -> Any:
    """Convert a value for JSON.

    Arrays become lists, NamedTuples dictionaries, and numbers that are not finite None.
    """
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {name: json_value(part) for name, part in value.items()}
    if hasattr(value, "tolist"):  # avoids importing NumPy, which slows down the help of commands
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [json_value(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


class Quantity(NamedTuple):
    """Unit, meaning and format of a number in tables, figures, summaries and netCDF files."""

    unit: str
    """SI unit, "-" for a dimensionless number, "" for text and counts."""
    meaning: str = ""
    label: str = ""
    """Column heading in reports."""
    symbol: str = ""
    """Column heading in the terminal, by default the label."""
    form: str = "4"
    """Number of significant digits, the name of a format in
    :data:`microslip.report.cells.FORMS`, or a format specification of Python."""

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the CF conventions, with the unit "1" for a dimensionless number."""
        unit = "1" if self.unit == "-" else self.unit
        return {"units": unit, "long_name": self.meaning}


def count(label: str) -> Quantity:
    """Return the quantity of a column of whole numbers or text."""
    return Quantity("", label=label)


def hertz(label: str) -> Quantity:
    """Return the quantity of a column of frequencies [Hz]."""
    return Quantity("Hz", label=label, form=".5g")


def dimensionless(label: str, form: str = "ratio") -> Quantity:
    """Return the quantity of a column of dimensionless numbers."""
    return Quantity("-", label=label, form=form)


QUANTITIES: dict[str, Quantity] = {
    "normal_load": Quantity("N", "normal load", "Load", "load", "chosen"),
    "amplitude": Quantity(
        "m", "displacement amplitude", "Displacement amplitude", "amplitude", "chosen"
    ),
    "displacement": Quantity("m", "tangential displacement", "Displacement"),
    "force": Quantity("N", "force needed to hold the displacement", "Force"),
    # by amplitude
    "force_amplitude": Quantity("N", "force amplitude", "Force amplitude", "force", "chosen"),
    "force_ratio": Quantity("-", "force amplitude over force limit", "T/μN", "", "saturating"),
    "dissipated_energy": Quantity(
        "J", "energy dissipated in a cycle", "Energy per cycle", "energy/cycle", "3"
    ),
    "energy_ratio": Quantity("-", "dissipated energy over 4 times the product of both amplitudes"),
    "loss_factor": Quantity("-", "loss factor of the interface", "Loss factor η", "η", "ratio"),
    "damping_ratio": Quantity(
        "-", "equivalent viscous damping ratio of the interface", "Damping ratio ζ", "ζ", "ratio",
    ),
    "secant_stiffness": Quantity(
        "N/m", "force amplitude over displacement amplitude", "Secant stiffness", "", "3"
    ),
    "tangent_stiffness": Quantity(
        "N/m", "slope of the first loading curve at the amplitude", "Tangent stiffness"
    ),
    "dissipation_exponent": Quantity(
        "-", "local exponent of the amplitude in the dissipated energy", "Exponent", "", "general"
    ),
    "slider_density": Quantity("N/m^2", "stiffness of the Iwan sliders per yield displacement"),
    "stick_area": Quantity("m^2", "contact area that sticks at the end of first loading"),
    "stick_share": Quantity(
        "-", "stick area over real contact area", "Sticking fraction", "", "percent"
    ),
    # by load
    "separation": Quantity("m", "separation of the surfaces"),
    "standardised_separation": Quantity(
        "-", "separation over the spread of the heights", "h", "", "decimals"
    ),
    "contact_count": Quantity("-", "summits in contact", "Contacts", "contacts", "expected"),
    "contact_area": Quantity("m^2", "real contact area", "Real area", "real area", "area"),
    "contact_area_fraction": Quantity(
        "-", "real over apparent contact area", "Real area", "real area", "percent"
    ),
    "mean_contact_pressure": Quantity(
        "Pa", "normal load over real contact area", "Mean pressure", "N/real area", "3"
    ),
    "normal_stiffness": Quantity(
        "N/m", "normal stiffness; of unloading where the face yields", "kₙ", "", "3"
    ),
    "first_loading_stiffness": Quantity(
        "N/m", "normal stiffness on first loading", "kₙ on first loading", "kₙ, first loading", "3"
    ),
    "tangential_stiffness": Quantity(
        "N/m", "tangential stiffness at rest, contact alone", "kₜ", "", "3"
    ),
    "rig_normal_stiffness": Quantity(
        "N/m", "normal stiffness with the solid behind it", "kₙ at a rig", "kₙ, rig", "3"
    ),
    "rig_tangential_stiffness": Quantity(
        "N/m", "tangential stiffness with the solid behind it", "kₜ at a rig", "kₜ, rig", "3"
    ),
    "force_limit": Quantity("N", "force of gross slip", "μN", "", "3"),
    "slip_per_indentation": Quantity("-", "slip limit of a contact over its indentation"),
    "slip_scale": Quantity(
        "m", "displacement scale of the transition from sticking to sliding",
        "Slip scale", "slip scale", "3",
    ),
    # of a history
    "largest_displacement": Quantity(
        "m", "largest absolute displacement of the history",
        "Largest displacement", "largest displacement", "3",
    ),
    "largest_force": Quantity(
        "N", "largest absolute force of the history", "Largest force", "largest force", "3"
    ),
    "mode": Quantity("-", "number of the mode of the structure"),
    "modal_frequency": Quantity(
        "Hz", "frequency of a mode, by harmonic balance", "Frequency [Hz]", "Hz", ".5g"
    ),
    "modal_damping_ratio": Quantity(
        "-", "damping ratio of a mode in steady motion, by harmonic balance",
        "Damping ratio ζ, steady", "ζ", "ratio",
    ),
    **{
        f"modal_{name}_{word}": Quantity(
            unit, f"{share} % quantile of the {meaning} of a mode", f"{letter}, {share} %", "", form
        )
        for name, unit, meaning, letter, form in (
            ("frequency", "Hz", "frequency", "f", ".5g"),
            ("damping_ratio", "-", "damping ratio", "ζ", "ratio"),
        )
        for word, share in (("low", 5), ("median", 50), ("high", 95))
    },
    "quantile": Quantity("-", "fraction of the samples below"),
}  # fmt: skip
"""Meaning of the names of columns, keys and variables, in SI units."""

QUANTITY_UNITS: dict[str, str] = {name: quantity.unit for name, quantity in QUANTITIES.items()}
"""Unit of every quantity in tables and summaries."""
