"""Slack bolts in a study: numbers of the library, and refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest
from laps import DENSITY, STRIP

import microslip as ms
from microslip.study.build import build_surface

STUDY = STRIP
for _one, _two in (
    ('lap = "30 mm"', 'lap = "40 mm"'),
    ('positions = ["0 mm"]', 'positions = ["-9 mm", "9 mm"]'),
    ('shank = "6 mm"\nhole = "6.6 mm"\nwasher = "12 mm"\ntension = "5 kN"',
     'shank = "4 mm"\nhole = "4.5 mm"\nwasher = "7 mm"\ntension = "2.5 kN"'),
    ("patches = [3, 2]", 'patches = [4, 2]\n'
     'amplitude = { from = "0.1 um", to = "10 um", points = 2 }'),
    ("samples = 32\n", ""),
):  # fmt: skip
    assert _one in STUDY
    STUDY = STUDY.replace(_one, _two)


@pytest.mark.slow
def test_slack_stands_beside_tight_as_the_library_has_both() -> None:
    """What `microslip predict --set structure.bolts.slack=2` does."""
    asked = ms.Study.from_toml(STUDY, overrides=("structure.bolts.slack=2",))
    result = asked.run()
    structure = result.structure
    assert structure is not None
    lap, surface, curves = asked.structure.build(), build_surface(asked), []
    for slack in (2, ()):
        joint = lap.reduce(
            ms.Material.named("steel"), DENSITY, (4, 2), element_size=0.012, slack=slack,
            sensors={"sensor": ((0.1, 0.0, 0.0), "z")},
        )  # fmt: skip
        state = joint.tightened(surface, 0.35)
        curves.append(state.modes(0, [1e-7, 1e-5], at=joint.sensor("sensor"), damping_ratio=5e-4))
    (mode,), (beside,) = structure.modes, structure.tight
    np.testing.assert_allclose(mode.curve.frequency, curves[0].frequency, rtol=1e-8)
    np.testing.assert_allclose(beside.curve.frequency, curves[1].frequency, rtol=1e-8)
    np.testing.assert_allclose(beside.curve.damping_ratio, curves[1].damping_ratio, rtol=1e-6)
    assert (beside.of, beside.number) == (1, 1)
    assert 0.9 < beside.mac <= 1.0
    held = json.loads(json.dumps(result.summary["structure"], allow_nan=False))
    assert held["slack_bolts"] == [2]
    assert held["all_tight"][0]["modal_frequency"] == beside.curve.frequency.tolist()
    assert len(held["bolt_tension"]) == 1
    assert "Fully stuck with bolt 2 slack" in held["answer"]
    assert len(asked.structure.holes) == 2
    assert asked.structure.sensing == ((0.1, 0.0, 0.0), "z")


def test_a_slack_bolt_that_is_not_there_is_refused_at_its_key() -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(STUDY, overrides=("structure.bolts.slack=3",))
    message = str(caught.value)
    assert "slack must be an integer from 1 to 2" in message
    assert message.startswith("study: structure.bolts.slack")
    assert "\n" not in message
