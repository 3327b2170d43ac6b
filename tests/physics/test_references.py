"""The numbers of high-precision programs: the project's own, and another set where present."""

from typing import Any

import numpy as np
import pytest
from cases import case_params, interface_of, length_of, own_case, own_cases, pair_of, surface_of

EPS = np.finfo(float).eps
CASES = case_params()
OWN = case_params(shared=False)
# Rounding in some tens of operations; measured errors stay below 7e-15.
ROUNDING = 2e-14
# Asked of every tangent stiffness; formulas reach ROUNDING.
STIFFNESS = 1e-12

SCALARS = (
    "composite_modulus",
    "composite_shear_modulus",
    "stiffness_ratio",
    "slip_per_indentation",
    "normal_load",
    "contact_count",
    "contact_area",
    "normal_stiffness",
    "tangential_stiffness",
    "force_limit",
)
CURVES = {
    "backbone": lambda joint, x: joint.backbone(x),
    "secant_stiffness": lambda joint, x: joint.secant_stiffness(x),
    "dissipated_energy": lambda joint, x: joint.dissipated_energy(x),
    "energy_ratio": lambda joint, x: joint.energy_ratio(x),
    "loss_factor": lambda joint, x: joint.loss_factor(x),
    "damping_ratio": lambda joint, x: joint.damping_ratio(x),
    "dissipation_exponent": lambda joint, x: joint.dissipation_exponent(x),
}
# These depend on the load law at d + delta/kappa alone.
SHIFTED = {
    "tangent_stiffness": lambda joint, x: joint.backbone_stiffness(x),
    "stick_area": lambda joint, x: joint.stick_area(x),
    "slider_density": lambda joint, x: joint.sliders().density(x),
}


def curves_of(names: dict[str, Any]) -> list[Any]:
    """Each case with each of the curves that its numbers hold."""
    return [
        pytest.param(*param.values, name, id=f"{param.id}-{name}", marks=param.marks)
        for param in CASES
        for name in names
        if not param.values[0] or name in param.values[0]["result"]["amplitudes"]
    ]


@pytest.mark.parametrize("case", CASES)
def test_scalars(case):
    joint, result = interface_of(case), case["result"]
    got = {
        name: getattr(owner, name)
        for owner in (joint, pair_of(case))
        for name in SCALARS
        if hasattr(owner, name)
    }
    assert set(got) == set(SCALARS)
    for name in set(SCALARS) & set(result):
        assert got[name] == pytest.approx(result[name], rel=ROUNDING, abs=0), name


@pytest.mark.parametrize("case", CASES)
def test_separation(case):
    joint, wanted = interface_of(case), case["result"]["separation"]
    length = max(abs(wanted), length_of(case))
    assert joint.separation == pytest.approx(wanted, rel=0, abs=4e-15 * length)
    loads = joint.normal_load * np.array([[1.0, 0.5], [1e-3, 1e-6]])
    d = joint.surface.separation(loads)
    # The last places of d, and of the length that d is measured by, are worth this much load.
    doubt = 4 * EPS * np.maximum(np.abs(d), length_of(case)) * joint.surface.stiffness(d)
    assert np.all(np.abs(joint.surface.load(d) - loads) <= ROUNDING * loads + doubt)


@pytest.mark.parametrize(("case", "name"), curves_of(CURVES))
def test_amplitude_curves(case, name):
    """At every amplitude, those included at which the plain formulas lose all digits."""
    rows = case["result"]["amplitudes"]
    joint, x = interface_of(case), np.array(rows["displacement"])
    np.testing.assert_allclose(CURVES[name](joint, x), rows[name], rtol=ROUNDING)


@pytest.mark.parametrize(("case", "name"), curves_of(SHIFTED))
def test_shifted_curves(case, name):
    rows = case["result"]["amplitudes"]
    joint, x = interface_of(case), np.array(rows["displacement"])
    got, wanted = SHIFTED[name](joint, x), np.array(rows[name])
    # Just before a summit slips its share depends on s - delta/kappa, so on the last places of d
    # and kappa: what moving delta by those makes of the result is allowed as well. It matters for
    # one sphere within 3e-5 of its slip limit, where the nearest doubles of d and kappa cost 2e-12.
    doubt = 4 * EPS * (x + joint.slip_per_indentation * abs(joint.separation))
    swing = np.abs(SHIFTED[name](joint, x + doubt) - got)
    # Moments below 1e-300 are no longer held to full precision.
    lost = 1e-290 * np.abs(wanted).max()
    assert np.all(np.abs(got - wanted) <= ROUNDING * np.abs(wanted) + swing + lost)
    ordinary = x < 0.99 * joint.slip_per_indentation * length_of(case)
    np.testing.assert_allclose(got[ordinary], wanted[ordinary], rtol=1e-13)


@pytest.mark.parametrize("case", OWN)
def test_force_amplitudes(case):
    """The same curves at force amplitudes, below the limit where displacement is well defined."""
    rows, joint = case["result"]["amplitudes"], interface_of(case)
    force, x = np.array(rows["backbone"]), np.array(rows["displacement"])
    use = force < 0.999 * joint.force_limit
    assert use.sum() >= 4
    slope = np.array(rows["tangent_stiffness"])[use] / np.array(rows["secant_stiffness"])[use]
    # An amplitude from a force knows its last places only as far as the backbone rises.
    rough = ROUNDING / slope.min()
    np.testing.assert_allclose(joint.backbone_displacement(force[use]), x[use], rtol=rough)
    for name in CURVES:
        got = getattr(joint, name, None)
        if name != "backbone" and got is not None:
            np.testing.assert_allclose(
                got(force_amplitude=force[use]), np.array(rows[name])[use], rtol=4 * rough
            )


@pytest.mark.parametrize("case", CASES)
def test_history(case):
    path, wanted = (case["result"]["history"][key] for key in ("displacement", "force"))
    got = interface_of(case).force(path)
    np.testing.assert_allclose(got, wanted, rtol=0, atol=ROUNDING * np.abs(wanted).max())


@pytest.mark.parametrize("case", OWN)
def test_settled_cycle(case):
    cycle, joint = case["result"]["settled_cycle"], interface_of(case)
    response = joint.periodic(cycle["displacement"])
    scale = np.abs(cycle["force"]).max()
    np.testing.assert_allclose(response.force, cycle["force"], rtol=0, atol=ROUNDING * scale)
    # null where a loop closes on the sample: the stiffness jumps there.
    pairs = [
        (got, wanted)
        for got, wanted in zip(response.stiffness, cycle["tangent_stiffness"], strict=True)
        if wanted is not None
    ]
    assert len(pairs) >= len(response.stiffness) - 4
    got, wanted = np.array(pairs).T
    np.testing.assert_allclose(got, wanted, rtol=STIFFNESS)


@pytest.mark.parametrize("case", CASES)
def test_trial(case):
    """What a time integrator is given: force and tangent stiffness of a move from rest."""
    rows, joint = case["result"]["amplitudes"], interface_of(case)
    x, state = np.array(rows["displacement"]), joint.start()
    force, stiffness = np.array([state.try_(v) for v in x]).T
    np.testing.assert_allclose(force, rows["backbone"], rtol=ROUNDING)
    wanted = np.array(rows["tangent_stiffness"])
    # Where the force still changes with it. Last places of d and kappa as in test_shifted_curves.
    felt = wanted > 1e-6 * joint.tangential_stiffness
    assert felt.sum() >= 3
    doubt = 4 * EPS * (x + joint.slip_per_indentation * abs(joint.separation))
    swing = np.abs(joint.backbone_stiffness(x + doubt) - joint.backbone_stiffness(x))
    error = np.abs(stiffness - wanted)
    assert np.all((error <= STIFFNESS * wanted + swing)[felt]), (error / wanted)[felt].max()
    assert np.all(error <= STIFFNESS * joint.tangential_stiffness)


@pytest.mark.parametrize("case", CASES)
def test_quick_energy_is_the_exact_one(case):
    """What is tabulated against what it is a table of, between the reference amplitudes too.

    Far out the energy is a small difference of large numbers, on both sides of the comparison.
    """
    joint = interface_of(case)
    scale = joint.force_limit / joint.tangential_stiffness
    x = scale * np.geomspace(1e-12, 1e3, 400)
    np.testing.assert_allclose(joint.dissipated_energy(x), joint._exact_energy(x), rtol=2e-13)
    np.testing.assert_allclose(joint.backbone(x), joint._exact_backbone(x), rtol=2e-14)


def test_cases_cover_what_they_should():
    """Light and heavy, negative and positive separations, every kind of heights, a rigid body."""
    standard = {
        case["name"]: (case["result"]["separation"] - case["heights"].get("mean", 0.0))
        / length_of(case)
        for case in own_cases()
        if case["heights"]["kind"] == "gaussian"
    }
    assert min(standard.values()) < -11
    assert max(standard.values()) > 6.9
    assert {case["heights"]["kind"] for case in own_cases()} == {
        "gaussian",
        "exponential",
        "sphere",
        "summits",
    }
    assert any(body.get("rigid") for case in own_cases() for body in case["materials"])
    assert own_case("exponential-heavy")["result"]["separation"] < 0
    for case in own_cases():
        assert case["result"]["amplitudes"]["displacement"][0] == 1e-13


def test_light_load_is_not_the_end():
    """Down to where moments underflow, the load and its inverse agree."""
    surface = surface_of(own_case("gaussian-al2017"))
    loads = np.geomspace(1e-290, 1e7, 60)
    # N changes by h^2 times a relative change of d: the last place of d costs 1400 of N's.
    np.testing.assert_allclose(surface.load(surface.separation(loads)), loads, rtol=1e-12)
