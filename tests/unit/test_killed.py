"""A run that is killed, at any line of its work or at any moment: old result, new one, or none."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from microslip.report.folder import _rename

pytestmark = pytest.mark.skipif(os.name != "posix", reason="there is no such kill here")

# Runs in a process of its own: writes a result once for each line of the two modules, and is killed
# at that line. Prints what is there then, and after a next run.
AT_EVERY_LINE = r"""
import json, os, signal, sys
from pathlib import Path

from microslip.errors import StudyError
from microslip.report import folder

scene = sys.argv[1]
home = Path(sys.argv[2])
if "renames" in scene:
    folder._rename = lambda: None
target = home / ("a/b/result" if "deep" in scene else "result")
WATCHED = {folder.__file__}


def save(text, overwrite=True):
    with folder.staged(target, overwrite) as stage:
        names = ["summary.json", "one.csv", "two.csv"]
        for name in names:
            summary = {"kind": "microslip-result", "files": names, "text": text}
            (stage / name).write_text(json.dumps(summary))


def state():
    if not target.exists():
        return None
    files = sorted(target.iterdir())
    texts = {json.loads(file.read_text())["text"] for file in files}
    return [len(files), *sorted(texts)]


def hidden():
    return sorted(path.suffix for path in target.parent.glob(".result.*")) + sorted(
        path.suffix for path in home.glob(".result.*") if home != target.parent
    )


def killed_at(line):
    child = os.fork()
    if child == 0:
        seen = 0

        def trace(frame, event, argument):
            nonlocal seen
            if frame.f_code.co_filename in WATCHED and event == "line":
                seen += 1
                if seen == line:
                    os.kill(os.getpid(), signal.SIGKILL)
            return trace

        sys.settrace(trace)
        save("new")
        os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def clear():
    for path in sorted(home.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()


line, lived = 0, False
while not lived:
    line += 1
    clear()
    if "old" in scene:
        save("old")
    lived = not killed_at(line)
    there, left, refused = state(), hidden(), False
    try:
        save("late", overwrite=False)
    except StudyError:
        refused = True
    looked = state()
    save("last")
    found = [there, left, refused, looked, state(), hidden()]
    print(json.dumps(found))
"""
OLD, NEW, LATE, LAST = ([3, word] for word in ("old", "new", "late", "last"))
SWAPS = _rename() is not None


def killed_at_every_line(scene: str, home: Path) -> list[list[Any]]:
    home.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", AT_EVERY_LINE, scene, str(home)],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    return [json.loads(line) for line in done.stdout.splitlines()]


# By default those in which there is something to lose.
@pytest.mark.parametrize(
    "scene",
    [
        pytest.param("swap old", marks=pytest.mark.slow),
        pytest.param("swap", marks=pytest.mark.slow),
        pytest.param("swap deep", marks=pytest.mark.slow),
        "renames old",
        pytest.param("renames", marks=pytest.mark.slow),
    ],
)
def test_killed_at_any_line_of_writing(scene: str, tmp_path: Path) -> None:
    found = killed_at_every_line(scene, tmp_path / "home")
    assert len(found) > 100
    states = [there for there, *_ in found]
    whole = [OLD, NEW] if "old" in scene else [None, NEW]
    gap = [None] if scene == "renames old" else []
    for there, left, refused, looked, last, kept in found:
        assert there in whole + gap
        # The next run refuses what is there, and brings back what was between two renames.
        assert refused == (there is not None or bool(gap))
        assert looked == (LATE if not refused else there or OLD)
        assert last == LAST
        # It removes what was left but for what the user may still want.
        wanted = [".old"] if left == [".old"] and there == NEW else []
        if kept != wanted:
            # It no longer looks further up, once the folders above are made.
            assert scene == "swap deep"
            assert kept == left == [".tmp"]
            assert there is None
    first = states.index(NEW)
    assert all(there == NEW for there in states[first:])
    assert all(there != NEW for there in states[:first])
    if scene == "renames old":
        assert None in states
    if scene == "swap deep":
        assert sum(kept != [] for *_, kept in found) < 0.1 * len(found)
    # The kills did hit the moments in which something is left.
    assert any(left for _, left, *_ in found)
