"""A manifest says which file is of which specimen, load and stage, and two commands read it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from command import run
from sliders import slider

import microslip as ms
from microslip.laboratory.manifest import Manifest

MUS = (0.50, 0.56, 0.53)
RATE, FREQUENCY = 2000.0, 10.0


def stiffness_at(load: float) -> float:
    """Of a contact whose stiffness is proportional to its load to the power 0.8."""
    return 2e8 * (load / 1000.0) ** 0.8


def cell_record(mu: float, load: float, amplitude: float, seed: int, settle: float) -> ms.Record:
    """Cycles of one elastic slider, summed step by step; its limit grows exponentially."""
    rng = np.random.default_rng(seed)
    n = np.arange(40 * int(RATE / FREQUENCY))
    x = amplitude * np.sin(2.0 * np.pi * FREQUENCY / RATE * n)
    limit = mu * load * (1.0 - settle * np.exp(-n * FREQUENCY / RATE / 4.0))
    force = slider(x, stiffness_at(load), limit) + 1e-3 * mu * load * rng.normal(size=n.size)
    return ms.Record(x, force, sample_rate=RATE)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three specimens at three stages, each of another load."""
    folder = tmp_path_factory.mktemp("campaign")
    rows = ["file;Specimen;load [N];Amplitude;stage;cycle;worn volume [mm^3];Öl"]
    for i, mu in enumerate(MUS):
        for stage, (load, first) in enumerate(((400.0, 1), (800.0, 1001), (1600.0, 10001)), 1):
            name = f"s{i}-{stage}.csv"
            record = cell_record(mu, load, 3e-5, 10 * i + stage, 0.3 if stage == 1 else 0.0)
            record.to_csv(folder / name)
            volume = {1: "0", 2: ""}.get(stage, f"0,0{6 + i}")
            rows.append(f"{name};S{i};{load:g};30 um;{stage};{first};{volume};PAO {i}")
    (folder / "manifest.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return folder


def test_measure_reads_a_manifest(campaign: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    outcome = run("measure", "--manifest", str(campaign / "manifest.csv"), "-o", str(out))
    assert outcome.exit_code == 0, outcome.output
    data = json.loads((out / "summary.json").read_text("utf-8"))["campaign"]
    pandas = pytest.importorskip("pandas")
    read = pandas.read_csv(out / "campaign.csv")
    # Each specimen has one volume that was not zero, over the energy of all its cycles.
    assert [row["worn_volume"] for row in data["wear"]["records"][1::2]] == [6e-11, 7e-11, 8e-11]
    worn = [read["worn_volume [m^3]"].to_numpy()[3 * i + 2] for i in range(3)]
    assert worn == [6e-11, 7e-11, 8e-11]
    # Of one cell E_d/4Nδ_g is its friction.
    friction = {
        row["specimen"]: row["friction_energy"] for row in data["table"] if row["stage"] == "3"
    }
    assert friction == {f"S{i}": pytest.approx(mu, rel=2e-3) for i, mu in enumerate(MUS)}
    assert len(read) == 9
    # The page on pandas has columns of these names.
    page = (Path(__file__).parents[2] / "docs" / "campaigns.md").read_text("utf-8")
    names = page.partition("```csv campaign.csv\n")[2].partition("\n")[0].split(",")
    assert set(names) <= {*read.columns, "normal_load [N]"}
    rows = (out / "campaign.csv").read_text("utf-8").splitlines()
    assert rows[0].split(",")[:5] == [
        *("record", "specimen", "stage", "Öl", "cycles"),
    ]


@pytest.mark.slow
def test_a_workbook_is_a_manifest_and_a_record(campaign: Path, tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl", reason="the extra excel is not installed")
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["file", "specimen", "load [kN]", "cycle"])
    sheet.append(["loops.xlsx", "A", 0.4, 1])
    book.save(tmp_path / "manifest.xlsx")
    made = cell_record(0.5, 400.0, 3e-5, 1, 0.0)
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Rig 7"])
    sheet.append(["time [s]", "displacement [um]", "force [N]", "operator"])
    for i, (x, force) in enumerate(zip(made.displacement, made.force, strict=True)):
        sheet.append([i / RATE, 1e6 * x, force, "J"])
    book.save(tmp_path / "loops.xlsx")
    record = ms.Record.read(tmp_path / "loops.xlsx")
    assert np.allclose(record.displacement, made.displacement, rtol=1e-12)
    assert np.allclose(record.force, made.force, rtol=1e-14)
    manifest = Manifest.read(tmp_path / "manifest.xlsx")
    assert manifest.loaded(record, 0).normal_load == 400.0
    outcome = run("measure", "--manifest", str(tmp_path / "manifest.xlsx"))
    assert outcome.exit_code == 0, outcome.output
    broken = tmp_path / "broken.xlsx"
    broken.write_bytes(b"PK\x03\x04nothing")
    with pytest.raises(ms.InputError, match="not a usable Excel workbook"):
        ms.Record.read(broken)
    with pytest.raises(ms.InputError, match="limit"):
        ms.Record.read(tmp_path / "loops.xlsx", limit=100)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("specimen,load\nA,5\n", 'a row of names with a column "file"'),
        ("file,load\na.csv,5\n", 'row 2, column "normal_load": "5" has no unit'),
        ("file,load\na.csv,5 um\n", "wanted a force"),
        ("file,specimen\n,A\n", 'row 2: the column "file" is empty'),
        ("file,load [N],normal force [N]\na,1,1\n", "two columns"),
        ("file\n", "a row for each file, got none"),
        ("file,oil\na,x\nb,x\n./a,y\n", 'row 4: "./a" is in row 2 already'),
        ("My campaign\nfile,load [N]\na,1\nb,-2\n", 'row 4, column "normal_load": wanted a value'),
        ("file,sample rate\na,fast\n", 'row 2, column "sample_rate": wanted a number in Hz'),
    ],
)
def test_wrong_manifests(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "manifest.csv"
    path.write_text(text)
    with pytest.raises(ms.InputError, match=words):
        Manifest.read(path)


def test_a_workbook_is_read_as_it_is_seen(tmp_path: Path) -> None:
    """The first visible sheet, merged cells in all of their rows."""
    openpyxl = pytest.importorskip("openpyxl", reason="the extra excel is not installed")
    book = openpyxl.Workbook()
    book.active.append(["file", "specimen"])
    book.active.append(["wrong.csv", "X"])
    book.active.sheet_state = "hidden"
    sheet = book.create_sheet("records")
    sheet.append(["Campaign of May"])
    sheet.merge_cells("A1:D1")
    sheet.append(["file", "specimen", "oil", "load [N]"])
    for file in "abcd":
        sheet.append([f"{file}.csv", None, None, 500])
    for first, last, name in ((3, 4, "S1"), (5, 6, "S2")):
        sheet[f"B{first}"] = name
        sheet.merge_cells(f"B{first}:B{last}")
    sheet["C3"] = "PAO"
    sheet.merge_cells("C3:C6")
    book.active = 1
    book.save(tmp_path / "manifest.xlsx")
    read = Manifest.read(tmp_path / "manifest.xlsx")
    assert [Path(path).name for path in read.paths] == ["a.csv", "b.csv", "c.csv", "d.csv"]
    assert read.columns["specimen"] == ("S1", "S1", "S2", "S2")
    assert read.columns["oil"] == ("PAO",) * 4


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize(
    "words",
    [
        ("measure", "pipe"),
        ("measure", "--manifest", "pipe"),
        ("measure", "--manifest", "manifest.csv"),
        ("identify", "pipe"),
        ("identify", "--manifest", "pipe"),
        ("check", "pipe"),
        ("predict", "pipe"),
        ("predict", "law.toml"),
        ("surface", "pipe"),
        ("batch", "pipe", "--study", "law.toml"),
    ],
)
def test_named_pipes_are_refused(here: Path, words: tuple[str, ...]) -> None:
    """A pipe without a writer blocks whoever opens it, so that a test of it would never end."""
    os.mkfifo("pipe")
    Path("manifest.csv").write_text("file\npipe\n")
    law = 'schema = 1\n[joint]\nlaw_file = "pipe"\n[excitation]\namplitudes = ["1 um"]\n'
    Path("law.toml").write_text(law)
    Path("run.csv").write_text("x [um],F [N]\n0,1\n1,2\n")
    outcome = run(*words)
    assert outcome.exit_code == 2, outcome.output
    assert "got a named pipe" in outcome.stderr
    assert outcome.stderr.count("\n") == 1


def test_no_wear_of_a_specimen_counted_twice(campaign: Path, tmp_path: Path) -> None:
    """Two series from cycle 1 hide the life of their specimen; another specimen has its wear."""
    rows = ["file,specimen,cycle,load,worn volume [mm^3]"]
    rows += [
        f"{campaign / f's0-{stage}.csv'},A,1,,{volume}" for stage, volume in ((1, 0.1), (2, 0.2))
    ]
    rows += [f"{campaign / 's1-1.csv'},B,1,,0.05", f"{campaign / 's2-1.csv'},C,900,,0.05"]
    (tmp_path / "manifest.csv").write_text("\n".join(rows) + "\n")
    outcome = run("measure", "--manifest", str(tmp_path / "manifest.csv"), "--all")
    assert outcome.exit_code == 0, outcome.output
    text = " ".join(outcome.stdout.split())
    assert text.count("several series whose cycles are counted from the same number") == 2
    assert "begins at cycle 900" in text
    assert "from 1 worn volume and" in text
    found = json.loads(
        run("measure", "--manifest", str(tmp_path / "manifest.csv"), "--json").stdout
    )
    alone = ms.measure(ms.Record.read(campaign / "s1-1.csv")).cycles["dissipated_energy"].sum()
    assert found["campaign"]["wear"]["value"] == pytest.approx(0.05e-9 / alone, rel=1e-6)
    # Without the column the order of two records of one specimen is unknown.
    (tmp_path / "manifest.csv").write_text("\n".join(row.replace(",1,", ",,") for row in rows))
    text = " ".join(run("measure", "--manifest", str(tmp_path / "manifest.csv")).stdout.split())
    assert 'in a column "first cycle"' in text


def test_files_are_read_each_in_its_way(here: Path) -> None:
    """Columns, units and missing columns by row; loads that differ are on the first screen."""
    made = cell_record(0.5, 400.0, 3e-5, 1, 0.0)
    made.to_csv("a.csv")
    rows = (f"{i},{1e6 * x!r},{f!r}" for i, (x, f) in enumerate(zip(*(
        values.tolist() for values in (made.displacement, made.force)), strict=True)))  # fmt: skip
    Path("b.csv").write_text("clock,A,B\n" + "\n".join(rows) + "\n")
    head = "file,load [N],amplitude,displacement column,force column,time column,sample rate"
    texts = (head, "a.csv,400,60 um,,,,", f"b.csv,400,,A [um],B [N],none,{RATE:g}")
    Path("manifest.csv").write_text("\n".join(texts) + "\n")
    outcome = run("measure", "--manifest", "manifest.csv", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    text = " ".join(outcome.stdout.split())
    assert "a: amplitude 60.0 µm by the manifest, measured 30.0 µm" in text
    rows_read = json.loads(Path("out/summary.json").read_text("utf-8"))["campaign"]["table"]
    assert [row["record"] for row in rows_read] == ["a", "b"]
    energies = [row["dissipated_energy"] for row in rows_read]
    assert energies[0] == pytest.approx(energies[1], rel=1e-9)


def test_a_cell_is_the_heading_of_a_column_or_its_name_with_a_unit(here: Path) -> None:
    record = cell_record(0.5, 1000.0, 2e-6, 1, 0.0)
    forces = record.force, 1e3 * record.force
    rows = np.column_stack((1e6 * record.displacement, *forces, np.arange(len(record)) // 200))
    head = "motion,Force (N),Force (mN),cycle [-]"
    np.savetxt("a.csv", rows, delimiter=",", header=head, comments="")
    text = "file,displacement column,force column,cycle column,sample rate\n"
    Path("list.csv").write_text(f"{text}a.csv,motion [um],Force (N),cycle [-],{RATE:g}\n")
    given = Manifest.read("list.csv").reading(0)
    read = ms.Record.read("a.csv", **given)
    np.testing.assert_allclose(read.force, record.force, rtol=1e-12)
    np.testing.assert_allclose(read.displacement, record.displacement, rtol=1e-12)
    assert read.cycle_number is not None


def test_a_record_is_named_once(here: Path) -> None:
    cell_record(0.5, 400.0, 3e-5, 1, 0.0).to_csv("a.csv")
    for words in (("a.csv", "./a.csv"), ("a.csv", ".")):
        outcome = run("measure", *words)
        assert (outcome.exit_code, outcome.stdout) == (2, "")
        assert "a.csv is named twice" in outcome.stderr
