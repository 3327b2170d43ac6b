"""Numbers of a fit and their names as people read them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from microslip._core.units import engineering, significant

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
