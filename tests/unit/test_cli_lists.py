"""The command materials."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command import STUDY, fails, run

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
