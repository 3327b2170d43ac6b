"""Several laps, the ground and slack bolts in a study: numbers of the library, and refusals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import microslip as ms
from microslip.study.build import build_surface

EXAMPLE = Path(__file__).parents[2] / "examples" / "two_laps.toml"
COARSE = ("structure.element_size=20 mm", "structure.patches=[2, 1]",
          "structure.amplitude.points=2")  # fmt: skip


@pytest.fixture(scope="module")
def study() -> str:
    """The example."""
    return EXAMPLE.read_text(encoding="utf-8")


@pytest.mark.slow
def test_slack_stands_beside_tight_as_the_library_has_both(study: str) -> None:
    """What `microslip predict --set structure.bolts.slack=3` does."""
    asked = ms.Study.from_toml(study, overrides=(*COARSE, "structure.bolts.slack=3"))
    result = asked.run()
    structure = result.structure
    assert structure is not None
    part = asked.structure
    beam = part.build()
    metals = [ms.Material(200e9, 0.3), ms.Material(70e9, 0.33)]
    surface = build_surface(asked)
    curves = []
    for slack in (3, ()):
        joint = beam.reduce(
            metals, [7800.0, 2700.0], (2, 1), element_size=0.02, slack=slack,
            sensors={"sensor": ((0.13, 0.0, -0.003), "z")},
        )  # fmt: skip
        state = joint.tightened(surface, 0.3)
        curves.append(state.modes(0, [1e-6, 2e-4], at=joint.sensor("sensor"), damping_ratio=5e-4))
    (mode,), (beside,) = structure.modes, structure.tight
    np.testing.assert_allclose(mode.curve.frequency, curves[0].frequency, rtol=1e-8)
    np.testing.assert_allclose(beside.curve.frequency, curves[1].frequency, rtol=1e-8)
    np.testing.assert_allclose(beside.curve.damping_ratio, curves[1].damping_ratio, rtol=1e-6)
    assert (beside.of, beside.number) == (1, 1)
    assert 0.9 < beside.mac <= 1.0
    held = json.loads(json.dumps(result.summary["structure"], allow_nan=False))
    assert held["slack_bolts"] == [3]
    assert held["all_tight"][0]["modal_frequency"] == beside.curve.frequency.tolist()
    assert len(held["bolt_tension"]) == 3
    assert "fully stuck with bolt 3 slack" in held["answer"]
    assert len(part.holes) == 4
    assert part.sensing == ((0.13, 0.0, -0.003), "z")


BAD = [
    ("structure.bolts.slack=5", r"slack must be an integer from 1 to 4"),
    ("structure.lap=30 mm", "wanted none beside structure.laps"),
    ("structure.bolts.positions=0 mm", "wanted none beside structure.laps"),
    ('structure.materials=["steel", "stele"]', 'got "stele"'),
    ("structure.ground=top", 'wanted "left" or "right"'),
    ("structure.ground=right", "missing; the right end lies on the ground"),
    ("structure.length=300 mm", "write at=-0.13"),
]


@pytest.mark.parametrize(("override", "message"), BAD)
def test_mistakes_stand_at_their_key(study: str, override: str, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(study, overrides=(override,))
    told = str(caught.value)
    assert message in told
    assert told.startswith("study: structure")
    assert "\n" not in told
