"""Wrong studies: the one line that each of them gets, pinned as it is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from studies import STUDY

import microslip as ms


def test_an_empty_study_is_reported_how_to_begin(tmp_path: Path) -> None:
    for text in ("", "\n\n", "# only a comment"):
        path = tmp_path / "joint.toml"
        path.write_text(text)
        assert message_of(path) == (
            f"{path}: wanted a study, got none; microslip new NAME.toml writes one"
        )


# What only the numbers tell. -----------------------------------------------------------------


def refused(**changes: Any) -> str:
    """The message of a study in Python, its `study: ` taken off."""
    surface = {"law": "sphere", "materials": ("steel", "al2017"), "radius": "5 mm"}
    joint = {"friction_coefficient": 0.2, "normal_load": ("1 N", "2 N")}
    with pytest.raises(ms.StudyError) as caught:
        ms.Study(**{"schema": 1, "surface": surface, "joint": joint, **changes})
    return str(caught.value).removeprefix("study: ")


def test_a_history_is_limited_by_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "x.csv").write_text("x [um]\n" + 60 * "1\n-1\n")
    joint = {"friction_coefficient": 0.2, "normal_load": ["1 N", "2 N"]}
    excitation = {"history": {"file": str(tmp_path / "x.csv"), "column": "x"}}
    monkeypatch.setattr("microslip.study.consistency.MAX_SAMPLES", 200)
    assert refused(joint=joint, excitation=excitation) == (
        "excitation.history: wanted at most 200 samples in all, got 240 (loads times rows)"
    )
    monkeypatch.setattr("microslip.study.fields.MAX_ROWS", 100)
    assert refused(joint=joint, excitation=excitation) == (
        f"excitation.history: {tmp_path / 'x.csv'}: wanted at most 100 rows, got more"
    )


# -- columns of files -----------------------------------------------------------------------


# -- the file itself ------------------------------------------------------------------------


def message_of(path: Path) -> str:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.load(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_missing_file_is_named_with_the_nearest_one(tmp_path: Path) -> None:
    (tmp_path / "joint.toml").write_text(STUDY)
    path = tmp_path / "jiont.toml"
    assert message_of(path) == f'{path}: no such file; did you mean "joint.toml"?'
    path = tmp_path / "x" / "joint.toml"
    assert message_of(path) == f"{path}: no such file"


def test_a_file_that_is_not_utf8_is_located(tmp_path: Path) -> None:
    path = tmp_path / "joint.toml"
    path.write_bytes(STUDY.replace("A joint", "Füge").encode("latin-1"))
    assert message_of(path) == (
        f"{path}: line 2: not UTF-8 text (byte 0xfc); save the file as UTF-8"
    )


def test_odd_paths_and_sizes_are_reported(tmp_path: Path) -> None:
    assert "cannot be read" in message_of(tmp_path / ("x" * 300))
    assert "cannot be read" in message_of(Path("a\0b"))
    assert "nested too deeply" in message_of_text("a = " + 100_000 * "[")
    if Path("/dev/zero").exists():
        assert "wanted a study file, got a device" in message_of(Path("/dev/zero"))


def message_of_text(text: str) -> str:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text)
    return str(caught.value)
