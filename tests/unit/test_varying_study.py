"""Studies whose normal load varies: over the cycles of the loops, or along a history."""
# ruff: noqa: E501 - each message stands on one line

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path

import h5py
import numpy as np
import pytest
from studies import AMPLITUDES, CURVE, LOADS, SURFACE, SURFACES, edited

import microslip as ms
from microslip.study.preview import preview
from microslip.study.varying import VaryingLoop

ALL = ('formats = ["csv"]', 'formats = ["csv", "netcdf", "png"]')
ROWS = [(0.0, 0.0, 1.0), (0.4, 50.0, 1.5), (-0.2, -20.0, 0.7), (0.3, 80.0, 1.2), (-0.5, 0.0, 0.9)]
RECORD = "\n".join(["x [um],T [N],N [kN]", *(",".join(map(str, row)) for row in ROWS)])


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A folder with a record whose normal load was measured."""
    (tmp_path / "record.csv").write_text(RECORD, encoding="utf-8")
    return tmp_path


def varying(how: str, *edits: tuple[str, str]) -> str:
    return edited((CURVE, f"{CURVE}\nload_variation = {{ {how} }}"), *edits)


def replayed(column: str = "x", quantity: str = "displacement", loads: str = "N") -> str:
    history = f'file = "record.csv", column = "{column}", quantity = "{quantity}"'
    history += f', normal_load = {{ column = "{loads}" }}'
    return edited((CURVE, f"{CURVE}\nhistory = {{ {history} }}"))


@pytest.mark.parametrize(
    ("how", "share", "phase", "harmonic"),
    [
        ("share = 0.5", 0.5, 0.0, 1),
        ('share = 0.5, phase = "90 deg"', 0.5, math.pi / 2, 1),
        ('share = 0.3, phase = "-1.5 rad", harmonic = 2', 0.3, -1.5, 2),
        ('share = 0.3, phase = "30 deg", harmonic = 3', 0.3, math.pi / 6, 3),
    ],
)
def test_the_loops_are_the_settled_cycles_of_the_interface(
    how: str, share: float, phase: float, harmonic: int
) -> None:
    """Bit for bit the second cycle of coupled_response, which the third one repeats."""
    result = ms.Study.from_toml(varying(how)).run()
    given = result.study.excitation.load_variation
    assert given is not None
    assert given.phase == pytest.approx(phase, rel=1e-15)
    phase = given.phase  # the double nearest to the decimal number, which pi / 6 is not
    size = 1024 if harmonic < 3 else 2048
    longer = 2.0 * np.pi / size * (np.arange(3 * size + size // 4 + 1) % size)
    second = slice(size + size // 4, 2 * size + size // 4 + 1)
    angle = longer[: second.stop]
    for joint, loops, cycles in zip(result.joints, result.loops, result.varying, strict=True):
        load = joint.normal_load * (1.0 + share * np.sin(harmonic * angle + phase))
        for loop, amplitude in zip(loops, (1e-7, 1e-6), strict=True):
            assert isinstance(loop, VaryingLoop)
            found = joint.coupled_response(amplitude * np.sin(angle), normal_load=load)
            np.testing.assert_array_equal(loop.displacement, found.displacement[second])
            np.testing.assert_array_equal(loop.force, found.force[second])
            np.testing.assert_array_equal(loop.normal_load, load[second])
            third = joint.coupled_force(
                amplitude * np.sin(longer),
                normal_load=joint.normal_load * (1.0 + share * np.sin(harmonic * longer + phase)),
            )[-1 - size :]
            np.testing.assert_allclose(third, loop.force, rtol=0.0, atol=1e-12 * found.force.max())
            energy = found.dissipated_energy
            assert loop.dissipated_energy == energy[second.stop - 1] - energy[second.start]
            # The area of the polygon is the same but for its sampling.
            area = ms.Loop(loop.displacement, loop.force).dissipated_energy
            assert loop.dissipated_energy == pytest.approx(area, rel=1e-4)
        assert cycles.dissipated_energy[1] == loop.dissipated_energy
        assert cycles.force_amplitude[1] == loop.force_amplitude
        assert cycles.smallest_normal_load[1] == load.min()
        assert cycles.largest_normal_load[1] == load.max()


def test_what_is_at_constant_load_is_that_of_the_study_without_variation() -> None:
    plain = ms.Study.from_toml(edited()).run()
    result = ms.Study.from_toml(varying("share = 0.5")).run()
    assert plain.varying == ()
    for mine, other in ((result.rows, plain.rows), (result.curves, plain.curves)):
        for table, wanted in zip(mine, other, strict=True):
            for name, column in wanted.columns().items():
                np.testing.assert_array_equal(table.columns()[name], column)
    row, cycles = result.rows[1], result.varying[1]
    np.testing.assert_array_equal(
        cycles.energy_share, cycles.dissipated_energy / row.dissipated_energy
    )
    np.testing.assert_allclose(cycles.damping_ratio, cycles.loss_factor / 2.0, rtol=1e-15)
    ratio = cycles.dissipated_energy / (4.0 * cycles.amplitude * cycles.force_amplitude)
    np.testing.assert_array_equal(cycles.energy_ratio, ratio)


def test_a_vanishing_variation_is_the_constant_load() -> None:
    cycles = ms.Study.from_toml(varying("share = 1e-9")).run().varying[1]
    np.testing.assert_allclose(cycles.energy_share, 1.0, rtol=1e-5)


def test_out_of_phase_more_is_lost() -> None:
    """Putignano, Ciavarella and Barber (2011)."""
    energies = [
        ms.Study.from_toml(varying(f'share = 0.5, phase = "{phase} deg"')).run().varying[1]
        for phase in (0, 45, 90)
    ]
    lost = [cycles.dissipated_energy[0] for cycles in energies]
    assert lost == sorted(lost)
    assert lost[0] < lost[2] / 1.5


def test_an_amplitude_is_the_same_at_every_load() -> None:
    result = ms.Study.from_toml(varying('amplitude = "400 N"')).run()
    ends = [
        (cycles.smallest_normal_load[0], cycles.largest_normal_load[0]) for cycles in result.varying
    ]
    np.testing.assert_allclose(ends, [(100.0, 900.0), (1600.0, 2400.0)], rtol=1e-12)


def test_a_surface_with_an_end_may_lift_off() -> None:
    text = varying("share = 1.0", (SURFACE, SURFACES["sphere"]), (LOADS, '"20 N"'))
    loop = ms.Study.from_toml(text).run().loops[0][0]
    assert isinstance(loop, VaryingLoop)
    assert loop.normal_load.min() == 0.0
    assert loop.force[np.argmin(loop.normal_load)] == 0.0


@pytest.mark.parametrize(("column", "quantity"), [("x", "displacement"), ("T", "force")])
def test_a_history_is_replayed_under_its_loads(home: Path, column: str, quantity: str) -> None:
    result = ms.Study.from_toml(replayed(column, quantity), folder=home).run()
    x, force, loads = np.array([[f"{a}e-6", f"{b}", f"{c}e3"] for a, b, c in ROWS], float).T
    for joint, response in zip(result.joints, result.histories, strict=True):
        np.testing.assert_array_equal(response.varying_normal_load, loads)
        if quantity == "force":
            np.testing.assert_array_equal(response.force, force)
            wanted = joint.coupled_displacement(force, normal_load=loads)
            np.testing.assert_array_equal(response.displacement, wanted)
            energy = joint.coupled_response(force=force, normal_load=loads).dissipated_energy
        else:
            np.testing.assert_array_equal(response.displacement, x)
            np.testing.assert_array_equal(response.force, joint.coupled_force(x, normal_load=loads))
            energy = joint.coupled_response(x, normal_load=loads).dissipated_energy
        np.testing.assert_array_equal(response.dissipated_energy, energy)
    entry = result.summary["joints"][0]["history"]
    assert (entry["smallest_normal_load"], entry["largest_normal_load"]) == (700.0, 1500.0)
    notes = " ".join(result.summary["notes"])
    assert 'excitation.history.normal_load: 5 values from record.csv, column "N [kN]"' in notes
    assert "starts at displacement 0 under the normal load of each joint" in notes


def test_loads_that_do_not_vary_are_the_constant_load(home: Path) -> None:
    """With N constant both engines agree."""
    (home / "record.csv").write_text("x [um],N [kN]\n0,2\n0.4,2\n-0.2,2\n0.3,2\n", "utf-8")
    response = ms.Study.from_toml(replayed(), folder=home).run()
    joint, found = response.joints[1], response.histories[1]
    wanted = joint.force(found.displacement)
    np.testing.assert_allclose(found.force, wanted, rtol=0.0, atol=1e-12 * abs(wanted).max())


def test_the_files_read_back(home: Path) -> None:
    history = 'history = { file = "record.csv", column = "x", normal_load = { column = "N" } }'
    text = varying('share = 0.4, phase = "90 deg"', (AMPLITUDES, f"{AMPLITUDES}\n{history}"), ALL)
    result = ms.Study.from_toml(text, folder=home).run()
    result.save(home / "result")
    tables = {}
    for name in ("loops", "varying", "history", "curves"):
        with (home / "result" / f"{name}.csv").open(encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        tables[name] = dict(zip(head, np.array(rows, float).T, strict=True))
    flat = [loop for loops in result.loops for loop in loops]
    for column, name in (("varying_normal_load [N]", "normal_load"), ("force [N]", "force")):
        wanted = np.concatenate([getattr(loop, name) for loop in flat])
        np.testing.assert_array_equal(tables["loops"][column], wanted)
    energy = np.concatenate([cycles.dissipated_energy for cycles in result.varying])
    np.testing.assert_array_equal(tables["varying"]["dissipated_energy [J]"], energy)
    loads = [response.varying_normal_load for response in result.histories]
    np.testing.assert_array_equal(
        tables["history"]["varying_normal_load [N]"], np.concatenate(loads)
    )
    assert "varying_normal_load [N]" not in tables["curves"]
    with h5py.File(home / "result" / "result.nc") as file:
        np.testing.assert_array_equal(file["varying_dissipated_energy"][:].ravel(), energy)
        np.testing.assert_array_equal(
            file["varying_normal_load"][1, 0], result.loops[1][0].normal_load
        )
        np.testing.assert_array_equal(file["history_varying_normal_load"][:], np.stack(loads))
        assert file["varying_loss_factor"].attrs["units"] in ("1", b"1")
    summary = json.loads((home / "result" / "summary.json").read_text(encoding="utf-8"))
    row = summary["joints"][1]["varying"][0]
    assert row["dissipated_energy"] == result.varying[1].dissipated_energy[0]
    assert summary["study"]["excitation"]["load_variation"] == {
        "share": 0.4, "phase": math.radians(90.0), "harmonic": 1
    }  # fmt: skip
    assert any(note.startswith("excitation.load_variation: the loops") for note in summary["notes"])
    assert preview(result.study)["files"] == summary["files"]


def test_the_report_says_what_is_at_which_load(home: Path) -> None:
    from microslip.study.report import page

    html = page(ms.Study.from_toml(varying('amplitude = "100 N", phase = "-90 deg"')).run())
    for text in (
        "<h2>Cycles at constant load</h2>",
        "<h2>Cycles as the normal load varies</h2>",
        "±100 N, phase −90°, harmonic 1",
        "The normal load varies over these cycles.",
        "All this is at constant normal load.",
    ):
        assert text in html, text
    plain = page(ms.Study.from_toml(edited()).run())
    assert "<h2>Cycles</h2>" in plain
    assert "varies" not in plain


def test_the_figures_show_the_load(home: Path) -> None:
    from microslip.study.figures import DRAW

    result = ms.Study.from_toml(replayed(), folder=home).run()
    labels = [axes.get_ylabel() for axes in DRAW["history"](result).axes]
    assert "Normal load [kN]" in labels
    loops = DRAW["loops"](ms.Study.from_toml(varying("share = 0.4")).run())
    assert loops.axes[0].get_title() == "Amplitude 0.1 µm, load varies"


KEY = "excitation.load_variation"
ANGLE = f'{KEY}.phase: wanted an angle such as "90 deg", got '
SIZES = 'wanted amplitude = "400 N" or share = 0.2, one of them, got'
WRONG = [
    ("", f"{KEY}: {SIZES} neither"),
    ('share = 0.2, amplitude = "100 N"', f"{KEY}: {SIZES} both"),
    ("amplitude = 0.2", f'{KEY}.amplitude: wanted a force such as "2 kN", got 0.2 (a number without a unit)'),
    ('amplitude = "600 N"', f"{KEY}.amplitude: wanted at most the normal load 500 N, got 600 N (the load would go below zero)"),
    ("share = 1.2", f"{KEY}.share: wanted a number above 0 and at most 1 such as 0.2, got 1.2"),
    ("share = 0.2, phase = 90", f"{ANGLE}90 (a number without a unit)"),
    ('share = 0.2, phase = "90 N"', f'{ANGLE}"90 N" (a force)'),
    ('share = 0.2, phase = "90 %"', f'{ANGLE}"90 %" (wanted in deg or rad)'),
    ('share = 0.2, phase = "400 deg"', f'{ANGLE}"400 deg" (more than a turn)'),
    ("share = 0.2, harmonic = 0", f"{KEY}.harmonic: wanted a whole number from 1 to 10, such as 2, got 0"),
    ("share = 0.2, harmonic = 1.5", f"{KEY}.harmonic: wanted a whole number from 1 to 10, such as 2, got 1.5"),
    ("share = 0.2, fase = 1", f'{KEY}.fase: unknown key; did you mean "phase"?'),
]  # fmt: skip


@pytest.mark.parametrize(("how", "message"), WRONG)
def test_a_wrong_variation(how: str, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(varying(how))
    assert str(caught.value) == f"study: {message}"


def test_a_variation_goes_with_displacements() -> None:
    text = varying("share = 0.2", (f"amplitudes = {AMPLITUDES}", 'force_amplitudes = ["50 N"]'))
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text)
    assert str(caught.value) == (
        "study: excitation.load_variation: wanted with displacement amplitudes, got "
        "force_amplitudes; remove one (under force control a load that varies can make a joint "
        "ratchet: no closed loop)"
    )


@pytest.mark.parametrize("phase", ["0 deg", "33 deg"])
def test_where_heights_have_no_end_the_load_is_not_lost(phase: str) -> None:
    study = ms.Study.from_toml(varying(f'share = 1.0, phase = "{phase}"'))
    with pytest.raises(ms.StudyError) as caught:
        study.run()
    assert str(caught.value) == (
        "study: excitation.load_variation: normal_load must stay above zero on this surface, whose "
        "heights have no end: at any separation some summit touches; got 0 at sample 0"
    )


WRONG_RECORDS = [
    ("x [um],N [kN]\n0,1\n1,-0.2\n", "x", "displacement", "excitation.history.normal_load: record.csv: wanted loads of zero or more, got -200 N in row 2 of the numbers"),
    ("x [um],load [kN]\n0,1\n1,1\n", "x", "displacement", 'excitation.history.normal_load: record.csv: no column "N"; the columns are "x [um]" and "load [kN]"'),
    ("x [um],N\n0,1\n1,1\n", "x", "displacement", 'excitation.history.normal_load: record.csv: column "N": no unit; write it in the header, such as "[N]", or unit = "N"'),
    ("x [um],N [um]\n0,1\n1,1\n", "x", "displacement", 'excitation.history.normal_load: record.csv: column "N [um]": wanted a unit such as "N", got "um" (a length)'),
    ("T [N],N [kN]\n0,1\n300,0.5\n", "T", "force", "excitation.history: record.csv: wanted forces within the force limit, ±275 N in row 2 of the numbers, got 300 N"),
]  # fmt: skip


@pytest.mark.parametrize(("record", "column", "quantity", "message"), WRONG_RECORDS)
def test_a_wrong_record(
    tmp_path: Path, record: str, column: str, quantity: str, message: str
) -> None:
    (tmp_path / "record.csv").write_text(record, encoding="utf-8")
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(replayed(column, quantity), folder=tmp_path)
    assert str(caught.value) == f"study: {message}"


def test_a_record_without_load_needs_a_surface_with_an_end(tmp_path: Path) -> None:
    (tmp_path / "record.csv").write_text("x [um],N [kN]\n0,1\n1,0\n", encoding="utf-8")
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(replayed(), folder=tmp_path).run()
    assert str(caught.value) == (
        "study: excitation.history: normal_load must stay above zero on this surface, whose "
        "heights have no end: at any separation some summit touches; got 0 at sample 1"
    )


def test_the_terminal_shows_both_loads() -> None:
    from microslip.study.tables import show

    stream = io.StringIO()
    show(ms.Study.from_toml(varying("share = 0.5")).run().summary, stream)
    text = stream.getvalue()
    assert "Cycles at constant load\n" in text
    assert "Cycles as the load varies\n" in text
    assert "250 N – 750 N" in text
    assert "the loops are settled cycles under a normal load that varies about N by 50 %" in text
