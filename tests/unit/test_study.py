"""Study files: what is read, and the one line that each wrong one gets."""
# ruff: noqa: E501 - the messages are pinned as they are read, each on one line

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import pytest

import microslip as ms
from microslip.study import folder as folder_module
from microslip.study.units import (
    AREA,
    DENSITY,
    FORCE,
    LENGTH,
    PRESSURE,
    QuantityError,
    engineering,
    significant,
    to_si,
)

STUDY = """\
schema = 1
title = "A joint"

[material.al]
young_modulus = "69 GPa"
poisson_ratio = 0.33

[surface]
materials = ["al", "al"]
law = "greenwood-williamson"
heights = { kind = "gaussian", std = "0.5 um" }
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"

[joint]
friction_coefficient = 0.55
normal_load = ["500 N", "2 kN"]

[excitation]
amplitudes = ["0.1 um", "1 um"]
curve = { from = "1 nm", to = "100 um", points = 20 }

[output]
formats = ["csv"]
"""
AMPLITUDES = '["0.1 um", "1 um"]'
CURVE = '{ from = "1 nm", to = "100 um", points = 20 }'
GAUSSIAN = '{ kind = "gaussian", std = "0.5 um" }'
LOADS = '["500 N", "2 kN"]'
LAWS = '"greenwood-williamson", "population", "sphere" or "table"'


def edited(*edits: tuple[str, str]) -> str:
    text = STUDY
    for old, new in edits:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    return text


# What is replaced in the study, by what, and the message that follows.
WRONG = [
    # TOML
    ('title = "A', "title = A", "line 2, column 9: not TOML: invalid value (text and quantities stand in quotes)"),
    ("[output]", "[output", "line 24, column 8: not TOML: expected ']' at the end of a table declaration"),
    ("[output]", "[joint]", "line 24, column 7: not TOML: cannot declare [joint] twice"),
    ("schema = 1", "schema = 1\nschema = 1", "line 2, column 11: not TOML: this key is given twice"),
    ('["csv"]', '["csv"', "line 25, column 17: not TOML: unclosed array"),
    ("0.33", "0." + 5000 * "3" + "e", "line 6, column 5019: not TOML: expected newline or end of document after a statement"),
    ("0.33", "1" + 5000 * "0", "not a study: an integer of thousands of digits"),
    # keys
    ("schema = 1", "", "schema: missing; write for example schema = 1"),
    ("schema = 1", "schema = 2", "schema: wanted schema = 1, got 2"),
    ("schema = 1", "schema = true", "schema: wanted schema = 1, got true"),
    ('title = "A joint"', 'titel = "A joint"', 'titel: unknown key; did you mean "title"?'),
    ('title = "A joint"', "title = 3", "title: wanted one line of at most 200 characters, got 3"),
    ('title = "A joint"', 'title = "a\\nb"', 'title: wanted one line of at most 200 characters, got "a\\nb"'),
    ("[surface]", "[surfaces]", 'surfaces: unknown key; did you mean "surface"?'),
    ("[surface]", "[[surface]]", "surface: wanted a table [surface], got a list of 1"),
    ("[joint]", "[excitement]", 'excitement: unknown key; did you mean "excitation"? (and 1 more error)'),
    ("young_modulus", "youngs_modulus", 'material.al.youngs_modulus: unknown key; did you mean "young_modulus"?'),
    ('young_modulus = "69 GPa"', "", 'material.al.young_modulus: missing; write for example young_modulus = "69 GPa"'),
    ("young_modulus", "radius", 'material.al.young_modulus: missing; write for example young_modulus = "69 GPa" (and 1 more error)'),
    ("[material.al]", "[material]", 'material.young_modulus: wanted a table such as [material.steel] with young_modulus = "210 GPa" and poisson_ratio = 0.3, got "69 GPa" (and 1 more error)'),
    ("friction_coefficient = 0.55", 'friction_coefficient = 0.55\nradius = "1 mm"', 'joint.radius: unknown key here; it belongs in [surface] with law = "greenwood-williamson"'),
    ("friction_coefficient = 0.55", "friction_coefficient = 0.55\ncolour = 1", "joint.colour: unknown key; the keys here are friction_coefficient, normal_load"),
    ("schema = 1", 'schema = 1\nhardness = "1 GPa"', "hardness: unknown key here; it belongs in [material.NAME]"),
    ("heights =", "hights =", 'surface.hights: unknown key; did you mean "heights"?'),
    ("std", "sdt", 'surface.heights.sdt: unknown key; did you mean "std"?'),
    (GAUSSIAN, '"0.5 um"', 'surface.heights: wanted a table such as { kind = "gaussian", std = "0.5 um" }, got "0.5 um"'),
    # laws and kinds
    ('law = "greenwood-williamson"', "", f"surface.law: missing; wanted {LAWS}"),
    ("law =", "lwa =", 'surface.lwa: unknown key; did you mean "law"?'),
    ('"greenwood-williamson"', '"greenwod"', f'surface.law: wanted {LAWS}, got "greenwod"; did you mean "greenwood-williamson"?'),
    ('"greenwood-williamson"', "7", f"surface.law: wanted {LAWS}, got 7"),
    ('"greenwood-williamson"', '"sphere"', 'surface.heights: unknown key here; it belongs in [surface] with law = "greenwood-williamson" (and 2 more errors)'),
    ('"greenwood-williamson"', '"population"', 'surface.heights.kind: wanted "values", got "gaussian" (and 2 more errors)'),
    ('"gaussian"', '"gauss"', 'surface.heights.kind: wanted "gaussian", "exponential" or "values", got "gauss"; did you mean "gaussian"?'),
    ("kind", "knd", 'surface.heights.knd: unknown key; did you mean "kind"?'),
    (GAUSSIAN, '{ kind = "values", values = [] }', 'surface.heights.values: wanted a list such as ["0.4 um", "0.7 um"], got an empty list'),
    # materials
    ('["al", "al"]', '["al", "all"]', 'surface.materials, item 2: wanted "al", the materials of this file, got "all"; did you mean "al"?'),
    ('["al", "al"]', '["al"]', 'surface.materials: wanted the names of the two bodies such as ["steel", "steel"], got a list of 1'),
    ('["al", "al"]', '"al"', 'surface.materials: wanted the names of the two bodies such as ["steel", "steel"], got "al"'),
    ("poisson_ratio = 0.33", "rigid = true", "material.al.young_modulus: unknown key; a rigid material has no other"),
    ("poisson_ratio = 0.33", 'poisson_ratio = 0.3\nrigid = "no"', 'material.al.rigid: wanted true, got "no" (and 2 more errors)'),
    # plain numbers
    ("0.33", "0.7", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got 0.7"),
    ("0.33", "-1", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got -1"),
    ("0.33", "nan", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got nan"),
    ("0.33", '"0.33"', 'material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got "0.33"'),
    ("0.33", "true", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got true"),
    ("0.55", "-0.55", "joint.friction_coefficient: wanted a positive number such as 0.55, got -0.55"),
    ("0.55", "0", "joint.friction_coefficient: wanted a positive number such as 0.55, got 0"),
    ("0.55", "inf", "joint.friction_coefficient: wanted a positive number such as 0.55, got inf"),
    # quantities
    ('"69 GPa"', '"69 um"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69 um" (a length)'),
    ('"69 GPa"', "69e9", 'material.al.young_modulus: wanted a pressure such as "69 GPa", got 69000000000.0 (a number without a unit)'),
    ('"69 GPa"', '"69 gpa"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69 gpa" (unknown unit "gpa"; did you mean "GPa"?)'),
    ('"69 GPa"', '"-69 GPa"', 'material.al.young_modulus: wanted a positive pressure such as "69 GPa", got "-69 GPa"'),
    ('"69 GPa"', '"inf GPa"', 'material.al.young_modulus: wanted a finite pressure such as "69 GPa", got "inf GPa"'),
    ('"69 GPa"', "1979-05-27", 'material.al.young_modulus: wanted a pressure such as "69 GPa", got the date or time 1979-05-27'),
    ('"0.5 um"', '"0.5 GPa"', 'surface.heights.std: wanted a length such as "0.5 um", got "0.5 GPa" (a pressure)'),
    ('"0.5 um"', '"0.5"', 'surface.heights.std: wanted a length such as "0.5 um", got "0.5" (no unit)'),
    ('"0.5 um"', '"um"', 'surface.heights.std: wanted a length such as "0.5 um", got "um" (no number)'),
    ('"0.5 um"', '"0,5 um"', 'surface.heights.std: wanted a length such as "0.5 um", got "0,5 um" (the decimal sign is the point, ".")'),
    ('"0.5 um"', '"0 um"', 'surface.heights.std: wanted a positive length such as "0.5 um", got "0 um"'),
    ('"1 mm"', '"1e50 mm"', 'surface.radius: wanted a length such as "1 mm", got "1e50 mm" (beyond all measure)'),
    ('"1 mm"', '"1 mn"', 'surface.radius: wanted a length such as "1 mm", got "1 mn" (unknown unit "mn")'),
    ('"100 1/mm^2"', '"7800 kg/m^3"', 'surface.density: wanted a number per area such as "100 1/mm^2", got "7800 kg/m^3" (a mass per volume)'),
    ('"100 1/mm^2"', '"0 1/mm^2"', 'surface.density: wanted a positive number per area such as "100 1/mm^2", got "0 1/mm^2"'),
    ('"2 cm^2"', '"2 cm2"', 'surface.area: wanted an area such as "2 cm^2", got "2 cm2" (unknown unit "cm2"; did you mean "cm^2"?)'),
    ('"2 cm^2"', '"2 cm"', 'surface.area: wanted an area such as "2 cm^2", got "2 cm" (a length)'),
    (LOADS, '"2 KN"', 'joint.normal_load: wanted a force such as "2 kN", got "2 KN" (unknown unit "KN"; did you mean "kN"?)'),
    (LOADS, '["500 N", 2000]', 'joint.normal_load, item 2: wanted a force such as "2 kN", got 2000 (a number without a unit)'),
    # lists
    (LOADS, "[]", 'joint.normal_load: wanted a list such as ["500 N", "2 kN"], got an empty list'),
    (LOADS, '["1 kN", "2 kN", "1000 N"]', "joint.normal_load: wanted values that differ, got the same one as items 1 and 3"),
    (LOADS, "{ from = 3 }", 'joint.normal_load: wanted a list such as ["500 N", "2 kN"], got a table'),
    (AMPLITUDES, '["0.1 um", "0 um"]', 'excitation.amplitudes, item 2: wanted a positive length such as "1 um", got "0 um"'),
    (AMPLITUDES, '["0.1 um", ["1 um"]]', 'excitation.amplitudes, item 2: wanted a length such as "1 um", got a list of 1'),
    (AMPLITUDES, '"1 um"', 'excitation.amplitudes: wanted a list such as ["0.1 um", "1 um"], got "1 um"'),
    (AMPLITUDES, str(1001 * ["1 um"]), "excitation.amplitudes: wanted at most 1000 items, got 1001"),
    ('"100 um"', '"1 nm"', "excitation.curve.to: wanted more than `from` (1 nm), got 1 nm"),
    ('"1 nm"', '"1 m"', "excitation.curve.to: wanted more than `from` (1 m), got 100 µm"),
    ("points = 20", "points = 1", "excitation.curve.points: wanted a whole number from 2 to 1000000, such as 200, got 1"),
    ("points = 20", "points = 20.5", "excitation.curve.points: wanted a whole number from 2 to 1000000, such as 200, got 20.5"),
    ("points = 20", "points = 1_000_001", "excitation.curve.points: wanted a whole number from 2 to 1000000, such as 200, got 1000001"),
    ("points = 20", "points = 1_000_000", "excitation.curve.points: wanted at most 1000000 points in all, got 2000000 (loads times points)"),
    (CURVE, '["1 nm", "1 um"]', 'excitation.curve: wanted a table such as { from = "1 nm", to = "100 um", points = 200 }, got a list of 2'),
    ('["csv"]', '["cvs"]', 'output.formats, item 1: wanted "csv", "svg" or "png", got "cvs"; did you mean "csv"?'),
    ('["csv"]', "[]", 'output.formats: wanted a list such as ["csv", "svg", "png"], got an empty list'),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_each_wrong_study_gets_its_own_line(old: str, new: str, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(edited((old, new)), "joint.toml")
    assert str(caught.value) == f"joint.toml: {message}"


def test_the_first_of_several_errors_is_named_and_the_others_counted() -> None:
    text = edited(('"69 GPa"', '"69"'), ("0.33", "7"), ("std", "sdt"), ("0.55", "0"))
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text, "joint.toml")
    assert str(caught.value) == (
        'joint.toml: material.al.young_modulus: wanted a pressure such as "69 GPa", '
        'got "69" (no unit) (and 3 more errors)'
    )


def with_table(separation: str, load: str) -> str:
    start, end = STUDY.index("heights ="), STUDY.index("[joint]")
    text = STUDY[:start] + f"separation = {separation}\nload = {load}\n" + STUDY[end:]
    return text.replace("greenwood-williamson", "table")


def test_what_the_physics_refuses_is_blamed_on_its_key() -> None:
    text = with_table('["0 um", "0.5 um", "1 um"]', '["1 kN", "0.3 kN", "0 N"]')
    with pytest.raises(ms.StudyError, match=r"^joint.toml: joint.normal_load, item 2: must be "):
        ms.Study.from_toml(text, "joint.toml").run()


def test_two_rigid_bodies_are_refused() -> None:
    text = edited(
        ('young_modulus = "69 GPa"\npoisson_ratio = 0.33', "rigid = true"),
    )
    with pytest.raises(ms.StudyError, match=r"^joint.toml: surface.materials: .*rigid"):
        ms.Study.from_toml(text, "joint.toml").run()


TABLES = [
    ('["0 um", "1 um", "0.5 um"]', '["2 kN", "1 kN", "0 N"]', "separation"),
    ('["0 um", "1 um", "2 um"]', '["2 kN", "2.5 kN", "0 N"]', "load"),
    ('["0 um", "1 um", "2 um"]', '["2 kN", "1.9 kN", "0 N"]', "load"),
    ('["0 um", "1 um", "2 um"]', '["2 kN", "0 N"]', "separation and load"),
]


@pytest.mark.parametrize(("separation", "load", "word"), TABLES)
def test_a_table_that_is_no_normal_law_is_refused(separation: str, load: str, word: str) -> None:
    text = with_table(separation, load)
    with pytest.raises(ms.StudyError, match=rf"^joint.toml: surface.*{word}"):
        ms.Study.from_toml(text, "joint.toml").run()


# -- the file itself ------------------------------------------------------------------------


def message_of(path: Path) -> str:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.load(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_missing_file_is_named_with_the_nearest_one(tmp_path: Path) -> None:
    (tmp_path / "joint.toml").write_text(STUDY)
    path = tmp_path / "jiont.toml"
    assert message_of(path) == f'{path}: no such file; did you mean "joint.toml"?'
    path = tmp_path / "x" / "joint.toml"
    assert message_of(path) == f"{path}: no such file"


def test_a_folder_is_no_study(tmp_path: Path) -> None:
    assert message_of(tmp_path) == f"{tmp_path}: wanted a study file, got a folder"


def test_a_file_that_is_not_utf8_is_located(tmp_path: Path) -> None:
    path = tmp_path / "joint.toml"
    path.write_bytes(STUDY.replace("A joint", "Füge").encode("latin-1"))
    assert message_of(path) == (
        f"{path}: line 2: not UTF-8 text (byte 0xfc); save the file as UTF-8"
    )


def test_an_unreadable_file_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    path = tmp_path / "joint.toml"
    path.write_text(STUDY)
    monkeypatch.setattr(Path, "open", refuse)
    assert message_of(path) == f"{path}: cannot be read: permission denied"


def test_odd_paths_and_sizes_are_reported(tmp_path: Path) -> None:
    assert "cannot be read" in message_of(tmp_path / ("x" * 300))
    assert "cannot be read" in message_of(Path("a\0b"))
    assert "nested too deeply" in message_of_text("a = " + 100_000 * "[")
    if Path("/dev/zero").exists():
        assert message_of(Path("/dev/zero")) == "/dev/zero: wanted a study of at most 64 MB"


def message_of_text(text: str) -> str:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text)
    return str(caught.value)


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path: Path) -> None:
    path = tmp_path / "joint.toml"
    path.write_bytes(STUDY.replace("\n", "\r\n").encode("utf-8-sig"))
    assert ms.Study.load(path).title == "A joint"


# -- what is read ---------------------------------------------------------------------------


def test_quantities_are_si_floats_to_the_last_bit() -> None:
    study = ms.Study.from_toml(STUDY)
    assert study.material["al"].young_modulus == 69e9
    assert study.surface.heights.std == 5e-7
    assert study.surface.density == 1e8
    assert study.surface.area == 2e-4
    assert study.joint.normal_load == (500.0, 2000.0)
    assert study.excitation.amplitudes == (1e-7, 1e-6)
    with pytest.raises(Exception, match="frozen"):
        study.title = "another"


@pytest.mark.parametrize("digit", range(1, 10))
def test_a_decimal_quantity_is_the_nearest_double(digit: int) -> None:
    for power, unit in ((-9, "nm"), (-6, "um"), (-3, "mm"), (-2, "cm")):
        assert to_si(f"0.{digit} {unit}", LENGTH, "1 um") == float(f"0.{digit}e{power}")


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("0.5 µm", LENGTH, 5e-7),  # micro sign
        ("0.5 μm", LENGTH, 5e-7),  # Greek letter
        ("0.5um", LENGTH, 5e-7),
        (".5e0 micron", LENGTH, 5e-7),
        ("1 in", LENGTH, 0.0254),
        ("2 cm²", AREA, 2e-4),
        ("100 /mm^2", DENSITY, 1e8),
        ("100 mm^-2", DENSITY, 1e8),
        ("100 mm⁻²", DENSITY, 1e8),
        ("1_000 N", FORCE, 1e3),
        ("1 lbf", FORCE, 4.4482216152605),
        ("69000 N/mm^2", PRESSURE, 69e9),
    ],
)
def test_units_are_read(text: str, kind: object, value: float) -> None:
    assert to_si(text, kind, "") == value


@pytest.mark.parametrize(
    "text",
    [
        *("", " ", "1", "um", "1 m m", "1 2 m", "0x10 m", "nan m", "1 dB", "1 \x1b[31mum"),
        *("1e99999999999999999999 m", "1e400 m", "1e-400 m", "1 m**999999999"),
        "1 __import__('os')",
    ],
)
def test_odd_quantities_are_refused_on_one_line(text: str) -> None:
    with pytest.raises(QuantityError) as caught:
        to_si(text, LENGTH, "1 um")
    assert str(caught.value).isprintable()


def test_numbers_are_written_for_readers() -> None:
    for value, text in (
        *((0.0, "0 N"), (1.0, "1.00 N"), (999.4, "999 N"), (999.6, "1.00 kN"), (-2e3, "-2.00 kN")),
        *((1.1e3, "1.10 kN"), (3.43e-7, "343 nN"), (5.7e9, "5.70 GN"), (None, "–")),
        *((1e-22, "1.00e-22 N"), (1e13, "1.00e+13 N")),
    ):
        assert engineering(value, "N") == text
    for value, text in ((1e-6, "1 µm"), (1e-5, "10 µm"), (1e-4, "100 µm"), (1.5e-3, "1.5 mm")):
        assert engineering(value, "m", trim=True) == text
    for value, text in (
        *((0.0, "0"), (1.0, "1.00"), (12345.0, "12345"), (0.0123, "0.0123")),
        *((1e-9, "1.00e-09"), (math.inf, "inf"), (None, "–")),
    ):
        assert significant(value) == text


SURFACES = {
    "exponential": 'law = "greenwood-williamson"\nheights = { kind = "exponential", scale = "0.8 um" }\n'
    'radius = "1 mm"\ndensity = "100 1/mm^2"\narea = "2 cm^2"',
    "values": 'law = "greenwood-williamson"\n'
    'heights = { kind = "values", values = ["0 um", "0.2 um", "-0.3 um"] }\n'
    'radius = "1 mm"\ndensity = "100 1/mm^2"\narea = "2 cm^2"',
    "population": 'law = "population"\nradius = ["1 mm", "2 mm", "1 mm"]\n'
    'heights = { kind = "values", values = ["0 um", "0.2 um", "-0.3 um"] }',
    "sphere": 'law = "sphere"\nradius = "5 mm"',
    "table": 'law = "table"\nseparation = ["0 um", "0.5 um", "1 um"]\n'
    'load = ["2 kN", "0.5 kN", "0 N"]',
    "tail": 'law = "table"\nseparation = ["0 um", "0.5 um", "1 um"]\n'
    'load = ["2 kN", "0.9 kN", "0.5 kN"]\ntail = "exponential"',
}


@pytest.mark.parametrize("name", SURFACES)
def test_every_surface_law_runs_and_saves(name: str, tmp_path: Path) -> None:
    start, end = STUDY.index("law ="), STUDY.index("[joint]")
    text = f"{STUDY[:start]}{SURFACES[name]}\n\n{STUDY[end:]}"
    result = ms.Study.from_toml(text.replace(LOADS, '"50 N"')).run()
    result.save(tmp_path / "result")
    joint = result.summary["joints"][0]
    assert joint["force_limit"] == pytest.approx(27.5)
    if name in ("table", "tail"):
        assert joint["contact_count"] is None
        assert "stick_area" not in joint["amplitudes"][0]


def test_a_rigid_body_is_a_material() -> None:
    text = edited(
        ("[surface]", "[material.stone]\nrigid = true\n\n[surface]"),
        ('["al", "al"]', '["al", "stone"]'),
    )
    joints = ms.Study.from_toml(text).run().joints
    alone = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material.rigid())
    assert joints[0].surface.pair.composite_modulus == alone.composite_modulus


def test_amplitudes_left_open_are_said_in_the_result() -> None:
    text = edited((f"amplitudes = {AMPLITUDES}\ncurve = {CURVE}", ""))
    result = ms.Study.from_toml(text).run()
    scale = 3.4e-7  # slip per indentation times standard deviation, to two digits
    assert list(result.rows[0].amplitude) == pytest.approx([3.4e-8, 1.02e-7, 3.4e-7, 3.4e-6])
    assert result.curves[0].amplitude[0] == pytest.approx(1e-3 * scale)
    assert result.curves[0].amplitude[-1] == pytest.approx(1e2 * scale)
    of = "times the slip scale, 340 nm when rounded to two digits."
    assert result.summary["notes"][:2] == [
        f"excitation.amplitudes is not given: 0.1, 0.3, 1, 10 {of}",
        f"excitation.curve is not given: 0.001 to 100 {of}",
    ]


def test_progress_rises_to_one() -> None:
    shares: list[float] = []
    ms.Study.from_toml(STUDY).run(shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


# -- the folder -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def result() -> ms.Result:
    return ms.Study.from_toml(STUDY).run()


def refusal(result: ms.Result, folder: Path, overwrite: bool = True) -> str:
    before = snapshot(folder)
    with pytest.raises(ms.StudyError) as caught:
        result.save(folder, overwrite=overwrite)
    assert snapshot(folder) == before
    message = str(caught.value)
    assert message.startswith(f"{folder}: ")
    return message[len(f"{folder}: ") :]


def snapshot(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.parent.rglob("*"))
    }


def test_a_result_is_whole_and_nothing_is_left_beside_it(result: ms.Result, tmp_path: Path) -> None:
    written = result.save(tmp_path / "a" / "b")
    assert sorted(p.name for p in (tmp_path / "a" / "b").iterdir()) == sorted(
        ["summary.json", "study.toml", "loops.csv", "curves.csv"]
    )
    assert all(path.is_file() for path in written)
    assert [p.name for p in tmp_path.iterdir()] == ["a"]
    assert [p.name for p in (tmp_path / "a").iterdir()] == ["b"]
    assert (tmp_path / "a" / "b" / "study.toml").read_text() == STUDY


def test_the_folder_has_the_usual_permissions(result: ms.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "result")
    (tmp_path / "usual").mkdir()
    assert (tmp_path / "result").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_an_existing_folder_is_kept_unless_told(result: ms.Result, tmp_path: Path) -> None:
    folder = tmp_path / "result"
    result.save(folder)
    assert refusal(result, folder, overwrite=False) == (
        "exists; replace it with --overwrite or name another with -o"
    )
    (folder / "summary.json").write_text(
        (folder / "summary.json").read_text().replace("A joint", "Old")
    )
    result.save(folder, overwrite=True)
    assert json.loads((folder / "summary.json").read_text())["title"] == "A joint"
    assert [p.name for p in tmp_path.iterdir()] == ["result"]


def test_only_a_result_is_replaced(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    assert refusal(result, file) == "is a file; name a folder with -o"
    assert "cannot be written: not a directory" in refusal(result, file / "result")

    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("years of work")
    no_result = "not replaced: it is no result of microslip (no summary.json of one)"
    assert refusal(result, mine) == no_result
    for text in ("", "[]", "{}", '{"kind": "other"}', '{"kind": "microslip-result"}', 9999 * "["):
        (mine / "summary.json").write_text(text)
        assert refusal(result, mine) == no_result

    folder = tmp_path / "result"
    result.save(folder)
    (folder / "notes.txt").write_text("years of work")
    assert refusal(result, folder) == (
        'not replaced: "notes.txt" in it is not of the result; move it elsewhere first'
    )
    (folder / "notes.txt").unlink()
    (folder / "loops.csv").unlink()
    (folder / "loops.csv").mkdir()
    (folder / "loops.csv" / "thesis.tex").write_text("years of work")
    assert refusal(result, folder).startswith('not replaced: "loops.csv" in it')
    (folder / "loops.csv" / "thesis.tex").unlink()
    (folder / "loops.csv").rmdir()

    link = tmp_path / "link"
    link.symlink_to(folder)
    assert refusal(result, link) == "is a link; name the folder itself, or another one with -o"
    dangling = tmp_path / "dangling"
    dangling.symlink_to(tmp_path / "nowhere")
    assert refusal(result, dangling).startswith("is a link")

    holds = "not replaced: it holds the current or the home folder"
    monkeypatch.chdir(folder)
    assert refusal(result, folder) == holds
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.setenv("USERPROFILE", str(folder))
    assert refusal(result, folder) == holds


def test_root_is_never_replaced(result: ms.Result) -> None:
    root = Path(Path.cwd().anchor)
    with pytest.raises(ms.StudyError, match="not replaced: it holds the current or the home"):
        result.save(root, overwrite=True)


def test_litter_and_empty_folders_do_not_stand_in_the_way(
    result: ms.Result, tmp_path: Path
) -> None:
    folder = tmp_path / "result"
    folder.mkdir()
    result.save(folder, overwrite=True)
    (folder / ".DS_Store").write_text("")
    result.save(folder, overwrite=True)
    assert not (folder / ".DS_Store").exists()


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("old", [False, True])
def test_a_failure_while_writing_leaves_things_as_they_were(
    result: ms.Result,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    old: bool,
) -> None:
    folder = tmp_path / "deep" / "result"
    if old:
        result.save(folder)
    before = snapshot(tmp_path / "deep")

    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("microslip.study.output.curve_blocks", fail)
    wanted = ms.StudyError if isinstance(error, OSError) else KeyboardInterrupt
    with pytest.raises(wanted) as caught:
        result.save(folder, overwrite=old)
    if wanted is ms.StudyError:
        assert str(caught.value) == f"{folder}: cannot be written: no space left on device"
    assert snapshot(tmp_path / "deep") == before


def test_a_failure_while_moving_brings_the_old_result_back(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "result"
    result.save(folder)
    before = snapshot(folder)
    rename = Path.rename

    def refuse(self: Path, target: Path) -> Path:
        if self.suffix == ".tmp":
            raise OSError(1, "Operation not permitted")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse)
    with pytest.raises(ms.StudyError, match="cannot be written: operation not permitted"):
        result.save(folder, overwrite=True)
    with pytest.raises(ms.StudyError, match="cannot be written: operation not permitted"):
        result.save(tmp_path / "x" / "y")
    assert snapshot(folder) == before


def test_a_folder_that_appears_meanwhile_is_not_touched(result: ms.Result, tmp_path: Path) -> None:
    folder = tmp_path / "result"

    def compute() -> None:
        with folder_module.staged(folder):
            folder.mkdir()
            (folder / "thesis.tex").write_text("years of work")

    with pytest.raises(ms.StudyError, match="exists; replace it with --overwrite"):
        compute()
    assert [p.name for p in tmp_path.iterdir()] == ["result"]
    assert [p.name for p in folder.iterdir()] == ["thesis.tex"]


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="permissions do not bind here")
def test_a_place_that_cannot_be_written_is_refused(result: ms.Result, tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(ms.StudyError, match="cannot be written: permission denied"):
            result.save(tmp_path / "result")
    finally:
        tmp_path.chmod(0o700)


def test_a_place_that_cannot_be_looked_into_is_refused(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stat = Path.stat

    def refuse(self: Path, *, follow_symlinks: bool = True) -> os.stat_result:
        if self.name == "secret":
            raise PermissionError(13, "Permission denied")
        return stat(self, follow_symlinks=follow_symlinks)

    monkeypatch.setattr(Path, "stat", refuse)
    with pytest.raises(ms.StudyError, match="cannot be written: permission denied"):
        result.save(tmp_path / "secret")


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no /proc")
def test_a_place_where_nothing_can_be_made_is_refused(result: ms.Result) -> None:
    with pytest.raises(ms.StudyError, match=r"^/proc/result: cannot be written: "):
        result.save("/proc/result")
