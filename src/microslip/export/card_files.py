"""Contact cards in the words and units of finite-element programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

from microslip._core.files import whole_file
from microslip._core.wording import one_line
from microslip._version import __version__
from microslip.errors import InputError
from microslip.export.contact_card import ContactCard
from microslip.export.request import check_name, check_word, described
from microslip.friction import Interface

_NOT_RUN = "not run here, written after the public manual"


@dataclass(frozen=True)
class UnitSystem:
    """The units of a deck, in which its numbers are written."""

    name: str
    """Length, force, mass."""
    length: float
    """Its unit of length [m]."""
    force: float
    """Its unit of force [N]."""
    mass: float
    """Its unit of mass [kg]."""


UNITS = {
    "m": UnitSystem("m, N, kg, s: pressures in Pa", 1.0, 1.0, 1.0),
    "mm": UnitSystem("mm, N, t, s: pressures in MPa", 1e-3, 1.0, 1e3),
    "mm-ms": UnitSystem("mm, kN, kg, ms: pressures in GPa", 1e-3, 1e3, 1.0),
    "in": UnitSystem("in, lbf, lbf s^2/in, s: pressures in psi", 0.0254, 4.4482216152605, 175.1268),
}
"""Systems of units of decks."""


class _Deck:
    """The numbers of a card in the units of a deck, as texts."""

    def __init__(self, card: ContactCard, units: UnitSystem, name: str) -> None:
        pressure = units.force / units.length**2
        layer = card.layer
        self.card, self.name, self.mu = card, name, _text(card.friction_coefficient)
        self.normal = _text(card.normal_stiffness / pressure * units.length)
        self.stick = _text(card.stick_stiffness / pressure * units.length)
        self.slip = _text(card.elastic_slip / units.length)
        self.table = [
            (_text(p / pressure), _text(c / units.length))
            for p, c in zip(card.pressures.tolist(), card.overclosures.tolist(), strict=True)
        ]
        self.modulus, self.shear = (
            _text(value / pressure) for value in (layer.young_modulus, layer.shear_modulus)
        )
        self.shear_stiffness = _text(
            layer.shear_modulus / layer.thickness / pressure * units.length
        )
        self.thickness = _text(layer.thickness / units.length)
        self.loss = _text(layer.loss_factor)
        self.density = (
            None if layer.density is None else _text(layer.density * units.length**3 / units.mass)
        )

    def dense(self, *lines: str) -> list[str]:
        """Lines with the density in place of @, if there is one."""
        return [] if self.density is None else [line.replace("@", self.density) for line in lines]

    def needed(self, program: str) -> str:
        """The density, which an explicit program cannot do without."""
        if self.density is None:
            raise InputError(
                f"`density` must be given for {program}, whose layers need a mass [kg/m^3], for "
                "example density=2700.0; got none"
            )
        return self.density


def _text(value: float) -> str:
    return f"{value:.9e}"


def _abaqus(d: _Deck) -> list[str]:
    """Also read by CalculiX but for the friction; directions of the layer are 1 along z."""
    name = d.name.upper()
    return [
        f"*SURFACE INTERACTION, NAME={name}",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR",
        *(f"{p}, {c}" for p, c in d.table),
        f"*FRICTION, ELASTIC SLIP={d.slip}",
        f"{d.mu},",
        "** The layer: *COHESIVE SECTION, RESPONSE=TRACTION SEPARATION, THICKNESS=SPECIFIED, of",
        f"** the thickness {d.thickness}.",
        f"*MATERIAL, NAME={name}_LAYER",
        "*ELASTIC, TYPE=TRACTION",
        f"{d.modulus}, {d.shear}, {d.shear}",
        *d.dense("*DENSITY", "@,"),
        f"*DAMPING, STRUCTURAL={d.loss}",
    ]


def _calculix(d: _Deck) -> list[str]:
    name = d.name.upper()
    weak = _text(1e-6 * float(d.modulus))
    return [
        "** For *CONTACT PAIR, TYPE=NODE TO SURFACE, whose tangential stiffness is constant; with",
        "** TYPE=SURFACE TO SURFACE CalculiX 2.20 makes no force of a table, and does not say so.",
        f"*SURFACE INTERACTION, NAME={name}",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR",
        *(f"{p}, {c}" for p, c in d.table),
        "*FRICTION",
        f"{d.mu}, {d.stick}",
        f"** The layer: solid elements of the thickness {d.thickness} along z; *ORIENTATION turns",
        f"** it. The loss factor of its shear is {d.loss}.",
        f"*MATERIAL, NAME={name}_LAYER",
        "*ELASTIC, TYPE=ENGINEERING CONSTANTS",
        f"{weak}, {weak}, {d.modulus}, 0., 0., 0., {weak}, {d.shear},",
        f"{d.shear}, 293.",
        *d.dense("*DENSITY", "@,"),
    ]


def _ansys(d: _Deck) -> list[str]:
    return [
        "! Real constants of CONTA174 (3 = FKN, 12 = FKT; a minus makes them absolute), for the",
        "! pure penalty method, KEYOPT(2)=1; both stiffnesses are those of the joint's pressure.",
        "! Before: MICROSLIP_R, the set of real constants, MICROSLIP_M, a free material number.",
        "RMODIF,MICROSLIP_R,3,-" + d.normal,
        "RMODIF,MICROSLIP_R,12,-" + d.stick,
        f"MP,MU,MICROSLIP_M,{d.mu}",
        f"! The layer: SOLID185 of the thickness {d.thickness} along z of its element system.",
        *(f"MP,{key},MICROSLIP_M+1,{1e-6 * float(d.modulus):.9e}" for key in ("EX", "EY", "GXY")),
        f"MP,EZ,MICROSLIP_M+1,{d.modulus}",
        *(f"MP,{key},MICROSLIP_M+1,{d.shear}" for key in ("GYZ", "GXZ")),
        *(f"MP,{key},MICROSLIP_M+1,0" for key in ("PRXY", "PRYZ", "PRXZ")),
        *d.dense("MP,DENS,MICROSLIP_M+1,@"),
        "TB,SDAMP,MICROSLIP_M+1,1,,STRU",
        f"TBDATA,1,{d.loss}",
    ]


def _code_aster(d: _Deck) -> list[str]:
    return [
        "# Words for ZONE in DEFI_CONTACT(FORMULATION='CONTINUE', FROTTEMENT='COULOMB', ...),",
        "# whose stiffnesses are those of the joint's pressure.",
        f"{d.name}_zone = dict(",
        "    ALGO_CONT='PENALISATION',",
        f"    COEF_PENA_CONT={d.normal},",
        "    ALGO_FROT='PENALISATION',",
        f"    COEF_PENA_FROT={d.stick},",
        f"    COULOMB={d.mu},",
        ")",
        f"# The layer, of the thickness {d.thickness} along N: DEFI_MATERIAU(ELAS_ORTH=_F(**...)).",
        f"# The loss factor of its shear is {d.loss}.",
        f"{d.name}_layer = dict(",
        *(f"    {key}={1e-6 * float(d.modulus):.9e}," for key in ("E_L", "E_T", "G_LT")),
        f"    E_N={d.modulus},",
        *(f"    {key}={d.shear}," for key in ("G_LN", "G_TN")),
        *(f"    {key}=0.0," for key in ("NU_LT", "NU_LN", "NU_TN")),
        *d.dense("    RHO=@,"),
        ")",
    ]


def _moose(d: _Deck) -> list[str]:
    weak = f"{1e-6 * float(d.modulus):.9e}"
    constants = f"{weak} {weak} {d.modulus} {weak} {d.shear} {d.shear} 0 0 0 0 0 0"
    return [
        "# primary and secondary are to be set; stiffnesses are those of the joint's pressure.",
        "[Contact]",
        f"  [{d.name}]",
        "    formulation = mortar_penalty",
        "    model = coulomb",
        f"    friction_coefficient = {d.mu}",
        f"    penalty = {d.normal}",
        f"    penalty_friction = {d.stick}",
        "    use_dual = false",
        "  []",
        "[]",
        f"# The layer: elements of the thickness {d.thickness} along z, in a block to be set; the",
        f"# loss factor of its shear is {d.loss}.",
        "[Materials]",
        f"  [{d.name}_layer]",
        "    type = ComputeElasticityTensor",
        "    fill_method = orthotropic",
        f"    C_ijkl = '{constants}'",
        "  []",
        "[]",
    ]


def _openradioss(d: _Deck) -> list[str]:
    density = d.needed("openradioss")
    return [
        "# Its contacts have stiffnesses of nodes, none per unit area: the joint is the layer,",
        "# elements of /PROP/TYPE43 (CONNECT) between the faces, which sticks. Friction of an",
        f"# /INTER on the same faces, in place of the layer, is {d.mu}.",
        "/MAT/LAW59/1",
        f"{d.name}",
        "#              RHO_I",
        f"{density:>20}",
        "#                  E                   G     Imass     Icomp",
        f"{d.normal:>20}{d.shear_stiffness:>20}{0:>10}{0:>10}",
        "#  NB_func   Fsmooth                Fcut",
        f"{0:>10}{0:>10}{0:>20}",
        f"# The loss factor of its shear is {d.loss}.",
    ]


def _lsdyna(d: _Deck) -> list[str]:
    short = [f"{float(v):.4e}".rjust(10) for v in (d.needed("ls-dyna"), d.shear_stiffness)]
    normal = f"{float(d.normal):.4e}".rjust(10)
    return [
        "$ Its contacts have no stiffness per unit area: the joint is the layer, cohesive elements",
        "$ (ELFORM 19 or 20) between the faces, which stick. FS and FD of a *CONTACT on the same",
        f"$ faces, in place of the layer, are {d.mu}; numbers have five digits.",
        "*MAT_COHESIVE_ELASTIC",
        "$      mid        ro     roflg   intfail        et        en   fn_fail",
        f"{1:>10}{short[0]}{0:>10}{0.0:>10}{short[1]}{normal}{0.0:>10}",
        f"$ The loss factor of its shear is {d.loss}.",
    ]


@dataclass(frozen=True)
class _Program:
    """A program that a card is written for."""

    mark: str
    write: Callable[[_Deck], list[str]]
    holds: str
    """Stiffnesses that follow the pressure: table, slip, none."""
    run: str = _NOT_RUN


PROGRAMS = {
    "abaqus": _Program("**", _abaqus, "table slip"),
    "calculix": _Program(
        "**", _calculix, "table", "run by the tests of microslip with CalculiX 2.20, two blocks"
    ),
    "ansys": _Program("!", _ansys, ""),
    "code_aster": _Program("#", _code_aster, ""),
    "moose": _Program("#", _moose, ""),
    "openradioss": _Program("#", _openradioss, "layer"),
    "ls-dyna": _Program("$", _lsdyna, "layer"),
}
"""Programs that cards are written for, by their names."""


@dataclass(frozen=True)
class CardFile:
    """A contact card that was written."""

    program: str
    """The program it is for."""
    file: Path
    """The file."""
    run: str
    """Whether this kind of card was ever run."""
    card: ContactCard
    """Its numbers, in SI units, and what they cannot hold."""


def write_card(
    program: str,
    joint: Interface,
    file: str | Path,
    *,
    units: str = "m",
    name: str = "joint",
    overwrite: bool = False,
    **options: Any,
) -> CardFile:
    """Write a joint as contact for a finite-element program, per unit area, in a deck's units.

    Parameters
    ----------
    program : str
        One of ``microslip.export.PROGRAMS``.
    joint : Interface
        The joint at its normal load.
    file : str or pathlib.Path
        File to write.
    units : str, optional
        ``"m"``: N, m, kg; ``"mm"``: N, mm, t; ``"mm-ms"``: kN, mm, kg; ``"in"``: lbf, in.
    name : str, optional
        Prefix of the names in the file.
    overwrite : bool, optional
        Whether a file that exists is replaced.
    **options
        Of :meth:`ContactCard.of`: area [m^2], amplitude [m], thickness [m], density [kg/m^3].

    Returns
    -------
    CardFile
        The file, and its numbers in SI units.
    """
    check_word("program", program, PROGRAMS)
    check_word("units", units, UNITS)
    check_name(name)
    card = ContactCard.of(joint, **options)
    deck = _Deck(card, UNITS[units], name)
    kind = PROGRAMS[program]
    lines = kind.write(deck)
    header = [
        f"Written by microslip {__version__}, contact card for {program}.",
        f"Units: {UNITS[units].name}. Numbers of this comment are in SI units.",
        f"Law: {one_line(described(joint))}",
        *_limits_of(card, kind.holds),
        f"Verification: {kind.run}.",
    ]
    comments = [
        f"{kind.mark} {short}"
        for line in header
        for short in wrap(line, 96, subsequent_indent="  ")
    ]
    path = Path(file)
    with whole_file(path, overwrite) as stage:
        stage.write_text("\n".join([*comments, *lines]) + "\n", encoding="utf-8")
    return CardFile(program, path, kind.run, card)


def _limits_of(card: ContactCard, holds: str) -> list[str]:
    """Limits of a card, line by line."""
    errors, layer = card.errors, card.layer
    half, twice = 0.5 * card.pressure, 2.0 * card.pressure
    stick = errors.elastic_slip if "slip" in holds else errors.constant_stick
    normal = (
        f"the table, {errors.pressure:.1g} off between its points"
        if "table" in holds
        else f"constant, up to {errors.normal_stiffness:.0%} off from {half:.3g} to {twice:.3g} Pa"
    )
    lines = [
        f"At the joint's pressure, {card.pressure:.6g} Pa: normal stiffness "
        f"{card.normal_stiffness:.6g} Pa/m, tangential stiffness at rest "
        f"{card.stick_stiffness:.6g} Pa/m, elastic slip {card.elastic_slip:.6g} m.",
        f"Normal: {normal}.",
        f"Tangential stiffness: up to {stick:.0%} off from {half:.3g} to {twice:.3g} Pa.",
    ]
    if "layer" not in holds:
        damping = "; ".join(
            f"{a:.2g} m: {joint:.2g}, {contact:.2g}" for a, joint, contact in errors.damping
        )
        lines += [
            f"The stick-slip contact exceeds the joint's force by up to "
            f"{errors.force:.0%}, and dissipates nothing below the elastic slip. Loss factors of "
            f"joint and contact at amplitudes: {damping}.",
        ]
    return [
        *lines,
        f"Layer: added between the faces, for an amplitude of slip of {layer.amplitude:.3g} m at "
        f"the joint's pressure, loss factor {layer.loss_factor:.3g}; it neither slips nor opens.",
    ]
