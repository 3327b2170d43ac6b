"""What the README promises beyond its code blocks, which test_docs.py runs."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import pages
import pytest
import run as bench

import microslip as ms

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = README.splitlines()


def test_the_two_commands_stand_alone_on_their_lines() -> None:
    for command in ("make demo", "make test"):
        assert LINES.count(command) == 1
    assert LINES.index("make demo") < LINES.index("make test")


def test_the_picture_is_there_and_small() -> None:
    (name,) = re.findall(r"(?m)^!\[[^]]+\]\(([^)]+)\)", README)
    picture = (ROOT / name).read_bytes()
    assert picture[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", picture[16:24])
    assert 800 <= width <= 1200
    assert height <= width
    assert len(picture) < 150_000


def test_it_is_short_and_its_first_snippet_too() -> None:
    assert len(LINES) <= 120
    snippet = re.findall(r"(?ms)^```python\n(.*?)^```", README)[0]
    assert len([line for line in snippet.splitlines() if line]) <= 9


def test_the_timings_are_those_of_the_script() -> None:
    """The tables, whole, with every task that is wanted something of."""
    page = (ROOT / "docs" / "timings.md").read_text(encoding="utf-8")
    begin, end = pages.markers("timings", "run.py")
    assert page.count(begin) == page.count(end) == 1
    text = page.split(begin)[1].split(end)[0]
    first, second, *sweeps = re.findall(r"(?m)(?:^\|.*\|\n)+", text)
    assert first.splitlines()[0] == "| task | wanted | measured |"
    assert second.splitlines()[0] == f"| {' | '.join(bench.OTHERS_HEAD)} |"
    for table in sweeps:
        assert table.splitlines()[0] == f"| {' | '.join(bench.SWEEPS_HEAD)} |"
    for wanted in ("≥ 50 M/s", "≥ 20 M/s", "≤ 50 µs", "≤ 20 ms", "≤ 1 ms"):
        assert f"| {wanted} |" in first
    assert re.search(r"microslip \d+\.\d+\.\d+", text)
    assert "numpy" not in text.split("|")[0]


def test_the_benchmark_compares_like_with_like() -> None:
    """The three ways to the same forces give the same forces."""
    joint = ms.Interface(bench.make_surface(), friction_coefficient=0.55, normal_load=2000.0)
    for history in (bench.sine(300, 50), bench.gaussian_noise(300), bench.turning_noise(300)):
        forces = joint.force(history)
        assert bench.difference(bench.naive_force(joint, history), forces, joint) < 1e-14
    few = bench.turning_noise(20)
    population = bench.explicit_population(joint)
    assert bench.difference(population.force(few), joint.force(few), joint) < 1e-5
    assert bench.turning_share(bench.turning_noise(1000)) == pytest.approx(1.0, abs=2e-3)
    assert bench.turning_share(bench.sine(1000, 100)) == pytest.approx(0.02, abs=1e-3)


def test_the_benchmark_judges_and_writes() -> None:
    rate = bench.Row("r", 49e6, True, 50e6)
    seconds = bench.Row("t", 4.9e-5, False, 5e-5)
    assert (rate.verdict, seconds.verdict) == ("missed", "ok")
    assert (rate.measured_text, rate.wanted_text) == ("49 M/s", "≥ 50 M/s")
    assert (seconds.measured_text, seconds.wanted_text) == ("49 µs", "≤ 50 µs")
    assert bench.Row("n", 1.0).verdict == ""
    assert [bench.quantity(v, False) for v in (3.456e-9, 0.99999, 1.26e-2)] == [
        *("3.46 ns", "1.00 s", "12.6 ms")
    ]
    assert bench.two_digits(123456.0) == "120 000"
    text = bench.page_text([rate, seconds], [["a", "b", "c", "d", "e"]], "A machine.")
    assert "| r | ≥ 50 M/s | **49 M/s** (missed) |" in text
    assert "| t | ≤ 50 µs | 49 µs |" in text
    swept = bench.page_text([rate], [["a"] * 5], "A machine.", [["s", "t", "u", "v", "ok"]])
    *_, head, ruler, line = swept.splitlines()
    assert head == f"| {' | '.join(bench.SWEEPS_HEAD)} |"
    assert (ruler, line) == ("| --- | ---: | ---: | ---: | ---: |", "| s | t | u | v | ok |")


def test_the_tables_go_between_the_markers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "timings.md"
    section = ("timings.md", "timings", "run.py")
    begin, end = pages.markers(*section[1:])
    page.write_text(f"before\n{begin}\nold\n{end}\nafter\n", encoding="utf-8")
    monkeypatch.setattr(pages, "DOCS", tmp_path)
    pages.write_section(*section, "new")
    pages.write_section(*section, "newer")
    expected = f"before\n{begin}\nnewer\n{end}\nafter\n"
    assert page.read_text(encoding="utf-8") == expected
    page.write_text("no markers\n", encoding="utf-8")
    with pytest.raises(SystemExit, match="must hold these two lines"):
        pages.write_section(*section, "new")
