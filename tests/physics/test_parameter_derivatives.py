"""Derivatives by parameters: against differences of whole joints, of sweeps, and in closed form."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from usual import fine_slope

import microslip as ms

VALUES = {
    "friction_coefficient": 0.55, "normal_load": 2000.0, "std": 5e-7, "radius": 1e-3,
    "density": 1e8, "area": 2e-4, "young_modulus": 69e9, "poisson_ratio": 0.33,
    "other_young_modulus": 210e9, "other_poisson_ratio": 0.29,
}  # fmt: skip
HISTORY = 4e-7 * np.sin(np.arange(90) * 0.31) * (1.0 + 0.5 * np.sin(np.arange(90) * 0.047))
ROW = np.array([1e-7, 3e-7, -5e-8, 1e-7, 4e-8])
ORDERS = (0, 1, 3)
AMPLITUDES = np.array([[1e-9, 1e-7], [6e-7, 4e-6]])


def joint(heights: Any = ms.Gaussian, **changes: float) -> ms.Interface:
    v = {**VALUES, **changes}
    metals = [ms.Material(v[f"{k}young_modulus"], v[f"{k}poisson_ratio"]) for k in ("", "other_")]
    spread = heights(v["std"])
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(*metals), spread, v["radius"], v["density"], v["area"]
    )
    return ms.Interface(surface, v["friction_coefficient"], normal_load=v["normal_load"])


def answer(law: Any, quantity: str) -> np.ndarray:
    if quantity == "force":
        return law.force(HISTORY)
    if quantity == "periodic":
        return law.periodic(HISTORY, 1e-8).force
    if quantity == "harmonics":
        return law.harmonics(ROW, ORDERS, 1e-8).force
    return getattr(law, quantity)(AMPLITUDES)


def place(quantity: str) -> dict[str, Any]:
    if quantity in ("force", "periodic"):
        return {"at": HISTORY, "rest": 0.0 if quantity == "force" else 1e-8}
    if quantity == "harmonics":
        return {"at": ROW, "harmonics": ORDERS, "rest": 1e-8}
    return {"at": AMPLITUDES}


QUANTITIES = ("backbone", "force", "periodic", "harmonics", "dissipated_energy")


@pytest.mark.parametrize("heights", [ms.Gaussian, ms.Exponential])
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_derivatives_are_differences_of_whole_joints(quantity: str, heights: Any) -> None:
    found = joint(heights).parameter_derivatives(quantity, **place(quantity))
    assert set(found) == set(VALUES)
    for name, value in VALUES.items():

        def at(s: float, name: str = name, value: float = value) -> np.ndarray:
            return answer(joint(heights, **{name: value * (1.0 + s)}), quantity)

        wanted = fine_slope(at, 1e-3) / value
        base = answer(joint(heights), quantity)
        if quantity in ("force", "periodic", "harmonics"):
            scale = np.abs(base).max() / value
        else:
            scale = np.abs(base) / value  # each amplitude by itself
        assert np.max(np.abs(found[name] - wanted) / scale) < 2e-8, name
        assert found[name].shape == base.shape


def test_one_material_counts_for_both_bodies() -> None:
    """Forces grow with stiffness and load alike: sums of logarithmic slopes are known."""
    same = {"other_young_modulus": VALUES["young_modulus"], "other_poisson_ratio": 0.33}
    law = joint(**same)
    found = law.parameter_derivatives("force", HISTORY)
    assert "other_young_modulus" not in found
    v, force = VALUES, law.force(HISTORY)
    # Twice as stiff under twice the load is twice the force; so are more summits.
    for stiff in ("young_modulus", "area", "density"):
        total = found[stiff] * v[stiff] + found["normal_load"] * v["normal_load"]
        np.testing.assert_allclose(total, force, rtol=0, atol=1e-11 * np.abs(force).max())
    # T0/mu depends on u/mu alone: mu dT0/dmu = T0 - u T0'.
    u = np.geomspace(1e-9, 1e-5, 20)
    by_friction = law.parameter_derivatives("backbone", u, ["friction_coefficient"])
    wanted = (law.backbone(u) - u * law.backbone_stiffness(u)) / 0.55
    np.testing.assert_allclose(by_friction["friction_coefficient"], wanted, rtol=1e-7, atol=1e-12)


def test_batches_are_their_rows() -> None:
    law = joint()
    for quantity, rows in (
        ("force", np.stack([HISTORY, 0.3 * HISTORY])),
        ("harmonics", np.stack([ROW, 2.0 * ROW])),
    ):
        options = {"harmonics": ORDERS} if quantity == "harmonics" else {}
        together = law.parameter_derivatives(quantity, rows, ["std"], **options)["std"]
        for row, found in zip(rows, together, strict=True):
            alone = law.parameter_derivatives(quantity, row, ["std"], **options)["std"]
            np.testing.assert_array_equal(found, alone)


@pytest.mark.parametrize(
    ("law", "given", "says"),
    [
        (joint(), ("drag", 1e-7), "quantity must be one of backbone, force"),
        (joint(), ("backbone", 1e-7, ["mass"]), "names must be a list of friction_coefficient"),
        (joint(), ("backbone", 1e-7, "std"), "names must be a list of friction_coefficient"),
        (joint(), ("force", 1e-7), "at must be a sequence of displacements"),
        (joint(), ("dissipated_energy", -1e-7), "at must be amplitudes of zero or more"),
        (joint(), ("backbone", np.nan), "at must be finite"),
    ],
)  # fmt: skip
def test_impossible_values_are_refused(law: Any, given: tuple[Any, ...], says: str) -> None:
    with pytest.raises(ms.InputError, match=re.escape(says)):
        law.parameter_derivatives(*given)
