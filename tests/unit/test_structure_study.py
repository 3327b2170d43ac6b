"""A bolted structure in a study: what it answers, what it refuses, what its files hold."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from laps import DENSITY, STEEL, STRIP, small_lap

import microslip as ms
from microslip.figures.plot import Area
from microslip.report.document import Verdicts
from microslip.report.predicted.document import prediction_document
from microslip.report.predicted.preview import preview
from microslip.report.structure.judged import structure_verdicts
from microslip.report.structure.pictures import shape_plot
from microslip.study.build import build_surface
from microslip.study.new import template
from microslip.study.runs.structure_prediction import ForcedMode
from microslip.study.uncertain import at_central_values

STUDY = STRIP
for _plain, _changed in (
    ("= 0.35", "= { low = 0.1, high = 0.6 }"),
    ("base_damping", 'amplitude = { from = "0.1 um", to = "10 um", points = 3 }\nbase_damping'),
    (
        "samples = 32",
        'samples = 16\nform = { file = "form.csv", factor = { low = 0.0, high = 1.0 } }\n'
        'measured = { file = "test.csv" }',
    ),
    ('tension = "5 kN"', 'tension = { mean = "5 kN", cv = 0.15 }'),
):
    STUDY = STUDY.replace(_plain, _changed)
KNOWN = (
    ("{ low = 0.1, high = 0.6 }", "0.35"),
    ('{ mean = "5 kN", cv = 0.15 }', '"5 kN"'),
    ('form = { file = "form.csv", factor = { low = 0.0, high = 1.0 } }\n', ""),
    ('measured = { file = "test.csv" }\n', ""),
)


def text_of(*changes: tuple[str, str]) -> str:
    """The study with some of its text changed."""
    text = STUDY
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return text


FORM = "x [mm],y [mm],gap [um]\n" + "".join(
    f"{x},{y},{1e-3 * x * x}\n" for x in range(-15, 16, 5) for y in (-10, 0, 10)
)
TEST = "amplitude [um],frequency [Hz],damping_ratio [%]\n1,900,0.08\n10,899,0.11\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study with its files."""
    folder = tmp_path_factory.mktemp("strip")
    (folder / "strip.toml").write_text(STUDY, encoding="utf-8")
    (folder / "form.csv").write_text(FORM, encoding="utf-8")
    (folder / "test.csv").write_text(TEST, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def result(folder: Path) -> ms.Result:
    """It, run once."""
    return ms.Study.load(folder / "strip.toml").run()


@pytest.fixture(scope="module")
def drawn() -> ms.ReducedJoint:
    """The strip of the study by the library."""
    return small_lap().reduce(
        ms.Material.named("steel"), DENSITY, (3, 2), element_size=0.012,
        sensors={"sensor": ((0.1, 0.0, 0.0), "z")},
    )  # fmt: skip


def test_verdicts_cover_all_that_the_report_shows(result: ms.Result) -> None:
    structure = result.structure
    assert structure is not None
    (block,) = [s.blocks[0] for s in prediction_document(result).sections if s.title == "Validity"]
    assert isinstance(block, Verdicts)
    words = {verdict.name: verdict.word for verdict in block.verdicts}
    points = sum(verdict.points for verdict in structure.judged)
    beyond = sum(verdict.above + verdict.below for verdict in structure.judged)
    outside = next(v for v in block.verdicts if v.name == "points of tests outside the bands")
    assert outside.value == pytest.approx(beyond / points)
    assert (outside.word == "ok") == (beyond == 0)
    assert words["amplitudes without a solution"] == "ok"
    assert words["error of patches"] in ("ok", "watch", "outside")  # by merged patches
    assert result.summary["structure"]["verdicts"][0]["name"] == block.verdicts[0].name
    assert prediction_document(result).word != "ok"
    # A response that moves beyond the amplitudes, and a test that no lap has.
    (mode,), (test,) = structure.modes, structure.tests
    empty = np.full(2, math.nan)
    forced = ForcedMode(
        9.0, np.ones(1), np.ones(1), empty, None, None, math.nan, math.nan, 1.0
    )  # fmt: skip
    wrong = replace(
        structure, modes=(replace(mode, forced=(forced,)),),
        tests=(replace(test, frequency=np.full(test.frequency.shape, 1e5)),),
    )  # fmt: skip
    judged = {v.name: v.word for v in structure_verdicts(wrong)}
    assert judged["forced responses beyond the amplitudes"] == "outside"
    assert judged["points of tests beyond open and tied laps"] == "outside"


@pytest.mark.slow
def test_curves_are_those_of_the_library(
    result: ms.Result, folder: Path, drawn: ms.ReducedJoint
) -> None:
    structure = result.structure
    assert structure is not None
    mode = structure.modes[0]
    form = np.loadtxt(folder / "form.csv", delimiter=",", skiprows=1) * [1e-3, 1e-3, 1e-6]
    state = drawn.with_form(form, 0.5).tightened(result.joints[0].surface, 0.35)
    curve = state.modes(0, [1e-7, 1e-6, 1e-5], at=drawn.sensor("sensor"), damping_ratio=5e-4)
    np.testing.assert_allclose(mode.curve.frequency, curve.frequency, rtol=1e-9)
    np.testing.assert_allclose(mode.curve.damping_ratio, curve.damping_ratio, rtol=1e-6)
    np.testing.assert_allclose(state.normal_loads.sum(), 5e3, rtol=1e-9)


def test_bands_hold_what_was_drawn_and_inputs_are_ranked(result: ms.Result) -> None:
    assert result.structure is not None
    mode = result.structure.modes[0]
    assert mode.bands is not None
    low, middle, high = mode.bands.damping_ratio
    assert (low < middle).all()
    assert (middle < high).all()
    assert (low >= 0.99 * 5e-4).all(), "base damping is in all of them"
    names, shares = zip(*mode.bands.ranking, strict=True)
    assert set(names) == {"friction coefficient", "bolt tension", "factor on the form"}
    assert math.isclose(sum(shares), 1.0)
    assert list(shares) == sorted(shares, reverse=True)


@pytest.fixture(scope="module")
def ring(folder: Path) -> Path:
    """A ring-down of one mode."""
    time = np.arange(0.0, 0.1, 1e-4 / 3.0)
    decay = np.exp(-5.0 * time) * np.cos(2.0 * np.pi * 900.0 * time)
    rows = "".join(f"{t:.9g},{x:.9g}\n" for t, x in zip(time, decay, strict=True))
    (folder / "hammer.csv").write_text("time [s],displacement [um]\n" + rows, encoding="utf-8")
    return folder / "hammer.csv"


def run(*words: str | Path) -> Any:
    from click.testing import CliRunner

    from microslip.cli import main

    return CliRunner().invoke(main, [str(word) for word in words])


def test_a_band_is_for_ring_downs(folder: Path, ring: Path) -> None:
    table, band = folder / "test.csv", "700..1100 Hz"
    outcome = run("measure", table, "--band", band)
    assert outcome.exit_code == 2
    assert "band is for a ring-down, this is a curve" in outcome.stderr
    outcome = run("measure", ring, "--band", band, "--json")
    assert outcome.exit_code == 0, outcome.output
    (test,) = json.loads(outcome.stdout)["tests"]
    np.testing.assert_allclose(test["modal_frequency"], 900.0, rtol=1e-3)
    # A filter hears the ends of the signal: 6 % there, 1e-3 between.
    wanted = 5.0 / (2.0 * np.pi * 900.0)
    np.testing.assert_allclose(test["modal_damping_ratio"], wanted, rtol=0.1)
    np.testing.assert_allclose(test["modal_damping_ratio"][2:-2], wanted, rtol=5e-3)


def test_the_copy_of_a_study_finds_its_tests(folder: Path, tmp_path: Path) -> None:
    text = STUDY.replace("measured = {", "measured = [{").replace('"test.csv" }', '"test.csv" }]')
    study = ms.Study.from_toml(text, folder=folder)
    again = ms.Study.from_toml(study.text_for(tmp_path), folder=tmp_path)
    assert again.structure is not None
    np.testing.assert_array_equal(again.structure.measured[0].test.frequency, [900.0, 899.0])


@pytest.mark.slow
def test_a_study_tells_how_good_its_model_is(folder: Path) -> None:
    text = text_of(
        *KNOWN[:2], KNOWN[3], ("samples = 16", "converge = true"),
        ("patches = [3, 2]", "patches = [2, 1]"), ("{ low = 0.0, high = 1.0 }", "0.5"),
    )  # fmt: skip
    shares: list[float] = []
    result = ms.Study.from_toml(text, folder=folder).run(shares.append)
    assert shares == sorted(shares)
    assert sum(0.2 < share < 0.5 for share in shares) > 5  # while its patches are refined
    assert result.structure is not None
    found, mode = result.structure.convergence, result.structure.modes[0]
    assert found is not None
    assert found.joint.patches == result.structure.joint.patches > 2
    np.testing.assert_allclose(mode.curve.modal_amplitude[-1], found.curve.amplitude[-1], rtol=0.1)
    (section,) = [
        s for s in prediction_document(result).sections if s.title == "Convergence of the model"
    ]
    table, note = section.blocks
    assert {row[0] for row in table.data.rows()} >= {"kept modes", "harmonics"}
    assert note.text == f"{found.message}."
    told = result.summary["structure"]["convergence"]
    assert mode.bands is None
    assert json.dumps(told, allow_nan=False)


# ruff: noqa: E501
MESH = """sensor = { at = ["0.1 m", "0 m", "0 m"], direction = "z" }

[structure.mesh]
file = "strip.inp"
unit = "mm"
bodies = ["left", "right", "bolts", "heads"]
contacts = [["low face", "high face"]]
bolts = ["bolt 1"]
along = [1, 0, 0]

[structure.bolts]
tension = { mean = "5 kN", cv = 0.15 }
"""


def meshed() -> str:
    """The study with a mesh in place of its drawing, without form and test."""
    head = STUDY.partition("[structure.bolts]")[0].split("\n")
    drawn = ("length", "width", "thickness", "lap =", "element_size", "form", "measured")
    text = "\n".join(line for line in head if not line.startswith(drawn))
    return (
        text.replace("{ low = 0.1, high = 0.6 }", "0.35").replace("samples = 16", "samples = 8")
        + MESH
    )


@pytest.fixture(scope="module")
def with_mesh(folder: Path) -> Path:
    """The mesh of the drawing in a file of its own, in millimetres."""
    meshio = pytest.importorskip("meshio")
    mesh = small_lap().mesh(STEEL, DENSITY, element_size=0.012)
    (contact,) = mesh.contacts
    sets = {part.name: [part.cells] for part in (*mesh.bodies, *mesh.shanks)}
    nodes = {"low face": np.unique(contact.lower), "high face": np.unique(contact.upper)}
    meshio.Mesh(
        1e3 * mesh.points, [("hexahedron", mesh.cells)], cell_sets=sets, point_sets=nodes
    ).write(folder / "strip.inp")
    meshio.Mesh(1e3 * mesh.points, [("hexahedron", mesh.cells)]).write(folder / "nameless.vtk")
    return folder


def test_the_template_of_a_mesh_is_a_study_within_the_limits(with_mesh: Path) -> None:
    text = template("mesh", name="mesh.toml")
    names = {
        "parts.msh": "strip.inp", '["lower", "upper", "bolt"]': '["left", "right", "bolts", "heads"]',
        "lower face": "low face", "upper face": "high face", '"shank"': '"bolt 1"',
        "[structure.mesh]": "patches = [3, 2]\n[structure.mesh]",
    }  # fmt: skip
    for old, new in names.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    assert preview(ms.Study.from_toml(text, "mesh.toml", folder=with_mesh)).word == "ok"


@pytest.mark.slow
def test_a_mesh_of_ones_own_is_predicted_as_its_drawing_is(
    with_mesh: Path, tmp_path: Path, drawn: ms.ReducedJoint
) -> None:
    # Discs stand for head, nut and washers of the drawing; their density gives them those masses.
    bodies = small_lap().mesh(STEEL, DENSITY, element_size=0.012).bodies
    densities = ", ".join(f'"{body.density!r} kg/m^3"' for body in bodies)
    text = meshed().replace('unit = "mm"', f'unit = "mm"\ndensities = [{densities}]')
    study = ms.Study.from_toml(text, "meshed.toml", folder=with_mesh)
    assert any("hexahedron cells from strip.inp" in note for note in study.notes)
    result = study.run()
    assert result.structure is not None
    (mode,), joint = result.structure.modes, result.structure.joint
    # The file holds ten digits of each place.
    np.testing.assert_allclose(joint.patch_areas, drawn.patch_areas, rtol=1e-6)
    state = drawn.tightened(result.joints[0].surface, 0.35)
    curve = state.modes(0, [1e-7, 1e-6, 1e-5], at=drawn.sensor("sensor"), damping_ratio=5e-4)
    np.testing.assert_allclose(mode.curve.frequency, curve.frequency, rtol=1e-5)
    np.testing.assert_allclose(mode.curve.damping_ratio, curve.damping_ratio, rtol=1e-4)
    face = 0.03 * 0.02 - 0.25 * math.pi * 0.0066**2
    np.testing.assert_allclose(result.joints[0].normal_load, 5e3 / face * 2e-4, rtol=1e-6)
    assert mode.bands is not None
    assert mode.bands.ranking == (("bolt tension", pytest.approx(1.0)),)
    ((x, y, diameter, contact),) = result.structure.part.holes
    np.testing.assert_allclose((x, y, diameter), (0.0, 0.0, 0.006), atol=1e-8)
    assert contact == 0
    result.save(tmp_path / "out")
    saved = (tmp_path / "out/study.toml").read_text(encoding="utf-8")
    assert '[["low face", "high face"]]' in saved
    assert sum(isinstance(item, Area) for item in shape_plot(result.structure).panels[0].items) > 20


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("strip.inp", "none.inp", "structure.mesh: none.inp: no such file"),
        ("along = [1, 0, 0]", "along = [0, 0, 1]", "structure.mesh.along: along must not be normal to the contact faces"),
        ("strip.inp", "nameless.vtk", "structure.mesh: nameless.vtk: has no names; name its volumes and faces"),
        ('unit = "mm"', "", "structure.mesh: strip.inp: reaches over 200 m; if it is in millimetres, write unit = "),
        ('unit = "mm"', 'materials = ["steel"]', "structure.mesh.materials: wanted one per body, 4 in all, got 1"),
        ('unit = "mm"', 'unit = "mm"\nmaterials = ["steel", "steel", "stel", "steel"]', "structure.mesh.materials, item 3: wanted a metal of the table"),
        ('density = "7800 kg/m^3"', 'length = "1 m"', "structure.length: wanted only without structure.mesh"),
        ('tension = { mean = "5 kN", cv = 0.15 }', 'size = "M8"\ngrade = "8.8"\ntorque = "60 N m"\nnut_factor = 0.2',
         "structure: tension must be at most 2.07e+04 N, by a torque of 33.12 N m"),
        ('tension = { mean = "5 kN", cv = 0.15 }', 'grade = "8.8"\ntension = "5 kN"', "structure: grade needs the size of the bolts"),
        ('tension = { mean = "5 kN", cv = 0.15 }', 'torque = "6 N m"\nthread = "6 mm"\npitch = "1 mm"\nthread_friction = 0.1\nbearing_friction = 0.1',
         "structure: friction under the head needs the diameters of hole and head, or a size"),
    ],
)  # fmt: skip
def test_each_wrong_mesh_gets_its_own_line(
    old: str, new: str, message: str, with_mesh: Path
) -> None:
    assert old in meshed()
    with pytest.raises(ms.StudyError) as error:
        ms.Study.from_toml(meshed().replace(old, new), "strip.toml", folder=with_mesh)
    assert str(error.value).startswith(f"strip.toml: {message}"), str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.slow
def test_the_drawing_and_the_surface_of_a_structure_scatter(folder: Path) -> None:
    """Bending goes as the thickness; what else scatters is drawn and ranked with it."""
    text = text_of(
        *KNOWN, ("samples = 16", "samples = 8"),
        ('thickness = "12 mm"', 'thickness = { mean = "12 mm", cv = 0.05 }'),
        ('density = "50 1/mm^2"', 'density = { mean = "50 1/mm^2", cv = 0.1 }'),
    )  # fmt: skip
    result = ms.Study.from_toml(text, folder=folder).run()
    assert result.structure is not None
    (mode,) = result.structure.modes
    assert mode.bands is not None
    assert [name for name, _ in mode.bands.ranking] == ["surface.density", "structure.thickness"][
        :: -1 if mode.bands.ranking[0][0] == "structure.thickness" else 1
    ]
    low, middle, high = mode.bands.frequency[:, 0]
    # Quantiles of eight points, 5 % to 95 %: 2.6 standard deviations or so.
    assert math.log(high / low) == pytest.approx(2.6 * 0.05, rel=0.3)
    assert middle == pytest.approx(mode.curve.frequency[0], rel=0.02)


def known(*changes: tuple[str, str]) -> Any:
    """The structure of the study above, all of it known but for some changes."""
    result = ms.Study.from_toml(text_of(*KNOWN, *changes)).run()
    assert result.structure is not None
    return result.structure


@pytest.mark.slow
def test_samples_of_a_modulus_are_multiples_of_one_model() -> None:
    steel = '[material.mine]\nyoung_modulus = {}\npoisson_ratio = 0.3\n\n[surface]\nmaterials = ["mine", "mine"]'
    header = '[surface]\nmaterials = ["steel", "steel"]'
    uncertain = '{ values = ["160 GPa", "240 GPa"] }'
    bands = known((header, steel.format(uncertain))).modes[0].bands
    assert bands is not None
    low, high = (
        known((header, steel.format(f'"{e} GPa"'))).modes[0].curve.frequency for e in (160, 240)
    )
    # Curves of samples are solved to 1e-5 of the forces, from other starting points.
    np.testing.assert_allclose(bands.frequency[[0, 2]], [low, high], rtol=1e-6)


@pytest.mark.slow
def test_patches_unless_given_are_some_sixty() -> None:
    usual = known(
        ("patches = [3, 2]\n", ""), ('lap = "30 mm"', 'lap = "60 mm"'),
        ('element_size = "12 mm"', 'element_size = "4 mm"'),
    )  # fmt: skip
    assert usual.joint.patches == 60
    boxes = usual.joint.patch_boxes
    assert np.prod(boxes[:, 1::2] - boxes[:, ::2], axis=1).sum() == pytest.approx(0.06 * 0.02)


@pytest.mark.slow
def test_check_refuses_what_a_run_would_and_tells_what_it_takes(folder: Path) -> None:
    data = preview(ms.Study.load(folder / "strip.toml")).data["structure"]
    assert data["patches"] == 6
    assert data["balances"] == 17  # the middle and 16 samples of one mode
    assert data["reductions"] == 1
    factor, reduction, balance = data["measured"]
    assert min(data["measured"]) > 0.0
    # 17 curves as the one that was measured; the rest tabulates the law, once.
    low, high = data["seconds"]
    assert high == pytest.approx(1.6**2 * low)
    assert 1.6 * low > factor + reduction + 17 * balance
    assert 5000 < data["degrees_of_freedom"] < 40_000
    for change, message in (
        ('structure.sensor={at=["0.5 m","0 m","0 m"]}', r"\.sensor: .*must lie on the bodies"),
        ('structure.length="320 m"', r"limit of 10000; check the lengths 320 x 0\.02 x 0\.02"),
        ("structure.modes=[40]", r"\.modes, item 1.*: wanted a mode from 1 to 10.*, got 40"),
    ):
        with pytest.raises(ms.StudyError, match=message):
            preview(ms.Study.load(folder / "strip.toml", [change]))
    thick = ms.Study.load(folder / "strip.toml", ['structure.thickness={mean="12 mm",cv=0.05}'])
    assert preview(thick).data["structure"]["reductions"] == 17


FORCED = (
    ("samples = 16", 'samples = 64\nforce = { amplitude = ["0.3 N", "200 N"] }'),
    ('to = "10 um", points = 3', 'to = "30 um", points = 10'),
)


@pytest.mark.slow
def test_the_response_to_a_force_is_that_of_the_balance_of_harmonics() -> None:
    structure = known(*FORCED)
    (mode,) = structure.modes
    force, beyond = mode.forced
    joint, state = structure.joint, structure.state
    # Base damping as a dashpot in proportion to the mass, which damps this mode as much.
    base = 2.0 * 5e-4 * 2.0 * np.pi * mode.curve.linear_frequency * joint.mass
    held = ms.Structure(joint.mass, joint.stiffness, base)
    surface = build_surface(at_central_values(ms.Study.from_toml(text_of(*KNOWN))))
    field = joint.field(surface, 0.35)
    rest = held.attach(field, directions=joint.directions).preload(state.static_force)
    row = joint.sensor("sensor")
    near = np.linspace(0.99, 1.004, 15) * force.peak[1]
    whole = rest.forced_response(0.3 * row, near)
    amplitude = whole.amplitude(row)
    place = int(amplitude.argmax())
    assert amplitude[place] == pytest.approx(force.peak[0], rel=0.02)
    assert whole.frequency[place] == pytest.approx(force.peak[1], rel=1e-3)
    told = np.interp(whole.frequency, force.frequency, force.response)
    lasting = whole.stable & (abs(whole.frequency / force.peak[1] - 1.0) > 2e-3)
    np.testing.assert_allclose(told[lasting], amplitude[lasting], rtol=0.04)
    assert np.isnan(beyond.peak).all()
    assert 0.3 < beyond.largest_force < 200.0


@pytest.mark.slow
def test_samples_that_all_move_beyond_the_amplitudes_have_no_band(folder: Path) -> None:
    text = text_of(("samples = 16", 'samples = 8\nforce = { amplitude = "1 kN" }'))
    result = ms.Study.from_toml(text, folder=folder).run()
    (forced,) = result.structure.modes[0].forced
    assert (forced.beyond, forced.bands, forced.peak_bands) == (1.0, None, None)
    (found,) = result.summary["structure"]["modes"][0]["forced_response"]
    assert found["beyond"] == 1.0
    assert "sampling_error" not in found
    assert "Not covered: forced responses" in prediction_document(result).answer


def test_wrong_structures_get_a_line(folder: Path) -> None:
    """Rules between keys: bolts in the lap, their tension and torque, harmonics, modes of tests."""
    tension = 'tension = { mean = "5 kN", cv = 0.15 }'
    for old, new, message in (
        ('positions = ["0 mm"]', 'positions = ["40 mm"]', "bolt 1 at .* lies outside the lap"),
        (tension, 'torque = "8 N m"', "a torque needs the nominal diameter of the thread"),
        (tension, "", "bolts need their tension"),
        ('file = "test.csv"', 'file = "test.csv", mode = 3', "wanted one of structure.modes"),
        ("samples = 16", "harmonics = [0, 2]", "harmonics must include 1"),
    ):
        with pytest.raises(ms.StudyError, match=message):
            ms.Study.from_toml(STUDY.replace(old, new), folder=folder)
