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
from microslip.figures.layout import lay_out
from microslip.figures.picture import PictureCache
from microslip.figures.plot import Marks
from microslip.report.html import page as html_page
from microslip.report.predicted.document import document
from microslip.report.predicted.figures import FIGURES, names
from microslip.report.predicted.preview import preview
from microslip.report.terminal import show
from microslip.runs.columns import VaryingLoop

LIFTING = ((SURFACE, SURFACES["sphere"]), (LOADS, '["10 N", "20 N"]'))
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


def test_an_amplitude_is_the_same_at_every_load() -> None:
    result = ms.Study.from_toml(varying('amplitude = "400 N"')).run()
    ends = [
        (cycles.smallest_normal_load[0], cycles.largest_normal_load[0]) for cycles in result.varying
    ]
    np.testing.assert_allclose(ends, [(100.0, 900.0), (1600.0, 2400.0)], rtol=1e-12)


def test_a_surface_with_an_end_may_lift_off() -> None:
    hard = ("poisson_ratio = 0.33", 'poisson_ratio = 0.33\nhardness = "1.2 GPa"')
    text = varying("share = 1.0", (SURFACE, SURFACES["sphere"]), (LOADS, '"20 N"'), hard)
    result = ms.Study.from_toml(text).run()
    (found,) = judged(result)  # yield is judged at the load that is farthest from none
    assert found["Hertz pressure over that of first yield"]["normal_load"] == 40.0
    loop = result.loops[0][0]
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
    assert preview(result.study).data["files"] == summary["files"]


def page(result: ms.Result) -> str:
    return html_page(document(result), PictureCache())


def test_the_report_names_the_load_of_each_number(home: Path) -> None:
    html = page(ms.Study.from_toml(varying('amplitude = "100 N", phase = "-90 deg"')).run())
    for text in (
        "<h3>Cycles at constant load</h3>",
        "<h3>Cycles as the normal load varies</h3>",
        "±100 N, phase −90°, harmonic 1",
        "The normal load varies over these cycles about the one named: ±100 N, phase −90°, ",
        "every loop at constant load follows",
        "filled markers are the loops, under a load that varies about the one named; hollow ones ",
        "Lines and hollow markers are at constant normal load.",
        "All this is at constant normal load.",
        "each verdict is the worse of those at its smallest and at its largest value.",
        "! watch</span> at 2 kN, as it grows to 2.1 kN</td><td>real over",
        "at 500 N, as it grows to 600 N and 2 kN, as it grows to 2.1 kN</td><td>contact radius",
        "at 500 N, as it falls to 400 N and 2 kN, as it falls to 1.9 kN</td><td>contacts",
        "✓ ok</span></td><td>density × radius × std",
    ):
        assert text in html, text
    assert "markers are the loops." not in html
    plain = page(ms.Study.from_toml(edited()).run())
    assert "<h2>Cycles</h2>" in plain
    assert "markers are the loops." in plain
    for word in ("varies", "constant normal load", "worse"):
        assert word not in plain
    replay = page(ms.Study.from_toml(replayed(), folder=home).run())
    assert "The normal load starts from that of the joint and follows the file." in replay
    assert "All this is at constant normal load." in replay


def legend(result: ms.Result, name: str) -> str:
    return FIGURES[name](result).legend_title


def test_the_figures_show_the_load(home: Path) -> None:
    result = ms.Study.from_toml(replayed(), folder=home).run()
    labels = [panel.y.label for panel in FIGURES["history"](result).panels]
    assert "Normal load [kN]" in labels
    assert legend(result, "history") == "Normal load, starts at"
    assert {legend(result, name) for name in names(result) if name != "history"} == {
        "Constant normal load"
    }
    result = ms.Study.from_toml(varying('share = 0.4, phase = "-30 deg", harmonic = 2')).run()
    loops = FIGURES["loops"](result)
    assert loops.panels[0].title == "Amplitude 0.1 µm, load varies"
    how = "varies by ±40 %, phase −30°, harmonic 2"
    assert legend(result, "loops") == f"Mean normal load, which {how}"
    assert {legend(result, name) for name in names(result) if name != "loops"} == {
        "Constant normal load"
    }
    plain = ms.Study.from_toml(edited()).run()
    assert {legend(plain, name) for name in names(plain)} == {"Normal load"}


@pytest.mark.parametrize(
    ("name", "column"), [("energy_damping", "amplitude"), ("force_damping", "force_amplitude")]
)
def test_loops_under_a_varying_load_are_marked_beside_those_at_constant_load(
    name: str, column: str
) -> None:
    """Filled markers, so the figure does not say that the loops lose what they do not."""

    def filled(result: ms.Result, panel: int) -> list[np.ndarray]:
        items = FIGURES[name](result).panels[panel].items
        return [
            np.column_stack([item.x, item.y])
            for item in items
            if isinstance(item, Marks) and item.filled
        ]

    result = ms.Study.from_toml(varying('share = 1.0, phase = "90 deg"', *LIFTING)).run()
    for panel, quantity in enumerate(("dissipated_energy", "loss_factor")):
        axes = lay_out(FIGURES[name](result)).frames[panel]
        found = filled(result, panel)
        for cycles, points in zip(result.varying, found, strict=True):
            unit = 1e-6 if column == "amplitude" else 1.0
            x, y = getattr(cycles, column) / unit, getattr(cycles, quantity)
            np.testing.assert_allclose(points, np.column_stack([x, y]), rtol=1e-12)
            for values, (low, high) in ((x, axes.x[:2]), (y, axes.y[:2])):
                assert low < values.min()
                assert values.max() < high
    note = FIGURES[name](result).panels[0].note
    assert note == "hollow: constant load, filled: load varies by ±100 %, phase 90°, harmonic 1"
    plain = ms.Study.from_toml(edited(*LIFTING)).run()
    assert filled(plain, 0) == []
    assert FIGURES[name](plain).panels[0].note == ""


# -- verdicts ------------------------------------------------------------------------------------

SHARE, COUNT = "real over apparent area", "contacts"


def judged(result: ms.Result) -> list[dict[str, dict[str, object]]]:
    return [{v["name"]: v for v in joint["validity"]} for joint in result.summary["joints"]]


def at(joint: ms.Interface, load: float) -> dict[str, ms.friction.Verdict]:
    return {verdict.name: verdict for verdict in joint.at(normal_load=load).validity}


def test_verdicts_are_those_of_the_worse_end_of_the_cycle(tmp_path: Path) -> None:
    """At 0.6 kN the joint is fine, at 1.17 kN, where its cycle goes, it is not."""
    numbers = ('formats = ["csv"]', 'formats = ["netcdf"]\nreport = false')
    text = varying("share = 0.95", (LOADS, '["4 N", "0.6 kN"]'), numbers)
    result = ms.Study.from_toml(text).run()
    light, heavy = judged(result)
    for found, load, name, word, worst in (
        (heavy, 600.0, SHARE, "watch", 1170.0),
        (heavy, 600.0, COUNT, "ok", 30.0),
        (light, 4.0, COUNT, "outside", 0.2),
        (light, 4.0, SHARE, "ok", 7.8),
    ):
        verdict, joint = found[name], result.joints[0]
        assert verdict["normal_load"] == pytest.approx(worst, rel=1e-12)
        same = at(joint, worst)[name]
        assert (verdict["word"], same.word) == (word, word)
        assert verdict["value"] == pytest.approx(same.value, rel=1e-9)
        assert at(joint, load)[name].word == "ok"
        assert verdict["limit"] == same.limit
    assert heavy["density * radius * std"]["normal_load"] is None
    assert [
        {v["name"]: v for v in entry["validity"]} for entry in preview(result.study).data["joints"]
    ] == [light, heavy]
    result.save(tmp_path / "result")
    with h5py.File(tmp_path / "result" / "result.nc") as file:
        name = "validity_real_over_apparent_area"
        assert file[name][:].tolist() == [light[SHARE]["value"], heavy[SHARE]["value"]]
        assert file[f"{name}_word"][:].tolist() == [0, 1]
        np.testing.assert_allclose(file[f"{name}_normal_load"][:], [7.8, 1170.0], rtol=1e-12)
        assert file[f"{name}_normal_load"].attrs["units"] in ("N", b"N")
        assert np.isnan(file["validity_density_radius_std_normal_load"][:]).all()


def test_verdicts_are_those_of_the_worse_load_of_a_history(tmp_path: Path) -> None:
    record = "x [um],N [kN]\n0,1\n0.4,20\n-0.2,0.001\n"
    (tmp_path / "record.csv").write_text(record, encoding="utf-8")
    result = ms.Study.from_toml(replayed(), folder=tmp_path).run()
    for found in judged(result):
        assert (found[SHARE]["word"], found[SHARE]["normal_load"]) == ("outside", 20_000.0)
        assert (found[COUNT]["word"], found[COUNT]["normal_load"]) == ("outside", 1.0)
        assert found[COUNT]["value"] == at(result.joints[0], 1.0)[COUNT].value


def test_the_load_of_the_joint_counts_where_a_history_stays_away_from_it(tmp_path: Path) -> None:
    """The history starts there, and loops and curves are at it."""
    (tmp_path / "record.csv").write_text("x [um],N [N]\n0,40\n1,30\n", encoding="utf-8")
    text = replayed().replace(LOADS, '"20 kN"')
    (found,) = judged(ms.Study.from_toml(text, folder=tmp_path).run())
    assert (found[SHARE]["word"], found[SHARE]["normal_load"]) == ("outside", 20_000.0)


def test_without_contact_there_are_no_contacts() -> None:
    surface = SURFACE, SURFACES["values"]
    (found,) = judged(ms.Study.from_toml(varying("share = 1.0", surface, (LOADS, '"5 N"'))).run())
    assert (found[COUNT]["word"], found[COUNT]["value"]) == ("outside", 0.0)
    assert found[COUNT]["normal_load"] == 0.0


@pytest.mark.parametrize(
    ("loads", "lines"),
    [
        (
            '"5 kN"',
            ["real over apparent area at 5 kN, as it grows to 9.75 kN: 11.2 % (ok up to 1 %)"],
        ),
        (
            '["4 N", "5 kN"]',
            [
                "real over apparent area at 5 kN, as it grows to 9.75 kN: ",
                "contacts at 4 N, as it falls to 200 mN: 2.24 to ",
            ],
        ),
    ],
)
def test_the_terminal_says_at_which_load(loads: str, lines: list[str]) -> None:
    study = ms.Study.from_toml(varying("share = 0.95", (LOADS, loads)))
    for told in (document(study.run()), preview(study)):
        stream = io.StringIO()
        show(told, stream)
        for line in lines:
            assert line in stream.getvalue()


KEY = "excitation.load_variation"


NO_END = "this surface never lifts off: its heights, or the tail of its table, have no end"


def refusals(text: str, folder: Path | None = None) -> list[str]:
    """What check and predict say, each of which refuses."""
    said = []
    for act in (preview, ms.Study.run):
        with pytest.raises(ms.StudyError) as caught:
            act(ms.Study.from_toml(text, folder=folder))
        said.append(str(caught.value))
    return said


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ("share = 1.0", "share: wanted less than 1, such as 0.99, got 1: the load 500 N"),
        (
            'share = 1.0, phase = "33 deg"',
            "share: wanted less than 1, such as 0.99, got 1: the load 500 N",
        ),
        (
            'amplitude = "500 N"',
            "amplitude: wanted less than the normal load 500 N, got 500 N: the load 500 N",
        ),
    ],
)
@pytest.mark.parametrize("surface", ["gaussian", "exponential", "scipy", "tail"])
def test_where_heights_have_no_end_the_load_is_not_lost(
    how: str, message: str, surface: str
) -> None:
    edits = () if surface == "gaussian" else ((SURFACE, SURFACES[surface]),)
    text = varying(how, *edits, (LOADS, '["500 N", "700 N"]'))
    assert refusals(text) == [f"study: {KEY}.{message} would go down to 0 N ({NO_END})"] * 2


HIGHER = "or begin the table higher"


@pytest.mark.parametrize(
    ("loads", "how", "message"),
    [
        ('"3 kN"', "share = 0.8", f"share: the load 3 kN grows to 5.4 kN; write share = 0.333 or less, {HIGHER}"),
        ('["1 kN", "3 kN"]', 'amplitude = "1 kN"', ""),
        ('["2 kN", "3 kN"]', 'amplitude = "1.2 kN"', f'amplitude: the load 3 kN grows to 4.2 kN; write amplitude = "999 N" or less, {HIGHER}'),
        ('"4 kN"', "share = 0.1", f"share: the load 4 kN grows to 4.4 kN; write a lower joint.normal_load, {HIGHER}"),
    ],
)  # fmt: skip
def test_a_load_stays_within_its_table(loads: str, how: str, message: str) -> None:
    table = SURFACE, SURFACES["table"].replace('"2 kN"', '"4 kN"')
    text = varying(how, table, (LOADS, loads))
    if not message:
        preview(ms.Study.from_toml(text))
        ms.Study.from_toml(text).run()
        return
    name, _, rest = message.partition(": ")
    wanted = "wanted loads up to the first load of the table, 4 kN, but"
    assert refusals(text) == [f"study: {KEY}.{name}: {wanted} {rest}"] * 2


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("share", [0.5, 0.9999999, 1.0])
def test_check_refuses_what_predict_refuses(surface: str, share: float) -> None:
    text = varying(f"share = {share}", (SURFACE, SURFACES[surface]), (LOADS, '"20 N"'))
    study = ms.Study.from_toml(text)
    said = []
    for act in (preview, ms.Study.run):
        try:
            act(study)
        except ms.StudyError as error:
            said.append(str(error))
    assert len(set(said)) == (1 if said else 0)
    assert len(said) in (0, 2)
    assert bool(said) == (share == 1.0 and surface in ("exponential", "scipy", "tail"))


WRONG_RECORDS = [
    ("x [um],N [kN]\n0,1\n1,-0.2\n", "x", "displacement", "excitation.history.normal_load: record.csv: line 3, column \"N [kN]\": wanted a force of zero or more [N], got \"-0.2\""),
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
    said = "wanted loads above zero, got 0 N in row 2 of the numbers"
    assert (
        refusals(replayed(), tmp_path)
        == [f"study: excitation.history.normal_load: record.csv: {said} ({NO_END})"] * 2
    )
    table = SURFACES["table"].replace('"0 N"]', '"0 N"]\n')
    ms.Study.from_toml(replayed().replace(SURFACE, table), folder=tmp_path).run()


def test_a_record_stays_within_its_table(tmp_path: Path) -> None:
    (tmp_path / "record.csv").write_text("x [um],N [kN]\n0,1\n1,2.5\n", encoding="utf-8")
    text = replayed().replace(SURFACE, SURFACES["table"])
    said = "record.csv: wanted loads up to the first load of the table, 2 kN, got 2.5 kN in row 2"
    assert (
        refusals(text, tmp_path)
        == [f"study: excitation.history.normal_load: {said} of the numbers; begin the table higher"]
        * 2
    )
