"""Tests of modes against bands: inside, above or below, candidates, errors of units."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from laps import STRIP

import microslip as ms
from microslip.study.runs.structure import _bands
from microslip.study.runs.structure_prediction import ModeSamples, joint_damping
from microslip.study.runs.structure_tests import amplitude_trends, compare_tests
from microslip.study.structure import measured_base_damping

AMPLITUDE = np.geomspace(1e-6, 1e-4, 5)


def mode(**bands: Any) -> Any:
    """A mode with bands from 99 to 101 Hz and 0.1 to 0.2 %."""
    ones = np.ones(5)
    given = {
        "frequency": np.outer([99.0, 100.0, 101.0], ones),
        "damping_ratio": np.outer([1e-3, 1.5e-3, 2e-3], ones),
        "slopes": {
            "frequency": (("friction coefficient", 0.001), ("bolt tension", 0.02)),
            "damping_ratio": (("friction coefficient", -0.5), ("bolt tension", -0.2)),
        },
    }
    curve = SimpleNamespace(
        amplitude=AMPLITUDE, frequency=np.linspace(100.0, 99.0, 5), base_damping=5e-4,
        damping_ratio=np.linspace(1e-3, 5.5e-3, 5), converged=np.ones(5, dtype=bool),
        decay_damping_ratio=np.linspace(1e-3, 5.5e-3, 5),
    )  # fmt: skip
    return SimpleNamespace(number=1, bands=SimpleNamespace(**(given | bands)), curve=curve)


def modal_test(frequency: Any, damping: Any, amplitude: Any = (2e-6, 1e-5, 5e-5)) -> ms.ModalTest:
    ones = np.ones(3)
    return ms.ModalTest(
        np.asarray(amplitude), frequency * ones, damping * ones, mode=0, name="test.csv"
    )


def verdicts(test: ms.ModalTest) -> Any:
    return compare_tests((test,), (mode(),), "displacement")


def test_inside_above_and_below() -> None:
    frequency, damping = verdicts(modal_test(100.5, np.array([1.5e-3, 1.9e-3, 1.1e-3])))
    assert (frequency.word, frequency.inside, frequency.candidates) == ("inside", 3, ())
    assert damping.word == "inside"
    frequency, damping = verdicts(modal_test(98.01, np.array([1.5e-3, 1.9e-3, 2.2e-3])))
    assert (frequency.word, frequency.below, frequency.inside) == ("below", 3, 0)
    assert frequency.distance == pytest.approx(-0.01)
    # Friction moves the frequency 20 times less: it is no candidate.
    assert frequency.candidates == (("bolt tension", "less"),)
    assert (damping.word, damping.above, damping.inside) == ("above", 1, 2)
    assert damping.distance == pytest.approx(0.1)
    assert damping.candidates == (("friction coefficient", "less"), ("bolt tension", "less"))
    assert not damping.unit


@pytest.mark.parametrize(
    ("factor", "word"), [(1e3, "divided by 1000"), (1e-3, "multiplied by 1000")]
)
def test_amplitudes_in_other_units_are_recognised(factor: float, word: str) -> None:
    test = modal_test(100.0, 1.5e-3, factor * np.array([2e-6, 1e-5, 5e-5]))
    frequency, damping = verdicts(test)
    assert (frequency.word, frequency.unit) == ("not compared", f"amplitudes {word}")
    assert damping.unit == f"amplitudes {word}"


def test_frequencies_and_ratios_in_other_units_are_recognised() -> None:
    for factor, word in ((2.0 * np.pi, "rad/s instead of Hz"), (1e-3, "kHz instead of Hz")):
        frequency, damping = verdicts(modal_test(100.0 * factor, 1.5e-3))
        assert frequency.unit == f"frequencies in {word}"
        assert damping.word == "inside"
    _, damping = verdicts(modal_test(100.0, 0.15))
    assert damping.word == "above"
    assert damping.unit == "damping ratios in percent"


def test_rise_over_fall_tells_microslip_from_geometry() -> None:
    test = modal_test(np.array([100.0, 99.5, 99.0]), np.array([1e-3, 1.2e-3, 1.5e-3]))
    predicted, measured = amplitude_trends((test,), (mode(),))
    assert predicted.ratio == pytest.approx(0.45)
    assert (predicted.base_damping, predicted.doubt) == (5e-4, "")
    assert measured.ratio == pytest.approx(0.05)
    assert "large deflections" in measured.doubt


def test_stuck_joints_have_a_damping_that_has_a_logarithm() -> None:
    curve: Any = SimpleNamespace(
        damping_ratio=np.array([5e-4, 5e-4 - 1e-19, 6e-4, np.nan]), base_damping=5e-4
    )
    found = joint_damping(curve)
    np.testing.assert_allclose(found[:3], [1e-14, 1e-14, 1e-4], rtol=1e-10)
    assert np.isnan(found[3])


@pytest.mark.filterwarnings("error")
def test_samples_without_a_solution_give_no_band_and_no_warning() -> None:
    part = ms.Study.from_toml(STRIP).structure
    rng = np.random.default_rng(0)
    scores, dense = rng.standard_normal((32, 2)), rng.standard_normal((64, 2))
    nothing = np.full((32, part.amplitudes.size), np.nan)
    base = np.full(32, 5e-4), np.full(64, 5e-4)
    sampled = ModeSamples(scores, dense, nothing, nothing, nothing, base)
    bands = _bands(sampled, part, ("friction coefficient", "bolt tension"), None)
    assert bands is not None
    assert bands.unsolved == 32
    assert np.isnan(bands.damping_error).all()
    assert np.isnan(bands.damping_ratio).all()


def test_tests_at_small_amplitude_set_the_base_damping() -> None:
    """Points of 3e-4 + 100 a leave 3e-4 to the smallest, each within its error."""
    amplitude = np.array([1e-6, 2e-6, 3e-6, 1e-4])
    damping = 3e-4 + 100.0 * amplitude
    ring = ms.ModalTest(amplitude, np.full(4, 100.0), damping)
    found = measured_base_damping([ring])
    assert (found.low, found.high) == pytest.approx((0.95 * 3e-4, 1.05 * 4e-4))
    one = ms.ModalTest(amplitude[:1], [100.0], damping[:1])
    alone = measured_base_damping([one])
    assert (alone.low, alone.high) == pytest.approx((0.95 * 4e-4, 1.05 * 4e-4))


def test_base_damping_is_measured_only_with_a_test(tmp_path: Path) -> None:
    text = STRIP.replace("base_damping_ratio = 0.0005", 'base_damping_ratio = "measured"')
    with pytest.raises(ms.StudyError, match=r'"measured" only with structure\.measured'):
        ms.Study.from_toml(text)
    rows = "amplitude [um],frequency [Hz],damping_ratio [%]\n1,900,0.04\n2,900,0.05\n"
    (tmp_path / "test.csv").write_text(rows, encoding="utf-8")
    part = ms.Study.from_toml(
        text.replace("samples", 'measured = { file = "test.csv" }\nsamples', 1), folder=tmp_path
    ).structure
    assert (part.base_damping_ratio.low, part.base_damping_ratio.high) == pytest.approx(
        (0.95 * 3e-4, 1.05 * 4e-4)
    )
