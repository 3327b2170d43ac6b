"""Batches of studies: restarts, failures, workers that die."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import microslip as ms
from microslip.cli import main
from microslip.study.runs import batch

STUDY = """
schema = 1
surface = { law = "sphere", materials = ["steel", "steel"], radius = "5 mm" }
joint = { friction_coefficient = 0.5, normal_load = "20 N" }
excitation = { amplitudes = ["0.1 um", "1 um"] }
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "study.toml").write_text(STUDY)
    rows = ["name,joint.normal_load,joint.friction_coefficient"]
    rows += [f"p{i},{10 + i} N,0.{i + 1}" for i in range(6)]
    (tmp_path / "changes.csv").write_text("\n".join([*rows, "wrong,-3 N,0.5"]) + "\n")
    return tmp_path


def called(*words: object) -> Any:
    return CliRunner().invoke(main, ["batch", *map(str, words)])


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "items.csv").open() as file:
        return list(csv.DictReader(file))


def test_changes_to_a_study(folder: Path) -> None:
    out = folder / "out"
    done = called(folder / "changes.csv", "--study", folder / "study.toml", "-o", out)
    assert done.exit_code == 0, done.output
    assert "6 of 7 items done, 1 failed" in done.output
    assert "wanted a positive force" in done.output
    rows = table(out)
    assert len(rows) == 12
    joint = ms.Study.from_toml(STUDY).run().joints[0].at(normal_load=12.0)
    wanted = ms.Interface(joint.surface, 0.3, 12.0).loss_factor(1e-6)
    (found,) = (r for r in rows if r["item"] == "p2" and float(r["amplitude [m]"]) == 1e-6)
    assert float(found["loss_factor [-]"]) == pytest.approx(wanted, rel=1e-13)
    data = json.loads((out / "summary.json").read_text())
    assert (data["items"], data["done"], len(data["failed"])) == (7, 6, 1)
    assert set(data["files"]) == {p.name for p in out.iterdir() if p.is_file()}


def test_a_second_run_does_what_is_left(folder: Path) -> None:
    out, words = folder / "out", (folder / "changes.csv", "--study", folder / "study.toml")
    items = batch.items_of(folder / "changes.csv", folder / "study.toml")
    batch.run_batch([*items[:2], items[-1]], out)  # what is there after a stop
    before = {p.name: p.stat().st_mtime_ns for p in (out / "items").iterdir()}
    done = called(*words, "-o", out, "--workers", 2)
    assert "6 of 7 items done" in done.output
    after = {p.name: p.stat().st_mtime_ns for p in (out / "items").iterdir()}
    kept = {name for name, when in before.items() if after[name] == when}
    assert len(kept) == 2  # the item that failed is tried again
    assert {row["item"] for row in table(out)} == {f"p{i}" for i in range(6)}
    # A changed study makes all of it anew, a spoilt outcome itself.
    (folder / "study.toml").write_text(STUDY.replace("5 mm", "6 mm"))
    items = batch.items_of(folder / "changes.csv", folder / "study.toml")
    assert batch.earlier_outcomes(out, items) == {}
    called(*words, "-o", out)
    (out / "items" / items[0].file_name).write_text('{"half')
    assert len(batch.earlier_outcomes(out, items)) == 5


def test_a_folder_of_studies(folder: Path) -> None:
    many = folder / "many"
    many.mkdir()
    (many / "one.toml").write_text(STUDY)
    (many / "spoilt.toml").write_text("nothing\n")
    found = batch.run_batch(batch.items_of(many, None), folder / "out")
    assert [o["item"] for o in found.done] == ["one.toml"]
    assert [o["item"] for o in found.failed] == ["spoilt.toml"]
    (folder / "changes.csv").write_bytes(b"a\n\0")
    with pytest.raises(ms.InputError, match="wanted text"):
        batch.items_of(folder / "changes.csv", folder / "study.toml")


def die(item: batch.BatchItem) -> batch.Outcome:
    """Work that kills its worker: always for one item, once for another."""
    once = Path(item.study).with_suffix(".once")
    if item.name == "p1" or (item.name == "p4" and not once.exists()):
        once.touch()
        os._exit(9)
    return {"item": item.name, "mark": item.mark, "status": "done", "rows": []}


def test_workers_may_die(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "run_item", die)
    items = [batch.BatchItem(f"p{i}", str(folder / "study.toml")) for i in range(6)]
    found = batch.run_batch(items, folder / "out", workers=2)
    assert [o["item"] for o in found.failed] == ["p1"]
    assert "the worker process died 3 times" in found.failed[0]["reason"]
    assert len(found.done) == 5


WRONG = {
    "no such": (["nowhere"], "nowhere: no such file or folder"),
    "no study": (["changes.csv"], "--study must be given: changes.csv is a table of changes"),
    "empty": (["empty"], "wanted studies, got none"),
    "twice": (["twice.csv", "--study", "study.toml"], "wanted each item once, got a twice"),
    "no batch": ([".", "-o", "full"], "full: exists and is not a batch"),
    "ragged": (["ragged.csv", "--study", "study.toml"], "wanted 2 columns, got 1 in row 1"),
    "dask": ([".", "--dask", "tcp://127.0.0.1:9", "-o", "out"], "--dask"),
}


@pytest.mark.parametrize("case", WRONG.values(), ids=WRONG)
def test_wrong_input_is_reported(
    case: tuple[list[str], str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words, message = case
    monkeypatch.chdir(folder)
    if "--dask" in words:
        pytest.importorskip("distributed", reason="the extra dask is not installed")
        monkeypatch.setattr(batch, "DASK_PATIENCE", "1s")
    for name in ("empty", "full"):
        Path(name).mkdir()
    Path("full/mine.txt").write_text("mine")
    Path("twice.csv").write_text("name,title\na,x\na,y\n")
    Path("ragged.csv").write_text("a,b\n1\n")
    found = called(*words)
    assert found.exit_code == 2, found.output
    assert message in found.output


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same(folder: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")
    words = (folder / "changes.csv", "--study", folder / "study.toml")
    assert called(*words, "-o", folder / "a").exit_code == 0
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        assert called(*words, "-o", folder / "b", "--dask", address).exit_code == 0
    assert (folder / "a" / "items.csv").read_text() == (folder / "b" / "items.csv").read_text()
