"""Models of laws for an identification: names, options, bounds, guesses, and what is refused."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from scipy import stats

import microslip as ms
from microslip.friction.surface_guesses import conventional_radius
from microslip.identification.models import MODELS, model_of, template_of
from microslip.identification.models.base import Materials

PAIR = ms.Interface.examples()[0].surface.pair
NAMES = {
    "interface": ms.Interface,
    "jenkins": ms.Jenkins,
    "iwan": ms.Iwan,
    "segalman": ms.SegalmanIwan,
}
LAWS: dict[str, Any] = {
    "interface": ms.Interface.examples()[0],
    "jenkins": ms.Jenkins(5e7, 100.0),
    "iwan": ms.Iwan([3e7, 1e7, 6e7], [60.0, 50.0, 30.0]),
    "segalman": ms.SegalmanIwan(4000.0, 1.5e8, -0.5, 0.6),
}


def test_every_model_has_a_name() -> None:
    # A sphere on a flat is an interface too, and goes by its name alone.
    assert [model.name for model in MODELS] == [*NAMES, "sphere"]


@pytest.mark.parametrize("name", NAMES)
def test_name_class_and_instance_mean_the_same(name: str) -> None:
    model = model_of(name)
    assert type(model_of(NAMES[name])) is type(model)
    assert type(model_of(LAWS[name])) is type(model)
    assert type(model_of(name.upper().replace("-", " "))) is type(model)
    assert model_of(model) is model
    assert model.start is None


@pytest.mark.parametrize("name", NAMES)
def test_instance_gives_the_start_and_builds_itself(name: str) -> None:
    law = LAWS[name]
    model = model_of(law)
    start = model.start
    assert start is not None
    assert tuple(start) == model.names
    again = model.build(start)
    x = np.array([0.0, 1e-7, 3e-6, -2e-6, 1e-5])
    assert again.force(x) == pytest.approx(law.force(x), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_guess_is_within_bounds_and_near(name: str) -> None:
    law = LAWS[name]
    reach = law.force_limit / law.tangential_stiffness
    loops = [law.loop(a * reach, 400) for a in (3.0, 10.0)]
    loads = [2000.0, 2000.0]
    model = model_of(name).prepared(loops, loads)
    guess = model.guess(loops, loads)
    assert tuple(guess) == model.names
    assert model.within(guess) == guess
    assert all(type(value) is float for value in guess.values())
    again = model.build(guess, 2000.0, Materials(PAIR))
    assert 0.5 < again.force_limit / law.force_limit < 2.0
    assert 0.5 < again.tangential_stiffness / law.tangential_stiffness < 2.0


@pytest.mark.parametrize("name", NAMES)
def test_models_survive_copies(name: str) -> None:
    model = model_of(LAWS[name])
    values = model.start or {}
    for other in (copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        assert other.start == values
        u = np.array([0.0, 1e-7, 1e-6])
        assert np.array_equal(other.branch(u, values, None)[2], model.branch(u, values, None)[2])


def test_bounds_of_separations() -> None:
    gauss = model_of("interface").parameters[2]
    assert (gauss.name, gauss.low, gauss.high) == ("standardised_separation", -4.0, 8.0)
    assert gauss.beyond
    shifted = model_of("interface", heights=ms.Gaussian(1e-6, mean=3e-6)).parameters[2]
    assert (shifted.low, shifted.high) == pytest.approx((-1.0, 11.0))
    low, high = template_of(ms.Exponential(5e-7)).bounds()
    assert low == -1.0
    assert 30.0 < high < 45.0  # exp(-h) is 1e-16
    given = template_of([0.0, 1e-6, 3e-6])
    assert given.load(given.bounds()[1]) > 0.0
    weibull = template_of(stats.weibull_min(2.2, scale=1e-6))
    assert weibull.load(weibull.bounds()[1]) > 0.0


def test_heights_count_by_their_shape_alone() -> None:
    u = np.geomspace(1e-10, 1e-5, 40)
    values = {"friction_coefficient": 0.4, "slip_scale": 4e-7, "standardised_separation": 1.2}
    for small, large in (
        (ms.Gaussian(1e-7), ms.Gaussian(3e-5)),
        ([0.0, 1e-6, 3e-6], [0.0, 1e-3, 3e-3]),
    ):
        first, second = (
            model_of("interface", heights=y, reference_load=500.0) for y in (small, large)
        )
        for a, b in zip(
            first.branch(u, values, 300.0), second.branch(u, values, 300.0), strict=True
        ):
            assert b == pytest.approx(a, rel=1e-11, abs=1e-11 * np.abs(a).max())


@pytest.mark.parametrize("surface", [law.surface for law in ms.Interface.examples()[::3]], ids=repr)
def test_any_surface_with_heights_is_a_template(surface: ms.NormalLaw) -> None:
    if isinstance(surface, ms.SphereOnFlat):
        with pytest.raises(ms.InputError, match="heights must differ from one another"):
            model_of("interface", surface=surface)
        return
    if type(surface).__name__ == "TightenedSurface":  # its yielding has a length of its own
        with pytest.raises(ms.InputError, match="surface must be one whose lengths scale"):
            model_of("interface", surface=surface)
        return
    joint = ms.Interface(surface, 0.4, 1e-3 * surface.load(surface._span[0]))
    model = model_of(joint)
    u = joint.force_limit / joint.tangential_stiffness * np.geomspace(1e-4, 30.0, 50)
    force, slope, _ = model.branch(u, model.start or {}, joint.normal_load)
    assert force == pytest.approx(joint.backbone(u), rel=1e-10)
    assert slope == pytest.approx(joint.backbone_stiffness(u), rel=1e-9, abs=1e-10 * slope[0])


def test_reference_load_is_the_mean_of_the_loads() -> None:
    loops = [ms.Jenkins(5e7, 100.0).loop(8e-6)] * 2
    model: Any = model_of("interface").prepared(loops, [100.0, 400.0])
    assert model.reference_load == pytest.approx(200.0)
    assert model.prepared(loops, [1.0, 1.0]) is model
    fixed: Any = model_of("interface", reference_load=50.0).prepared(loops, [100.0, 400.0])
    assert fixed.reference_load == 50.0


def test_iwan_grid_is_made_from_the_data() -> None:
    law = ms.Jenkins(5e7, 100.0)  # yields at 2 um
    model: Any = model_of("iwan", cells=10).prepared([law.loop(8e-6)], [None])
    assert model.yields.size == 10 == len(model.parameters)
    assert model.yields[0] < 2e-6 < model.yields[-1] < 8e-6
    assert np.diff(np.log(model.yields)) == pytest.approx(np.log(model.yields[1] / model.yields[0]))
    with pytest.raises(ValueError, match="read-only"):
        model.yields[0] = 0.0


def test_convention_for_the_radius() -> None:
    radius = conventional_radius(density_root=3e6, std=5e-7)
    density = 3e6 / radius**0.5
    assert density * radius * 5e-7 == pytest.approx(0.05)


@pytest.mark.parametrize(
    "heights",
    [
        ms.Gaussian(1e-6, mean=2e-7),
        ms.Exponential(1e-6),
        ms.contact.heights.Discrete([0.0, 1e-6, 3e-6]),
        ms.contact.heights.Statistical(stats.weibull_min(2.2, scale=1e-6)),
        ms.contact.heights.Statistical(stats.norm(1e-7, 5e-7)),
        ms.contact.heights.Statistical(stats.beta(a=2.0, b=3.0, loc=-1e-6, scale=3e-6)),
    ],
    ids=repr,
)
def test_scaled_heights(heights: ms.HeightDistribution) -> None:
    other = heights._scaled(3.0)
    assert other.spread == pytest.approx(3.0 * heights.spread)
    y = np.array([-3e-7, 1e-7, 8e-7])
    assert other.cdf(3.0 * y) == pytest.approx(heights.cdf(y), rel=1e-9)


# -- what is refused ------------------------------------------------------------------------------


def test_what_is_missing() -> None:
    loop = ms.Jenkins(5e7, 100.0).loop(8e-6)
    iwan: Any = model_of("iwan")
    with pytest.raises(ms.InputError, match="yields must be known"):
        iwan.branch(np.zeros(1), dict.fromkeys(iwan.names, 1.0), None)
    known = iwan.prepared([loop], [None])
    with pytest.raises(ms.InputError, match="stiffnesses must be above zero for one cell"):
        known.build(dict.fromkeys(known.names, 0.0))


def test_a_separation_at_each_load() -> None:
    """Split, the parameter is that at the load itself; shared, that at the reference."""
    shared = model_of("interface").prepared([0, 0], [500.0, 2000.0])
    own = shared.split(shared.at_reference, [500.0, 2000.0])
    values = {"friction_coefficient": 0.4, "slip_scale": 4e-7, "standardised_separation": 1.2}
    u = np.linspace(1e-8, 1e-6, 9)
    for load in (500.0, 2000.0):
        made = {one.name: one for one in own.derived(values, [load])}
        there = {one.name: one for one in shared.derived(values, [load])}
        assert made["standardised_separation"].value == pytest.approx(1.2, abs=1e-12)
        assert abs(there["standardised_separation"].value - 1.2) > 0.2
        moved = {**values, "standardised_separation": there["standardised_separation"].value}
        assert own.branch(u, moved, load)[0] == pytest.approx(
            shared.branch(u, values, load)[0], rel=1e-9
        )
    # Other names, and laws that know no load, stay as they are.
    assert shared.split(["slip_scale"], [500.0]).own_loads == ()
    jenkins = model_of("jenkins")
    assert jenkins.split(["stiffness"], [500.0]) is jenkins
    assert all(one.natural for one in model_of("iwan").parameters)
