"""The record of predictions: frozen inputs, true labels, a page that shows what was computed."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


def runner() -> ModuleType:
    spec = importlib.util.spec_from_file_location("record_run", ROOT / "record" / "run.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["record_run"] = module
    spec.loader.exec_module(module)
    return module


RUN = runner()
RESULTS = json.loads(RUN.RESULTS.read_text("utf-8"))["cases"]


@pytest.mark.parametrize("name", RUN.cases())
def test_a_case_is_frozen_and_described(name: str) -> None:
    RUN.check_frozen(name)
    case, rows = RUN.read_case(name), RESULTS[name]["rows"]
    assert [row["name"] for row in rows] == [row["name"] for row in case["measured"]]
    assert [row["measured"] for row in rows] == [float(row["value"]) for row in case["measured"]]
    assert ("miss" in case) == any(not row["inside"] for row in rows)


def test_a_changed_input_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RUN, "HERE", tmp_path)
    case = tmp_path / "new"
    case.mkdir()
    (case / "predict.py").write_text("FRICTION = 0.2\n", "utf-8")
    with pytest.raises(ValueError, match="new is not frozen"):
        RUN.check_frozen("new")
    (case / "frozen.sha256").write_text(RUN.checksums("new"), "utf-8")
    RUN.check_frozen("new")
    (case / "predict.py").write_text("FRICTION = 0.3\n", "utf-8")
    with pytest.raises(ValueError, match="inputs of new have changed"):
        RUN.check_frozen("new")


def test_the_page_shows_the_results() -> None:
    assert RUN.PAGE.read_text("utf-8") == RUN.page(RESULTS)


@pytest.mark.parametrize("name", ["fouvry-2017", "kono-2012"])
def test_quick_cases_predict_the_stored_numbers(name: str) -> None:
    bands = RUN.predict(name)
    for row in RESULTS[name]["rows"]:
        np.testing.assert_allclose(bands[row["name"]], row["predicted"], rtol=1e-9)
