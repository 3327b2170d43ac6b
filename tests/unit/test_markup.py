"""Names with markup, quotes, formulas and control characters stay text wherever they go."""

from __future__ import annotations

import base64
import csv
import json
import os
import re
import shutil
import subprocess
import tempfile
import tomllib
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest
from command import run
from html_pages import Page
from studies import CURVE, LOADS, edited

import microslip as ms
from microslip._core.dataset import text_cell
from microslip._core.wording import one_line

pytestmark = pytest.mark.skipif(os.name == "nt", reason="files cannot have such names here")

RUN = "document.documentElement.dataset.ran=1"
SCRIPT, IMAGE = f"<script>{RUN}</script>", f"<img src=x onerror={RUN}>"
TITLE = f'</title>{SCRIPT}{IMAGE} "& =1+1 $\\frac{{$'
FORMULA = f'=HYPERLINK(1){IMAGE}"&'
NEWLINE = '-2"\ntitle = "mine"\x1b[31m\x9b31m$\\frac{$'
CALL = "=cmd|' /C calc'!A0"
PAIR = f"[{json.dumps(SCRIPT)}, {json.dumps(CALL)}]"
STEEL = f'[material.{json.dumps(CALL)}]\nyoung_modulus = "210 GPa"\npoisson_ratio = 0.3\n'
STUDY = edited(
    ('"A joint"', json.dumps(TITLE)),
    ("[material.al]", f"{STEEL}[material.{json.dumps(SCRIPT)}]"),
    ('["al", "al"]', PAIR),
    (LOADS, '"2 kN"'),
    (f"curve = {CURVE}", ""),
    ("[output]", f'history = {{ file = {json.dumps(FORMULA + ".csv")}, column = "displacement" }}'),
    ('formats = ["csv"]', ""),
)


class Left(NamedTuple):
    """What the commands leave behind."""

    folders: dict[str, Path]
    printed: str


@pytest.fixture(scope="module")
def left() -> Left:
    """Folders of every command that was given such names, and all that they printed."""
    home, before = Path(tempfile.mkdtemp()), Path.cwd()
    os.chdir(home)
    try:
        Path("study.toml").write_text(STUDY, encoding="utf-8")
        rig = ms.VirtualTribometer(ms.Interface.examples()[0], noise=0.003, sample_rate=2560)
        for amplitude, name in ((4e-6, FORMULA), (8e-6, NEWLINE)):
            record = rig.record(amplitude=amplitude, frequency=10.0, cycles=6)
            record.to_csv(f"{name}.csv")
            text = Path(f"{name}.csv").read_text(encoding="utf-8")
            text = text.replace("normal_load [N]", f'"{CALL} [N]"')
            Path(f"{name}.csv").write_text(text, encoding="utf-8")
        records = [f"{FORMULA}.csv", f"{NEWLINE}.csv"]
        rows = np.random.default_rng(1).normal(size=(40, 40))
        smooth = sum(np.roll(rows, shift, axis) for axis in (0, 1) for shift in range(-3, 4))
        np.savetxt(f"{FORMULA}.txt", 0.2 * smooth)
        load = ["--normal-load", CALL]
        commands = {
            "predict": ["study.toml"],
            "measure": [*load, "--png", "--", *records],
            "identify": [*load, "--study", "study.toml", "--", *records],
            "surface": ["--cutoff=none", "--pixel=2 um", "--unit=um", "--", f"{FORMULA}.txt"],
        }
        printed = ""
        for command, given in commands.items():
            outcome = run(command, "-o", command, *given)
            assert outcome.exit_code == 0, (command, outcome.output)
            printed += outcome.output
        return Left({command: home / command for command in commands}, printed)
    finally:
        os.chdir(before)


@pytest.mark.parametrize(
    ("command", "names"),
    [
        ("predict", [TITLE, SCRIPT, CALL, FORMULA]),
        ("measure", [FORMULA]),
        ("identify", [FORMULA]),
        ("surface", [FORMULA]),
    ],
)
def test_pages_hold_names_as_text(left: Left, command: str, names: list[str]) -> None:
    """No element, attribute or address is made of a name, and each name can be read.

    Links within the page lead to one element each.
    """
    page = Page((left.folders[command] / "report.html").read_text(encoding="utf-8"))
    for name in names:
        assert name in page.text
    anchors = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    links = [(attrs.get("href") or "")[1:] for tag, attrs in page.tags if tag == "a"]
    assert len(set(anchors)) == len(anchors)
    assert {link for link in links if "/" not in link} <= set(anchors)
    images = [attrs["src"] or "" for tag, attrs in page.tags if tag == "img"]
    assert images
    for image in images:
        harmless(base64.b64decode(image.partition(",")[2]))


def harmless(svg: bytes) -> str:
    """The words of a figure, in which nothing can run."""
    root = ElementTree.fromstring(svg)
    for element in root.iter():
        assert "script" not in element.tag
        assert "foreignObject" not in element.tag
        assert not any(name.startswith("on") for name in element.attrib)
    return "".join(root.itertext())


def test_figures_hold_names_as_text(left: Left) -> None:
    """Figures open in a browser, too."""
    figures = {path: harmless(path.read_bytes()) for path in left.folders["predict"].glob("*.svg")}
    assert len(figures) == 5
    assert all(TITLE[:20] in words for words in figures.values())
    assert (left.folders["measure"] / "loops.png").stat().st_size > 10_000


def browser() -> str:
    """The browser to look with."""
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        pytest.skip("no chromium is installed, so no browser reads the pages")
    return found


def as_read(page: Path, profile: Path) -> str:
    """The elements of a page after a browser has read it and run what it holds."""
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"]
    options += ["--disable-background-networking", f"--user-data-dir={profile}", "--dump-dom"]
    done = subprocess.run(
        [browser(), *options, page.as_uri()], capture_output=True, timeout=120, check=True
    )
    return done.stdout.decode("utf-8")


def test_nothing_runs_in_a_browser(left: Left, tmp_path: Path) -> None:
    """All pages in one, so that the browser starts once; and it would run what is not escaped."""
    pages = {command: folder / "report.html" for command, folder in left.folders.items()}
    whole = "".join(page.read_text(encoding="utf-8") for page in pages.values())
    (tmp_path / "all.html").write_text(whole, encoding="utf-8")
    read = as_read(tmp_path / "all.html", tmp_path / "profile")
    assert read.count("<figure>") >= 10
    assert "data-ran" not in read
    wrong = pages["measure"].read_text(encoding="utf-8").replace("&lt;", "<").replace("&gt;", ">")
    (tmp_path / "wrong.html").write_text(wrong, encoding="utf-8")
    # Even so the page's own policy lets nothing run; without it everything would.
    assert 'data-ran="1"' not in as_read(tmp_path / "wrong.html", tmp_path / "profile")
    (tmp_path / "open.html").write_text(re.sub("<meta http-equiv[^>]*>", "", wrong), "utf-8")
    assert 'data-ran="1"' in as_read(tmp_path / "open.html", tmp_path / "profile")


def test_tables_hold_no_formulas(left: Left) -> None:
    """A spreadsheet computes nothing, and nothing else is lost of a name than its controls."""
    tables = [path for folder in left.folders.values() for path in folder.glob("*.csv")]
    assert {"cycles.csv", "residuals.csv", "history.csv", "summits.csv"} <= {p.name for p in tables}
    for path in tables:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        assert len({len(row) for row in rows}) == 1
        for row in rows:
            for cell in row:
                assert "\n" not in cell
                if cell.lstrip()[:1] in tuple("=+-@"):
                    float(cell)
        if path.name in ("cycles.csv", "residuals.csv"):
            names = [one_line(NEWLINE), FORMULA]
            assert {row[0] for row in rows[1:]} == {f"'{name}" for name in names}


@pytest.mark.parametrize("name", ["=1", "+1", "-1", "@a", "  =1", "\N{FULLWIDTH EQUALS SIGN}1"])
def test_a_cell_is_no_formula(name: str) -> None:
    """Also behind spaces and in full width; what is no formula stays as it is."""
    assert text_cell(name) == f'"\'{name}"'
    assert text_cell(f"a{name}") == f'"a{name}"'
    assert text_cell('a"b\tc') == '"a""b\\tc"'


def test_data_hold_names_as_they_are(left: Left) -> None:
    """JSON and netCDF have quotes of their own."""
    summary = json.loads((left.folders["predict"] / "summary.json").read_text(encoding="utf-8"))
    assert summary["title"] == TITLE
    assert set(summary["study"]["material"]) == {SCRIPT, CALL}
    with h5py.File(left.folders["predict"] / "result.nc") as file:
        assert file.attrs["title"].decode("utf-8") == TITLE
    records = json.loads((left.folders["measure"] / "summary.json").read_text(encoding="utf-8"))
    assert [record["name"] for record in records["records"]] == [FORMULA, NEWLINE]


@pytest.mark.parametrize(
    ("command", "name"), [("predict", "study.toml"), ("identify", "joint.toml")]
)
def test_studies_hold_names_as_text(left: Left, command: str, name: str) -> None:
    """What is left to go on with is read as it was meant, comments of it included."""
    study = tomllib.loads((left.folders[command] / name).read_text(encoding="utf-8"))
    assert study["title"].startswith(TITLE)
    assert command == "identify" or set(study["material"]) == {SCRIPT, CALL}
    assert run("check", str(left.folders[command] / name)).exit_code == 0


def test_a_terminal_is_not_painted(left: Left) -> None:
    """Control characters of a name are shown, not sent."""
    assert not {c for c in left.printed if not c.isprintable()} - {"\n", "\N{NO-BREAK SPACE}"}
    assert "\\x1b" in left.printed
