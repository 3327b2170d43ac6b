"""The commands check, new and demo."""

from __future__ import annotations

import errno
import io
import json
import os
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import STUDY, fails, names, run

import microslip as ms
from microslip.study.new import TEMPLATE_LAWS, TEMPLATES, demo_text, template


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
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
        " To compute 2 loops, curves of 20 points in all, and write 4 files:\n"
        "  microslip predict joint.toml --set 'joint.normal_load=3 kN'\n"
    )


def test_check_says_what_comes_from_the_table_and_from_files() -> None:
    rows = "\n".join(f"{0.1 * i},{i}" for i in range(30))
    Path("data.csv").write_text(f"x [um],y [nm]\n{rows}\n", encoding="utf-8")
    text = STUDY.replace('["al", "al"]', '["steel", "glass"]').replace(
        'al = { young_modulus = "69 GPa", poisson_ratio = 0.33, hardness = "1.2 GPa" }',
        "glass.rigid = true",
    )
    text = text.replace(
        'kind = "gaussian", std = "0.5 um"', 'kind = "values", file = "data.csv", column = "y"'
    )
    text = text.replace("[output]", 'history = { file = "data.csv", column = "x" }\n\n[output]')
    Path("files.toml").write_text(text, encoding="utf-8")
    outcome = run("check", "files.toml")
    assert outcome.exit_code == 0, outcome.output
    assert re.search(
        r"\nmaterial\.steel\.young_modulus +– \(table of metals\) +2\.1e11 Pa\n", outcome.stdout
    )
    assert re.search(
        r'\nsurface\.heights\.values +data\.csv, column "y" +30 values, 0 to 2\.9e-8 m\n',
        outcome.stdout,
    )
    assert re.search(
        r'\nexcitation\.history +data\.csv, column "x" +30 values, 0 to 2\.9e-6 m\n', outcome.stdout
    )
    assert "EN 1993-1-1:2005" in outcome.stdout
    assert "histories of 30 samples in all" in outcome.stdout
    found = json.loads(run("check", "files.toml", "--json").stdout)
    entries = {entry.pop("key"): entry for entry in found["quantities"]}
    assert entries["surface.heights.values"] == {
        "written": 'data.csv, column "y"',
        "count": 30,
        "smallest": 0.0,
        "largest": 2.9e-8,
        "unit": "m",
    }
    assert entries["material.steel.young_modulus"] == {
        "written": None,
        "value": 210e9,
        "unit": "Pa",
    }
    assert "material.glass.rigid" not in entries


def test_check_in_json() -> None:
    outcome = run("check", "joint.toml", "--json")
    assert outcome.exit_code == 0
    found = json.loads(outcome.stdout)
    assert found["kind"] == "microslip-check"
    assert (found["loops"], found["points"], found["samples"]) == (2, 20, 0)
    assert run("predict", "joint.toml").exit_code == 0
    summary = json.loads(Path("joint-result/summary.json").read_text("utf-8"))
    assert found["files"] == summary["files"]
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


def test_a_name_without_its_end_is_completed() -> None:
    line = 'error: joint: no such file; did you mean "joint.toml"?'
    assert fails("check", "joint") == line
    assert fails("predict", "joint") == line
    Path("joint.csv").touch()  # now it is not clear which
    assert fails("check", "joint") == "error: joint: no such file"


def test_check_finds_what_predict_would_find() -> None:
    Path("joint.toml").write_text(STUDY.replace("1 mm", "1 mn"), encoding="utf-8")
    assert fails("check", "joint.toml") == fails("predict", "joint.toml")
    assert fails("check", "elsewhere") == "error: elsewhere: no such file"
    assert fails("check", "joint.toml", "--set", "joint.normal_lod=3 kN").startswith(
        "error: joint.toml: "
    )


# -- new, demo -------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", TEMPLATE_LAWS)
def test_a_new_study_runs_as_it_is(law: str) -> None:
    outcome = run("new", "mine.toml", "--law", law)
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    assert outcome.stdout == (
        "Written to mine.toml. Next:\n  microslip check mine.toml\n  microslip predict mine.toml\n"
    )
    text = Path("mine.toml").read_text("utf-8")
    assert max(map(len, text.splitlines())) <= 110
    assert text.isascii()
    study = ms.Study.load("mine.toml")
    assert study.title == "mine"
    assert study.surface.law == law
    result = study.run()
    verdicts = [verdict for joint in result.joints for verdict in joint.validity]
    # Summits of mild steel yield; these are of hardened steel.
    assert {verdict.word for verdict in verdicts} <= {"ok"}
    ratios = result.rows[-1].force_ratio
    assert ratios[0] < 0.75
    assert ratios[-1] > 0.99, "from micro to gross slip"


@pytest.mark.slow
@pytest.mark.parametrize("law", TEMPLATE_LAWS)
def test_every_key_of_a_new_study_can_be_used(law: str) -> None:
    """Each line in a comment counts without its #, in place of the one that it excludes."""
    rows = "\n".join(f"{0.1 * i},{0.2 * i},{9 - 0.25 * i + 0.002 * i**2}" for i in range(20))
    Path("record.csv").write_text(f"x [um],t [s],N\n{rows}\n", encoding="utf-8")
    Path("heights.csv").write_text(f"y [um],t,N\n{rows}\n", encoding="utf-8")
    Path("normal.csv").write_text(f"d [um],t,N [kN]\n{rows}\n", encoding="utf-8")
    text = template(law=law)
    keys = [line for line in text.splitlines() if re.match(r"# (\w+ = |\[)", line)]
    assert len(keys) >= 6
    for line in keys:
        key = re.match(r"# \[?([\w.]+)", line)[1]  # type: ignore[index]
        changed = text.replace(line, line[2:])
        if line.startswith("# ["):
            start = changed.index(line[2:])
            end = changed.index("\n\n", start)
            changed = changed[:start] + changed[start:end].replace("\n# ", "\n") + changed[end:]
            assert key in changed
        elif re.search(rf"(?s)\n# \[[^\n]*\n(# [^\n]*\n)*{re.escape(line)}\n", text):
            continue  # with its table
        elif key in ("file", "column"):
            changed = re.sub(r"(?s)\nvalues = \[.*?\n\]", "", text).replace("# file", "file")
            changed = changed.replace("# column", "column")
        elif law == "table" and key in ("separation", "load"):
            changed = re.sub(r"(?m)^(separation|load) = .*\n", "", text)
            changed = re.sub(r"(?m)^# ((separation|load) = )", r"\1", changed)
        else:
            other = "amplitudes" if key == "force_amplitudes" else key
            changed = re.sub(rf"(?m)^{other} = .*\n", "", text).replace(line, line[2:])
        study = ms.Study.from_toml(changed, "new", folder=Path.cwd())
        assert all(np.isfinite(row.dissipated_energy).all() for row in study.run().rows), line


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


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("mine", 'mine: wanted a name that ends in .toml, such as "mine.toml"'),
        ("mine.tml", 'mine.tml: wanted a name that ends in .toml, such as "mine.toml"'),
        (".toml", '.toml: wanted a name that ends in .toml, such as "joint.toml"'),
        ("", '.: wanted a name that ends in .toml, such as "joint.toml"'),
        ("no/mine.toml", "no/mine.toml: cannot be written: no such file or directory"),
    ],
)
def test_new_with_a_name_that_will_not_do(name: str, line: str) -> None:
    assert fails("new", name) == f"error: {line}"


def test_new_with_another_law() -> None:
    assert fails("new", "mine.toml", "--law", "sphre") == (
        "error: --law: wanted greenwood-williamson, population, sphere, table, "
        'got "sphre"; did you mean "sphere"? (usage: microslip new [OPTIONS] NAME.toml)'
    )
    with pytest.raises(ms.StudyError) as caught:
        template(law="greenwood")
    assert str(caught.value) == (
        'law: wanted "greenwood-williamson", "population", "sphere" or "table", got "greenwood"; '
        'did you mean "greenwood-williamson"?'
    )


def test_new_on_a_full_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(io.BytesIO):
        def write(self, text: Any) -> int:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    opened = Path.open

    def full(path: Path, mode: str = "r", *rest: Any, **options: Any) -> Any:
        if "x" not in mode:  # what comes with the package is read
            return opened(path, mode, *rest, **options)
        path.touch()
        return Full()

    monkeypatch.setattr(Path, "open", full)
    assert fails("new", "mine.toml") == (
        "error: mine.toml: cannot be written: no space left on device"
    )


@pytest.mark.parametrize("name", ['a "b" \\ c.toml', "Füge.toml", "spaces in it.toml"])
def test_new_with_a_name_to_be_quoted(name: str) -> None:
    if os.name == "nt":
        pytest.skip("no such names there")
    outcome = run("new", name)
    assert outcome.exit_code == 0, outcome.output
    assert ms.Study.load(name).title == name.removesuffix(".toml")
    *_, last = outcome.stdout.splitlines()
    assert shlex.split(last) == ["microslip", "predict", name]
    assert last.split("predict ")[1] in Path(name).read_text("utf-8")


def test_new_points_to_the_schema_only_where_it_lies_beside() -> None:
    assert run("new", "first.toml").exit_code == 0
    assert "#:schema" not in Path("first.toml").read_text("utf-8")
    Path("study.schema.json").write_text(run("schema").stdout, encoding="utf-8")
    assert run("new", "second.toml").exit_code == 0
    assert (
        Path("second.toml").read_text("utf-8").startswith("#:schema study.schema.json\n# A study")
    )
    assert ms.Study.load("second.toml").title == "second"


def test_the_beam_is_the_example_and_fine() -> None:
    example = Path(__file__).parents[2] / "examples/bolted_beam.toml"
    assert demo_text(beam=True) == example.read_text(encoding="utf-8")
    study = ms.Study.load(example)
    assert study.structure is not None
    assert study.structure.build().bolts.tension.tolist() == [12250.0] * 3


def test_the_demo_runs_anywhere() -> None:
    outcome = run("demo")
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    assert "\nWritten to microslip-demo:\n" in outcome.stdout
    assert names() == ["joint.toml", "microslip-demo"]
    assert "2 kN" in Path("microslip-demo/study.toml").read_text("utf-8")
    assert fails("demo") == (
        "error: microslip-demo: exists; replace it with --overwrite, or give another folder with -o"
    )
    outcome = run("demo", "-o", "other", "--json")
    summary = json.loads(outcome.stdout)
    assert 2000.0 in [joint["normal_load"] for joint in summary["joints"]]
    assert Path("other/summary.json").is_file()
