"""Friction laws in JSON files come back as they were; files that are no laws are refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.friction import LAWS
from microslip.friction.law_files import _by_name

EXAMPLES = [law for kind in LAWS for law in kind.examples()]


@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: type(law).__name__)
def test_a_law_of_numbers_comes_back_and_others_are_refused(
    law: ms.BackboneLaw, tmp_path: Path
) -> None:
    file = tmp_path / "law.json"
    if type(law) not in _by_name().values():
        with pytest.raises(ms.InputError, match="law must be one of coulomb, jenkins"):
            ms.friction.save_law(law, file)
        assert not file.exists()
        return
    ms.friction.save_law(law, file)
    again = ms.friction.load_law(file)
    assert type(again) is type(law)
    x = np.array([0.0, 1e-7, 3e-6, -2e-6, 1e-5])
    np.testing.assert_array_equal(again.force(x), law.force(x))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "microslip-result"}, 'is not a law file: "kind" must be "microslip-law"'),
        ({"version": 2}, "version must be 1, got 2"),
        ({"law": "bouc-wen"}, "law must be one of coulomb, jenkins, iwan, segalman, sliders, got"),
        ({"parameters": {"stiffness": 1.0}}, "parameters of jenkins must be stiffness, force_lim"),
        ({"parameters": {"stiffness": -1.0, "force_limit": 1.0}}, "stiffness must be above zero"),
        ({"units": {"stiffness": "N/mm", "force_limit": "N"}}, "units must be"),
    ],
)
def test_a_wrong_file_is_refused(change: dict[str, Any], message: str, tmp_path: Path) -> None:
    file = tmp_path / "law.json"
    ms.friction.save_law(ms.Jenkins(5e7, 100.0), file)
    content = json.loads(file.read_text("utf-8"))
    file.write_text(json.dumps(content | change), "utf-8")
    with pytest.raises(ms.InputError) as caught:
        ms.friction.load_law(file)
    assert str(caught.value).startswith(f"law.json: {message}")


def test_text_is_no_law(tmp_path: Path) -> None:
    (tmp_path / "law.json").write_text("[[[", "utf-8")
    with pytest.raises(ms.InputError, match=r"law\.json: is not a JSON law file"):
        ms.friction.load_law(tmp_path / "law.json")
    with pytest.raises(ms.InputError, match=r"other\.json: no such file"):
        ms.friction.load_law(tmp_path / "other.json")
