"""Studies whose load is spread unevenly: keys, figures, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from studies import LOADS, edited

import microslip as ms
from microslip.figures.plot import Line
from microslip.report.predicted.document import prediction_pictures
from microslip.report.predicted.history_figure import pressure

CONE = (LOADS, f'{LOADS}\npressure = {{ kind = "cone", outer = "7 mm", inner = "2 mm" }}')
BOLT = '{ kind = "bolt", size = "M5", plates = ["3 mm", "4 mm"], count = 2, edge = "10 mm"'


def bolted(more: str) -> str:
    return edited((f"normal_load = {LOADS}", f"pressure = {BOLT}{more} }}"))


def test_a_study_equals_the_same_in_python() -> None:
    result = ms.Study.from_toml(edited(CONE)).run()
    surface = result.joints[0].surface
    for joint, load in zip(result.joints, (500.0, 2000.0), strict=True):
        wanted = ms.PressedJoint(surface, 0.55, ms.Pressure.cone(7e-3, 2e-3), load)
        assert joint.tangential_stiffness == wanted.tangential_stiffness
        assert joint.dissipated_energy(1e-7) == wanted.dissipated_energy(1e-7)
    said = result.summary["pressure"]
    assert said["kind"] == "cone"
    assert said["largest_pressure"] == float(result.joints[0].pressures.max())
    assert any(note.startswith("joint.pressure: cone, on ") for note in result.summary["notes"])
    judged = {item["name"]: item["value"] for item in result.summary["joints"][1]["validity"]}
    even = ms.Interface(surface, 0.55, normal_load=2000.0)
    area = {v.name: v.value for v in even.validity}["real over apparent area"]
    assert judged["real over apparent area"] > 1.5 * area  # where most presses
    shown = [picture.name for picture in prediction_pictures(result)]
    assert "pressure" in shown and "contact_state" not in shown  # noqa: PT018
    plot = pressure(result)
    lines = [item for item in plot.panels[0].items if isinstance(item, Line)]
    assert len(lines) == 2
    slips = [item.y for item in plot.panels[1].items if isinstance(item, Line)]
    assert len(slips) == 2
    assert np.all(np.diff(slips[0]) > 0.0)  # slip begins at the rim
    assert "pressure.svg" not in result.summary["files"]  # only CSV was asked for


def test_bolts_say_the_load() -> None:
    for more, load in (
        (', preload = "600 N"', 1200.0),
        (', torque = "2 N m"', 2 * 2.0 / (0.2 * 5e-3)),
        (', torque = "2 N m", nut_factor = 0.16', 2 * 2.0 / (0.16 * 5e-3)),
    ):
        study = ms.Study.from_toml(bolted(more))
        assert study.joint.normal_load == (pytest.approx(load, rel=1e-12),)
    frictions = ', torque = "2 N m", thread_friction = 0.12, bearing_friction = 0.12'
    by_vdi = ms.Study.from_toml(bolted(frictions)).joint.normal_load[0]
    # VDI 2230: M = F [0.16 P + 0.58 d2 mu_G + D_Km/2 mu_K].
    lever = 0.16 * 0.8e-3 + 0.58 * 4.48e-3 * 0.12 + 0.25 * (5.5e-3 + 6.88e-3) * 0.12
    assert by_vdi == pytest.approx(2 * 2.0 / lever, rel=0.01)
    joint = ms.Study.from_toml(bolted(', preload = "600 N"')).run().joints[0]
    assert joint.force_limit == pytest.approx(0.55 * 1200.0)


def test_columns(tmp_path: Path) -> None:
    (tmp_path / "film.csv").write_text("a [mm^2],p [MPa]\n10,30\n20,10\n5,0\n", encoding="utf-8")
    film = 'pressure = { kind = "patches", area = { file = "film.csv", column = "a" }, '
    film += 'pressure = { file = "film.csv", column = "p" } }'
    text = edited((LOADS, f"{LOADS}\n{film}"))
    joint = ms.Study.from_toml(text, folder=tmp_path).run().joints[1]
    assert joint.pressure.areas == pytest.approx([1e-5, 2e-5])
    assert joint.pressure.shares == pytest.approx([0.6, 0.4])
