"""Studies: what they compute."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from studies import AMPLITUDES, CURVE, LOADS, SURFACE, SURFACES, edited

import microslip as ms

NO_REPORT = "report = false\n"
RECORD = [0.0, 0.4, -0.2, 0.3, -0.5, 0.0, 2.0, -3.0]


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """A folder with a record of displacements and one of forces."""
    rows = [f"{x},{100.0 * x}" for x in RECORD]
    (tmp_path / "record.csv").write_text("\n".join(["x [um],T [N]", *rows]), encoding="utf-8")
    return tmp_path


def with_history(column: str, quantity: str) -> str:
    history = f'history = {{ file = "record.csv", column = "{column}", quantity = "{quantity}" }}'
    return edited((CURVE, f"{CURVE}\n{history}")) + NO_REPORT


@pytest.mark.parametrize("name", SURFACES)
def test_every_surface_law_runs_and_saves(name: str, tmp_path: Path) -> None:
    formats = ('["csv"]', '["csv", "netcdf"]')
    text = edited((SURFACE, SURFACES[name]), (LOADS, '"50 N"'), formats) + NO_REPORT
    result = ms.Study.from_toml(text).run()
    result.save(tmp_path / "result")
    joint = result.summary["joints"][0]
    assert joint["force_limit"] == pytest.approx(27.5)
    unknown = name in ("table", "tail")
    assert (joint["contact_count"] is None) == unknown
    for names in (joint["amplitudes"][0], result.rows[0].columns(), result.curves[0].columns()):
        assert ("stick_area" in names) == ("stick_share" in names) == (not unknown)
    assert ("contact_area" in result.to_xarray()) == (not unknown)


def test_force_amplitudes_stand_for_displacement_amplitudes() -> None:
    forces = [50.0, 200.0]
    text = edited((f"amplitudes = {AMPLITUDES}", 'force_amplitudes = ["50 N", "200 N"]'))
    result = ms.Study.from_toml(text).run()
    for joint, row, loops in zip(result.joints, result.rows, result.loops, strict=True):
        assert row.force_amplitude.tolist() == forces
        np.testing.assert_array_equal(row.amplitude, joint.backbone_displacement(forces))
        for name in ("energy_ratio", "loss_factor", "secant_stiffness", "dissipation_exponent"):
            np.testing.assert_array_equal(
                getattr(row, name), getattr(joint, name)(force_amplitude=forces)
            )
        for loop, amplitude, force in zip(loops, row.amplitude, forces, strict=True):
            assert loop.displacement_amplitude == amplitude
            assert loop.force_amplitude == pytest.approx(force, rel=1e-12)
    assert result.rows[0].amplitude[0] != result.rows[1].amplitude[0]
    notes = " ".join(result.summary["notes"])
    assert "amplitudes is not given" not in notes


def test_a_history_is_what_the_joint_does(record: Path) -> None:
    result = ms.Study.from_toml(with_history("x", "displacement"), folder=record).run()
    x = np.array([float(f"{value}e-6") for value in RECORD])
    for joint, response in zip(result.joints, result.histories, strict=True):
        np.testing.assert_array_equal(response.displacement, x)
        np.testing.assert_array_equal(response.force, joint.force(x))
    notes = " ".join(result.summary["notes"])
    assert "8 values from record.csv" in notes
    entry = result.summary["joints"][1]["history"]
    assert entry == {
        "largest_displacement": 3e-6,
        "largest_force": abs(result.histories[1].force).max(),
        "dissipated_energy": result.histories[1].dissipated_energy[-1],
    }


def test_a_history_of_forces_is_held_by_displacements(record: Path) -> None:
    text = with_history("T", "force").replace(LOADS, '["1 kN", "2 kN"]')
    result = ms.Study.from_toml(text, folder=record).run()
    forces = 100.0 * np.array(RECORD)
    for joint, response in zip(result.joints, result.histories, strict=True):
        np.testing.assert_array_equal(response.force, forces)
        np.testing.assert_array_equal(response.displacement, joint.displacement(forces))
        again = joint.force(response.displacement)
        np.testing.assert_allclose(again, forces, rtol=0.0, atol=1e-10 * abs(forces).max())
    # The same energy whichever of the two is given.
    other = ms.Study.from_toml(with_history("x", "displacement"), folder=record).run()
    joint = other.joints[1]
    wanted = type(response).of(joint, result.histories[1].displacement, "displacement")
    np.testing.assert_allclose(
        result.histories[1].dissipated_energy,
        wanted.dissipated_energy,
        rtol=1e-9,
        atol=1e-12 * wanted.dissipated_energy[-1],
    )
