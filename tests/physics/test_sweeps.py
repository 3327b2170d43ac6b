"""Arrays of joints against one interface after the other, on every surface and in every shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy import stats
from usual import PAIR, rough

import microslip as ms
from microslip.contact import NORMAL_LAWS, grids


@dataclass(frozen=True)
class OwnLaw(ms.NormalLaw):
    """A law from outside: N = (1e6 (1e-6 - d))^2 below 1 um."""

    pair: ms.MaterialPair = PAIR

    @property
    def _span(self) -> tuple[float, float]:
        return 0.0, 1e-6

    @property
    def _edge(self) -> float:
        return 1e-6

    def _derivative(self, separation: np.ndarray, order: int) -> np.ndarray:
        s = np.maximum(1e-6 - separation, 0.0)
        if order == 2:
            return np.where(s > 0.0, 2e12, 0.0)
        return 1e12 * {-1: s**3 / 3.0, 0: s**2, 1: -2.0 * s}[order]


QUANTITIES = (
    "force_amplitude", "dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio",
    "secant_stiffness", "tangent_stiffness", "dissipation_exponent", "stick_area", "separation",
    "normal_stiffness", "tangential_stiffness", "contact_count", "contact_area", "force_limit",
    "slip_per_indentation",
)  # fmt: skip
RNG = np.random.default_rng(3)
SURFACES = {
    **{
        f"{type(e).__name__}-{i}": e
        for i, e in enumerate(e for law in NORMAL_LAWS for e in law.examples())
    },
    # Bounded below, so that heavy loads touch every summit; scipy's, with breaks.
    "uniform": rough(stats.uniform(-1e-6, 2e-6)),
    "weibull": rough(stats.weibull_min(2.2, scale=1e-6)),
    "300 summits": ms.AsperityPopulation(PAIR, RNG.normal(size=300) * 5e-7, 1e-3),
    "straight table": ms.TabulatedNormalLaw(PAIR, [0.0, 1e-6, 2e-6, 3e-6], [3.0, 2.0, 1.0, 0.0]),
    "straight table with a tail": ms.TabulatedNormalLaw(
        PAIR, [0.0, 1e-6, 2e-6, 3e-6], [3.0, 2.0, 1.0, 0.5], tail="exponential"
    ),
    "a law from outside": OwnLaw(),
}
# Names of what an interface has by another name, or as a property.
PROPERTIES = {
    "separation", "normal_stiffness", "tangential_stiffness", "contact_count", "contact_area",
    "force_limit", "slip_per_indentation",
}  # fmt: skip
OTHER_NAMES = {"force_amplitude": "backbone", "tangent_stiffness": "backbone_stiffness"}


def joint_on(surface: ms.NormalLaw) -> tuple[ms.Interface, np.ndarray, np.ndarray]:
    """A joint with loads and amplitudes from all sticks to all slides."""
    low = surface._span[0]
    most = float(surface.load(low))
    # Heights that begin abruptly: also so heavy that every summit touches.
    heaviest = 3.0 if surface._edge == low and not isinstance(surface, OwnLaw) else 0.9
    heaviest = min(heaviest, 0.9 * surface._heaviest / most)
    loads = most * np.array([1e-4, 0.3, 0.02, heaviest, 1e-3])
    joint = ms.Interface(surface, 0.4, normal_load=loads[1])
    scale = joint.force_limit / joint.tangential_stiffness
    return joint, loads, scale * np.array([0.0, 1e-5, 1e-3, 0.03, 0.4, 1.3, 7.0, 300.0])


def one_by_one(
    joint: ms.Interface, frictions: Any, loads: Any, amplitudes: Any, name: str, by_force: bool
) -> np.ndarray:
    values = np.empty((len(frictions), len(loads), len(amplitudes)))
    for i, friction in enumerate(frictions):
        for j, load in enumerate(loads):
            each = ms.Interface(joint.surface, friction, normal_load=load)
            if name in PROPERTIES:
                values[i, j] = getattr(each, name)
                continue
            a = each.backbone_displacement(amplitudes) if by_force else amplitudes
            values[i, j] = (
                a if name == "amplitude" else getattr(each, OTHER_NAMES.get(name, name))(a)
            )
    return values


def swept_over(
    surface: ms.NormalLaw, frictions: Any, loads: Any, *, quantities: Any = None, **along: Any
) -> Any:
    """Results with the dimensions friction, load and amplitude."""
    return ms.evaluate(
        surface=surface,
        friction_coefficient=np.reshape(frictions, (-1, 1, 1)),
        normal_load=np.reshape(loads, (-1, 1)),
        quantities=quantities,
        **along,
    )


def known_to(surface: ms.NormalLaw) -> list[str]:
    contacts = {"contact_count", "contact_area", "stick_area"}
    without = contacts if isinstance(surface, (ms.TabulatedNormalLaw, OwnLaw)) else set()
    return [name for name in QUANTITIES if name not in without]


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_equal_to_one_interface_after_the_other(surface: ms.NormalLaw) -> None:
    joint, loads, amplitudes = joint_on(surface)
    frictions = [0.1, 0.7]
    names = known_to(surface)
    swept = swept_over(surface, frictions, loads, amplitude=amplitudes, quantities=names)
    for name in names:
        wanted = one_by_one(joint, frictions, loads, amplitudes, name, by_force=False)
        assert swept[name].shape == (2, 5, 8)
        # Interfaces tabulate their energies to 1e-12, at worst.
        np.testing.assert_allclose(swept[name], wanted, rtol=3e-13, atol=1e-290, err_msg=name)


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_force_amplitudes(surface: ms.NormalLaw) -> None:
    joint, loads, _ = joint_on(surface)
    forces = 0.1 * loads.min() * np.array([0.0, 1e-6, 1e-2, 0.5, 0.99])
    names = ["amplitude", "dissipated_energy", "damping_ratio", "secant_stiffness"]
    swept = swept_over(surface, [0.1, 0.7], loads, force_amplitude=forces, quantities=names)
    for name in names:
        wanted = one_by_one(joint, [0.1, 0.7], loads, forces, name, by_force=True)
        # Near the limit the displacement of a force magnifies the rounding of the force.
        np.testing.assert_allclose(swept[name], wanted, rtol=1e-11, atol=1e-290, err_msg=name)


@pytest.mark.parametrize("kind", ["drop", "fall", "excess", "excess_slope"])
@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_every_way_gives_the_same(
    surface: ms.NormalLaw, kind: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against the sums of the law itself; which way is quickest is a matter of shape only."""
    _, loads, _ = joint_on(surface)
    d = surface.separation(loads)
    length = float(np.median(loads / surface.stiffness(d)))
    u = length * np.concatenate(([0.0], np.geomspace(1e-6, 1e3, 30)))
    wanted = np.array([getattr(surface, f"_{kind}")(float(place), u) for place in d])
    monkeypatch.setattr(grids, "_ROW", 0.0)  # a table for each row, where there can be one
    curve = grids.Pointwise(surface)
    rows, steps = np.repeat(d, u.size), np.tile(u, d.size)
    for way in (True, False):
        monkeypatch.setattr(grids, "_by_rows", lambda *_, way=way: way)
        for values in (curve._exact(kind, rows, steps), curve.sum(kind, rows, steps)):
            np.testing.assert_allclose(values, wanted.ravel(), rtol=2e-13, atol=0, err_msg=str(way))


@pytest.mark.parametrize("shape", [(1, 12000), (3, 12000), (70, 70), (2000, 3), (5000, 1)])
def test_any_shape(shape: tuple[int, int]) -> None:
    joint = ms.Interface.examples()[0]
    loads = np.geomspace(1.0, 2e4, shape[0]) if shape[0] > 1 else np.array([300.0])
    amplitudes = np.geomspace(1e-11, 1e-4, shape[1]) if shape[1] > 1 else np.array([2e-7])
    names = [name for name in QUANTITIES if name not in PROPERTIES]
    friction = joint.friction_coefficient
    swept = swept_over(joint.surface, friction, loads, amplitude=amplitudes, quantities=names)
    for j in {0, shape[0] // 2, shape[0] - 1}:
        each = joint.at(normal_load=loads[j])
        for name in names:
            wanted = getattr(each, OTHER_NAMES.get(name, name))(amplitudes)
            np.testing.assert_allclose(swept[name][0, j], wanted, rtol=3e-13, err_msg=name)


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_separations_of_many_loads(surface: ms.NormalLaw) -> None:
    """By a profile and one step of Newton's method, or not: the same to rounding."""
    _, loads, _ = joint_on(surface)
    many = np.concatenate((np.geomspace(loads.min(), loads.max(), 2001), loads))
    d = grids.pointwise_of(surface).separations(many)
    wanted = surface.separation(many)
    length = many / surface.stiffness(wanted)
    assert np.all(np.abs(d - wanted) <= 4e-16 * np.abs(wanted) + 2e-15 * length)
