"""Bad input wherever numbers enter: a clear error of one line, and nothing is lost."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip._core.errors import InputError

AL = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(AL, AL)
SURFACE = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), radius=1e-3, density=1e8, area=2e-4)
POPULATION = ms.AsperityPopulation(PAIR, [0.0, 1e-7, 3e-7], 1e-3)
D = np.linspace(0.0, 1e-6, 11)
TABLE = ms.TabulatedNormalLaw(PAIR, D, 1e3 * (1.0 - D / 1e-6) ** 2)
JOINTS = {
    "gaussian": ms.Interface(SURFACE, 0.55, 2000.0),
    "population": ms.Interface(POPULATION, 0.55, 1.0),
    "sphere": ms.Interface(ms.SphereOnFlat(PAIR, 5e-3), 0.55, 10.0),
    "table": ms.Interface(TABLE, 0.55, 500.0),
}
MEASURES = (
    "dissipated_energy",
    "energy_ratio",
    "loss_factor",
    "damping_ratio",
    "secant_stiffness",
    "dissipation_exponent",
)


def refusal(call: Callable[..., Any], *args: object, **kwargs: object) -> str:
    with pytest.raises(InputError) as caught:
        call(*args, **kwargs)
    message = str(caught.value)
    assert "\n" not in message
    return message


# -- arrays ----------------------------------------------------------------------------------------

# Every entrance for arrays, with the name that its messages give the array.
ARRAYS: dict[str, tuple[Callable[..., Any], str]] = {
    "load": (SURFACE.load, "separation"),
    "stiffness": (SURFACE.stiffness, "separation"),
    "contact_probability": (SURFACE.contact_probability, "separation"),
    "contact_count": (POPULATION.contact_count, "separation"),
    "contact_area": (POPULATION.contact_area, "separation"),
    "table": (TABLE.load, "separation"),
    "separation": (SURFACE.separation, "load"),
    "pdf": (SURFACE.heights.pdf, "height"),
    "cdf": (SURFACE.heights.cdf, "height"),
    "probability_above": (SURFACE.heights.probability_above, "height"),
    "partial_moment": (lambda v: SURFACE.heights.partial_moment(1.5, v), "threshold"),
    "heights": (lambda v: ms.AsperityPopulation(PAIR, v, 1.0), "heights"),
    "radii": (lambda v: ms.AsperityPopulation(PAIR, [0.0, 1.0], v), "radii"),
    "discrete": (ms.Discrete, "heights"),
    "density": (JOINTS["gaussian"].sliders().density, "yield_displacement"),
    "advance": (lambda v: JOINTS["gaussian"].start().advance(v), "displacement"),
    "loop amplitude": (JOINTS["gaussian"].loop, "amplitude"),
    "loop displacement": (lambda v: ms.Loop(v, [1.0, 2.0, 1.0, 0.0]), "displacement"),
    "loop force": (lambda v: ms.Loop([1.0, 2.0, 1.0, 0.0], v), "force"),
    "table separation": (lambda v: ms.TabulatedNormalLaw(PAIR, v, [2.0, 1.0, 0.0]), "separation"),
    "table load": (lambda v: ms.TabulatedNormalLaw(PAIR, [0.0, 1.0, 2.0], v), "load"),
}
for _kind, _joint in JOINTS.items():
    ARRAYS |= {
        f"{_kind} force": (_joint.force, "displacement"),
        f"{_kind} displacement": (_joint.displacement, "force"),
        f"{_kind} periodic": (_joint.periodic, "displacement_cycle"),
        f"{_kind} backbone": (_joint.backbone, "displacement"),
        f"{_kind} backbone_stiffness": (_joint.backbone_stiffness, "displacement"),
        f"{_kind} backbone_displacement": (_joint.backbone_displacement, "force"),
        f"{_kind} stick_area": (_joint.stick_area, "displacement"),
    }
for _name in MEASURES:
    _measure = getattr(JOINTS["gaussian"], _name)
    ARRAYS[_name] = (_measure, "amplitude")
    ARRAYS[f"{_name} of force"] = (
        lambda v, measure=_measure: measure(force_amplitude=v),
        "force_amplitude",
    )


def refused_everywhere(value: object, expected: Callable[[str], str]) -> None:
    """Offer ``value`` to every entrance; each has to answer with the message that is expected."""
    wrong = {}
    for entrance, (call, name) in ARRAYS.items():
        try:
            call(value)
            wrong[entrance] = "accepted"
        except InputError as error:
            message = str(error)
            if not message.startswith(expected(name)) or "\n" in message or len(message) > 160:
                wrong[entrance] = message
        except Exception as error:
            wrong[entrance] = repr(error)
    assert wrong == {}


NOT_NUMBERS: list[object] = [
    "1e-6",
    "1 um",
    b"1",
    1j,
    [1e-7, 1j],
    [1e-7, "1e-7"],
    [1e-7, None],
    [[1.0], [1.0, 2.0]],
    {"a": 1.0},
    {1.0, 2.0},
    [10**400],
    np.array(["1"]),
    np.array([1e-7, None]),
    np.array(["2020"], dtype="M8[D]"),
    np.array([3], dtype="m8[s]"),
    np.zeros(2, dtype=[("a", float)]),
    object,
]


@pytest.mark.parametrize("value", NOT_NUMBERS, ids=lambda v: repr(v)[:40])
def test_not_numbers(value: object) -> None:
    refused_everywhere(value, lambda name: f"{name} must be a number or an array of numbers, got ")


def test_nothing() -> None:
    for call, name in ARRAYS.values():
        starts = (f"{name} must be a number or", "exactly one of amplitude [m] or")
        assert refusal(call, None).startswith(starts)


@pytest.mark.parametrize(
    "value", [[], (), np.zeros(0), np.zeros((0, 3)), np.zeros((3, 0))], ids=repr
)
def test_empty_arrays(value: object) -> None:
    refused_everywhere(value, lambda name: f"{name} must hold at least one number, got an empty")


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_not_finite(bad: float) -> None:
    for value, count, size, index in (
        (bad, 1, 1, 0),
        ([1e-7, 0.0, bad, 1e-8, bad], 2, 5, 2),
        (np.array([bad, 0.0], dtype=np.float32), 1, 2, 0),
    ):
        text = f"{count} of {size} values are not, the first is {bad} at index {index}"
        refused_everywhere(value, lambda name, text=text: f"{name} must be finite: {text}")


@pytest.mark.parametrize("value", [True, [True, False], np.array([True])], ids=repr)
def test_booleans_are_no_numbers(value: object) -> None:
    # As for single numbers: True is no displacement.
    refused_everywhere(value, lambda name: f"{name} must be")


def test_missing_values_are_no_numbers() -> None:
    # What lies under a mask was declared missing: it must not be used.
    value = np.ma.array([1e-7, 2e-7, 1e-7, 0.0], mask=[False, True, False, False])
    refused_everywhere(value, lambda name: f"{name} must be")


RECORDS = [
    name
    for name in ARRAYS
    if (name.split()[0] in JOINTS and name.split()[-1] in ("force", "displacement", "periodic"))
    or name in ("advance", "heights", "discrete", "table separation", "table load")
]


@pytest.mark.parametrize("name", RECORDS)
@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (4, 1), (1, 2, 2)])
def test_records_have_one_dimension(name: str, shape: tuple[int, ...]) -> None:
    call, argument = ARRAYS[name]
    message = refusal(call, np.full(shape, 1e-8))
    assert message == f"{argument} must be one-dimensional, got shape {shape}"


# -- amplitudes ------------------------------------------------------------------------------------


@pytest.mark.parametrize("joint", JOINTS.values(), ids=JOINTS)
@pytest.mark.parametrize("name", MEASURES)
def test_amplitude_or_force_amplitude(joint: ms.Interface, name: str) -> None:
    measure = getattr(joint, name)
    wanted = "exactly one of amplitude [m] or force_amplitude=... [N] must be given, got "
    assert refusal(measure) == wanted + "neither"
    assert refusal(measure, None, force_amplitude=None) == wanted + "neither"
    assert refusal(measure, 1e-7, force_amplitude=1.0) == wanted + "both"
    assert refusal(measure, -1e-7) == "amplitude must not be negative, got -1e-07"
    assert refusal(measure, [0.0, -5e-324]) == "amplitude must not be negative, got -4.94066e-324"
    message = "force_amplitude must not be negative, got -0.1"
    assert refusal(measure, force_amplitude=[0.0, -0.1]) == message
    with pytest.raises(TypeError):
        measure(None, 1.0)  # force amplitudes are named


@pytest.mark.parametrize("joint", JOINTS.values(), ids=JOINTS)
@pytest.mark.parametrize("factor", [1.0, 1.0 + 2**-52, 2.0, 1e300])
def test_force_at_or_beyond_the_limit(joint: ms.Interface, factor: float) -> None:
    limit = joint.force_limit
    force = factor * limit
    ending = (
        f" must be below the force limit {limit:.10g} N in magnitude (at the limit slip "
        f"is unlimited), got {force:.10g} N"
    )
    for sign in (1.0, -1.0):
        for value in (sign * force, [0.0, sign * force], [[sign * force]]):
            assert refusal(joint.backbone_displacement, value) == "force" + ending
        for record in (sign * force, [0.5 * limit, sign * force, 0.0]):
            assert refusal(joint.displacement, record) == "force" + ending
    for name in MEASURES:
        message = refusal(getattr(joint, name), force_amplitude=[0.0, force])
        assert message == "force_amplitude" + ending


@pytest.mark.parametrize(
    ("amplitude", "message"),
    [
        (0, "amplitude must be one number above zero [m], got 0"),
        (0.0, "amplitude must be one number above zero [m], got 0.0"),
        (-1e-6, "amplitude must be one number above zero [m], got -1e-06"),
        ([1e-6], "amplitude must be one number above zero [m], got [1e-06]"),
        ([1e-6, 2e-6], "amplitude must be one number above zero [m], got [1e-06, 2e-06]"),
    ],
    ids=str,
)
def test_loop_amplitude(amplitude: object, message: str) -> None:
    for joint in JOINTS.values():
        assert refusal(joint.loop, amplitude) == message


@pytest.mark.parametrize("samples", [4, 0, -1, 5.0, 512.5, "512", None, True, [512], math.nan])
def test_loop_samples(samples: object) -> None:
    message = f"samples must be an integer from 5 to 10000000, got {samples!r}"
    for joint in JOINTS.values():
        assert refusal(joint.loop, 1e-7, samples) == message


# -- forms in which arrays come --------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["i1", "u1", "<i4", ">i8", "u8", "f2", "f4", ">f4"])
def test_other_kinds_of_numbers(kind: str) -> None:
    joint = ms.Interface(SURFACE, 0.55, 2000.0)
    force = np.array([0, 1, 100, 7, 3], dtype=kind)
    expected = joint.displacement(force.astype(float))
    np.testing.assert_array_equal(joint.displacement(force), expected)
    assert joint.displacement(force).dtype == np.float64


@pytest.mark.parametrize("joint", JOINTS.values(), ids=JOINTS)
def test_huge_displacements_just_slip(joint: ms.Interface) -> None:
    huge = [1e308, -1e308, 1.7e308, -1.7e308, 1e200]
    limit = joint.force_limit
    expected = limit * np.array([1, -1, 1, -1, 1])
    np.testing.assert_allclose(joint.force(huge), expected, rtol=1e-14)
    np.testing.assert_allclose(joint.backbone(huge), expected, rtol=1e-14)
    np.testing.assert_array_equal(joint.backbone_stiffness(huge), 0.0)
    state = joint.start()
    for x, f in zip(huge, expected, strict=True):
        assert state.try_(x) == (pytest.approx(f, rel=1e-14, abs=0), 0.0)
        state.commit()
