"""What the README, CONTRIBUTING and docs/ show is true: every block of code and command runs.

Python blocks run in the order of the page, in one namespace a page. A comment that begins with
numbers (or is a list, a text, True or False) after an expression or an assignment is what comes
out, to the digits shown; the name of an error on the line below is the error with its message:

    joint.force_limit  # 1100.0 N
    joint.force([0.0, 3e-7])  # 0 920.7
    ms.Gaussian(std=0.0)
    # InputError: std must be above zero [m], got 0

TOML blocks are studies, or parts that replace those of the first study of the page; where the
first line is a comment with a file name, the block is that file for the commands of the page.
"""

from __future__ import annotations

import ast
import io
import re
import shlex
import shutil
import subprocess
import sys
import tokenize
import tomllib
import types
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from click.testing import CliRunner

import microslip as ms
from microslip.cli import main

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")])
NUMBER = r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?"


class Block(NamedTuple):
    language: str
    text: str
    line: int


def blocks(page: Path, language: str) -> list[Block]:
    """Fenced blocks of a language, in order."""
    found, inside, begin = [], "", 0
    lines: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1):
        fence = re.match(r"```(\w*)\s*$", line)
        if fence and not inside:
            inside, begin, lines = fence[1] or "text", number, []
        elif fence:
            found.append(Block(inside, "\n".join(lines) + "\n", begin))
            inside = ""
        elif inside:
            lines.append(line)
    assert not inside, f"{page.name}: the block of line {begin} is not closed"
    return [block for block in found if block.language == language]


def pages_with(language: str) -> list[Any]:
    names = [(page, str(page.relative_to(ROOT))) for page in PAGES]
    return [pytest.param(page, id=name) for page, name in names if blocks(page, language)]


# -- python ---------------------------------------------------------------------------------------


def comments(source: str) -> dict[int, str]:
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return {t.start[0]: t.string.lstrip("# ") for t in tokens if t.type == tokenize.COMMENT}


def agree(value: Any, shown: str, where: str) -> None:
    """A value against the numbers that a comment begins with, half a unit of their last digit."""
    texts = re.match(rf"{NUMBER}(?:,? {NUMBER}(?![\w.]))*", shown)
    assert texts is not None
    wanted = re.findall(NUMBER, texts[0])
    got = np.ravel(np.asarray(value, dtype=float))
    assert got.size == len(wanted), f"{where}: {got.size} numbers, the comment shows {wanted}"
    for number, text in zip(got, wanted, strict=True):
        step = 10.0 ** int(Decimal(text).as_tuple().exponent)
        assert abs(number - float(text)) <= 0.5000001 * step, f"{where}: {number!r}, not {text}"


def run_python(source: str, namespace: dict[str, Any], where: str, first_line: int = 0) -> int:
    """Run a block and hold its results against its comments; how many were held."""
    said, held = comments(source), 0
    for node in ast.parse(source).body:
        line = f"{where}:{first_line + node.lineno}"
        comment = said.get(node.end_lineno or 0, "")
        error = re.match(r"(\w+Error): (.+)", said.get((node.end_lineno or 0) + 1, ""))
        code = compile(ast.Module([node], []), line, "exec")
        if error:
            with pytest.raises(ms.InputError) as caught:
                exec(code, namespace)
            assert type(caught.value).__name__ == error[1], line
            assert str(caught.value) == error[2], line
            held += 1
        elif re.match(rf"{NUMBER}(?![\w.])", comment):
            if isinstance(node, ast.Expr):
                value = eval(compile(ast.Expression(node.value), line, "eval"), namespace)
            else:
                exec(code, namespace)
                assert isinstance(node, ast.Assign), f"{line}: a number after what has no value"
                value = eval(ast.unparse(node.targets[0]), namespace)
            agree(value, comment, line)
            held += 1
        elif isinstance(node, ast.Expr) and re.match(r"['\"\[]|(True|False|None)$", comment):
            value = eval(compile(ast.Expression(node.value), line, "eval"), namespace)
            assert value == ast.literal_eval(comment), f"{line}: {value!r}"
            held += 1
        else:
            exec(code, namespace)
    return held


@pytest.fixture
def namespace(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """A module of its own, which dataclasses can find, in an empty folder with the examples."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    module = types.ModuleType("page")
    monkeypatch.setitem(sys.modules, "page", module)
    return module.__dict__


@pytest.mark.parametrize("page", pages_with("python"))
def test_python_blocks(page: Path, namespace: dict[str, Any]) -> None:
    held = 0
    for block in blocks(page, "python"):
        held += run_python(block.text, namespace, page.name, block.line)
    assert held > 0, "a page of code shows what comes out"


@pytest.mark.parametrize(
    "wrong",
    [
        "2.0  # 2.1",
        "[1.0, 2.0]  # 1 3",
        "[1.0, 2.0]  # 1",
        "x = 920.74  # 920.8",
        "'ok'  # 'watch'",
        "['ok', 'ok']  # ['ok']",
        "1 == 1  # False",
        "ms.Gaussian(std=1.0)\n# InputError: std must be above zero [m], got 0",
        "ms.Gaussian(std=0.0)\n# InputError: std must be above zero",
        "ms.Gaussian(std=0.0)\n# StudyError: std must be above zero [m], got 0",
    ],
)
def test_a_wrong_comment_is_found(wrong: str) -> None:
    with pytest.raises((AssertionError, pytest.fail.Exception)):
        run_python(wrong, {"ms": ms}, "here")


def test_a_right_comment_is_held() -> None:
    source = (
        "2.04  # 2.0 is two digits\nx = [1.0, -2e-7]  # 1, -2.0e-7 m\n'a'  # 'a'\n1 == 1  # True\n"
    )
    assert run_python(source, {}, "here") == 4


# -- commands -------------------------------------------------------------------------------------


def commands(page: Path) -> Iterator[tuple[int, str]]:
    for block in blocks(page, "sh"):
        for number, line in enumerate(block.text.splitlines(), start=block.line + 1):
            command = re.sub(r"\s+# .*", "", line).strip()
            if command:
                yield number, command


def run_make(words: list[str]) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for word in words:
        name, assigned, _ = word.partition("=")
        kind = rf"^{re.escape(name)} \?=" if assigned else rf"^{re.escape(name)}:"
        assert re.search(kind, makefile, re.MULTILINE), f"the Makefile knows no {name}"


def run_script(words: list[str]) -> None:
    """A script of the repository: it is there, and its --help knows the options."""
    assert (ROOT / words[0]).is_file(), words[0]
    options = [word for word in words[1:] if word.startswith("-")]
    if options:
        ask = [sys.executable, str(ROOT / words[0]), "--help"]
        known = subprocess.run(ask, capture_output=True, text=True, check=True).stdout
        assert all(option in known for option in options), options


def run_command(command: str) -> str:
    words = shlex.split(command)
    env: dict[str, str | None] = {}
    while re.fullmatch(r"[A-Z_]+=\S*", words[0]):
        name, _, value = words.pop(0).partition("=")
        env[name] = value
    if words[0] == "microslip":
        outcome = CliRunner().invoke(main, words[1:], env=env)
        assert outcome.exit_code == 0, f"{command}: {outcome.output}"
        return outcome.output
    if words[0] == "make":
        run_make(words[1:])
    elif words[0] == "python":
        run_script(words[1:])
    elif words[0] == ".ci/run":
        assert (ROOT / words[0]).is_file()
    else:
        assert words == ["pip", "install", "."], f"unknown command: {command}"
    return ""


@pytest.mark.parametrize("page", pages_with("sh"))
def test_commands(page: Path, namespace: dict[str, Any]) -> None:
    for block in blocks(page, "toml"):
        name = re.match(r"# (\S+\.toml)\n", block.text)
        if name:
            Path(name[1]).write_text(block.text, encoding="utf-8")
    for number, command in commands(page):
        try:
            run_command(command)
        except AssertionError as error:
            raise AssertionError(f"{page.name}:{number}: {error}") from None


# -- studies --------------------------------------------------------------------------------------


def with_parts(study: str, part: str) -> str:
    """A study in which a part takes the place of the tables of its names."""
    names = set(tomllib.loads(part))
    kept = [
        piece
        for piece in re.split(r"(?m)^(?=\[)", study)
        if not (head := re.match(r"\[(\w+)", piece)) or head[1] not in names
    ]
    return "".join(kept) + "\n" + part


@pytest.mark.parametrize("page", pages_with("toml"))
def test_studies(page: Path) -> None:
    found = blocks(page, "toml")
    assert "schema" in tomllib.loads(found[0].text), "the first study of a page is a whole one"
    for block in found:
        whole = "schema" in tomllib.loads(block.text)
        text = block.text if whole else with_parts(found[0].text, block.text)
        result = ms.Study.from_toml(text, f"{page.name}:{block.line}").run()
        assert all(np.isfinite(row.dissipated_energy).all() for row in result.rows)


# -- links ----------------------------------------------------------------------------------------


def anchors(page: Path) -> set[str]:
    """Anchors of the headings, as GitHub makes them."""
    heads = re.findall(r"(?m)^#+ (.+)$", re.sub(r"(?ms)^```.*?^```", "", page.read_text("utf-8")))
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CHANGELOG.md"], ids=lambda page: page.name)
def test_links(page: Path) -> None:
    text = re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith(("https://", "http://")):
            continue
        name, _, anchor = target.partition("#")
        file = page if not name else (page.parent / name).resolve()
        assert file.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in anchors(file), f"{page.name}: {target}"


def test_the_index_lists_every_page() -> None:
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        assert page.name == "index.md" or f"({page.name})" in index
