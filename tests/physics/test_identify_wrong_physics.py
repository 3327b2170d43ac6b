"""Records that a law cannot tell apart or does not answer pass for none of its numbers.

They are made of parallel sliders, stepped sample by sample, without the package.
"""

from __future__ import annotations

import numpy as np
import pytest
from laboratory.physics import Floats, Joint, motion, respond, sampled

import microslip as ms

MU, SLIP_SCALE, RIG = 0.55, 3.4e-7, 2e9


def loops(
    backbone: tuple[Floats, Floats],
    load: float,
    reach: float,
    noise: float,
    rng: np.random.Generator,
    top: float = np.inf,
) -> ms.Record:
    """Twelve cycles; ``top`` is the share of the limit at which the force is cut off."""
    limit = backbone[1][-1]
    amplitude = reach * float(np.interp(0.98 * limit, backbone[1], backbone[0]))
    x = motion(12, amplitude)
    force = np.clip(respond(x, backbone), -top * limit, top * limit)
    x, force = sampled(x, 200.0), sampled(force, 200.0)
    x = x + 0.3 * noise * amplitude * rng.normal(size=x.size)
    force = force + noise * limit * rng.normal(size=x.size)
    return ms.Record(x, force, normal_load=load, sample_rate=2000.0)


def far_and_identified(fit: ms.Identification, truth: dict[str, float]) -> list[str]:
    """Numbers called identified that are off by more than 5 % and more than their interval."""
    return [
        name
        for name, true in truth.items()
        if (number := fit.parameters[name]).verdict == "identified"
        and not number.low <= true <= number.high
        and abs(number.value / true - 1.0) > 0.05
    ]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    ("law", "loads", "rig", "noise"),
    [
        ("jenkins", (1000.0,), 5e8, 0.01),
        ("jenkins", (1000.0,), 2e9, 0.03),
        ("interface", (400.0, 2500.0), 2e9, 0.01),
    ],
)
def test_a_force_that_was_clipped_before_its_noise(
    law: str, loads: tuple[float, ...], rig: float, noise: float, seed: int
) -> None:
    """Its plateau is no friction; the misfit says less than half of what it moves the limit by."""
    rng = np.random.default_rng([31, seed])
    joint = Joint(MU, SLIP_SCALE, 1.2, 1000.0, rig)
    records = [loops(joint.backbone(load), load, 2.5, noise, rng, 0.9) for load in loads]
    fit = ms.identify(records, law, held_back=0, intervals="curvature")
    truth = {"rig_stiffness": rig}
    truth |= {"force_limit": MU * 1000.0} if law == "jenkins" else {"friction_coefficient": MU}
    assert not far_and_identified(fit, truth)
    assert {caveat.kind for caveat in fit.caveats} >= {"misfit"}


@pytest.mark.parametrize("reaches", [(2.5,), (0.5, 3.0)])
@pytest.mark.parametrize("intervals", ["profile", "curvature"])
def test_a_cell_behind_a_rig_is_another_cell(intervals: str, reaches: tuple[float, ...]) -> None:
    """A spring and a slider behind a spring: one stiffness in series, whatever the parts."""
    series, limit = 1.0 / (1.0 / 1e9 + 1.0 / RIG), 550.0
    yields = limit / series
    backbone = np.array([0.0, yields, 100.0 * yields]), np.array([0.0, limit, limit])
    rng = np.random.default_rng(32)
    records = [loops(backbone, 1000.0, reach, 0.003, rng) for reach in reaches]
    fit = ms.identify(records, "jenkins", held_back=0, intervals=intervals)
    assert fit.parameters["force_limit"].verdict == "identified"
    for name in ("stiffness", "rig_stiffness"):
        assert fit.parameters[name].verdict in ("bounded below", "not identified")
        assert "measure the rig" in fit.parameters["stiffness"].remedy


@pytest.mark.parametrize("seed", range(3))
def test_exponential_heights_in_gross_slip(seed: int) -> None:
    """Gaussian heights put the rig 4 to 6 % off; exponential ones answer as well, and say so."""
    rng = np.random.default_rng([seed, 77])
    u = np.append(0.0, np.geomspace(1e-10, 60.0 * SLIP_SCALE, 2000))
    force = MU * 1000.0 * -np.expm1(-u / SLIP_SCALE)
    backbone = np.append(u + force / RIG, 1e-3), np.append(force, force[-1])
    record = loops(backbone, 1000.0, 2.5, 0.01, rng)
    fit = ms.identify(record, held_back=0, summits=np.inf)
    rig = fit.parameters["rig_stiffness"]
    assert not rig.low <= RIG <= rig.high
    assert rig.verdict == "in doubt"
    assert rig.caveat is not None
    if rig.caveat.kind == "other heights":
        assert rig.caveat.data["value"] == pytest.approx(RIG, rel=0.03)


def test_without_their_number_summits_leave_numbers_apparent() -> None:
    """But friction, the force at gross slip; page and terminal are of one document."""
    from microslip.results.identified.document import Identified, document

    rng = np.random.default_rng(5)
    joint = Joint(MU, SLIP_SCALE, 0.5, 1000.0, RIG, tuple(rng.normal(size=20_000)))
    records = [
        loops(joint.backbone(load), load, reach, 0.02, rng)
        for load in (400.0, 2500.0)
        for reach in (0.4, 2.5)
    ]
    fit = ms.identify(records, held_back=0, intervals="curvature")
    assert fit.parameters["friction_coefficient"].verdict == "identified"
    for name in ("slip_scale", "rig_stiffness"):
        number = fit.parameters[name]
        assert number.verdict != "identified"
        if number.verdict == "apparent":
            assert number.caveat is not None
            assert number.caveat.kind == "continuum"
            assert "the number of all summits" in number.remedy
    told = document(Identified((fit,), None, None))
    assert told.word != "ok"
    assert any("summits" in note for note in told.data["identification"]["notes"])
    continuum = ms.identify(records, held_back=0, intervals="curvature", summits=np.inf)
    assert not any(caveat.kind == "continuum" for caveat in continuum.caveats)
    for name, number in fit.parameters.items():
        assert continuum.parameters[name].value == number.value
