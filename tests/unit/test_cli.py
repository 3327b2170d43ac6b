"""The command line: what it prints, where it writes, how it fails."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command import STUDY, fails, names, process, run

from microslip.cli import main


@pytest.fixture(autouse=True)
def _a_study(here: Path) -> None:
    Path("joint.toml").write_text(STUDY, encoding="utf-8")


COMMANDS = tuple(main.commands)


def test_help_needs_no_numpy() -> None:
    arguments = [["--help"], ["--version"], [], *([command, "--help"] for command in COMMANDS)]
    code = (
        "import sys\nfrom microslip.cli import main\n"
        f"for words in {arguments!r}:\n"
        "    try: main(words, standalone_mode=False)\n"
        "    except SystemExit as end: assert not end.code, words\n"
        "    assert not {'numpy', 'pint', 'rich', 'matplotlib'} & set(sys.modules), words\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("Usage:") >= len(COMMANDS)


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
    assert re.search(r"2 kN +5700 +2\.79 % +5\.70 GN/m +456 MN/m +1\.10 kN +343 nm +0\.568\n", text)
    assert re.search(r"2 kN +100 nm +0\.421 +13\.6 µJ +0\.0934 +0\.0467\n", text)
    assert "Validity\n" in text
    assert "ζ_mode = ΣE_d / 4πU" in text
    assert text.endswith("\n4 files in joint-result\n")
    assert "\x1b" not in text


def test_json_is_the_summary_and_nothing_else() -> None:
    outcome = run("predict", "joint.toml", "--json", "-o", "out")
    assert outcome.exit_code == 0
    assert json.loads(outcome.stdout) == json.loads(Path("out/summary.json").read_text("utf-8"))


def test_an_existing_folder_is_refused_before_anything_is_computed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert run("predict", "joint.toml", "-o", "out").exit_code == 0
    monkeypatch.setattr(
        "microslip.report.predicted.result.run_prediction", lambda *_: pytest.fail("computed")
    )
    assert fails("predict", "joint.toml", "-o", "out") == (
        "error: out: exists; replace it with --overwrite, or give another folder with -o"
    )
    assert fails("predict", "joint.toml", "-o", ".", "--overwrite") == (
        "error: .: not replaced: it contains the current or the home folder"
    )


def test_a_wrong_command_is_one_line() -> None:
    assert fails("predcit") == (
        'error: no command "predcit"; did you mean "predict"? '
        "(commands: demo, new, check, predict, batch, measure, identify, surface, "
        "export, materials, schema, figures, explore, app)"
    )
    usage = "(usage: microslip predict [OPTIONS] STUDY)"
    assert fails("predict") == f"error: missing STUDY {usage}"
    assert fails("predict", "joint.toml", "--overwrit") == (
        f'error: no option "--overwrit"; did you mean "--overwrite"? {usage}'
    )
    assert fails("predict", "joint.toml", "-o") == "error: option '-o' requires an argument"


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (RuntimeError("a\nbug"), 1,
         "internal error: RuntimeError: a bug (MICROSLIP_DEBUG=1 shows where)"),
        (MemoryError(), 2, "not enough memory"),
    ],
)  # fmt: skip
def test_an_internal_error_is_one_line(
    monkeypatch: pytest.MonkeyPatch, error: Exception, code: int, said: str
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("microslip.report.predicted.result.run_prediction", fail)
    assert fails("predict", "joint.toml", code=code) == f"error: {said}"
    if code == 1:
        monkeypatch.setenv("MICROSLIP_DEBUG", "1")
        assert isinstance(run("predict", "joint.toml").exception, RuntimeError)


def test_a_stream_without_greek_gets_plain_letters() -> None:
    Path("joint.toml").write_text(STUDY.replace("A [bold]", "Füge"), encoding="utf-8")
    done = process("predict", "joint.toml", PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    text = done.stdout.decode("ascii")
    assert text.startswith("F?ge joint")
    assert re.search(r"2 kN \| +100 nm \| +0\.421 \| +13\.6 uJ \| +0\.0934 \| +0\.0467", text)
    assert "zeta_mode = sum E_d / 4 pi U" in text
    assert b" nu " in process("materials", PYTHONIOENCODING="ascii").stdout


WRITING = [
    ["predict", "joint.toml"],
    ["predict", "joint.toml", "--json"],
    ["check", "joint.toml"],
    ["materials", "steel"],
    ["schema"],
    ["--help"],
]
# That no way of writing goes round the streams.
all_writing = pytest.mark.parametrize(
    "arguments",
    [
        pytest.param(words, marks=pytest.mark.slow if i else (), id=" ".join(words))
        for i, words in enumerate(WRITING)
    ],
)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
@all_writing
def test_a_full_output_is_one_line(arguments: list[str]) -> None:
    with Path("/dev/full").open("wb") as full:
        done = process(*arguments, stdout=full)
    assert done.returncode == 2
    wanted = b"error: standard output cannot be written: no space left on device\n"
    assert done.stderr == wanted
    assert ("joint-result" in names()) == (arguments[0] == "predict")


@pytest.mark.skipif(os.name == "nt", reason="pipes break otherwise there")
@all_writing
def test_a_pipe_that_nobody_reads_is_no_error(arguments: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = process(*arguments, stdout=writing)
    finally:
        os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")
    assert ("joint-result" in names()) == (arguments[0] == "predict")


@pytest.mark.skipif(os.name == "nt", reason="no shell that closes streams")
@all_writing
def test_streams_may_be_closed(arguments: list[str]) -> None:
    command = shlex.join([sys.executable, "-m", "microslip", *arguments])
    # One of them says which streams count, the others that no way of writing goes round them.
    for closed in (">&-", "<&- 2>&-") if arguments == WRITING[0] else ("<&- >&- 2>&-",):
        shutil.rmtree("joint-result", ignore_errors=True)
        done = subprocess.run(["sh", "-c", f"{command} {closed}"], capture_output=True, check=False)
        assert (done.returncode, done.stderr) == (0, b""), closed
        assert bool(done.stdout) == (">&-" not in closed.split())
        assert ("joint-result" in names()) == (arguments[0] == "predict")
