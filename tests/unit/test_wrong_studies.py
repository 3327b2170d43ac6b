"""Wrong studies: the one line that each of them gets, pinned as it is read."""

from __future__ import annotations

from pathlib import Path

import pytest
from cases import refusal
from studies import CURVE, STUDY, edited

import microslip as ms

EMPTY = "wanted a study, got none; microslip new NAME.toml writes one"
FILES = {
    "empty": ("joint.toml", b"", EMPTY),
    "blank": ("joint.toml", b"\n\n", EMPTY),
    "comment": ("joint.toml", b"# only a comment", EMPTY),
    "no UTF-8": ("joint.toml", STUDY.replace("A joint", "Füge").encode("latin-1"),
                 "line 2: not UTF-8 text (byte 0xfc); save the file as UTF-8"),
    "deep": ("joint.toml", b"a = " + 100_000 * b"[", "nested too deeply"),
    "missing": ("jiont.toml", b"", 'no such file; did you mean "joint.toml"?'),
    "no folder": ("x/joint.toml", b"", "no such file"),
    "long": ("x" * 300, b"", "cannot be read"),
    "null": ("a\0b", b"", "cannot be read"),
    "device": ("/dev/zero", b"", "wanted a study file, got a device"),
}  # fmt: skip


@pytest.mark.parametrize("case", FILES)
def test_a_file_that_is_no_study_is_one_line(case: str, here: Path) -> None:
    name, content, message = FILES[case]
    (here / "joint.toml").write_bytes(content)
    if name == "/dev/zero" and not Path(name).exists():
        pytest.skip("there is no such device")
    line = refusal(ms.Study.load, name)
    assert line.startswith(repr(name)[1:-1][:100])
    assert message in line


def test_a_history_is_limited_by_memory(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("x.csv").write_text("x [um]\n" + 60 * "1\n-1\n")
    history = 'history = { file = "x.csv", column = "x" }'
    text = edited((f"curve = {CURVE}", history))
    monkeypatch.setattr("microslip.study.consistency.MAX_SAMPLES", 200)
    assert refusal(ms.Study.from_toml, text) == (
        "study: excitation.history: wanted at most 200 samples in all, got 240 (loads times rows)"
    )
    monkeypatch.setattr("microslip.study.fields.MAX_ROWS", 100)
    assert refusal(ms.Study.from_toml, text) == (
        "study: excitation.history: x.csv: wanted at most 100 rows, got more"
    )
