"""Elastic materials, a table of metals, and pairs of materials with their composite moduli.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from types import MappingProxyType

from microslip._core.checks import exact, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign
from microslip._core.parameters import parameter, parameters_of
from microslip._core.units import HARDNESS
from microslip._core.wording import nearest


@dataclass(frozen=True)
class Material:
    """Linear elastic, isotropic material: E and nu of (19.4), G of (19.11).

    Parameters
    ----------
    young_modulus : float
        Young's modulus E [Pa], above zero and finite; for a rigid body see :meth:`rigid`.
    poisson_ratio : float
        Poisson's ratio [-], in (-1, 0.5].
    hardness : float, optional
        Indentation hardness H [Pa]: the largest pressure at a point of a
        :class:`microslip.DrawnFace` or a :class:`microslip.MeasuredContact`. For laws with summits
        it is used for the plasticity index only.

    Warns
    -----
    UserWarning
        If the modulus is probably in GPa or MPa: between 1.5 Pa and 1200 Pa, or with a Poisson's
        ratio below 0.45 between 10 kPa and 1.3 MPa.
    """

    young_modulus: float = field(
        metadata=parameter("E", "Pa", "Young's modulus E", above=0.0, example=69e9)
    )
    poisson_ratio: float = field(
        metadata=parameter("nu", "", "Poisson's ratio", above=-1.0, most=0.5, example=0.33)
    )
    hardness: float | None = field(
        default=None,
        metadata=parameter(
            "H", meaning="indentation hardness", kind=HARDNESS, above=0.0, example=1.2e9
        ),
    )

    def __post_init__(self) -> None:
        if isinstance(self.young_modulus, float) and self.young_modulus == math.inf:
            raise InputError(
                "`young_modulus` must be finite, got inf; a rigid body is Material.rigid()"
            )
        assign(self, **{p.name: p.checked(getattr(self, p.name)) for p in parameters_of(Material)})
        self._warn_of_unit()

    def _warn_of_unit(self) -> None:
        modulus = self.young_modulus
        if 1.5 <= modulus <= 1200.0:
            unit, factor = "GPa", 1e9
        elif 1e4 <= modulus <= 1.3e6 and self.poisson_ratio < 0.45:
            unit, factor = "MPa", 1e6
        else:
            return
        # A study asks back itself, and derivatives make bodies of their own.
        if str(sys._getframe(3).f_globals.get("__name__")).startswith("microslip."):
            return
        came = exact(modulus)
        warnings.warn(
            f"young_modulus is {came} Pa, as soft as a gel; if {came} {unit} is meant, "
            f'write {exact(modulus * factor)} or units("{came} {unit}")',
            stacklevel=4,
        )

    @classmethod
    def rigid(cls) -> Material:
        """Return a rigid body, with infinite Young's modulus."""
        body = object.__new__(cls)
        assign(body, young_modulus=math.inf, poisson_ratio=0.0, hardness=None)
        return body

    @classmethod
    def named(cls, name: str) -> Material:
        """Return a metal of the table of :func:`metals`.

        Parameters
        ----------
        name : str
            Name in the table, such as "steel" or "al2017", or an alias such as "S355", "316L" or
            "EN AW-6082"; capitals, spaces, hyphens and underscores are ignored.
        """
        return metal(name).material

    def __repr__(self) -> str:
        if self.is_rigid:
            return "Material.rigid()"
        hardness = "" if self.hardness is None else f", hardness={exact(self.hardness)}"
        return f"Material({exact(self.young_modulus)}, {exact(self.poisson_ratio)}{hardness})"

    @property
    def is_rigid(self) -> bool:
        """Whether the body is rigid."""
        return math.isinf(self.young_modulus)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E/(2 (1 + nu)) [Pa]."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))


@dataclass(frozen=True)
class Metal(Locked):
    """Metal of the table: its elastic constants and their sources.

    Parameters
    ----------
    name : str
        Name in studies and for :meth:`Material.named`.
    description : str
        Designations and temper.
    young_modulus : float
        Young's modulus E [Pa] (19.4).
    poisson_ratio : float
        Poisson's ratio [-].
    hardness : float or None
        Indentation hardness H [Pa] of the temper; None if the documents state none.
    sources : mapping of str to str
        Source document and year of each value, by parameter name.
    aliases : tuple of str
        Other names, such as "s355", "EN AW-6082" and numbers of standards.

    Notes
    -----
    Values are those of design codes and handbooks; measured moduli differ by a few percent.
    """

    name: str
    description: str
    young_modulus: float
    poisson_ratio: float
    hardness: float | None
    sources: Mapping[str, str] = field(hash=False)
    aliases: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _ = self.material
        assign(self, aliases=tuple(self.aliases), sources=MappingProxyType(dict(self.sources)))

    @property
    def material(self) -> Material:
        """Material with the constants of the metal."""
        return Material(self.young_modulus, self.poisson_ratio, self.hardness)


@lru_cache(maxsize=1)
def metals() -> Mapping[str, Metal]:
    """Return the table of engineering metals by name, with document and year of each value."""
    import tomllib
    from importlib.resources import files

    text = files("microslip").joinpath("metals.toml").read_text(encoding="utf-8")
    table = {}
    for name, entry in tomllib.loads(text).items():
        table[name] = Metal(name=name, **{"hardness": None, **entry})
    return MappingProxyType(table)


def metal(name: str) -> Metal:
    """Return a metal of the table by a name that :meth:`Material.named` accepts."""
    if not isinstance(name, str):
        raise InputError(f"`name` must be a text such as 'steel', got {show(name)}")
    entry = metal_called(name)
    if entry is None:
        plain = _plain(name)
        # A part of a name, such as "4340" or "iron", may be too short to be close to the whole.
        near = [key for key in metals() if len(plain) >= 3 and plain in key]
        if not near and (match := nearest(plain, metals())):
            near = [match]
        hint = f"there are {', '.join(metals())}"
        if near:
            hint = f"did you mean {' or '.join(map(repr, near))}?"
        raise InputError(f"no metal is named {show(name)}; {hint}")
    return entry


def metal_called(name: str) -> Metal | None:
    """Return the metal with a name or alias, or None."""
    return _by_name().get(_plain(name).replace("-", ""))


@lru_cache(maxsize=1)
def _by_name() -> Mapping[str, Metal]:
    return {
        _plain(name).replace("-", ""): metal
        for metal in metals().values()
        for name in (metal.name, *metal.aliases)
    }


def _plain(name: str) -> str:
    return "-".join(name.casefold().replace("_", " ").split())


@dataclass(frozen=True)
class MaterialPair:
    """Two bodies in contact, equivalent to one elastic body on a rigid one.

    Parameters
    ----------
    first, second : Material
        The two materials; at most one of them is rigid.
    """

    first: Material
    second: Material

    def __post_init__(self) -> None:
        for name in ("first", "second"):
            if not isinstance(getattr(self, name), Material):
                raise InputError(
                    f"`{name}` must be a Material, got {show(getattr(self, name))}; write "
                    "MaterialPair(Material(69e9, 0.33), Material(210e9, 0.3))"
                )
        if self.first.is_rigid and self.second.is_rigid:
            raise InputError("a pair needs one body that deforms, got two rigid ones")

    @property
    def composite_modulus(self) -> float:
        """Composite modulus E* [Pa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (19.4)."""
        return 1.0 / sum(
            (1.0 - m.poisson_ratio**2) / m.young_modulus for m in (self.first, self.second)
        )

    @property
    def composite_shear_modulus(self) -> float:
        """Composite shear modulus G* [Pa]: 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2 (19.11)."""
        return 1.0 / sum(
            (2.0 - m.poisson_ratio) / m.shear_modulus for m in (self.first, self.second)
        )

    @property
    def stiffness_ratio(self) -> float:
        """Ratio E*/(4 G*) of normal to tangential stiffness of a round contact [-].

        Mindlin (1949), DOI 10.1115/1.4009973.
        """
        return self.composite_modulus / (4.0 * self.composite_shear_modulus)

    @property
    def dundurs_beta(self) -> float:
        """Second constant of Dundurs, beta [-]: zero for equal bodies, magnitude at most 0.5.

        Half the difference of (1 - 2 nu)/G of the two bodies over the sum of their (1 - nu)/G
        (Dundurs 1969, DOI 10.1115/1.3564739). It describes the coupling of normal and tangential
        contact.
        """
        bodies = [(m.poisson_ratio, m.shear_modulus) for m in (self.first, self.second)]
        (first, second), total = (
            [(1.0 - 2.0 * nu) / g for nu, g in bodies],
            sum((1.0 - nu) / g for nu, g in bodies),
        )
        return 0.5 * (first - second) / total

    @property
    def hardness(self) -> float | None:
        """Hardness of the softer body [Pa]; None if neither is known."""
        hardnesses = [m.hardness for m in (self.first, self.second) if m.hardness is not None]
        return min(hardnesses) if hardnesses else None

    def with_hardness(self, hardness: float) -> MaterialPair:
        """Return the pair with the hardness [Pa] of its deformable bodies replaced."""
        first, second = (
            body if body.is_rigid else replace(body, hardness=hardness)
            for body in (self.first, self.second)
        )
        return MaterialPair(first, second)
