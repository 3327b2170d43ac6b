"""An identification that is honest: its intervals hold the truth, and it refuses what it must."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

import microslip as ms
from microslip.identification import Identification
from microslip.laboratory.virtual import InSeries

Floats = NDArray[np.float64]

MU, STD, RIG = 0.55, 0.5e-6, 2e8
"""The worked example: Al 2017 milled, radius 1 mm, 1e8 summits a square metre on 2 cm^2."""
PAIR = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material(69e9, 0.33))
SURFACE = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(STD), radius=1e-3, density=1e8, area=2e-4)
LOADS = (200.0, 500.0, 1000.0, 2000.0, 5000.0)
REFERENCE = 1000.0  # their geometric mean
AMPLITUDES = (6e-6, 12e-6, 30e-6)  # stick to gross slip, the rig's deflection included
FORCE_NOISE, DISPLACEMENT_NOISE = 0.005, 0.002  # of the force limit, and of the amplitude
LOAD_NOISE = 0.01  # of the load
CYCLES, SAMPLES = 5, 128
NAMES = ("friction_coefficient", "slip_scale", "standardised_separation", "rig_stiffness")


def moment(h: float) -> float:
    """F_3/2 of Gaussian heights, by quadrature."""
    value, _ = quad(
        lambda u: u**1.5 * math.exp(-0.5 * (h + u) ** 2) / math.sqrt(2.0 * math.pi), 0.0, 40.0
    )
    return float(value)


def truth() -> dict[str, float]:
    """Parameters as the identification has them."""
    joint = ms.Interface(SURFACE, MU, normal_load=REFERENCE)
    scale = joint.slip_per_indentation * STD
    return dict(zip(NAMES, (MU, scale, joint.separation / STD, RIG), strict=True))


def record(load: float, amplitude: float, seed: int, cycles: int, samples: int) -> ms.Record:
    """One record with its noise."""
    noise = {
        "force": FORCE_NOISE * MU * load,
        "displacement": DISPLACEMENT_NOISE * amplitude,
        "normal_load": LOAD_NOISE * load,
    }
    rig = ms.VirtualTribometer(
        ms.Interface(SURFACE, MU, normal_load=load),
        rig_stiffness=RIG,
        noise=noise,
        sample_rate=float(samples),
        seed=seed,
    )
    return rig.record(amplitude=amplitude, frequency=1.0, cycles=cycles)


def rich(trial: int) -> Identification:
    """Five loads, three amplitudes."""
    records = [
        record(load, amplitude, 1000 * trial + i, CYCLES, SAMPLES)
        for i, (load, amplitude) in enumerate((n, a) for n in LOADS for a in AMPLITUDES)
    ]
    return ms.identify(records, held_back=0.0, summits=np.inf)


def poor(trial: int) -> Identification:
    """One load, gross slip, a rig of unknown compliance."""
    return ms.identify(
        record(2000.0, 30e-6, 7000 + trial, CYCLES, SAMPLES), held_back=0.0, summits=np.inf
    )


# -- the bound that no unbiased method can beat ---------------------------------------------------


def joint_of(mu: float, scale: float, h: float, load: float) -> ms.Interface:
    """The joint of a load that has these parameters at the reference load."""
    std = scale / (mu * PAIR.stiffness_ratio)
    stiff = 4.0 / 3.0 * PAIR.composite_modulus * math.sqrt(1e-3) * std**1.5 * 2e-4
    density = REFERENCE / (stiff * moment(h))
    surface = ms.GreenwoodWilliamson(
        PAIR, ms.Gaussian(std), radius=1e-3, density=density, area=2e-4
    )
    return ms.Interface(surface, mu, normal_load=load)


def settled(joint: ms.Interface, rig: float, cosine: float, sine: float) -> Floats:
    """Force of the settled cycle behind the rig: the second of two from rest, as rules have it."""
    angle = 2.0 * math.pi * np.arange(SAMPLES) / SAMPLES
    x = cosine * np.cos(angle) + sine * np.sin(angle)
    # The turning points lie between samples: without them the loop would be another one.
    turn = math.atan2(sine, cosine) % (2.0 * math.pi)
    extra = np.array([turn, (turn + math.pi) % (2.0 * math.pi)])
    every = np.concatenate((angle, extra))
    order = np.argsort(every)
    cycle = cosine * np.cos(every[order]) + sine * np.sin(every[order])
    force = np.asarray(InSeries(joint, rig).force(np.tile(cycle, 3)))[2 * cycle.size :]
    back = np.empty(every.size)
    back[order] = force
    assert x.size == SAMPLES
    return back[:SAMPLES]


@cache
def cramer_rao() -> dict[str, float]:
    """Smallest standard deviations of the parameters; of scales those of their logarithms.

    Unknown beside them: of each record the force's offset, and amplitude and phase of the
    displacement and the load, which its own samples tell with their noise.
    """
    values = np.array(list(truth().values()))
    information = np.zeros((4, 4))
    cycles = CYCLES - 1
    for load in LOADS:
        for amplitude in AMPLITUDES:

            def answer(
                p: Floats, a: float = 0.0, b: float = 0.0, n: float = load, top: float = amplitude
            ) -> Floats:
                return settled(joint_of(p[0], p[1], p[2], n), p[3], top + a, b)

            by = []
            for i in range(4):
                step = 1e-4 if i == 2 else 1e-4 * values[i]
                up, down = values.copy(), values.copy()
                up[i] += step
                down[i] -= step
                unit = 1.0 if i == 2 else 1.0 / values[i]
                by.append((answer(up) - answer(down)) / (2.0 * step * unit))
            small = 1e-4 * amplitude
            by.append((answer(values, a=small) - answer(values, a=-small)) / (2.0 * small))
            by.append((answer(values, b=small) - answer(values, b=-small)) / (2.0 * small))
            more, less = (answer(values, n=(1.0 + way * 1e-4) * load) for way in (1.0, -1.0))
            by.append((more - less) / 2e-4)
            by.append(np.ones(SAMPLES))
            jacobian = np.array(by).T / (FORCE_NOISE * MU * load)
            whole = cycles * jacobian.T @ jacobian
            own = 0.5 * SAMPLES * cycles / (DISPLACEMENT_NOISE * amplitude) ** 2
            whole[4, 4] += own
            whole[5, 5] += own
            whole[6, 6] += SAMPLES * cycles / LOAD_NOISE**2
            lost = whole[:4, 4:] @ np.linalg.solve(whole[4:, 4:], whole[4:, :4])
            information += whole[:4, :4] - lost
    return dict(zip(NAMES, np.sqrt(np.diag(np.linalg.inv(information))), strict=True))


def half_width(name: str, low: float, high: float) -> float:
    """Half the width of an interval, of its logarithm for a scale."""
    if name == "standardised_separation":
        return 0.5 * (high - low)
    return 0.5 * math.log(high / low)


# -- what is tested -------------------------------------------------------------------------------


def covered_and_widths(trials: range) -> tuple[dict[str, int], dict[str, list[float]]]:
    """How often each interval holds the truth, and widths over those of the bound."""
    true, bound = truth(), cramer_rao()
    covered = dict.fromkeys(NAMES, 0)
    widths: dict[str, list[float]] = {name: [] for name in NAMES}
    for trial in trials:
        found = rich(trial)
        assert found.status == "converged"
        for name in NAMES:
            one = found.parameters[name]
            covered[name] += one.low <= true[name] <= one.high
            widths[name].append(half_width(name, one.low, one.high) / (1.959964 * bound[name]))
    return covered, widths


@pytest.mark.slow
def test_rich_design_in_short() -> None:
    """Two trials: at 95 % less than 1 of 2 would be a chance of one in 400."""
    covered, widths = covered_and_widths(range(2))
    for name in NAMES:
        assert covered[name] >= 1, name
        assert 0.7 < np.median(widths[name]) < 1.5, name


def test_poor_design_in_short() -> None:
    """It refuses the separation, says why and what would settle it."""
    for trial in range(2):
        one = poor(trial).parameters["standardised_separation"]
        assert one.verdict == "not identified"
        assert "rig's stiffness" in one.remedy
        assert "another normal load" in one.remedy


@pytest.mark.slow
def test_rich_design_covers() -> None:
    """100 trials: each 95 % interval holds the truth in 90 to 99 % and is as short as can be.

    An exact method is outside of that once in 30 such tests of one parameter; seeds are fixed.
    """
    covered, widths = covered_and_widths(range(100))
    for name in NAMES:
        share, width = covered[name] / 100.0, float(np.median(widths[name]))
        print(f"{name}: covered {share:.1%}, median width {width:.3f} of the Cramer-Rao bound")
    for name in NAMES:
        assert 0.90 <= covered[name] / 100.0 <= 0.99, name
        assert np.median(widths[name]) <= 1.5, name


@pytest.mark.slow
def test_poor_design_refuses() -> None:
    """60 trials: at least 95 % say "not identified" of the separation."""
    verdicts = [poor(trial).parameters["standardised_separation"].verdict for trial in range(60)]
    share = verdicts.count("not identified") / len(verdicts)
    print(f"standardised_separation refused in {share:.1%} of the trials")
    assert share >= 0.95
