"""Normal laws: closed forms, loads that they can and cannot carry, and what they refuse."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import refusal
from usual import PAIR, SURFACE, rough

import microslip as ms
from microslip.contact import NORMAL_LAWS

D = np.linspace(0.0, 1e-6, 11)
N = 1e3 * (1.0 - D / 1e-6) ** 2
PARABOLA = ms.TabulatedNormalLaw(PAIR, D, N)
TAILED = ms.TabulatedNormalLaw(PAIR, D, 1e3 * np.exp(-D / 3e-7), tail="exponential")
EXAMPLES = [law for kind in NORMAL_LAWS for law in kind.examples()]


# -- loads that cannot be carried ------------------------------------------------------------------


def test_load_too_heavy_for_a_table() -> None:
    for law in (PARABOLA, TAILED):
        assert law.separation(1e3) == pytest.approx(0.0, abs=1e-20)
        for load in (1500.0, [1.0, 1500.0]):
            assert refusal(law.separation, load) == (
                "load must be at most 1000 N, where the table begins, got 1500 N"
            )
        assert "at most 1000 N" in refusal(ms.Interface, law, 0.5, 1500.0)


@pytest.mark.parametrize(
    "law",
    [SURFACE, rough(ms.Exponential(5e-7)), TAILED, PARABOLA, rough([1e-7, 3e-7]),
     ms.AsperityPopulation(PAIR, [0.0, 1e-7], 1e-3), ms.SphereOnFlat(PAIR, 1e-3)],
    ids=["Gaussian", "exponential", "tailed", "parabola", "given", "population", "sphere"],
)  # fmt: skip
@pytest.mark.parametrize(
    "load", [1e-3, 1e-6, 1e-15, 1e-39, 1e-100, 1e-300, 5e-324, 1e6, 1e20, 1e39, 1e100, 1e308]
)
def test_light_and_heavy_loads_are_carried_or_refused(law: ms.NormalLaw, load: float) -> None:
    """The joint carries the load that was given, and its backbone is made of that load."""
    refused = ""
    try:
        joint = ms.Interface(law, 0.55, load)
    except ms.InputError as error:
        refused = str(error)
    if refused:
        assert "load must be " in refused
        return
    assert law.load(joint.separation) == pytest.approx(load, rel=1e-9, abs=0)
    if load <= 1e-3:
        slip = 30.0 * joint.slip_per_indentation * 1e-6
        assert joint.backbone(slip) == pytest.approx(joint.force_limit, rel=1e-9, abs=0)
        assert joint.loop(slip).force_amplitude == pytest.approx(joint.force_limit, rel=1e-9, abs=0)
        assert joint.tangential_stiffness > 0.0


# -- what is refused when a law is made ------------------------------------------------------------


@pytest.mark.parametrize(
    "law",
    [law for law in EXAMPLES if law._deepest > -1.0 and math.isinf(law._heaviest)],
    ids=lambda law: type(law).__name__,
)
def test_summits_are_pressed_by_their_radius_at_most(law) -> None:
    """Hertz's contacts end far before; what lies beyond is a slip of the pen, such as -1 m."""
    deepest = law._deepest
    assert law.load(deepest) > 0.0
    joint = ms.Interface(law, 0.3, normal_load=0.1 * law.load(law._span[0]))
    for refused in (
        lambda: law.load(-1.0),
        lambda: law.separation(1.1 * law.load(deepest)),
        lambda: joint.coupled_force([1e-7], separation=-1.0),
        lambda: joint.start().try_(1e-7, separation=-1.0),
        lambda: ms.JointField(law, 0.3, areas=1e-5, separations=-1.0, surface_area=1e-4),
    ):
        with pytest.raises(ms.InputError, match="radius") as caught:
            refused()
        assert caught.value.argument in ("separation", "load")
