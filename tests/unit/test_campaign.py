"""Several records together: rows, runs; and files that are none."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from command import run

import microslip as ms
from microslip.laboratory import Campaign as Campaign
from microslip.report.measured import measurement_document


def loops(amplitude: float, seed: int, noise: float = 0.3, limit: float = 100.0) -> ms.Record:
    """Twelve cycles of one cell behind nothing, with noise."""
    rng, rig = np.random.default_rng(seed), ms.VirtualTribometer(ms.Jenkins(5e7, limit))
    made = rig.record(amplitude=amplitude, frequency=5.0, cycles=12)
    x = made.displacement + rng.normal(0.0, 1e-9, len(made))
    force = made.force + rng.normal(0.0, noise, len(made))
    return ms.Record(x, force, normal_load=200.0, sample_rate=2560.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs of two records, and a file that is none."""
    top = tmp_path_factory.mktemp("rigs")
    for run_number, limit in enumerate((100.0, 110.0)):
        inside = top / f"run{run_number}"
        inside.mkdir()
        for i, amplitude in enumerate((1.5e-6, 2e-5)):
            record = loops(amplitude, 10 * run_number + i, limit=limit)
            record.to_csv(inside / f"loops{i}.csv")
    (top / "run1" / "notes.txt").write_text("nothing but words\n")
    return top


def test_a_folder_has_a_row_a_record(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    names = ("run0", ""), ("run0", "0.001"), ("run1", ""), ("run1", "0.001")
    files = sorted(path.relative_to(folder) for path in folder.rglob("*.csv"))
    rows = [",".join((str(f), *n)) for f, n in zip(files, names, strict=True)]
    rows = ["file,run,worn volume [mm^3]", *rows, "run1/notes.txt,run1,"]
    (folder / "manifest").write_text("\n".join(rows) + "\n")
    outcome = run("measure", "--manifest", str(folder / "manifest"), "-o", str(out))
    assert outcome.exit_code == 0, outcome.output
    assert "1 file could not be measured" in outcome.stdout
    campaign = json.loads((out / "summary.json").read_text("utf-8"))["campaign"]
    rows = campaign["table"]
    assert [row["run"] for row in rows] == ["run0", "run0", "run1", "run1"]
    assert rows[1]["chord_stiffness"] == pytest.approx(5e7, rel=0.03)
    assert campaign["skipped"][0]["file"].endswith("notes.txt")
    assert {row["regime"] for row in rows} == {"stick", "gross slip"}
    # Files of one run are not in the order of its cycles unless the manifest numbers them.
    assert all("first cycle" in reason for reason in campaign["wear"]["unknown"].values())
    for name in ("campaign.csv", "report.html"):
        assert (out / name).stat().st_size > 100
    assert len((out / "campaign.csv").read_text("utf-8").splitlines()) == 5


def test_sticking_cycles_are_called_so_in_noise() -> None:
    """Noise of 1 % once called a third of them gross slip."""
    for seed in range(5):
        measured = ms.measure(loops(1.0e-6, seed, noise=0.5))
        assert set(measured.regimes) == {"stick"}
        assert measured.probability["stick"] > 0.99


# -- files as rigs leave them ----------------------------------------------------------------------


def test_a_cut_last_line_and_lone_gaps_cost_no_file(tmp_path: Path) -> None:
    rows = [f"{1e-6 * math.sin(0.1 * i)!r},{math.cos(0.1 * i)!r}" for i in range(400)]
    rows[100] = "nan,0.5"
    path = tmp_path / "cut.csv"
    path.write_text("displacement [m],force [N]\n" + "\n".join(rows) + "\n1e-7")
    record = ms.Record.read(path, sample_rate=100.0)
    assert len(record) == 400
    assert record.displacement[100] == pytest.approx(1e-6 * math.sin(10.0), abs=1e-8)
    assert any("interpolated linearly: 1 row without numbers" in note for note in record.notes)
    path.write_text("displacement [m],force [N]\n1e-6,2\n1e-7\n2e-6,3\n")
    with pytest.raises(ms.InputError, match="line 3: wanted 2 cells"):
        ms.Record.read(path, sample_rate=100.0)


def test_a_column_of_the_manifest_replaces_no_measured_one(tmp_path: Path) -> None:
    """Names that the user gives do not decide which columns are shown or written."""
    measured = [ms.measure(loops(1.5e-6, seed)) for seed in (1, 2)]
    given = {"settled": ["by eye", "no"], "frequency [Hz]": ["low", "low"], "operator": ["A", "B"]}
    document = measurement_document(Campaign(tuple(measured), given))
    (row, _) = document.data["campaign"]["table"]
    assert row["settled (manifest)"] == "by eye"
    assert row["settled"] in ("yes", "no")
    assert row["amplitude"] == pytest.approx(1.5e-6, rel=1e-2)
    (file,) = (file for file in document.files if file.name == "campaign.csv")
    file.write(tmp_path / "campaign.csv")
    heads = (tmp_path / "campaign.csv").read_text("utf-8").splitlines()[0].split(",")
    assert len(set(heads)) == len(heads)
