"""The folder of a result: whole or not at all, and nothing else is ever touched."""

from __future__ import annotations

import errno
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from studies import STUDY

import microslip as ms
from microslip.report import folder as folder_module

RENAME = folder_module._rename
PLAIN = STUDY + "report = false\n"


@pytest.fixture(scope="module")
def result() -> ms.Result:
    return ms.Study.from_toml(PLAIN).run()


@pytest.fixture(params=["one step", "two renames"], autouse=True)
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """With the renames that the system has in one step, and without them."""
    if request.param == "two renames":
        monkeypatch.setattr(folder_module, "_rename", lambda: None)
    return request.param


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


@pytest.mark.parametrize("mode", [0o755, 0o2755], ids=["usual", "hands its group down"])
def test_the_folder_has_the_usual_permissions(result: ms.Result, tmp_path: Path, mode: int) -> None:
    tmp_path.chmod(mode)
    result.save(tmp_path / "result")
    (tmp_path / "usual").mkdir()
    assert (tmp_path / "result").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_an_existing_folder_is_kept_unless_told(result: ms.Result, tmp_path: Path) -> None:
    folder = tmp_path / "result"
    result.save(folder)
    assert refusal(result, folder, overwrite=False) == (
        "exists; replace it with --overwrite or name another with -o"
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
    assert refusal(result, file) == "is a file; name a folder with -o"
    assert "cannot be written: not a directory" in refusal(result, file / "result")

    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("years of work")
    no_result = "not replaced: it is no result of microslip (no summary.json of one)"
    assert refusal(result, mine) == no_result
    for text in ("", "[]", "{}", '{"kind": "other"}', '{"kind": "microslip-result"}', 9999 * "["):
        (mine / "summary.json").write_text(text)
        assert refusal(result, mine) == no_result

    folder = tmp_path / "result"
    result.save(folder)
    (folder / "notes.txt").write_text("years of work")
    assert refusal(result, folder) == (
        'not replaced: "notes.txt" in it is not of the result; move it elsewhere first'
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
    assert refusal(result, link) == "is a link; name the folder itself, or another one with -o"
    dangling = tmp_path / "dangling"
    dangling.symlink_to(tmp_path / "nowhere")
    assert refusal(result, dangling).startswith("is a link")

    holds = "not replaced: it holds the current or the home folder"
    monkeypatch.chdir(folder)
    assert refusal(result, folder) == holds
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.setenv("USERPROFILE", str(folder))
    assert refusal(result, folder) == holds


def test_root_is_never_replaced(result: ms.Result) -> None:
    root = Path(Path.cwd().anchor)
    with pytest.raises(ms.StudyError, match="not replaced: it holds the current or the home"):
        result.save(root, overwrite=True)


def test_litter_and_empty_folders_do_not_stand_in_the_way(
    result: ms.Result, tmp_path: Path
) -> None:
    folder = tmp_path / "result"
    folder.mkdir()
    result.save(folder, overwrite=True)
    (folder / ".DS_Store").write_text("")
    result.save(folder, overwrite=True)
    assert not (folder / ".DS_Store").exists()


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

    monkeypatch.setattr("microslip.report.files.write_csv", fail)
    wanted = ms.StudyError if isinstance(error, OSError) else KeyboardInterrupt
    with pytest.raises(wanted) as caught:
        result.save(folder, overwrite=old)
    if wanted is ms.StudyError:
        assert str(caught.value) == f"{folder}: cannot be written: no space left on device"
    assert snapshot(tmp_path / "deep") == before


def test_a_failure_while_moving_leaves_things_as_they_were(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "result"
    result.save(folder)
    before = snapshot(folder)
    rename = Path.rename

    def refuse(self: Path, target: Path) -> Path:
        if self.suffix == ".tmp":
            raise OSError(1, "Operation not permitted")
        return rename(self, target)

    monkeypatch.setattr(folder_module, "_rename", lambda: None)
    monkeypatch.setattr(Path, "rename", refuse)
    with pytest.raises(ms.StudyError, match="cannot be written: operation not permitted"):
        result.save(folder, overwrite=True)
    with pytest.raises(ms.StudyError, match="cannot be written: operation not permitted"):
        result.save(tmp_path / "x" / "y")
    assert snapshot(folder) == before


def test_an_error_of_the_system_is_reported(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that says something else than that there is no such rename."""
    folder = tmp_path / "result"
    result.save(folder)
    before = snapshot(folder)
    monkeypatch.setattr(folder_module, "_rename", lambda: lambda *_: errno.EBUSY)
    with pytest.raises(ms.StudyError, match="cannot be written: device or resource busy"):
        result.save(folder, overwrite=True)
    assert snapshot(folder) == before


@pytest.mark.parametrize("number", [errno.ENOSYS, errno.EINVAL, errno.ENOTSUP])
def test_a_file_system_without_these_renames_will_do(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    monkeypatch.setattr(folder_module, "_rename", lambda: lambda *_: number)
    result.save(tmp_path / "result")
    result.save(tmp_path / "result", overwrite=True)
    assert [p.name for p in tmp_path.iterdir()] == ["result"]


@pytest.mark.skipif(sys.platform not in ("linux", "darwin"), reason="two renames are all there is")
def test_this_system_swaps_folders_in_one_step(tmp_path: Path) -> None:
    """Or the other tests would not test that."""
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / name).touch()
    rename = RENAME()
    assert rename is not None
    assert rename(*(os.fsencode(tmp_path / name) for name in ("a", "b")), folder_module._SWAP) == 0
    assert [p.name for p in (tmp_path / "a").iterdir()] == ["b"]
    taken = rename(*(os.fsencode(tmp_path / name) for name in ("a", "b")), folder_module._NEW)
    assert taken == errno.EEXIST


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


def test_a_place_that_cannot_be_looked_into_is_refused(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stat = Path.stat

    def refuse(self: Path, *, follow_symlinks: bool = True) -> os.stat_result:
        if self.name == "secret":
            raise PermissionError(13, "Permission denied")
        return stat(self, follow_symlinks=follow_symlinks)

    monkeypatch.setattr(Path, "stat", refuse)
    with pytest.raises(ms.StudyError, match="cannot be written: permission denied"):
        result.save(tmp_path / "secret")


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no /proc")
def test_a_place_where_nothing_can_be_made_is_refused(result: ms.Result) -> None:
    with pytest.raises(ms.StudyError, match=r"^/proc/result: cannot be written: "):
        result.save("/proc/result")


# -- at the same time ---------------------------------------------------------------------------


def just_before_the_replacement(monkeypatch: pytest.MonkeyPatch, act: Callable[[], object]) -> None:
    replace = folder_module._replace

    def acted(*arguments: object) -> None:
        act()
        replace(*arguments)

    monkeypatch.setattr(folder_module, "_replace", acted)


def test_a_file_put_there_in_the_last_moment_is_not_lost(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "result"
    result.save(folder)
    before = snapshot(folder)
    mine = folder / "thesis.tex"
    just_before_the_replacement(monkeypatch, lambda: mine.write_text("years of work"))
    with pytest.raises(ms.StudyError, match=r'not replaced: "thesis\.tex" in it is not of'):
        result.save(folder, overwrite=True)
    assert mine.read_text() == "years of work"
    mine.unlink()
    assert snapshot(folder) == before


def test_a_folder_that_appears_in_the_last_moment_is_not_touched(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "result"
    move = folder_module.move

    def late(stage: Path, target: Path) -> None:
        folder.mkdir()
        (folder / "thesis.tex").write_text("years of work")
        move(stage, target)

    monkeypatch.setattr(folder_module, "move", late)
    for overwrite, words in (
        (False, "exists; replace it"),
        (True, "not replaced: it is no result"),
    ):
        with pytest.raises(ms.StudyError, match=words):
            result.save(folder, overwrite=overwrite)
        assert [p.name for p in tmp_path.iterdir()] == ["result"]
        (folder / "thesis.tex").unlink()
        folder.rmdir()


def test_a_result_that_another_run_put_there_meanwhile_is_replaced_if_that_may_be(
    result: ms.Result, tmp_path: Path
) -> None:
    folder = tmp_path / "result"

    def compute(overwrite: bool) -> None:
        with folder_module.staged(folder, overwrite) as stage:
            (stage / "summary.json").write_text("second")
            if not folder.exists():
                result.save(folder)

    with pytest.raises(ms.StudyError, match="exists; replace it with --overwrite"):
        compute(overwrite=False)
    compute(overwrite=True)
    assert (folder / "summary.json").read_text() == "second"
    assert [p.name for p in tmp_path.iterdir()] == ["result"]


def test_files_that_vanish_while_others_are_written_are_missed(
    result: ms.Result, tmp_path: Path
) -> None:
    from microslip.report.files import write_all
    from microslip.report.predicted.result import files

    def compute() -> None:
        with folder_module.staged(tmp_path / "result") as stage:
            write_all(files(result, stage), stage)
            (stage / "curves.csv").unlink()

    with pytest.raises(ms.StudyError, match=r"cannot be written: curves\.csv has vanished"):
        compute()
    assert list(tmp_path.iterdir()) == []


# -- what killed runs leave ---------------------------------------------------------------------


@pytest.fixture
def leftover(result: ms.Result, tmp_path: Path) -> Path:
    """A hidden folder with a whole result, for the place `result`."""
    hidden = tmp_path / ".result.abcd_123.tmp"
    result.save(hidden)
    return hidden


def test_a_leftover_is_removed_by_the_next_run(
    result: ms.Result, tmp_path: Path, leftover: Path
) -> None:
    begun = tmp_path / ".result.12345678.tmp"  # killed while it wrote the first file
    begun.mkdir()
    (begun / "summary.json").write_text('{"kind": "micro')
    empty = tmp_path / ".result.87654321.tmp"  # killed while it computed
    empty.mkdir()
    half = tmp_path / ".result.1_2_3_4_.tmp"
    half.mkdir()
    for name in ("summary.json", "loops.csv"):
        (half / name).write_bytes((leftover / name).read_bytes())
    result.save(tmp_path / "result")
    assert [p.name for p in tmp_path.iterdir()] == ["result"]


def test_nothing_else_is_removed(result: ms.Result, tmp_path: Path, leftover: Path) -> None:
    whole = snapshot(leftover)
    others = (
        *(".other.abcd_123.tmp", "result.abcd_123.tmp", ".result.abcd_123"),
        *(".result.ABCD_123.tmp", ".result.abcd_1234.tmp", ".result.x.abcd_123.tmp"),
        *(".result.zzzzzzzz.old", ".result.abcd_123.bak", ".resultxabcd_123.tmp"),
    )
    for name in others:
        result.save(tmp_path / name)
    file = tmp_path / ".result.aaaaaaaa.tmp"
    file.write_text("a file")
    link = tmp_path / ".result.bbbbbbbb.tmp"
    link.symlink_to(tmp_path / ".other.abcd_123.tmp", target_is_directory=True)
    foreign = tmp_path / ".result.cccccccc.tmp"
    result.save(foreign)
    (foreign / "thesis.tex").write_text("years of work")
    linked = tmp_path / ".result.dddddddd.tmp"
    result.save(linked)
    (linked / "loops.csv").unlink()
    (linked / "loops.csv").symlink_to(file)
    strange = tmp_path / ".result.eeeeeeee.tmp"
    strange.mkdir()
    (strange / "loops.csv").write_text("mine, though it has that name")
    before = snapshot(leftover)
    assert len(before) > len(whole)
    result.save(tmp_path / "result")
    after = snapshot(leftover)
    gone = [path for path in before if path not in after]
    assert sorted(gone) == sorted(str(p) for p in (leftover, *(leftover / n for n in NAMES)))
    assert all(after[path] == before[path] for path in after if path in before)


NAMES = ("summary.json", "study.toml", "loops.csv", "curves.csv")


@pytest.mark.skipif(os.name != "posix", reason="nobody can be asked here, so nothing is removed")
def test_a_run_at_work_is_left_alone(result: ms.Result, tmp_path: Path) -> None:
    folder = tmp_path / "result"
    with folder_module.staged(folder, overwrite=True) as stage:
        (stage / "summary.json").write_text("{}")
        result.save(folder)
        result.save(folder, overwrite=True)
        assert [p.name for p in stage.iterdir()] == ["summary.json"]
    assert [p.name for p in tmp_path.iterdir()] == ["result"]
    assert [p.name for p in folder.iterdir()] == ["summary.json"]


def test_where_nobody_can_be_asked_nothing_is_removed(
    result: ms.Result, tmp_path: Path, leftover: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folder_module, "_hold", lambda folder: (None, None))
    result.save(tmp_path / "result")
    assert leftover.is_dir()


@pytest.fixture
def between(result: ms.Result, tmp_path: Path, leftover: Path) -> Path:
    """A place as a kill between two renames leaves it: nothing there, old and new are hidden."""
    old = tmp_path / ".result.abcd_123.old"
    result.save(old)
    text = (old / "summary.json").read_text("utf-8").replace("A joint", "The older one")
    (old / "summary.json").write_text(text, "utf-8")
    return tmp_path / "result"


def title(folder: Path) -> str:
    return json.loads((folder / "summary.json").read_text("utf-8"))["title"]


@pytest.mark.parametrize("asked", [True, False], ids=["asked", "nobody to ask"])
def test_an_older_result_is_brought_back(
    result: ms.Result, between: Path, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not asked:
        monkeypatch.setattr(folder_module, "_hold", lambda folder: (None, None))
        monkeypatch.setattr(folder_module, "_PATIENCE", 0.05)
    assert not between.exists()
    with pytest.raises(ms.StudyError, match="exists; replace it with --overwrite"):
        result.save(between)
    assert title(between) == "The older one"
    left = [] if asked else [".result.abcd_123.tmp"]
    assert sorted(p.name for p in between.parent.iterdir()) == [*left, "result"]
    result.save(between, overwrite=True)
    assert title(between) == "A joint"


def test_an_older_result_is_brought_back_into_nothing_but_a_gap(
    result: ms.Result, between: Path, leftover: Path
) -> None:
    """What is in its place stays; without the newer one beside it, it is one that was replaced."""
    old = leftover.with_suffix(".old")
    result.save(between.with_name("elsewhere"))
    between.with_name("elsewhere").rename(between)
    with pytest.raises(ms.StudyError, match="exists"):
        result.save(between)
    assert title(between) == "A joint"
    assert title(old) == "The older one"
    assert not leftover.exists()
    between.rename(between.with_name("kept"))
    result.save(between)
    assert title(between) == "A joint"
    assert title(old) == "The older one"


@pytest.mark.skipif(os.name != "posix", reason="nobody can be asked here")
def test_a_run_between_its_renames_is_not_disturbed(
    result: ms.Result, between: Path, leftover: Path
) -> None:
    with folder_module.locked(leftover) as mine:
        assert mine
        folder_module._tidy(
            folder_module._Place(between, "result", "microslip-result", "result", True),
            between.parent,
        )
        assert not between.exists()
        assert leftover.is_dir()


def test_a_name_of_the_greatest_length_will_do(result: ms.Result, tmp_path: Path) -> None:
    for name in ("n" * 250, "\N{MICRO SIGN}" * 120):
        folder = tmp_path / name
        result.save(folder)
        result.save(folder, overwrite=True)
        assert [p.name for p in tmp_path.iterdir()] == [name]
        prefix = folder_module._prefix(folder)
        assert folder_module._prefix(folder.with_name(name[:-1] + "x")) != prefix
        (tmp_path / f"{prefix}abcd_123.tmp").mkdir()
        result.save(folder, overwrite=True)
        assert [p.name for p in tmp_path.iterdir()] == [name]
        for file in folder.iterdir():
            file.unlink()
        folder.rmdir()
