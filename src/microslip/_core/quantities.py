"""Every quantity of a result by its name: unit and meaning, in one place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple


def named(source: Any, *names: str) -> dict[str, Any]:
    """Attributes by their names, all of a record without any; records in them as well."""
    values = {name: getattr(source, name) for name in names or source._fields}
    return {n: named(v) if hasattr(v, "_asdict") else v for n, v in values.items()}


def json_value(value: Any) -> Any:
    """Return a value as JSON holds it: lists for arrays, None for a number that is not finite."""
    if isinstance(value, Mapping):
        return {name: json_value(part) for name, part in value.items()}
    if hasattr(value, "tolist"):  # NumPy's; help and lists of the command start without NumPy
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [json_value(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


class Quantity(NamedTuple):
    """Unit ("-" for none) and meaning of a number in tables, in the summary and in netCDF."""

    unit: str
    meaning: str

    @property
    def attributes(self) -> dict[str, str]:
        """The same as the CF conventions want it, where "1" is the unit of a plain number."""
        unit = "1" if self.unit == "-" else self.unit
        return {"units": unit, "long_name": self.meaning}


QUANTITIES: dict[str, Quantity] = {
    "normal_load": Quantity("N", "normal load"),
    "amplitude": Quantity("m", "displacement amplitude"),
    "displacement": Quantity("m", "tangential displacement"),
    "force": Quantity("N", "force that holds the displacement"),
    # what belongs to an amplitude
    "force_amplitude": Quantity("N", "force amplitude"),
    "force_ratio": Quantity("-", "force amplitude over force limit"),
    "dissipated_energy": Quantity("J", "energy dissipated in a cycle"),
    "energy_ratio": Quantity("-", "dissipated energy over 4 displacement times force amplitude"),
    "loss_factor": Quantity("-", "loss factor of the interface"),
    "damping_ratio": Quantity("-", "equivalent viscous damping ratio of the interface"),
    "secant_stiffness": Quantity("N/m", "force amplitude over displacement amplitude"),
    "tangent_stiffness": Quantity("N/m", "slope of the first loading curve at the amplitude"),
    "dissipation_exponent": Quantity("-", "local power of the amplitude in the dissipated energy"),
    "slider_density": Quantity("N/m^2", "stiffness of the Iwan sliders per yield displacement"),
    "stick_area": Quantity("m^2", "contact area that sticks at the end of the first loading"),
    "stick_share": Quantity("-", "stick area over real contact area"),
    # what belongs to an amplitude under a normal load that varies
    # what belongs to a load
    "separation": Quantity("m", "separation of the surfaces"),
    "standardised_separation": Quantity("-", "separation over the spread of the heights"),
    "contact_count": Quantity("-", "summits in contact"),
    "contact_area": Quantity("m^2", "real contact area"),
    "contact_area_fraction": Quantity("-", "real over apparent contact area"),
    "mean_contact_pressure": Quantity("Pa", "normal load over real contact area"),
    "normal_stiffness": Quantity("N/m", "normal stiffness"),
    "tangential_stiffness": Quantity("N/m", "tangential stiffness at rest"),
    "force_limit": Quantity("N", "force of gross slip"),
    "slip_per_indentation": Quantity("-", "slip limit of a contact over its indentation"),
    "slip_scale": Quantity("m", "displacement over which the joint goes from sticking to sliding"),
    "cubic_coefficient": Quantity("J/m^3", "c of the energy at small amplitudes a, c a^3"),
    "linear_offset": Quantity("m", "b of the energy at large amplitudes a, 4 mu N (a - b)"),
    # a history
    "largest_displacement": Quantity("m", "largest displacement of the history in size"),
    "largest_force": Quantity("N", "largest force of the history in size"),
    "mode": Quantity("-", "number of the mode of the structure"),
    "modal_frequency": Quantity("Hz", "frequency of a mode, by harmonic balance"),
    "modal_damping_ratio": Quantity(
        "-", "damping ratio of a mode in steady motion, by harmonic balance"
    ),
    **{
        f"modal_{name}_{word}": Quantity(unit, f"{share} % quantile of the {meaning} of a mode")
        for name, unit, meaning in (
            ("frequency", "Hz", "frequency"),
            ("damping_ratio", "-", "damping ratio"),
        )
        for word, share in (("low", 5), ("median", 50), ("high", 95))
    },
    "quantile": Quantity("-", "share of the samples below"),
}
"""Meanings of the names of columns, keys and variables; all numbers are in SI units."""

UNITS: dict[str, str] = {name: quantity.unit for name, quantity in QUANTITIES.items()}
"""Unit of every quantity in the tables and in the summary."""
