"""Names of parameters as people read them."""

from __future__ import annotations

from collections.abc import Sequence

from microslip._core.units import engineering
from microslip.identification.verdicts import AT_A_LOAD

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
    """A name as people read it: "slip_scale at 500 N" is "slip scale κσ at 500 N".

    ``load`` [N] is that of the number: named with one that belongs to a load without saying so.
    """
    key, _, place = name.partition(" ")
    text = _LABELS.get(key, key.replace("_", " "))
    if load is not None and not place and key in AT_A_LOAD:
        place = f"at {engineering(load, 'N', 4, trim=True)}"
    return f"{text} {place}" if place else text


def short_symbols(names: Sequence[str], loads: Sequence[float | None]) -> list[str]:
    """Symbols of parameters, or their words, with the load [N] each belongs to."""
    texts = []
    for name, load in zip(names, loads, strict=True):
        key, _, place = name.partition(" ")
        if load is not None and not place and key in AT_A_LOAD:
            place = f"at {engineering(load, 'N', 4, trim=True)}"
        symbol = _SYMBOLS.get(key)
        texts.append(label(name, load) if symbol is None else f"{symbol} {place}".rstrip())
    return texts
