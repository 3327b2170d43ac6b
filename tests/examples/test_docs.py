"""What the README, CONTRIBUTING and docs/ show is true: every block of code and command runs.

Python blocks run in the order of the page, in one namespace a page. A comment that begins with
numbers (or is a list, a text, True or False) after an expression or an assignment is what comes
out, to the digits shown; the name of an error on the line below is the error with its message:

    joint.force_limit  # 1100.0 N
    joint.force([0.0, 3e-7])  # 0 920.7
    ms.Gaussian(std=0.0)
    # InputError: std must be above zero [m], got 0

TOML blocks are studies, or parts that replace those of the first study of the page; where the
first line is a comment with a file name, the block is that file for the commands and the code of
the page. A CSV block is the file that its fence names (```csv heights.csv), and a Python block
whose fence names a file makes that file (```python ground.npy).

Commands run in the order of the page, in a folder with the examples. One that is meant to fail has
its exit code in a comment (# exit code 2). The lines of a text block are printed by the commands
of the page above it. What a MATLAB block reads is in the file of the worked example. Blocks of C
and Julia, and MATLAB that reads no file, are recipes: tests/physics/test_hosts_recipes.py.
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

import make_reference
import numpy as np
import pytest
from cases import folded
from click.testing import CliRunner

import microslip as ms
from microslip import export, identification, surfaces
from microslip.cli import main
from microslip.figures.picture import Picture

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
MADE = ("_build", "api", "gallery")  # by Sphinx
PAGES = sorted(
    [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    + [page for page in DOCS.rglob("*.md") if page.relative_to(DOCS).parts[0] not in MADE]
)
NAMED = {str(page.relative_to(ROOT)): page for page in PAGES}
LANGUAGES = {
    *("python", "sh", "toml", "csv", "text", "matlab", "c", "julia", "{toctree}", "{eval-rst}")
}
# What takes seconds runs with the slow tests.
LONG = {
    ("docs/structures.md", "python"),
    ("docs/from-a-scan.md", "python"),
    ("docs/identify.md", "python"),
    ("docs/for-structural-dynamicists.md", "python"),
    ("docs/bolted-structures.md", "python"),
    ("docs/scans.md", "python"),
    ("docs/batches.md", "sh"),
    ("docs/bolted-structures.md", "sh"),
    ("docs/command.md", "sh"),
    ("docs/scans.md", "sh"),
    ("docs/from-a-scan.md", "sh"),
    ("docs/identify.md", "sh"),
    ("docs/study.md", "sh"),
    ("docs/study.md", "toml"),
    ("docs/bolted-structures.md", "toml"),
    ("docs/from-a-scan.md", "toml"),
    ("docs/figures.md", "sh"),
}
NUMBER = r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?"


class Block(NamedTuple):
    language: str
    text: str
    line: int
    name: str


def all_blocks(page: Path) -> list[Block]:
    """Fenced blocks, in order."""
    found: list[Block] = []
    inside: tuple[str, str, str, int] | None = None
    lines: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1):
        fence = re.match(r"(`{3,})(\S*) *(.*)$", line)
        if fence and inside is None:
            inside, lines = (fence[1], fence[2] or "text", fence[3], number), []
        elif inside and line.rstrip() == inside[0]:
            text = "\n".join(lines) + "\n"
            name = re.match(r"# (\S+\.toml)\n", text)
            found.append(Block(inside[1], text, inside[3], name[1] if name else inside[2]))
            inside = None
        elif inside:
            lines.append(line)
    assert not inside, f"{page.name}: the block of line {inside and inside[3]} is not closed"
    return found


def blocks(page: Path, language: str) -> list[Block]:
    return [block for block in all_blocks(page) if block.language == language]


def write_files(page: Path) -> None:
    """The files that blocks of the page are."""
    for block in all_blocks(page):
        if block.language in ("toml", "csv") and re.fullmatch(r"[\w-]+\.(toml|csv)", block.name):
            Path(block.name).write_text(block.text, encoding="utf-8")
        elif block.language == "python" and block.name:
            exec(compile(block.text, f"{page.name}:{block.line}", "exec"), {})
            assert Path(block.name).is_file(), f"{page.name}:{block.line}: makes no {block.name}"


def pages_with(language: str) -> list[Any]:
    names = [(page, str(page.relative_to(ROOT))) for page in PAGES]
    return [
        pytest.param(page, id=name, marks=pytest.mark.slow if (name, language) in LONG else ())
        for page, name in names
        if blocks(page, language)
    ]


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


@pytest.fixture(autouse=True)
def quick_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures take most of the time, and are drawn and looked at by other tests."""
    from matplotlib.figure import Figure

    empty = b'<svg xmlns="http://www.w3.org/2000/svg"></svg>'
    monkeypatch.setattr(Picture, "as_bytes", lambda picture, kind: empty)
    monkeypatch.setattr(Picture, "svg", empty)
    monkeypatch.setattr(Figure, "savefig", lambda figure, path, **_: Path(path).write_bytes(empty))


@folded("page", NAMED, whole=True)
def test_every_block_is_of_a_kind_that_is_tested(page: Path) -> None:
    assert {block.language for block in all_blocks(page)} <= LANGUAGES


@pytest.mark.parametrize("page", pages_with("python"))
def test_python_blocks(page: Path, namespace: dict[str, Any]) -> None:
    held = 0
    write_files(page)
    for block in blocks(page, "python"):
        held += run_python(block.text, namespace, page.name, block.line)
    assert held > 0, "a page of code shows what comes out"


# -- commands -------------------------------------------------------------------------------------


def commands(block: Block) -> Iterator[tuple[int, str, int]]:
    """Line, command and exit code of each line of a block that has one."""
    for number, line in enumerate(block.text.splitlines(), start=block.line + 1):
        command, _, comment = line.partition("  # ")
        code = re.match(r"exit code (\d+)", comment)
        if command.strip() and not command.startswith("#"):
            yield number, command.strip(), int(code[1]) if code else 0


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


def run_command(command: str, exit_code: int = 0) -> str:
    """Run a command, and what it printed; output goes to a file where the line says so."""
    command, _, file = command.partition(" > ")
    words = shlex.split(command)
    env: dict[str, str | None] = {}
    while re.fullmatch(r"[A-Z_]+=\S*", words[0]):
        name, _, value = words.pop(0).partition("=")
        env[name] = value
    if words[0] == "microslip":
        outcome = CliRunner().invoke(main, words[1:], env=env)
        assert outcome.exit_code == exit_code, f"{command}: {outcome.output}"
        if file:
            Path(file).write_text(outcome.stdout, encoding="utf-8")
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


def same_spaces(text: str) -> list[str]:
    return [" ".join(line.split()) for line in text.splitlines() if line.split()]


@pytest.mark.parametrize("page", pages_with("sh"))
def test_commands(page: Path, namespace: dict[str, Any]) -> None:
    """They run, and print what the text blocks below them show."""
    write_files(page)
    printed: list[str] = []
    for block in all_blocks(page):
        if block.language == "sh":
            for number, command, exit_code in commands(block):
                try:
                    printed += same_spaces(run_command(command, exit_code))
                except AssertionError as error:
                    raise AssertionError(f"{page.name}:{number}: {error}") from None
        elif block.language == "text":
            missing = [line for line in same_spaces(block.text) if line not in (*printed, "…")]
            assert not missing, f"{page.name}:{block.line}: not printed: {missing}"


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
def test_studies(page: Path, namespace: dict[str, Any]) -> None:
    write_files(page)
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


@folded("page", NAMED | {"CHANGELOG.md": ROOT / "CHANGELOG.md"}, whole=True)
def test_links(page: Path) -> None:
    text = re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith(("https://", "http://")):
            continue
        name, _, anchor = target.partition("#")
        file = page if not name else (page.parent / name).resolve()
        assert file.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in anchors(file), f"{page.name}: {target}"


# -- pages from declarations ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["study-keys.md", "command-options.md", "results-names.md", "verdicts.md"]
)
def test_reference_pages_are_those_of_the_declarations(name: str) -> None:
    written = (DOCS / name).read_text(encoding="utf-8")
    assert written == make_reference.PAGES[name](), "python docs/make_reference.py writes it again"


# -- site -----------------------------------------------------------------------------------------


def test_the_reference_has_every_public_name() -> None:
    names: list[str] = []
    for block in blocks(DOCS / "api.md", "{eval-rst}"):
        names += re.findall(r"(?m)^   (\w+)$", block.text)
    assert len(set(names)) == len(names)
    missing = set(ms.__all__) - {"__version__"} - set(names)
    assert not missing, "a public name needs a line in docs/api.md"
    other = set(names) - set(ms.__all__)
    rooms = (surfaces, identification, export)
    assert other <= {"metals", "Metal"}.union(*(room.__all__ for room in rooms))
