"""The commands check, new and demo."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from command import STUDY, fails, names, run

import microslip as ms
from microslip.study.new import TEMPLATES, demo_text


@pytest.fixture(autouse=True)
def _a_study(here: Path) -> None:
    Path("joint.toml").write_text(STUDY, encoding="utf-8")


# -- check -----------------------------------------------------------------------------------------


def test_check_shows_what_was_written_in_si_units() -> None:
    outcome = run("check", "joint.toml", "--set", "joint.normal_load=3 kN")
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    assert names() == ["joint.toml"], "it writes nothing"
    for key, written, si in (
        ("material.al.young_modulus", "69 GPa", "6.9e10 Pa"),
        ("material.al.poisson_ratio", "0.33", "0.33"),
        ("surface.heights.std", "0.5 um", "5e-7 m"),
        ("surface.density", "100 1/mm^2", "1e8 1/m^2"),
        ("joint.normal_load", "3 kN", "3000 N"),
        ("excitation.amplitudes", "0.1 um, 1 um", "1e-7, 1e-6 m"),
        ("excitation.curve.points", "20", "20"),
    ):
        assert re.search(rf"\n{key} +{re.escape(written)} +{re.escape(si)}\n", outcome.stdout), key
    assert re.search(
        r"\n3 kN +7418 +4\.02 % +7\.83 GN/m +466 MN/m +1\.65 kN +343 nm +0\.329\n", outcome.stdout
    )
    assert "\n  watch   plasticity index: 0.721 (ok up to 0.6)" in outcome.stdout
    assert "\njoint.normal_load was overridden: 3 kN.\n" in outcome.stdout
    assert outcome.stdout.endswith(
        " To compute 2 loops, curves of 20 points in all:\n"
        "  microslip predict joint.toml --set 'joint.normal_load=3 kN'\n"
    )


def test_check_in_json() -> None:
    outcome = run("check", "joint.toml", "--json")
    assert outcome.exit_code == 0
    found = json.loads(outcome.stdout)
    assert found["kind"] == "microslip-check"
    assert (found["loops"], found["points"], found["samples"]) == (2, 20, 0)
    assert run("predict", "joint.toml").exit_code == 0
    summary = json.loads(Path("joint-result/summary.json").read_text("utf-8"))
    assert found["study"] == summary["study"]
    entry = {key: summary["joints"][0][key] for key in found["joints"][0]}
    assert found["joints"] == [entry]
    assert "validity" in entry
    quantities = {entry["key"]: entry for entry in found["quantities"]}
    assert quantities["excitation.amplitudes"] == {
        "key": "excitation.amplitudes",
        "written": ["0.1 um", "1 um"],
        "value": [1e-7, 1e-6],
        "unit": "m",
    }


# -- new, demo -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["joint", "population", "sphere", "table"])
def test_a_new_study_runs_as_it_is(kind: str) -> None:
    outcome = run("new", "mine.toml", "--template", kind)
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    assert outcome.stdout == (
        "Written to mine.toml. Next:\n  microslip check mine.toml\n  microslip predict mine.toml\n"
    )
    text = Path("mine.toml").read_text("utf-8")
    assert max(map(len, text.splitlines())) <= 110
    assert text.isascii()
    study = ms.Study.load("mine.toml")
    assert study.title == "mine"
    assert study.surface.law == ("greenwood-williamson" if kind == "joint" else kind)
    result = study.run()
    verdicts = [verdict for joint in result.joints for verdict in joint.validity]
    # Summits of mild steel yield; these are of hardened steel.
    assert {verdict.word for verdict in verdicts} <= {"ok"}
    ratios = result.rows[-1].force_ratio
    assert ratios[0] < 0.75
    assert ratios[-1] > 0.99, "from micro to gross slip"


@pytest.mark.slow
def test_templates_are_listed_and_written() -> None:
    templates, processes = run("new", "--list").stdout.split("Processes for --process", 1)
    assert "milled" in processes
    listed = [line.split()[0] for line in templates.splitlines()]
    assert tuple(listed) == tuple(TEMPLATES)
    for name in listed:
        outcome = run("new", f"{name}-one.toml", "--template", name)
        assert outcome.exit_code == 0, outcome.output
        text = Path(f"{name}-one.toml").read_text("utf-8")
        for step in outcome.stdout.splitlines()[1:]:
            assert f"#   {step.strip()}" in text
    rng = np.random.default_rng(0)
    np.savetxt("face.csv", rng.normal(size=(64, 64)).cumsum(0).cumsum(1) * 0.02, delimiter=",")
    scan = ("--set", 'surface.unit="um"', "--set", 'surface.pixel="1 um"')
    for words in (("structure-one.toml",), ("record-one.toml",), ("scan-one.toml", *scan)):
        assert run("check", *words).exit_code == 0
    assert "structure.mesh: parts.msh: no such file" in fails("check", "mesh-one.toml")
    outcome = run("batch", "batch-one.csv", "--study", "batch-one.toml", "-o", "many")
    assert "3 items done" in outcome.stdout
    Path("second.csv").write_text("mine", encoding="utf-8")
    assert "second.csv: exists" in fails("new", "second.toml", "--template", "batch")
    assert not Path("second.toml").exists()
    assert Path("second.csv").read_text("utf-8") == "mine"


def test_new_never_overwrites() -> None:
    before = Path("joint.toml").read_bytes()
    assert fails("new", "joint.toml") == (
        "error: joint.toml: exists and is not overwritten; give another name"
    )
    Path("folder.toml").mkdir()
    assert "folder.toml: exists" in fails("new", "folder.toml")
    if os.name != "nt":
        Path("link.toml").symlink_to("nowhere.toml")
        assert "link.toml: exists" in fails("new", "link.toml")
    assert Path("joint.toml").read_bytes() == before


def test_the_beam_is_the_example_and_fine() -> None:
    example = Path(__file__).parents[2] / "examples/bolted_beam.toml"
    assert demo_text(beam=True) == example.read_text(encoding="utf-8")
    study = ms.Study.load(example)
    assert study.structure is not None
    assert study.structure.build().bolts.tension.tolist() == [12250.0] * 3


def test_the_demo_runs_anywhere() -> None:
    outcome = run("demo")
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    assert outcome.stdout.endswith(" files in microslip-demo\n")
    assert names() == ["joint.toml", "microslip-demo"]
    assert "2 kN" in Path("microslip-demo/study.toml").read_text("utf-8")
    assert fails("demo") == (
        "error: microslip-demo: exists; replace it with --overwrite, or give another folder with -o"
    )
    outcome = run("demo", "-o", "other", "--json")
    summary = json.loads(outcome.stdout)
    assert 2000.0 in [joint["normal_load"] for joint in summary["joints"]]
    assert Path("other/summary.json").is_file()
