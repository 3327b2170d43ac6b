"""Nothing imports upwards and no circle is left, late imports and those of types included.

The graph is read off the sources, so nothing is imported here. A name that a package hands on, in
its ``__init__.py`` or in the stub by which it loads lazily, counts as the module it comes from.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src" / "microslip"


class Import(NamedTuple):
    """An import statement: which module imports which one, and where it stands."""

    importer: str
    imported: str
    line: int
    how: str

    @property
    def pair(self) -> tuple[str, str]:
        return self.importer, self.imported


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
        else:
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


def file_of(module: str) -> str:
    path = SOURCES.parent.joinpath(*module.split("."))
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return str(path.relative_to(ROOT))


def drawn(path: list[Import], closed: bool) -> str:
    """A way through the graph as text, one import a line."""
    lines = []
    for depth, item in enumerate(path):
        how = f" ({item.how})" if item.how else ""
        here = f"{file_of(item.importer)}:{item.line}"
        first, last = depth == 0, depth == len(path) - 1
        edge = ("┌─▶" if first else "│  ") if closed else "   "
        lines.append(f"  {edge} {item.importer}   {here}{how}")
        lines.append(f"  {'│' if closed else ' '}       ↓")
        if last:
            lines.append(f"  {'└───' if closed else '    '} {item.imported}")
    return "\n".join(lines)


def knot(edges: Mapping[str, list[Import]]) -> dict[str, list[Import]]:
    """The graph without the modules from which no circle can be reached."""
    left = dict(edges)
    while True:
        ends = [module for module, out in left.items() if not any(i.imported in left for i in out)]
        if not ends:
            return {m: [i for i in out if i.imported in left] for m, out in left.items()}
        for module in ends:
            del left[module]


def circle(edges: Mapping[str, list[Import]]) -> list[Import] | None:
    """A shortest circle of the graph; None where there is none."""
    edges = knot(edges)
    shortest: list[Import] | None = None
    for start in edges:
        came: dict[str, Import] = {}
        waiting = [start]
        while waiting and start not in came:
            later = []
            for module in waiting:
                for item in edges.get(module, ()):
                    if item.imported not in came:
                        came[item.imported] = item
                        later.append(item.imported)
            waiting = later
        if start in came:
            path = [came[start]]
            while path[0].importer != start:
                path.insert(0, came[path[0].importer])
            if shortest is None or len(path) < len(shortest):
                shortest = path
    return shortest


def graph() -> dict[str, list[Import]]:
    edges: dict[str, list[Import]] = {}
    for item in imports():
        edges.setdefault(item.importer, []).append(item)
    return edges


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
            wrong.append(drawn([item], closed=False))
    assert not wrong, "imports that go upwards:\n" + "\n".join(wrong)


def test_there_are_no_circles() -> None:
    path = circle(graph())
    assert path is None, "imports in a circle:\n" + drawn(path, closed=True)


def test_a_circle_is_found_and_drawn() -> None:
    """That the tests above can fail."""
    here = [
        Import("microslip.loops", "microslip.errors", 3, ""),
        Import("microslip.errors", "microslip.materials", 7, "late"),
        Import("microslip.materials", "microslip.loops", 9, "for types"),
    ]
    path = circle({item.importer: [item] for item in here})
    assert path is not None
    assert {item.pair for item in path} == {item.pair for item in here}
    text = drawn(path, closed=True)
    assert "src/microslip/errors.py:7 (late)" in text
    assert text.count("↓") == 3
    assert circle({item.importer: [item] for item in here[:2]}) is None
