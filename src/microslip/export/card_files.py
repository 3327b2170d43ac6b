"""Contact cards of a joint in the syntax and units of finite-element programs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.wording import one_line
from microslip._version import __version__
from microslip.export.c_source import render
from microslip.export.contact_card import ContactCard
from microslip.export.request import check_name, check_word, described
from microslip.friction import Interface


@dataclass(frozen=True)
class UnitSystem:
    """Units of length, force and mass of an input file of a finite-element program."""

    name: str
    """Names of the units of length, force, mass and time."""
    length: float
    """Unit of length [m]."""
    force: float
    """Unit of force [N]."""
    mass: float
    """Unit of mass [kg]."""


CARD_UNITS = {
    "m": UnitSystem("m, N, kg, s: pressures in Pa", 1.0, 1.0, 1.0),
    "mm": UnitSystem("mm, N, t, s: pressures in MPa", 1e-3, 1.0, 1e3),
    "mm-ms": UnitSystem("mm, kN, kg, ms: pressures in GPa", 1e-3, 1e3, 1.0),
    "in": UnitSystem("in, lbf, lbf s^2/in, s: pressures in psi", 0.0254, 4.4482216152605, 175.1268),
}
"""Unit systems of input decks, by name."""


@dataclass(frozen=True)
class _Program:
    mark: str
    """Comment mark."""
    holds: str
    """Contents of its card: "table" of pressures, "slip" (elastic slip), "layer" of elements."""
    run: str = "not run, written from the public manual"


PROGRAMS = {
    "abaqus": _Program("**", "table slip"),
    "calculix": _Program(
        "**", "table", "run by the tests of microslip with CalculiX 2.20, two blocks"
    ),
    "ansys": _Program("!", ""),
    "code_aster": _Program("#", ""),
    "moose": _Program("#", ""),
    "openradioss": _Program("#", "layer"),
    "ls-dyna": _Program("$", "layer"),
}
"""Programs with contact cards, by name."""


def _numbers(card: ContactCard, units: UnitSystem) -> dict[str, str]:
    """Return the numbers of a card as text in the units of a file, by name in the template."""
    pressure = units.force / units.length**2
    layer = card.layer
    rows = zip(card.pressures / pressure, card.overclosures / units.length, strict=True)
    values = {
        "MU": card.friction_coefficient,
        "NORMAL": card.normal_stiffness / pressure * units.length,
        "STICK": card.stick_stiffness / pressure * units.length,
        "SLIP": card.elastic_slip / units.length,
        "MODULUS": layer.young_modulus / pressure,
        "SHEAR": layer.shear_modulus / pressure,
        "SHEAR_STIFFNESS": layer.shear_modulus / layer.thickness / pressure * units.length,
        "THICKNESS": layer.thickness / units.length,
        "LOSS": layer.loss_factor,
    }
    if layer.density is not None:
        values["DENSITY"] = layer.density * units.length**3 / units.mass
    numbers = {word: f"{value:.9e}" for word, value in values.items()}
    # Directions in which the layer carries no load get a millionth of its modulus.
    numbers["WEAK"] = f"{1e-6 * float(numbers['MODULUS']):.9e}"
    numbers["TABLE"] = "\n".join(f"{p:.9e}, {c:.9e}" for p, c in rows)
    for word in ("DENSITY", "NORMAL", "SHEAR_STIFFNESS"):  # columns of fixed width
        if word in numbers:
            numbers[f"{word}_20"] = f"{numbers[word]:>20}"
            numbers[f"{word}_10"] = f"{float(numbers[word]):>10.4e}"
    return numbers


def write_card(
    program: str,
    joint: Interface,
    file: str | Path,
    *,
    units: str = "m",
    name: str = "joint",
    overwrite: bool = False,
    **options: Any,
) -> ContactCard:
    """Write a joint as a contact card of a finite-element program, per unit area.

    Parameters
    ----------
    program : str
        Finite-element program, one of ``microslip.export.PROGRAMS``.
    joint : Interface
        The joint at its normal load.
    file : str or pathlib.Path
        File to write.
    units : str, optional
        ``"m"``: N, m, kg; ``"mm"``: N, mm, t; ``"mm-ms"``: kN, mm, kg; ``"in"``: lbf, in.
    name : str, optional
        Beginning of all names in the file.
    overwrite : bool, optional
        Replace an existing file.
    **options
        Options of :meth:`ContactCard.of`: area [m^2], amplitude [m], thickness [m] and density
        [kg/m^3].

    Returns
    -------
    ContactCard
        The numbers of the card in SI units, and their errors. ``PROGRAMS[program].run`` states how
        this kind of card was verified.
    """
    check_word("program", program, PROGRAMS)
    check_word("units", units, CARD_UNITS)
    check_name(name)
    card = ContactCard.of(joint, **options)
    kind = PROGRAMS[program]
    if kind.holds == "layer" and card.layer.density is None:
        raise InputError(
            f"`density` must be given for {program} [kg/m^3], for example density=2700.0, got none"
        )
    body = render(
        f"card_{program}",
        "" if card.layer.density is None else "density",
        NAME=name,
        UPPER=name.upper(),
        **_numbers(card, CARD_UNITS[units]),
    )
    header = [
        f"Written by microslip {__version__}, contact card for {program}.",
        f"Units: {CARD_UNITS[units].name}. Numbers of this comment are in SI units.",
        f"Law: {one_line(described(joint))}",
        *_limits_of(card, kind.holds),
        f"Verification: {kind.run}.",
    ]
    comments = [
        f"{kind.mark} {short}"
        for line in header
        for short in wrap(line, 96, subsequent_indent="  ")
    ]
    with atomic_file(file, overwrite) as stage:
        stage.write_text("\n".join([*comments, body]), encoding="utf-8")
    return card


def _limits_of(card: ContactCard, holds: str) -> list[str]:
    errors, layer = card.errors, card.layer
    span = f"{0.5 * card.pressure:.3g} to {2.0 * card.pressure:.3g} Pa"
    stick = errors.elastic_slip if "slip" in holds else errors.normal_stiffness
    normal = (
        f"table, relative error up to {errors.pressure:.1g} between its points"
        if "table" in holds
        else f"constant, error up to {100.0 * errors.normal_stiffness:.0f} %, {span}"
    )
    lines = [
        f"At the joint's pressure, {card.pressure:.6g} Pa: normal stiffness "
        f"{card.normal_stiffness:.6g} Pa/m, tangential stiffness at rest "
        f"{card.stick_stiffness:.6g} Pa/m, elastic slip {card.elastic_slip:.6g} m.",
        f"Normal: {normal}.",
        f"Tangential stiffness: error up to {100.0 * stick:.0f} % from {span}.",
    ]
    if "layer" not in holds:
        damping = "; ".join(
            f"{a:.2g} m: {joint:.2g}, {contact:.2g}" for a, joint, contact in errors.damping
        )
        lines += [
            f"The stick-slip contact exceeds the joint's force by up to "
            f"{100.0 * errors.force:.0f} %, and dissipates nothing below the elastic slip. Loss "
            f"factors of joint and contact at amplitudes: {damping}.",
        ]
    return [
        *lines,
        f"Layer: added between the faces, for a slip amplitude of {layer.amplitude:.3g} m at the "
        f"joint's pressure, loss factor {layer.loss_factor:.3g}. It neither slips nor opens.",
    ]
