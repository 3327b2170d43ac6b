"""The folder of a result: whole or not at all, and nothing else is ever touched."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from studies import STUDY

import microslip as ms
from microslip.report import folder as folder_module

PLAIN = STUDY + "report = false\n"


@pytest.fixture(scope="module")
def result() -> ms.Result:
    return ms.Study.from_toml(PLAIN).run()


def refusal(result: ms.Result, folder: Path, overwrite: bool = True) -> str:
    before = snapshot(folder)
    with pytest.raises(ms.StudyError) as caught:
        result.save(folder, overwrite=overwrite)
    assert snapshot(folder) == before
    message = str(caught.value)
    assert message.startswith(f"{folder}: ")
    return message[len(f"{folder}: ") :]


def snapshot(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.parent.rglob("*"))
    }


def test_a_result_is_whole_and_nothing_is_left_beside_it(result: ms.Result, tmp_path: Path) -> None:
    written = result.save(tmp_path / "a" / "b")
    assert sorted(p.name for p in (tmp_path / "a" / "b").iterdir()) == sorted(
        ["summary.json", "study.toml", "loops.csv", "curves.csv"]
    )
    assert all(path.is_file() for path in written)
    assert [p.name for p in tmp_path.iterdir()] == ["a"]
    assert [p.name for p in (tmp_path / "a").iterdir()] == ["b"]
    assert (tmp_path / "a" / "b" / "study.toml").read_text() == PLAIN


def test_an_existing_folder_is_kept_unless_told(result: ms.Result, tmp_path: Path) -> None:
    folder = tmp_path / "result"
    result.save(folder)
    assert refusal(result, folder, overwrite=False) == (
        "exists; replace it with --overwrite, or give another folder with -o"
    )
    (folder / "summary.json").write_text(
        (folder / "summary.json").read_text().replace("A joint", "Old")
    )
    result.save(folder, overwrite=True)
    assert json.loads((folder / "summary.json").read_text())["title"] == "A joint"
    assert [p.name for p in tmp_path.iterdir()] == ["result"]


def test_only_a_result_is_replaced(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    assert refusal(result, file) == "is a file; give a folder with -o"
    assert "cannot be written: not a directory" in refusal(result, file / "result")

    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("years of work")
    no_result = "not replaced: it is not a result of this command (no such summary.json)"
    assert refusal(result, mine) == no_result
    for text in ("", "[]", "{}", '{"kind": "other"}', '{"kind": "microslip-result"}', 9999 * "["):
        (mine / "summary.json").write_text(text)
        assert refusal(result, mine) == no_result

    folder = tmp_path / "result"
    result.save(folder)
    (folder / "notes.txt").write_text("years of work")
    assert refusal(result, folder) == (
        'not replaced: "notes.txt" in it is not part of the result; move it elsewhere first'
    )
    (folder / "notes.txt").unlink()
    (folder / "loops.csv").unlink()
    (folder / "loops.csv").mkdir()
    (folder / "loops.csv" / "thesis.tex").write_text("years of work")
    assert refusal(result, folder).startswith('not replaced: "loops.csv" in it')
    (folder / "loops.csv" / "thesis.tex").unlink()
    (folder / "loops.csv").rmdir()

    link = tmp_path / "link"
    link.symlink_to(folder)
    assert refusal(result, link) == "is a link; give the folder itself, or another folder with -o"
    dangling = tmp_path / "dangling"
    dangling.symlink_to(tmp_path / "nowhere")
    assert refusal(result, dangling).startswith("is a link")

    holds = "not replaced: it contains the current or the home folder"
    monkeypatch.chdir(folder)
    assert refusal(result, folder) == holds
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.setenv("USERPROFILE", str(folder))
    assert refusal(result, folder) == holds


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("old", [False, True])
def test_a_failure_while_writing_leaves_things_as_they_were(
    result: ms.Result,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    old: bool,
) -> None:
    folder = tmp_path / "deep" / "result"
    if old:
        result.save(folder)
    before = snapshot(tmp_path / "deep")

    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("microslip.report.files.json_text", fail)
    wanted = ms.StudyError if isinstance(error, OSError) else KeyboardInterrupt
    with pytest.raises(wanted) as caught:
        result.save(folder, overwrite=old)
    if wanted is ms.StudyError:
        assert str(caught.value) == f"{folder}: cannot be written: no space left on device"
    assert snapshot(tmp_path / "deep") == before


def test_a_folder_that_appears_meanwhile_is_not_touched(result: ms.Result, tmp_path: Path) -> None:
    folder = tmp_path / "result"

    def compute() -> None:
        with folder_module.staged(folder):
            folder.mkdir()
            (folder / "thesis.tex").write_text("years of work")

    with pytest.raises(ms.StudyError, match="exists; replace it with --overwrite"):
        compute()
    assert [p.name for p in tmp_path.iterdir()] == ["result"]
    assert [p.name for p in folder.iterdir()] == ["thesis.tex"]


def test_a_file_put_there_in_the_last_moment_is_not_lost(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "result"
    result.save(folder)
    move_in = folder_module._move_in

    def late(stage: Path, place: folder_module._Place) -> None:
        (folder / "thesis.tex").write_text("years of work")
        move_in(stage, place)

    monkeypatch.setattr(folder_module, "_move_in", late)
    result.save(folder, overwrite=True)
    assert (tmp_path / "result.old" / "thesis.tex").read_text() == "years of work"
    assert refusal(result, folder).startswith("not replaced: result.old exists")


# -- killed ----------------------------------------------------------------------------------------


# Writes a result in a process of its own for each line of the module, is killed at that line, and
# prints what is in the place of the result and in that of the older one.
AT_EVERY_LINE = r"""
import json, os, shutil, signal, sys
from pathlib import Path

from microslip.report import folder

home, has_old = Path(sys.argv[1]), sys.argv[2] == "True"
target = home / "result"


def save(text):
    with folder.staged(target, overwrite=True) as stage:
        names = ["summary.json", "one.csv", "two.csv"]
        for name in names:
            summary = {"kind": "microslip-result", "files": names, "text": text}
            (stage / name).write_text(json.dumps(summary))


def content(path):
    return sorted(json.loads(file.read_text())["text"] for file in path.glob("*"))


def killed_at(line):
    child = os.fork()
    if child == 0:
        seen = 0

        def trace(frame, event, argument):
            nonlocal seen
            if frame.f_code.co_filename == folder.__file__ and event == "line":
                seen += 1
                if seen == line:
                    os.kill(os.getpid(), signal.SIGKILL)
            return trace

        sys.settrace(trace)
        save("new")
        os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


line, lived = 0, False
while not lived:
    line += 1
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    if has_old:
        save("old")
    lived = not killed_at(line)
    print(json.dumps([content(target), content(home / "result.old")]))
"""


@pytest.mark.skipif(os.name != "posix", reason="there is no such kill here")
@pytest.mark.parametrize("has_old", [pytest.param(True, marks=pytest.mark.slow), False])
def test_killed_at_any_line_of_writing(has_old: bool, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", AT_EVERY_LINE, str(tmp_path / "home"), str(has_old)],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) > 30
    new, old = 3 * ["new"], 3 * ["old"]
    for place, aside in found:
        assert place in ([old, new, []] if has_old else [new, []])
        if has_old and place != new:
            assert old in (place, aside)
        # What is deleted last may be there in part; the new result is there before.
        assert aside in ([], old) or place == new
    states = [place for place, _ in found]
    assert all(place == new for place in states[states.index(new) :])
