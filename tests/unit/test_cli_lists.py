"""The commands materials, schema and completion."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from command import STUDY, fails, run

from microslip.cli import main
from microslip.contact.materials import metals


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("joint.toml").write_text(STUDY, encoding="utf-8")


# -- lists -----------------------------------------------------------------------------------------


def test_materials_in_json() -> None:
    every = json.loads(run("materials", "--json").stdout)
    assert list(every) == list(metals())
    for name, metal in metals().items():
        entry = every[name]
        for key in ("description", "young_modulus", "poisson_ratio", "hardness"):
            assert entry[key] == getattr(metal, key)
        assert entry["sources"] == dict(metal.sources)
    assert json.loads(run("materials", "steel", "--json").stdout) == {"steel": every["steel"]}
    assert [*json.loads(run("materials", "S355", "--json").stdout)] == ["steel-s355"]
    assert fails("materials", "al2071").endswith("did you mean 'al2017'?")


# -- completion ------------------------------------------------------------------------------------


def completed(*words: str) -> list[str]:
    env = {"_MICROSLIP_COMPLETE": "bash_complete", "COMP_WORDS": shlex.join(words)}
    env["COMP_CWORD"] = str(len(words) - 1)
    outcome = CliRunner().invoke(main, [], prog_name="microslip", env=env)
    assert outcome.exit_code == 0, outcome.output
    return [line for line in outcome.stdout.splitlines() if line]


def test_completion_of_words() -> None:
    assert completed("microslip", "pr") == ["plain,predict"]
    assert completed("microslip", "predict", "j", "") == []
    assert "plain,--overwrite" in completed("microslip", "predict", "--o")
    assert completed("microslip", "materials", "al20") == ["plain,al2017", "plain,al2024"]
    assert completed("microslip", "new", "x.toml", "--law", "s") == ["plain,sphere"]
    assert completed("microslip", "completion", "") == ["plain,bash", "plain,zsh", "plain,fish"]


def test_completion_of_studies() -> None:
    Path("sub").mkdir()
    Path("sub/other.toml").touch()
    Path("joint.csv").touch()
    assert completed("microslip", "predict", "jo") == ["plain,joint.toml"]
    assert completed("microslip", "check", "sub/") == ["plain,sub/other.toml"]
    assert completed("microslip", "check", "su") == ["file,su"], "the shell completes folders"
    assert completed("microslip", "check", "no/where") == ["file,no/where"]


def test_completion_of_keys() -> None:
    predict = ("microslip", "predict", "joint.toml", "--set")
    assert completed(*predict, "joint.n") == ["plain,joint.normal_load="]
    assert "plain,surface.heights.std=" in completed(*predict, "")
    assert "plain,title=" in completed(*predict, "")
    assert completed(*predict, "joint.normal_load=") == []
    assert completed("microslip", "check", "--set", "joint.n") == []
    Path("joint.toml").write_text("= nonsense", encoding="utf-8")
    assert completed(*predict, "joint.n") == []


def test_completion_in_bash(tmp_path: Path) -> None:
    bash = shutil.which("bash")
    if bash is None or os.name == "nt":
        pytest.skip("there is no bash")
    command = tmp_path / "bin" / "microslip"
    command.parent.mkdir()
    command.write_text(
        f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m microslip.cli "$@"\n', encoding="utf-8"
    )
    command.chmod(0o755)
    script = """
    eval "$(microslip completion bash)"
    complete -p microslip
    COMP_WORDS=(microslip predict jo) COMP_CWORD=2
    _microslip_completion microslip
    echo "${COMPREPLY[@]}"
    """
    env = {**os.environ, "PATH": f"{command.parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run([bash, "-c", script], capture_output=True, text=True, env=env, check=True)
    assert done.stdout.splitlines()[-1] == "joint.toml"
    assert "_microslip_completion microslip" in done.stdout
