"""Nothing imports upwards and no circle is left, late imports and those of types included.

The graph is read off the sources, so nothing is imported here. A name that a package hands on, in
its ``__init__.py`` or in the stub by which it loads lazily, counts as the module it comes from.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import pytest

import microslip

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src" / "microslip"


class Import(NamedTuple):
    """An import statement: which module imports which one, and where it stands."""

    importer: str
    imported: str
    line: int
    how: str


def module_name(path: Path) -> str:
    parts = path.relative_to(SOURCES.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def trees() -> dict[str, ast.Module]:
    return {module_name(path): ast.parse(path.read_text()) for path in SOURCES.rglob("*.py")}


@cache
def handed_on() -> dict[str, dict[str, str]]:
    """Names that packages hand on, and the module each of them comes from."""
    found: dict[str, dict[str, str]] = {}
    for path in (*SOURCES.rglob("__init__.py"), *SOURCES.rglob("__init__.pyi")):
        names = found.setdefault(module_name(path), {})
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.ImportFrom):
                assert node.level < 2, f"{path}: imports of a parent are not followed here"
                source = f"{module_name(path)}.{node.module}" if node.level else str(node.module)
                names |= {alias.asname or alias.name: source for alias in node.names}
    return found


def home(module: str, name: str) -> str:
    """Module from which a name comes that is imported from another one."""
    if f"{module}.{name}" in trees():
        return f"{module}.{name}"
    further = handed_on().get(module, {}).get(name)
    return module if further in (None, module) else home(str(further), name)


def statements(node: ast.AST, how: str = "") -> Iterator[tuple[ast.stmt, str]]:
    """All import statements below a node, and whether they are late or for types."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.Import, ast.ImportFrom)):
            yield child, how
        elif isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield from statements(child, "late")
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            yield from statements(child, "for types")
        elif isinstance(child, (ast.stmt, ast.excepthandler, ast.match_case)):
            yield from statements(child, how)


@cache
def imports() -> tuple[Import, ...]:
    found = []
    for importer, tree in trees().items():
        for statement, how in statements(tree):
            if isinstance(statement, ast.Import):
                targets = [alias.name for alias in statement.names]
            else:
                assert not statement.level, f"{importer}: relative imports are not followed here"
                targets = [home(str(statement.module), alias.name) for alias in statement.names]
            found += [
                Import(importer, target, statement.lineno, how)
                for target in dict.fromkeys(targets)
                if target in trees() and target != importer
            ]
    return tuple(found)


@cache
def layers() -> dict[str, int]:
    """Row of each package in the table of CONTRIBUTING.md, from the foundation up."""
    text = (ROOT / "CONTRIBUTING.md").read_text()
    section = text[text.index("## Packages") : text.index("## Checks")]
    rows = re.findall(r"^\| [a-z ]+ \| (`[^|]*) \|", section, re.MULTILINE)
    return {name: row for row, names in enumerate(rows) for name in re.findall(r"`(\w+)`", names)}


def layer_of(module: str) -> int | None:
    """Row of a module; the package itself only hands names on and has none."""
    parts = module.split(".")
    return layers()[parts[1]] if len(parts) > 1 else None


def test_every_package_has_its_layer() -> None:
    assert {module.split(".")[1] for module in trees() if "." in module} == layers().keys()


def test_nothing_imports_upwards() -> None:
    wrong = []
    for item in imports():
        here, there = layer_of(item.importer), layer_of(item.imported)
        if here is not None and (there is None or there > here):
            wrong.append(f"{item.importer}:{item.line} {item.how} imports {item.imported}")
    assert not wrong, "\n".join(wrong)


def test_there_are_no_circles() -> None:
    graph: dict[str, set[str]] = {}
    for item in imports():
        graph.setdefault(item.importer, set()).add(item.imported)
    TopologicalSorter(graph).prepare()  # or an error with the modules of a circle
    with pytest.raises(CycleError):
        TopologicalSorter({**graph, "microslip._core.errors": {"microslip.cli"}}).prepare()


# -- sizes -----------------------------------------------------------------------------------------


PACKAGE = Path(microslip.__file__).parent
TABLE = Path(__file__).parents[1] / "rooms.toml"


def test_no_package_exceeds_its_number_of_lines() -> None:
    allowed = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    found: Counter[str] = Counter()
    for path in PACKAGE.rglob("*.py"):
        inner = path.relative_to(PACKAGE)
        package = inner.parts[0] if len(inner.parts) > 1 else "modules"
        found[package] += path.read_text(encoding="utf-8").count("\n")
    assert found.keys() <= allowed.keys()
    larger = {name: (found[name], allowed[name]) for name in found if found[name] > allowed[name]}
    assert not larger, f"packages larger than tests/rooms.toml allows (lines, allowed): {larger}"
