"""Materials and pairs: their numbers, and the one line that each wrong value gets."""

from __future__ import annotations

import math
import re

import pytest

import microslip as ms
from microslip.contact.materials import metals

AL = ms.Material(69e9, 0.33)


# -- numbers ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("modulus", "ratio", "said"),
    [
        (210, 0.3, '210 GPa is meant, write 2.1e+11 or units("210 GPa")'),
        (210e3, 0.3, '210000 MPa is meant, write 2.1e+11 or units("210000 MPa")'),
        (2.5, 0.49, "2.5 GPa is meant"),
    ],
)
def test_a_modulus_that_reads_like_one_in_another_unit_is_flagged_as_a_likely_unit_error(
    modulus: float, ratio: float, said: str
) -> None:
    with pytest.warns(UserWarning, match=re.escape(said)) as caught:
        body = ms.Material(modulus, ratio)
    assert caught[0].filename == __file__  # it points at who wrote the number
    assert body.young_modulus == modulus


def test_composite_moduli_of_unlike_bodies() -> None:
    steel = ms.Material(210e9, 0.3)
    pair = ms.MaterialPair(AL, steel)
    normal = 1 / ((1 - 0.33**2) / 69e9 + (1 - 0.3**2) / 210e9)
    shear = 1 / ((2 - 0.33) / AL.shear_modulus + (2 - 0.3) / steel.shear_modulus)
    assert pair.composite_modulus == pytest.approx(normal, rel=1e-15, abs=0)
    assert pair.composite_shear_modulus == pytest.approx(shear, rel=1e-15, abs=0)
    assert pair.stiffness_ratio == pytest.approx(normal / (4 * shear), rel=1e-15, abs=0)


def test_rigid_body_adds_no_compliance() -> None:
    rigid = ms.Material.rigid()
    pair = ms.MaterialPair(AL, rigid)
    assert rigid.is_rigid
    assert not AL.is_rigid
    assert rigid.shear_modulus == math.inf
    assert pair.composite_modulus == pytest.approx(69e9 / (1 - 0.33**2), rel=1e-15, abs=0)
    assert pair.composite_shear_modulus == pytest.approx(AL.shear_modulus / 1.67, rel=1e-15, abs=0)
    twin = ms.MaterialPair(AL, AL)
    assert pair.composite_modulus == pytest.approx(2 * twin.composite_modulus, rel=1e-15, abs=0)


def test_hardness_of_a_pair_is_the_softer_one() -> None:
    soft, hard = ms.Material(69e9, 0.33, 1.1e9), ms.Material(210e9, 0.3, hardness=2e9)
    assert ms.MaterialPair(soft, hard).hardness == 1.1e9
    assert ms.MaterialPair(AL, hard).hardness == 2e9
    assert ms.MaterialPair(AL, AL).hardness is None
    assert ms.MaterialPair(ms.Material.rigid(), soft).hardness == 1.1e9


# -- wrong values ----------------------------------------------------------------------------------


@pytest.mark.parametrize("ratios", [(-0.99, 0.5), (0.5, -1 + 2**-53)])
@pytest.mark.parametrize("moduli", [(1e-40, 1e40), (1e40, 1e40), (1e-40, 1e-40)])
def test_extreme_pairs_have_finite_moduli(
    moduli: tuple[float, float], ratios: tuple[float, float]
) -> None:
    first, second = (ms.Material(e, nu) for e, nu in zip(moduli, ratios, strict=True))
    for pair in (ms.MaterialPair(first, second), ms.MaterialPair(second, ms.Material.rigid())):
        for value in (pair.composite_modulus, pair.composite_shear_modulus, pair.stiffness_ratio):
            assert 0.0 < value < math.inf


# -- the table of metals ---------------------------------------------------------------------------


PSI = 6894.757
HB = 9.80665e6
# E, G and nu typed again from the documents: in 10^6 psi, or in GPa where that is printed. G is
# printed by each of them but the standards on cast iron and stainless steel.
PRINTED = {
    "steel": (210.0, 81.0, 0.3, "GPa"),
    "steel-s355": (210.0, 81.0, 0.3, "GPa"),
    "steel-c45": (210.0, 81.0, 0.3, "GPa"),
    "steel-4340": (29.0, 11.0, 0.32, "Msi"),
    "tool-steel": (29.5, 11.4, 0.295, "Msi"),
    "stainless-304": (200.0, None, 0.3, "GPa"),
    "stainless-316l": (200.0, None, 0.3, "GPa"),
    "stainless-17-4ph": (28.5, 11.2, 0.27, "Msi"),
    "grey-iron": ((103.0 + 118.0) / 2.0, None, 0.26, "GPa"),
    "ductile-iron": (169.0, None, 0.275, "GPa"),
    "al2017": (69.0, None, 0.33, "GPa"),
    "al2024": (10.5, 4.0, 0.33, "Msi"),
    "al6061": (9.9, 3.8, 0.33, "Msi"),
    "al6082": (70.0, 27.0, 0.3, "GPa"),
    "al7075": (10.3, 3.9, 0.33, "Msi"),
    "az31b": (6.5, 2.4, 0.35, "Msi"),
    "ti-6al-4v": (16.0, 6.2, 0.31, "Msi"),
    "inconel-718": (29.4, 11.4, 0.29, "Msi"),
    "nickel": (28.9, 11.0, 0.312, "Msi"),
    "copper": (18.8, 7.01, 0.343, "Msi"),
    "brass": (14.6, 5.41, 0.35, "Msi"),
    "tungsten": (59.6, 23.3, 0.28, "Msi"),
}
# Numbers of Brinell or Vickers, typed again from the documents.
_NUMBERS = (
    *(105, 138, 171, 266, 697, 147, 147, 277, 210, 130, 105),
    *(120, 95, 94, 150, 49, 336, 331, 71, 40, 55, 262),
)
HARDNESS = dict(zip(PRINTED, _NUMBERS, strict=True))
NAMES = sorted(metals())


# -- values ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_values_are_those_printed(name: str) -> None:
    metal = metals()[name]
    assert set(metals()) == set(PRINTED)
    modulus, _, ratio, unit = PRINTED[name]
    expected = modulus * (PSI / 1e3 if unit == "Msi" else 1.0)
    assert metal.young_modulus / 1e9 == pytest.approx(expected, abs=0.0501)
    if unit == "GPa":
        assert metal.young_modulus == modulus * 1e9
    assert metal.poisson_ratio == ratio
    assert metal.hardness == pytest.approx(HARDNESS[name] * HB, abs=5.01e6)
    assert re.search(rf"H[BV] {HARDNESS[name]}\b", metal.sources["hardness"])


@pytest.mark.parametrize("name", NAMES)
def test_the_shear_modulus_is_the_printed_one(name: str) -> None:
    """E, G and nu are rounded each by itself, and not of one test: they agree to 3 %."""
    modulus, shear, ratio, unit = PRINTED[name]
    made = metals()[name].material.shear_modulus
    assert made == pytest.approx(metals()[name].young_modulus / (2 + 2 * ratio), rel=1e-15, abs=0)
    if shear is not None:
        assert shear == pytest.approx(modulus / (2 + 2 * ratio), rel=0.03, abs=0)
        printed = shear * (PSI / 1e3 if unit == "Msi" else 1.0)
        assert made / 1e9 == pytest.approx(printed, rel=0.03, abs=0)


# -- aliases and unlike pairs ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("alias", "name"),
    [
        ("Ti 6Al 4V", "ti-6al-4v"),
        ("  INCONEL_718 ", "inconel-718"),
        ("S355", "steel-s355"),
        ("316L", "stainless-316l"),
        ("EN AW-6082", "al6082"),
        ("en_aw 6082", "al6082"),
        ("Ti-6Al-4V", "ti-6al-4v"),
        ("Ti6Al4V", "ti-6al-4v"),
        ("AISI 4340", "steel-4340"),
        ("1.4301", "stainless-304"),
    ],
)
def test_aliases(alias: str, name: str) -> None:
    assert ms.Material.named(alias) == metals()[name].material


def test_dundurs_constant() -> None:
    """Of like bodies zero; odd in their order; of a rigid one (1 - 2 nu)/2(1 - nu)."""
    steel, al = ms.Material.named("steel"), ms.Material.named("al2017")
    assert ms.MaterialPair(steel, steel).dundurs_beta == 0.0
    there, back = (ms.MaterialPair(*pair).dundurs_beta for pair in ((steel, al), (al, steel)))
    assert there == -back
    assert there == pytest.approx(-0.1182, abs=1e-4)  # by hand
    rigid = ms.MaterialPair(steel, ms.Material.rigid()).dundurs_beta
    assert rigid == pytest.approx(0.4 / 1.4, rel=1e-15)
    joint = ms.Interface(ms.SphereOnFlat(ms.MaterialPair(steel, al), 5e-3), 0.3, normal_load=5.0)
    words = {verdict.name: verdict.word for verdict in joint.validity}
    assert words["Dundurs' constant of the pair"] == "watch"
