"""Floats or arrays in, the same shape out, and nothing of the caller's is touched."""

from __future__ import annotations

import inspect
from functools import partial
from typing import Any

import numpy as np
import pytest
from cases import folded, reach_of
from own_laws import HEIGHTS, LAWS

import microslip as ms
from microslip.contact import NORMAL_LAWS
from microslip.friction import Sliders

# Vectorised methods with a place in the middle of what each takes.
JOINT = {
    "backbone": "u", "backbone_stiffness": "u", "backbone_displacement": "f", "stick_area": "u",
    "dissipated_energy": "u", "energy_ratio": "u", "loss_factor": "u", "damping_ratio": "u",
    "secant_stiffness": "u", "dissipation_exponent": "u",
}  # fmt: skip
RECORDS = {
    "force": "u", "displacement": "f", "periodic": "u",
    "coupled_force": "u", "coupled_response": "u",
}  # fmt: skip
NORMAL = {
    "load": "d", "stiffness": "d", "separation": "n", "contact_probability": "d",
    "contact_count": "d", "contact_area": "d",
}  # fmt: skip
HEIGHT = {"partial_moment": "y", "probability_above": "y", "cdf": "y", "pdf": "y"}
SHAPES = [(1,), (3,), (2, 3), (1, 1, 1)]


def one_for_each_surface(joints: Any) -> list[Any]:
    chosen = {repr(getattr(joint, "surface", joint)): joint for joint in joints[::-1]}
    return list(chosen.values())[::-1]


JOINTS = one_for_each_surface(ms.Interface.examples())
OVER = {f"{type(joint.surface).__name__}{i}": joint for i, joint in enumerate(JOINTS)}


def by_force(method: Any, force: Any) -> Any:
    return method(force_amplitude=force)


def cases() -> dict[str, tuple[Any, np.ndarray]]:
    """A bound method and six numbers that it takes, for every example of every law."""
    spread, found = np.array([0.3, 0.9, 0.05, 0.7, 0.2, 0.99]), {}
    for law in LAWS:
        for i, joint in enumerate(one_for_each_surface(law.examples())):
            places = {
                "u": spread * reach_of(joint),
                "f": spread * joint.force_limit,
            }
            label = f"{law.__name__}{i}"
            own = {name: kind for name, kind in JOINT.items() if hasattr(joint, name)}
            for name, kind in own.items():
                found[f"{label}.{name}"] = getattr(joint, name), places[kind]
            for name in own:
                # All share the way from a force amplitude to a displacement.
                if name == "dissipated_energy" or (i == 0 and name.endswith(("r", "o", "s", "t"))):
                    if "amplitude" not in str(inspect.signature(getattr(joint, name))):
                        continue
                    call = partial(by_force, getattr(joint, name))
                    found[f"{label}.{name}(force)"] = call, places["f"]
            found[f"{label}.sliders"] = joint.sliders().density, places["u"]
    for law in NORMAL_LAWS:
        for i, surface in enumerate(law.examples()):
            joint = next(j for j in JOINTS if repr(j.surface) == repr(surface))
            places = {
                "d": joint.separation + spread * joint.normal_load / joint.normal_stiffness,
                "n": spread * joint.normal_load,
            }
            for name, kind in NORMAL.items():
                found[f"{law.__name__}{i}.{name}"] = getattr(surface, name), places[kind]
    for law in HEIGHTS:
        for i, heights in enumerate(law.examples()):
            y = heights.spread * (2.0 * spread - 1.0)
            for name in HEIGHT:
                if name == "partial_moment":
                    for order in (-0.5, 0, 0.5, 1, 1.5, 2, 2.5):
                        found[f"{law.__name__}{i}.{name}({order})"] = (
                            lambda t, h=heights, n=order: h.partial_moment(n, t),
                            y,
                        )
                else:
                    found[f"{law.__name__}{i}.{name}"] = getattr(heights, name), y
    return found


CASES = cases()
# Some laws cannot know.
UNKNOWN = (
    "TabulatedNormalLaw",
    "MeasuredContact0.contact_probability",
    "MeasuredContact0.contact_count",
    *(f"DrawnFace{i}.contact_{name}" for i in (0, 1) for name in ("probability", "count")),
    "Discrete0.pdf",
    "stick_area",
    "Coulomb",
)


def known(label: str) -> tuple[Any, np.ndarray]:
    """A case, skipped where the law cannot know."""
    call, x = CASES[label]
    if any(part in label for part in UNKNOWN):
        try:
            call(x)
        except ms.InputError as error:
            if any(word in str(error) for word in ("has no", "no density", "does not determine")):
                pytest.skip("not known to this law")
            raise
    return call, x


LABELS = {label: label for label in CASES}


OWN_TESTS = {"harmonics", "parameter_derivatives", "plot", "start"}


def test_every_vectorised_method_is_tested() -> None:
    for base, names in (
        (ms.Interface, {**JOINT, **RECORDS}),
        (ms.NormalLaw, NORMAL),
        (ms.HeightDistribution, HEIGHT),
        (Sliders, {"density"}),
    ):
        vectorised = {
            name
            for name, member in inspect.getmembers(base, inspect.isfunction)
            if not name.startswith("_") and "ArrayLike" in str(inspect.signature(member))
        }
        # Paths, coefficients and saved states have files of their own among the tests of physics;
        # a picture takes amplitudes and gives no numbers.
        assert vectorised - OWN_TESTS == set(names)


@folded("label", LABELS)
def test_arrays_keep_their_shape(label: str) -> None:
    call, x = known(label)
    single = np.array([call(float(v)) for v in x])
    # A probability near 0 or 1 is right to rounding of 1; all else to rounding of itself.
    close = {"rtol": 5e-15, "atol": 1e-15 if getattr(call, "__name__", "") == "cdf" else 0.0}
    for shape in SHAPES:
        size = int(np.prod(shape))
        given, kept = x[:size].reshape(shape).copy(), x[:size].reshape(shape).copy()
        result = call(given)
        assert type(result) is np.ndarray
        assert result.shape == shape
        assert result.dtype == np.float64
        np.testing.assert_allclose(result, single[:size].reshape(shape), **close)
        # Neither end holds on to the other.
        np.testing.assert_array_equal(given, kept)
        assert result.flags.writeable
        assert not np.shares_memory(result, given)
        result[...] = -1.0
        given[...] = kept
        np.testing.assert_allclose(call(given), single[:size].reshape(shape), **close)


@folded("label", LABELS)
def test_layout_does_not_matter(label: str) -> None:
    call, x = known(label)
    table = x.reshape(2, 3)
    expected = call(table)
    locked = table.copy()
    locked.setflags(write=False)
    for given in (
        np.asfortranarray(table),
        np.repeat(table, 2, axis=1)[:, ::2],
        table[::-1].copy()[::-1],
        table.astype(">f8"),
        table.tolist(),
        tuple(map(tuple, table)),
        locked,
    ):
        result = call(given)
        np.testing.assert_array_equal(result, expected)
        assert result.flags.writeable
    np.testing.assert_array_equal(call(table.T), call(np.ascontiguousarray(table.T)))


@folded("joint", OVER)
def test_records(joint: ms.Interface) -> None:
    x = joint.force_limit / joint.tangential_stiffness * np.array([0.4, -0.8, 0.3, 1.5, -2.0, 0.0])
    force = joint.force(x)
    load = min(1.1 * joint.normal_load, joint.surface._heaviest)
    for given, call in (
        (x, joint.force),
        (0.9 * force, joint.displacement),
        (x, partial(joint.coupled_force, normal_load=load)),
    ):
        given, kept = given.copy(), given.copy()
        result = call(given)
        assert type(result) is np.ndarray
        assert result.shape == given.shape
        assert result.dtype == np.float64
        assert result.flags.writeable
        assert not np.shares_memory(result, given)
        np.testing.assert_array_equal(given, kept)
        assert type(call(float(given[0]))) is float
        assert type(call(np.array(given[0]))) is float
        assert call(float(given[0])) == call(given[:1])[0]
    assert type(joint.start().advance(1e-9)) is float
