"""Materials and pairs: their numbers, and the one line that each wrong value gets."""

from __future__ import annotations

import math
import re

import pytest

import microslip as ms

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
