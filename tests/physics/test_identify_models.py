"""What the models tell an identification is true: values and every derivative, by other means."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from own_laws import Hyperbola

import microslip as ms
from microslip._core.checks import Floats
from microslip.contact.base import aluminium
from microslip.identification.models import MODELS, Model, model_of
from microslip.identification.models.base import Materials
from microslip.identification.models.surface_shape import Template

PAIR = aluminium()
LOADS = (300.0, 800.0, 1500.0)  # the examples of the interface hold 800 N as reference


def example_params(which: Callable[[Any], bool] = lambda model: True) -> list[Any]:
    return [
        pytest.param(model, values, id=f"{model.name}-{i}")
        for prototype in (*MODELS, model_of(Hyperbola))
        for i, (model, values) in enumerate(prototype.examples())
        if which(model)
    ]


def loads_of(model: Model) -> tuple[float | None, ...]:
    return LOADS if model.scales_with_load else (None,)


def length_of(model: Model, values: Mapping[str, float]) -> float:
    if "slip_scale" in values:
        return values["slip_scale"]
    law = model.build(values)
    return float(law.force_limit / law.tangential_stiffness)


def places(model: Model, values: Mapping[str, float]) -> Floats:
    """From rest to deep in gross slip."""
    return length_of(model, values) * np.append(0.0, np.geomspace(1e-6, 30.0, 300))


def sixth_order(function: Callable[[float], Any], x: float, step: float) -> Any:
    sums = [function(x + k * step) - function(x - k * step) for k in (1, 2, 3)]
    return (45.0 * sums[0] - 9.0 * sums[1] + sums[2]) / (60.0 * step)


# -- values ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("model", "values"), example_params())
def test_branch_is_the_backbone_of_the_law_it_builds(
    model: Model, values: Mapping[str, float]
) -> None:
    u = places(model, values)
    for load in loads_of(model):
        law = model.build(values, load, Materials(PAIR))
        force, slope, by_values = model.branch(u, values, load)
        # Both have tables right to 1e-13 of the limit, and separations right to rounding.
        assert np.abs(force - law.backbone(u)).max() <= 1e-12 * law.force_limit
        assert np.abs(slope - law.backbone_stiffness(u)).max() <= 1e-11 * law.tangential_stiffness
        assert by_values.shape == (len(model.parameters), u.size)
        relative = np.abs(force[1:] / law.backbone(u[1:]) - 1.0)
        assert relative.max() <= 1e-11  # small ones have all their digits, too


@pytest.mark.parametrize(("model", "values"), example_params())
def test_examples_lie_within_their_bounds(model: Model, values: Mapping[str, float]) -> None:
    assert tuple(values) == model.names
    for parameter in model.parameters:
        assert parameter.low <= values[parameter.name] <= parameter.high
        assert parameter.low > 0.0 or not parameter.is_log
    assert model.within(values) == dict(values)


@pytest.mark.parametrize(("model", "values"), example_params())
def test_radius_and_area_change_no_loop(model: Model, values: Mapping[str, float]) -> None:
    u = places(model, values)
    first = model.build(values, 500.0, Materials(PAIR))
    second = model.build(values, 500.0, Materials(PAIR, area=3e-5, radius=2e-4))
    assert np.abs(first.backbone(u) - second.backbone(u)).max() <= 1e-12 * first.force_limit


# -- derivatives ----------------------------------------------------------------------------------


def corners_of(model: Model, values: Mapping[str, float]) -> Floats:
    """Where a backbone has a corner, and differences across it have none."""
    if model.scales_with_load:
        return np.zeros(0)
    return np.asarray(model.build(values).sliders().yield_displacements)


SMOOTH = example_params(
    lambda m: (
        # A sphere's slope ends as a root: tests/physics/test_sphere_fit.py looks away from there.
        m.name not in ("segalman", "sphere")
        and not (isinstance(getattr(m, "template", None), Template) and m.template.law._spheres)
    ),
)


@pytest.mark.parametrize(("model", "values"), SMOOTH)
def test_derivatives_are_those_of_differences(model: Model, values: Mapping[str, float]) -> None:
    u = places(model, values)
    away = np.ones(u.size, dtype=bool)
    for corner in corners_of(model, values):
        away &= np.abs(u - corner) > 0.01 * corner
    for load in loads_of(model):
        force, _, by_values = model.branch(u, values, load)
        for i, name in enumerate(model.names):
            step = 1e-3 * max(abs(values[name]), 1e-2 if name.startswith("standard") else 0.0)

            def at(value: float, name: str = name, load: float | None = load) -> Floats:
                return model.branch(u, {**values, name: value}, load)[0]

            found = sixth_order(at, values[name], step)[away]
            # The value's rounding over the step; the step to the sixth is less.
            error = 1e-9 * np.abs(by_values[i]).max() + 3e-15 * force.max() / step
            assert np.abs(found - by_values[i, away]).max() <= error


def test_derivatives_of_gaussian_interfaces_to_many_digits() -> None:
    import mpmath as mp

    def moment(h: Any) -> Any:
        # F_{3/2}(h), DLMF 12.5.1.
        return mp.gamma(2.5) / mp.sqrt(2 * mp.pi) * mp.exp(-h * h / 4) * mp.pcfd(-2.5, h)

    model = model_of("interface", reference_load=800.0)
    mu, scale, load = 0.5, 3e-7, 260.0
    with mp.workdps(40):
        for h in (-3.0, 1.5, 6.0):
            guess = model.template.separation(h, load / 800.0)  # type: ignore[attr-defined]

            @cache
            def at_load(h: Any, guess: float = guess) -> tuple[Any, Any]:
                target = moment(h) * mp.mpf(load) / 800
                root = mp.findroot(lambda z: moment(z) / target - 1, guess)
                return root, moment(root)

            def share(x: Any, h: Any) -> Any:
                root, whole = at_load(h)
                return 1 - moment(root + x) / whole

            x = np.array([1e-6, 1e-3, 0.5, 4.0, 12.0])
            values = dict(zip(model.names, (mu, scale, h), strict=True))
            force, slope, by_values = model.branch(x * scale, values, load)
            step = mp.mpf("1e-12")  # in 40 digits: right to 24 of them
            for j, place in enumerate((x * scale).tolist()):
                steps = mp.mpf(place) / mp.mpf(scale)
                truth = share(steps, mp.mpf(h))
                by_x = (share(steps + step, mp.mpf(h)) - share(steps - step, mp.mpf(h))) / (
                    2 * step
                )
                by_h = (share(steps, mp.mpf(h) + step) - share(steps, mp.mpf(h) - step)) / (
                    2 * step
                )
                limit = mu * load
                near = {"rel": 1e-11, "abs": 0.0}
                assert force[j] == pytest.approx(limit * float(truth), **near)
                assert by_values[0, j] == pytest.approx(load * float(truth), **near)
                # In gross slip these are differences that have vanished beside their size at rest.
                most = float(-mp.diff(moment, mp.mpf(guess)) / moment(mp.mpf(guess)))
                far = {"rel": 1e-10, "abs": 2e-14 * limit * max(most, 1.0)}
                assert slope[j] * scale == pytest.approx(limit * float(by_x), **far)
                assert -by_values[1, j] * scale == pytest.approx(
                    limit * float(by_x * steps), rel=1e-10, abs=far["abs"] * x[j]
                )
                # Near rest it is x times a difference of two numbers of the size of `most`^2.
                noise = 1e-14 * limit * max(most, 1.0) ** 2 * min(x[j], 1.0)
                assert by_values[2, j] == pytest.approx(limit * float(by_h), rel=1e-10, abs=noise)


def test_derivatives_of_given_summits_by_complex_steps() -> None:
    heights = np.array([0.0, 2e-7, -3e-7, 5e-7, 1e-7])
    model = model_of("interface", heights=heights, reference_load=800.0)
    y = heights / np.std(heights)

    def moment(z: Any, power: float = 1.5) -> Any:
        s = y[:, None] - z
        return np.sum(np.where(s.real > 0.0, s, 0.0) ** power, axis=0)

    def force(u: Floats, mu: Any, scale: Any, h: Any, load: float) -> Any:
        root, target = h + 0j, moment(np.array([h]))[0] * load / 800.0
        root = np.real(root) + 0j
        for _ in range(100):  # Newton's steps, from where all touch: N is convex
            now = np.array([root])
            root = root + (moment(now)[0] - target) / (1.5 * moment(now, 0.5)[0])
        whole = moment(np.array([root]))
        return mu * load * (1.0 - moment(root + u / scale) / whole)

    u = 3e-7 * np.geomspace(1e-5, 30.0, 200)
    for h in (-2.0, 0.3):
        for load in LOADS:
            values = dict(zip(model.names, (0.5, 3e-7, h), strict=True))
            by_values = model.branch(u, values, load)[2]
            for i, name in enumerate(model.names):
                small = 1e-30 * abs(values[name])
                given = [values[n] + (1j * small if n == name else 0.0) for n in model.names]
                truth = np.imag(force(u, *given, load)) / small  # type: ignore[arg-type]
                # Differences of N' over small steps are right to rounding of N'.
                assert np.abs(by_values[i] - truth).max() <= 1e-12 * np.abs(truth).max()


@pytest.mark.parametrize(("model", "values"), example_params(which=lambda m: m.name == "segalman"))
def test_derivatives_of_segalman_by_complex_steps(
    model: Model, values: Mapping[str, float]
) -> None:
    def force(u: Floats, limit: Any, stiffness: Any, chi: Any, beta: Any) -> Any:
        # R u^chi up to phi and S there, from the definition.
        phi = limit / stiffness * (1 + beta) / (beta + (1 + chi) / (2 + chi))
        density = stiffness / (1 + beta) * (1 + chi) / phi ** (1 + chi)
        last = stiffness * beta / (1 + beta)
        x = u[u < phi.real]
        slipped = density * x ** (2 + chi) / (2 + chi)
        stuck = density * x * (phi ** (1 + chi) - x ** (1 + chi)) / (1 + chi) + last * x
        return np.append(slipped + stuck, np.full(u.size - x.size, limit))

    u = places(model, values)[1:]
    by_values = model.branch(u, values, None)[2]
    for i, name in enumerate(model.names):
        small = 1e-30
        given = [values[n] + (1j * small if n == name else 0j) for n in model.names]
        truth = np.imag(force(u, *given)) / small
        scale = max(np.abs(truth).max(), 1e-3 * values["force_limit"] / max(abs(values[name]), 1.0))
        assert np.abs(by_values[i] - truth).max() <= 1e-12 * scale


@pytest.mark.parametrize("h", [0.5, 3.0, 7.0])
def test_exponential_heights_have_no_separation(h: float) -> None:
    model = model_of("interface", heights=ms.Exponential(1.0), reference_load=800.0)
    x = np.append(0.0, np.geomspace(1e-6, 60.0, 200))
    values = dict(zip(model.names, (0.5, 3e-7, h), strict=True))
    force, slope, by_values = model.branch(x * 3e-7, values, 500.0)
    near = {"rel": 1e-12, "abs": 1e-13}
    assert force / 250.0 == pytest.approx(-np.expm1(-x), **near)
    assert slope * 3e-7 / 250.0 == pytest.approx(np.exp(-x), **near)
    assert by_values[0] / 500.0 == pytest.approx(-np.expm1(-x), **near)
    assert by_values[1] * 3e-7 / 250.0 == pytest.approx(-x * np.exp(-x), **near)
    assert np.abs(by_values[2]).max() <= 1e-13 * 250.0  # not at all: no loop can tell it


# -- what holds for any parameters ----------------------------------------------------------------


@settings(max_examples=15, deadline=None)
@given(
    mu=st.floats(0.05, 2.0),
    logarithm=st.floats(-9.0, -4.0),
    h=st.floats(-3.9, 7.0),
    ratio=st.floats(0.1, 10.0),
)
def test_gaussian_interfaces_of_any_values(
    mu: float, logarithm: float, h: float, ratio: float
) -> None:
    model = model_of("interface", reference_load=700.0)
    scale, load = 10.0**logarithm, 700.0 * ratio
    values = dict(zip(model.names, (mu, scale, h), strict=True))
    x = np.append(0.0, np.geomspace(1e-6, 40.0, 120))
    force, slope, by_values = model.branch(x * scale, values, load)
    limit = mu * load
    assert force[0] == 0.0
    assert not by_values[:, 0].any()
    assert np.all(np.diff(force) >= -1e-14 * limit)
    assert np.all(force <= limit * (1.0 + 1e-15))
    assert np.all(slope >= -1e-14 * limit / scale)
    assert by_values[0] == pytest.approx(force / mu, rel=1e-14)
    assert by_values[1] == pytest.approx(-x * slope, rel=1e-14, abs=0.0)
    # A lighter contact is a more even one: it slips earlier.
    assert by_values[2].min() >= -1e-12 * limit
    # Gross slip: nothing but friction is left to be told.
    assert force[-1] == pytest.approx(limit, rel=1e-14)
    assert abs(by_values[1, -1]) * scale <= 1e-13 * limit
    assert abs(by_values[2, -1]) <= 1e-13 * limit
    # The load enters by the separation alone.
    there = model.template.separation(h, ratio)  # type: ignore[attr-defined]
    own = model_of("interface", reference_load=load)
    again = own.branch(x * scale, {**values, "standardised_separation": there}, load)
    assert again[0] == pytest.approx(force, rel=1e-12)
    step = 1e-3

    def at(value: float) -> Floats:
        return model.branch(x * scale, {**values, "standardised_separation": value}, load)[0]

    found = sixth_order(at, h, step)
    assert np.abs(found - by_values[2]).max() <= 1e-9 * by_values[2].max() + 1e-11 * limit


@settings(max_examples=40, deadline=None)
@given(k=st.floats(1e3, 1e10), limit=st.floats(1e-3, 1e5), share=st.floats(0.0, 3.0))
def test_jenkins_is_homogeneous(k: float, limit: float, share: float) -> None:
    model = model_of("jenkins")
    values = {"stiffness": k, "force_limit": limit}
    force, _, by_values = model.branch(np.array([share * limit / k]), values, None)
    # T0 is homogeneous of degree one in (k, F): Euler's relation.
    assert float(by_values[:, 0] @ [k, limit]) == pytest.approx(float(force[0]), rel=1e-14)


# -- what follows ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("model", "values"), example_params())
def test_derived_quantities_and_their_gradients(model: Model, values: Mapping[str, float]) -> None:
    loads = loads_of(model)[:1]
    derived = model.derived(values, loads, Materials(PAIR, 2e-4))
    assert derived or {"stiffness", "force_limit"} == set(values)
    for j, item in enumerate(derived):
        for i, name in enumerate(model.names):
            step = 1e-3 * (abs(values[name]) or 1e-2)
            least = model.parameters[i].low + 3.0 * step
            if values[name] < least:  # differences need room on both sides
                values = {**values, name: least}
                item = model.derived(values, loads, Materials(PAIR, 2e-4))[j]

            def at(
                value: float, given: Mapping[str, float] = values, name: str = name, j: int = j
            ) -> float:
                return model.derived({**given, name: value}, loads, Materials(PAIR, 2e-4))[j].value

            found = sixth_order(at, values[name], step)
            error = 1e-9 * abs(item.gradient[i]) + 1e-14 * abs(item.value) / step
            assert found == pytest.approx(item.gradient[i], rel=0.0, abs=error)


def test_derived_quantities_are_those_of_the_joint() -> None:
    truth = ms.Interface.examples()[0]
    model = model_of(truth)
    values = dict(model.start or {})
    for load in LOADS:
        joint = truth.at(normal_load=load)
        found = {item.name: item for item in model.derived(values, [load])}
        assert found["force_limit"].value == pytest.approx(joint.force_limit, rel=1e-13)
        stiffness = found["tangential_stiffness"].value
        assert stiffness == pytest.approx(joint.tangential_stiffness, rel=1e-12)
        h = found["standardised_separation"].value
        assert h == pytest.approx(joint.separation / truth.surface.heights.std, rel=1e-12)
        assert found["standardised_separation"].load == load
    assert found["std"].value == pytest.approx(truth.surface.heights.std, rel=1e-13)
    product = truth.surface.density * math.sqrt(truth.surface.radius)
    assert found["density_root_radius"].value == pytest.approx(product, rel=1e-12)
    assert found["load_scale"].load is None
    again = model.build(values)
    assert again.surface.density == pytest.approx(truth.surface.density, rel=1e-12)
    assert again.separation == pytest.approx(truth.separation, rel=1e-12)
