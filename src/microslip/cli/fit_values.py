"""Values with units given to ``identify`` on the command line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from microslip._core.units import AREA, DENSITY, FORCE, LENGTH, STIFFNESS, TIME
from microslip._core.wording import did_you_mean
from microslip.cli.options import ends_in, quantity
from microslip.cli.records import is_number, pairs, slice_of, stiffness, with_deviation

_FOLLOWING = {
    "std": "m",
    "radius": "m",
    "density": "1/m^2",
    "summit_count": "",
    "contact_area": "m^2",
    "force_limit": "N",
    "tangential_stiffness": "N/m",
    "load_scale": "N",
}
"""Units of what follows from the parameters, as far as it may be known from elsewhere."""


def options_of(values: dict[str, Any], laws: Sequence[str]) -> dict[str, Any]:
    """Options of a fit in SI units, of what the command line gives for them."""
    plain = ("summits", "loss", "held_back", "confidence")
    return {
        "fixed": values_of(values["fix"], laws),
        "bounds": bounds_of(values["bound"], laws),
        "rig_stiffness": rig_stiffness_of(values["rig_stiffness"]),
        "contact_area": contact_area_of(values["contact_area"]),
        "known": known_of(values["known_values"], laws),
        "cycles": slice_of("--cycles", values["cycles"]),
        "nuisances": values["nuisances"] or None,
        "noise": noise_of(values["noise"]),
        "delay": "free" if values["free_delay"] else delay_of(values["lag"]),
        **{name: values[name] for name in plain},
    }


def values_of(texts: tuple[str, ...], laws: Sequence[str]) -> dict[str, float]:
    """Values of --fix, NAME=VALUE each."""
    units = _units_of(laws)
    return {
        name: _quantity("--fix", name, text, units) for name, text in pairs("fix", texts).items()
    }


def bounds_of(texts: tuple[str, ...], laws: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Bounds of --bound, NAME=LOW..HIGH each."""
    units = _units_of(laws)
    bounds = {}
    for name, text in pairs("bound", texts).items():
        low, high = (
            _quantity("--bound", name, end, units)
            for end in ends_in("--bound", text, f"{name}=LOW..HIGH")
        )
        if not low < high:
            raise click.UsageError(
                f'--bound wants {name}=LOW..HIGH with LOW below HIGH, got "{text}"'
            )
        bounds[name] = (low, high)
    return bounds


def known_of(texts: tuple[str, ...], laws: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Known values of --known, NAME=VALUE±DEVIATION each."""
    units = {**_units_of(laws), **_FOLLOWING}
    measured = {}
    for name, text in pairs("known", texts).items():
        value, deviation = with_deviation(text)
        if not value or not deviation:
            raise click.UsageError(f'--known wants {name}=VALUE±DEVIATION, got "{text}"')
        measured[name] = (
            _quantity("--known", name, value, units),
            _quantity("--known", name, deviation, units),
        )
    return measured


def _units_of(laws: Sequence[str]) -> dict[str, str]:
    """Units of the parameters of some laws."""
    from microslip.results.identified.document import units_of

    return units_of(laws)


def _quantity(option: str, name: str, text: str, units: dict[str, str]) -> float:
    """A value of a parameter [SI unit]."""
    base = name.partition(" at ")[0]
    if base not in units:
        near = did_you_mean(name, units)
        raise click.UsageError(
            f'{option}: no parameter "{name}"{near} (parameters: {", ".join(units)})'
        )
    kinds = (AREA, DENSITY, FORCE, LENGTH, STIFFNESS)
    kind = next((kind for kind in kinds if kind.unit == units[base]), None)
    if kind is None:
        if not is_number(text):
            raise click.UsageError(f'{option}: {name} is a plain number, got "{text}"')
        return float(text)
    examples = {"m": "0.3 um", "N": "1 kN", "N/m": "200 N/um"}
    example = examples.get(kind.unit, f"100 {kind.usual[0]}")
    return quantity(f"{option}: {name}", text, kind, example)


def noise_of(text: str | None) -> tuple[float, float] | None:
    """Standard deviations of a force [N] and of a displacement [m]."""
    if text is None:
        return None
    force, comma, length = text.partition(",")
    if not comma:
        raise click.UsageError(f'--noise wants FORCE,LENGTH, such as "2 N, 5 nm", got "{text}"')
    return (
        quantity("--noise", force.strip(), FORCE, "2 N"),
        quantity("--noise", length.strip(), LENGTH, "5 nm"),
    )


def delay_of(text: str | None) -> float | str:
    """A delay [s] with its unit, or "free"."""
    if text is None or text.strip() == "free":
        return 0.0 if text is None else "free"
    return quantity("--delay", text, TIME, "50 us", "any")


def rig_stiffness_of(text: str) -> Any:
    """Known stiffness of the rig: "free", None for a rigid one, a value, or with its deviation."""
    words = text.strip()
    if words in ("free", "rigid"):
        return "free" if words == "free" else None
    value, deviation = with_deviation(words)
    first = stiffness(value)
    return first if deviation is None else (first, stiffness(deviation))


def contact_area_of(text: str | None) -> tuple[float, float, float] | None:
    """A contact area [m^2], its uncertainty [m^2] and load [N]."""
    if text is None:
        return None
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 3:
        raise click.UsageError(
            '--contact-area wants an area, its uncertainty and the load, such as "6 mm^2, 1 mm^2, '
            f'2 kN", got "{text}"'
        )
    area, deviation = (quantity("--contact-area", part, AREA, "6 mm^2") for part in parts[:2])
    return area, deviation, quantity("--contact-area", parts[2], FORCE, "2 kN")
