"""The command line: what it prints, where it writes, how it fails."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import microslip as ms
from microslip.cli import main

STUDY = """\
schema = 1
title = "A [bold] joint"
material.al = { young_modulus = "69 GPa", poisson_ratio = 0.33, hardness = "1.2 GPa" }

[surface]
materials = ["al", "al"]
law = "greenwood-williamson"
heights = { kind = "gaussian", std = "0.5 um" }
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"

[joint]
friction_coefficient = 0.55
normal_load = "2 kN"

[excitation]
amplitudes = ["0.1 um", "1 um"]
curve = { from = "1 nm", to = "100 um", points = 20 }

[output]
formats = ["csv"]
"""


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("joint.toml").write_text(STUDY, encoding="utf-8")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


def names() -> list[str]:
    return sorted(path.name for path in Path.cwd().iterdir())


def fails(*arguments: str, code: int = 2) -> str:
    """The one line on standard error of a command that fails and leaves no trace."""
    before = names()
    outcome = run(*arguments)
    assert outcome.exit_code == code, outcome.output
    assert outcome.stdout == ""
    assert outcome.stderr.count("\n") == 1
    assert names() == before
    return outcome.stderr.rstrip("\n")


def test_version_names_the_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    assert re.fullmatch(
        rf"microslip {re.escape(ms.__version__)} \(kernel: (compiled|numpy)\)\n",
        run("--version").stdout,
    )
    monkeypatch.setenv("MICROSLIP_KERNEL", "numpy")
    assert run("--version").stdout == f"microslip {ms.__version__} (kernel: numpy)\n"


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["predict", "--help"], []])
def test_help_needs_no_numpy(arguments: list[str]) -> None:
    code = (
        "import sys\nfrom microslip.cli import main\n"
        f"try: main({arguments!r})\n"
        "except SystemExit as end: assert end.code == 0, end.code\n"
        "assert not {'numpy', 'pint', 'pydantic', 'rich', 'matplotlib'} & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "microslip" in done.stdout or "main" in done.stdout or "-c" in done.stdout


def test_predict_prints_tables_and_writes_a_folder() -> None:
    outcome = run("predict", "joint.toml")
    assert outcome.exit_code == 0, outcome.output
    assert outcome.stderr == ""
    assert names() == ["joint-result", "joint.toml"]
    assert sorted(p.name for p in Path("joint-result").iterdir()) == [
        "curves.csv",
        "loops.csv",
        "study.toml",
        "summary.json",
    ]
    text = outcome.stdout
    assert text.startswith("A [bold] joint\n")
    assert re.search(r"2 kN +5700 +2\.79 % +5\.70 GN/m +1\.10 kN +343 nm +0\.568\n", text)
    assert re.search(r"2 kN +100 nm +0\.421 +13\.6 µJ +0\.0934 +0\.0467\n", text)
    assert "Validity\n" in text
    assert "ζ_mode = ΣE_d / 4πU" in text
    assert "Written to joint-result:\n  summary.json  study.toml  loops.csv  curves.csv\n" in text
    assert "\x1b" not in text


def test_json_is_the_summary_and_nothing_else() -> None:
    outcome = run("predict", "joint.toml", "--json", "-o", "out")
    assert outcome.exit_code == 0
    assert json.loads(outcome.stdout) == json.loads(Path("out/summary.json").read_text("utf-8"))


def test_an_existing_folder_is_refused_before_anything_is_computed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert run("predict", "joint.toml", "-o", "out").exit_code == 0
    monkeypatch.setattr("microslip.study.run.run", lambda *_: pytest.fail("computed"))
    assert fails("predict", "joint.toml", "-o", "out") == (
        "error: out: exists; replace it with --overwrite or name another with -o"
    )
    Path("mine").mkdir()
    Path("mine/thesis.tex").write_text("years of work")
    assert fails("predict", "joint.toml", "-o", "mine", "--overwrite") == (
        "error: mine: not replaced: it is no result of microslip (no summary.json of one)"
    )
    assert fails("predict", "joint.toml", "-o", "joint.toml/x").startswith(
        "error: joint.toml/x: cannot be written: "
    )
    assert fails("predict", "joint.toml", "-o", ".", "--overwrite") == (
        "error: .: not replaced: it holds the current or the home folder"
    )


def test_overwrite_replaces_a_result() -> None:
    assert run("predict", "joint.toml", "-o", "out").exit_code == 0
    Path("joint.toml").write_text(STUDY.replace("2 kN", "3 kN"), encoding="utf-8")
    assert run("predict", "joint.toml", "-o", "out", "--overwrite").exit_code == 0
    assert (
        json.loads(Path("out/summary.json").read_text("utf-8"))["joints"][0]["normal_load"] == 3e3
    )


def test_a_wrong_study_is_one_line() -> None:
    assert fails("predict", "jiont.toml") == (
        'error: jiont.toml: no such file; did you mean "joint.toml"?'
    )
    Path("joint.toml").write_text(STUDY.replace("0.5 um", "0.5 GPa"), encoding="utf-8")
    assert fails("predict", "joint.toml") == (
        'error: joint.toml: surface.heights.std: wanted a length such as "0.5 um", '
        'got "0.5 GPa" (a pressure)'
    )


def test_a_wrong_command_is_one_line() -> None:
    assert (
        fails("predcit")
        == 'error: no command "predcit"; did you mean "predict"? (commands: predict)'
    )
    assert "Missing argument 'STUDY'" in fails("predict")
    assert "No such option" in fails("predict", "joint.toml", "--overwrit")
    assert "unexpected extra argument" in fails("predict", "joint.toml", "b.toml")


def test_an_internal_error_is_one_line_and_exits_1(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("a\nbug")

    monkeypatch.setattr("microslip.study.run.run", fail)
    assert fails("predict", "joint.toml", code=1) == (
        "error: internal error: RuntimeError: a bug (MICROSLIP_DEBUG=1 shows where)"
    )
    monkeypatch.setenv("MICROSLIP_DEBUG", "1")
    assert isinstance(run("predict", "joint.toml").exception, RuntimeError)


def test_interrupts_leave_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    assert run("predict", "joint.toml", "-o", "out").exit_code == 0
    before = {path.name: path.read_bytes() for path in Path("out").iterdir()}

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    def terminate(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr("microslip.study.output.curve_blocks", interrupt)
    assert run("predict", "joint.toml", "-o", "out", "--overwrite").exit_code == 130
    if os.name != "nt":
        monkeypatch.setattr("microslip.study.output.curve_blocks", terminate)
        assert run("predict", "joint.toml", "-o", "out", "--overwrite").exit_code == 143
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    assert names() == ["joint.toml", "out"]
    assert {path.name: path.read_bytes() for path in Path("out").iterdir()} == before


def piped(**environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "microslip.cli", "predict", "joint.toml", "--overwrite"],
        capture_output=True,
        env={**os.environ, "PYTHONUTF8": "0", **environment},
        check=False,
    )


def test_a_pipe_gets_whole_lines_without_colour() -> None:
    done = piped(PYTHONIOENCODING="utf-8", COLUMNS="20")
    assert done.returncode == 0, done.stderr
    text = done.stdout.decode("utf-8")
    assert "\x1b" not in text
    assert "…" not in text
    assert re.search(r"2 kN +5700 +2\.79 % +5\.70 GN/m +1\.10 kN +343 nm +0\.568\r?\n", text)


def test_a_stream_without_greek_gets_plain_letters() -> None:
    Path("joint.toml").write_text(STUDY.replace("A [bold]", "Füge"), encoding="utf-8")
    done = piped(PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    text = done.stdout.decode("ascii")
    assert text.startswith("F?ge joint")
    assert re.search(r"2 kN \| +100 nm \| +0\.421 \| +13\.6 uJ \| +0\.0934 \| +0\.0467", text)
    assert "zeta_mode = sum E_d / 4 pi U" in text


def printed(text: str) -> str:
    Path("joint.toml").write_text(text, encoding="utf-8")
    outcome = run("predict", "joint.toml", "--overwrite")
    assert outcome.exit_code == 0, outcome.output
    assert outcome.stderr == ""
    return outcome.stdout


def test_verdicts_say_where_ok_is() -> None:
    text = printed(STUDY.replace("2 kN", "30 kN"))
    assert "  watch   plasticity index: 0.721 (ok up to 0.6) – assumed: summits deform" in text
    assert re.search(r"  outside real over apparent area: \d\d\.\d % \(ok up to 10 %\) – ", text)
    text = printed(STUDY.replace("100 1/mm^2", "0.1 1/mm^2"))
    assert re.search(r"  (watch  |outside) contacts: [\d.]+ \(ok from 30\) – assumed: ", text)


def test_numbers_are_no_more_than_they_are() -> None:
    start, end = STUDY.index("law ="), STUDY.index("[joint]")
    sphere = f'{STUDY[:start]}law = "sphere"\nradius = "5 mm"\n\n{STUDY[end:]}'
    assert re.search(r"\n50 N +1 +0\.0\d+ mm²", printed(sphere.replace("2 kN", "50 N")))
    heights = 'heights = { kind = "values", values = ["9 um", "8 um", "-9 um"] }'
    two = f'{STUDY[:start]}law = "population"\nradius = "1 mm"\n{heights}\n{STUDY[end:]}'
    assert re.search(r"\n50 N +2 +", printed(two.replace("2 kN", "50 N")))
    text = printed(STUDY.replace('["0.1 um", "1 um"]', '["1 um", "100 um"]'))
    assert re.search(r"2 kN +1 µm +>0\.999 ", text)
    assert re.search(r"2 kN +100 µm +1\.000 ", text)
    far = '"gaussian", mean = "1 mm", std = "0.1 nm"'
    shown = printed(STUDY.replace('"gaussian", std = "0.5 um"', far))
    assert float(shown.splitlines()[5].split()[-1]) < -1000.0
    assert len(shown.splitlines()[5].split()[-1]) < 10


def test_a_title_that_cannot_be_drawn_is_said_once() -> None:
    text = STUDY.replace("A [bold] joint", "Stoß 接触" + 120 * "W").replace('["csv"]', '["png"]')
    said = "title: the figures have no letters for 接触 and draw boxes."
    assert printed(text).count(said) == 1
    assert "title:" not in printed(text.replace("接触", ""))
    assert "title:" not in printed(text.replace('["png"]', '["csv"]'))


def test_long_words_of_a_title_are_broken() -> None:
    from matplotlib import style

    from microslip.study.drawing import STYLE, new_figure

    with style.context(["default", STYLE]):
        figure = new_figure(3.0, "A " + 120 * "W" + " joint")
        lines = figure.get_suptitle().splitlines()
        assert [len(line) for line in lines] == [52, 50, 26]
        figure.draw_without_rendering()
    box = figure.texts[0].get_window_extent()
    assert 0.0 <= box.x0 < box.x1 <= figure.bbox.width


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
@pytest.mark.parametrize(
    "arguments", [["predict", "joint.toml"], ["predict", "joint.toml", "--json"], ["--help"]]
)
def test_a_full_output_is_one_line(arguments: list[str]) -> None:
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "microslip.cli", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    wanted = "error: standard output cannot be written: no space left on device\n"
    assert done.stderr == wanted
    assert ("joint-result" in names()) == (arguments[0] == "predict")


@pytest.mark.skipif(os.name == "nt", reason="pipes break otherwise there")
@pytest.mark.parametrize(
    "arguments", [["predict", "joint.toml"], ["predict", "joint.toml", "--json"]]
)
def test_a_pipe_that_nobody_reads_is_no_error(arguments: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "microslip.cli", *arguments],
            stdout=writing,
            stderr=subprocess.PIPE,
            check=False,
        )
    finally:
        os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")
    assert "joint-result" in names()
