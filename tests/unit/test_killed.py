"""A run that is killed at any line of its work leaves a result whole, or absent."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

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
@pytest.mark.parametrize("has_old", [True, False])
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
