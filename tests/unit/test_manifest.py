"""A manifest says which file is of which specimen, load and stage, and two commands read it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command import run

import microslip as ms
from microslip.report.identified.document import Identified, document
from microslip.report.identified.groups import Groups
from microslip.tribometer.manifest import Manifest

MUS = (0.50, 0.56, 0.53)
RIG, RATE, FREQUENCY = 3e8, 2000.0, 10.0


def stiffness_at(load: float) -> float:
    """Of a contact whose stiffness is proportional to its load to the power 0.8."""
    return 2e8 * (load / 1000.0) ** 0.8


def cell_record(mu: float, load: float, amplitude: float, seed: int, settle: float) -> ms.Record:
    """Cycles of one elastic slider, summed step by step; its limit grows exponentially."""
    rng = np.random.default_rng(seed)
    n = np.arange(40 * int(RATE / FREQUENCY))
    x = amplitude * np.sin(2.0 * np.pi * FREQUENCY / RATE * n)
    limit = mu * load * (1.0 - settle * np.exp(-n * FREQUENCY / RATE / 4.0))
    force, last = np.zeros(n.size), 0.0
    for i in range(1, n.size):
        last = min(max(last + stiffness_at(load) * (x[i] - x[i - 1]), -limit[i]), limit[i])
        force[i] = last
    force = force + 1e-3 * mu * load * rng.normal(size=n.size)
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
    # Of one cell E_d/4Nδ_g is its friction.
    friction = [
        p
        for p in data["specimens"]
        if p["quantity"] == "friction_energy" and "stage 3" in p["condition"]
    ]
    assert len(friction) == 1
    (friction,) = friction
    for label, mu in zip(("S0", "S1", "S2"), MUS, strict=True):
        assert friction["each"][label]["value"] == pytest.approx(mu, rel=2e-3)
    assert friction["mean"]["value"] == pytest.approx(np.mean(MUS), rel=2e-3)
    assert friction["between"] == pytest.approx(np.std(MUS, ddof=1), rel=0.02)
    # Student with two degrees of freedom: 4.3027 standard errors.
    half = friction["mean"]["high"] - friction["mean"]["value"]
    assert half == pytest.approx(4.302653 * np.std(MUS, ddof=1) / np.sqrt(3.0), rel=0.02)
    exponent = data["stiffness_over_load"]["exponent"]
    assert exponent["low"] < 0.8 < exponent["high"]
    assert exponent["high"] - exponent["low"] < 0.1
    constants = {law["column"]: law["constant"] for law in data["running_in"]}
    assert constants["friction_energy"]["low"] < 4.0 < constants["friction_energy"]["high"]
    assert {law["law"] for law in data["wear_laws"]} >= {"energy", "Archard"}
    # 400 cycles of each of three friction forces, and all those between that were not logged.
    archard = next(law for law in data["wear_laws"] if law["law"] == "Archard")
    way = 4.0 * (3e-5 - np.array([MUS[0] * load / stiffness_at(load) for load in (400, 800, 1600)]))
    work = 1000 * (400 * way[0] + 800 * way[1]) / 2.0 + 9000 * (800 * way[1] + 1600 * way[2]) / 2.0
    assert archard["coefficient"]["value"] == pytest.approx(0.07e-9 / work, rel=0.1)
    rows = (out / "records.csv").read_text("utf-8").splitlines()
    assert rows[0].split(",")[:5] == ["record", "specimen", "stage", "cycle", "Öl"]
    for name in ("friction-log", "means", "stiffness", "running-in", "wear", "fretting-map"):
        assert (out / f"{name}.svg").stat().st_size > 1000


@pytest.mark.slow
def test_identify_reads_it_and_fits_each_specimen(campaign: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("identify", "--manifest", str(campaign / "manifest.csv"), "--law", "jenkins")
    outcome = run(*words, "--rig-stiffness", "rigid", "-o", str(out))
    assert outcome.exit_code == 0, outcome.output
    groups = json.loads((out / "summary.json").read_text("utf-8"))["groups"]
    assert groups["column"] == "specimen"
    assert list(groups["fits"]) == ["S0", "S1", "S2"]
    assert (out / "groups.svg").stat().st_size > 1000
    outcome = run(*words, "--rig-stiffness", "rigid", "--group", "stage", "--json")
    assert outcome.exit_code == 0, outcome.output
    over = json.loads(outcome.stdout)["groups"]
    assert over["pooled"] == {}, "stages are no specimens"
    for stage, load in (("2", 800.0), ("3", 1600.0)):
        fit = over["fits"][stage]["parameters"]
        stiffness = next(v for k, v in fit.items() if k.startswith("stiffness"))
        assert stiffness["value"] == pytest.approx(stiffness_at(load), rel=0.02)


def test_specimens_that_no_common_fit_answers_are_reported_by_themselves() -> None:
    """Those whose own fit has not converged are listed, and say nothing of the others."""
    made = [cell_record(0.5, 400.0, 3e-5, seed, 0.0) for seed in (1, 2, 3)]
    records = [replace(record, normal_load=400.0) for record in made]
    found = ms.identify(
        records, "jenkins", rig_stiffness="rigid", held_back=0.0, intervals="curvature"
    )
    bad = replace(found, status="not converged")
    alone = Identified((bad,), None, None)
    assert alone.failed is bad
    labels = ["S0", "S0", "S1"]
    own = Groups.of("specimen", labels, labels, records, lambda of: found if len(of) > 1 else bad)
    assert own is not None
    assert (list(own.fits), own.failed) == (["S0"], {"S1": "not converged"})
    told = replace(alone, groups=own)
    assert told.failed is None
    assert document(told).answer.startswith("1 of 2 specimens fitted alone; all together jenkins")
    accepted = Groups.of("specimen", labels, labels, records, lambda of: bad, True)
    assert accepted is not None
    assert list(accepted.fits) == ["S0", "S1"]


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
        ("file,cycle\na.csv,first\n", 'row 2, column "cycle": wanted a number'),
        ("file,specimen\n,A\n", 'row 2: the column "file" is empty'),
        ("file,load [N],normal force [N]\na,1,1\n", "two columns"),
        ("file\n", "a row for each file, got none"),
    ],
)
def test_wrong_manifests(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "manifest.csv"
    path.write_text(text)
    with pytest.raises(ms.InputError, match=words):
        Manifest.read(path)
    outcome = run("measure", "--manifest", str(path))
    assert outcome.exit_code == 2
    assert outcome.stderr.count("\n") == 1
