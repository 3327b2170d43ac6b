"""Many joints at once: against an interface for each, on other arrays, and each error."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

import microslip as ms

RNG = np.random.default_rng(18)
COUNT = 40
ONE = {
    "young_modulus": 69e9, "poisson_ratio": 0.33, "std": 5e-7, "radius": 1e-3, "density": 1e8,
    "area": 2e-4, "friction_coefficient": 0.55, "normal_load": 2000.0,
}  # fmt: skip
MANY = {name: value * RNG.lognormal(0.0, 0.2, COUNT) for name, value in ONE.items()}
MANY["poisson_ratio"] = RNG.uniform(-0.2, 0.5, COUNT)
MANY["normal_load"] = RNG.lognormal(5.0, 3.0, COUNT)
# Of an amplitude the step counts, over some decades on both sides of the slip scale.
MANY["amplitude"] = 3e-7 * 10.0 ** RNG.uniform(-6.0, 2.0, COUNT)
CYCLIC = (
    "backbone", "dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio",
    "secant_stiffness",
)  # fmt: skip
AT_REST = (
    "separation", "slip_per_indentation", "normal_stiffness", "tangential_stiffness", "force_limit",
    "contact_count", "contact_area",
)  # fmt: skip


def joint_of(given: dict[str, Any], heights: Any = None) -> ms.Interface:
    first = second = ms.Material(given["young_modulus"], given["poisson_ratio"])
    if "other_poisson_ratio" in given:
        second = ms.Material.rigid()
        if np.isfinite(given["other_young_modulus"]):
            second = ms.Material(given["other_young_modulus"], given["other_poisson_ratio"])
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(first, second),
        ms.Gaussian(given["std"], given.get("mean", 0.0)) if heights is None else heights,
        given["radius"],
        given["density"],
        given["area"],
    )
    load = {name: given[name] for name in ("normal_load", "separation") if name in given}
    return ms.Interface(surface, given["friction_coefficient"], **load)


def at(given: dict[str, Any], i: int) -> dict[str, float]:
    return {name: float(v[i]) if np.ndim(v) else float(v) for name, v in given.items()}


def same(found: Any, joint: ms.Interface, given: dict[str, Any], i: int) -> None:
    a = given["amplitude"]
    for name in CYCLIC:
        assert found[name][i] == pytest.approx(getattr(joint, name)(a), rel=1e-13), name
    length = joint.normal_load / joint.normal_stiffness
    for name in AT_REST:
        near = {"abs": 1e-14 * length} if name == "separation" else {"rel": 1e-13}
        assert found[name][i] == pytest.approx(getattr(joint, name), **near), name
    exponent = joint.dissipation_exponent(a)
    # Near gross slip the table of an interface has 1e-12.
    assert found["dissipation_exponent"][i] == pytest.approx(exponent, rel=1e-12)
    assert found["tangent_stiffness"][i] == pytest.approx(joint.backbone_stiffness(a), rel=1e-13)


def test_it_is_an_interface_at_every_point() -> None:
    names = [*CYCLIC, *AT_REST, "dissipation_exponent", "tangent_stiffness"]
    found = ms.evaluate(**MANY, quantities=names)
    assert list(found) == names
    for i in range(COUNT):
        given = at(MANY, i)
        same(found, joint_of(given), given, i)


def test_other_heights_and_bodies() -> None:
    """Exponential and SciPy's heights, two materials, one of them rigid, and separations."""
    names = [*CYCLIC, *AT_REST, "dissipation_exponent", "tangent_stiffness"]
    other = {"other_young_modulus": np.array([210e9, np.inf]), "other_poisson_ratio": 0.3}
    for heights in (ms.Exponential(1e-6), stats.weibull_min(2.2, scale=1e-6), [0.0, 3e-7, 9e-7]):
        given = {**ONE, **other, "amplitude": 2e-7}
        spread = ms.GreenwoodWilliamson(
            ms.MaterialPair(*[ms.Material(1e9, 0.3)] * 2), heights, 1e-3, 1e8, 2e-4
        ).heights
        scaled = ms.evaluate(
            heights=heights, **{**given, "std": 2.0 * spread.spread}, quantities=names
        )
        found = ms.evaluate(
            heights=heights, **{k: v for k, v in given.items() if k != "std"}, quantities=names
        )
        for i in range(2):
            joint = joint_of(at(given, i), heights)
            same(found, joint, at(given, i), i)
            wide = joint_of(at(given, i), spread._scaled(2.0))
            assert scaled["dissipated_energy"][i] == pytest.approx(
                wide.dissipated_energy(2e-7), rel=1e-13
            )
    by_place = {k: v for k, v in ONE.items() if k != "normal_load"}
    by_place |= {"separation": np.array([1e-7, -2e-7]), "mean": 3e-7, "amplitude": 1e-7}
    found = ms.evaluate(**by_place, quantities=names)
    for i in range(2):
        same(found, joint_of(at(by_place, i)), at(by_place, i), i)


def test_xarray_and_dask() -> None:
    xarray = pytest.importorskip("xarray")
    loads = xarray.DataArray(np.geomspace(100.0, 5e3, 6), dims="load")
    a = xarray.DataArray(np.geomspace(1e-8, 1e-5, 4), dims="point", attrs={"units": "m"})
    given = {k: v for k, v in ONE.items() if k != "normal_load"}
    plain = ms.evaluate(**given, normal_load=loads.values[:, None], amplitude=a.values)
    labelled = ms.evaluate(**given, normal_load=loads, amplitude=a)
    assert labelled["loss_factor"].dims == ("load", "point")

    def loss(load: Any, amplitude: Any) -> Any:
        return ms.evaluate(**given, normal_load=load, amplitude=amplitude)["loss_factor"]

    by_user = xarray.apply_ufunc(loss, loads, a)
    np.testing.assert_array_equal(by_user.values, plain["loss_factor"])
    for name, values in plain.items():
        np.testing.assert_array_equal(labelled[name].values, values)
    one = ms.evaluate(**given, normal_load=loads, amplitude=a, quantities=["loss_factor"])
    np.testing.assert_array_equal(one["loss_factor"].values, plain["loss_factor"])
    pytest.importorskip("dask.array", reason="the extra dask is not installed")
    lazy = ms.evaluate(**given, normal_load=loads.chunk(load=4), amplitude=a)
    alone = ms.evaluate(
        **given,
        normal_load=loads.chunk(load=4),
        amplitude=a,
        quantities=["loss_factor"],
    )
    np.testing.assert_array_equal(alone["loss_factor"].compute().values, plain["loss_factor"])
    for name, values in plain.items():
        np.testing.assert_array_equal(lazy[name].compute().values, values)
