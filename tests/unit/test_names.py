"""Names say what is in them: no bare pronouns, participles or adverbs for variables."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import microslip

PACKAGE = Path(microslip.__file__).parent
# Words that are a noun or a term somewhere (a state at rest, even parts, the least of a range) are
# left to the reader.
WORDS = """
again also already always any apart both caught comes drawn each falls felt goes got heard
held it just kept laid less made meant mended met missed more much now once one ones only others own
picked put same says seen shown some spoilt stands stays still such sure taken tells that them then
these they thing things this those together told too tried wanted wants which who whole yet
"""
BARE = frozenset(WORDS.split())


def names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Variables, arguments, functions and classes that a module names, with their lines."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.lineno, node.name
        elif isinstance(node, (ast.ExceptHandler, ast.MatchAs)) and node.name:
            yield node.lineno, node.name


def test_no_bare_words() -> None:
    bare = []
    for path in sorted(PACKAGE.rglob("*.py")):
        inner = path.relative_to(PACKAGE)
        found = [(0, path.stem), *names(ast.parse(path.read_text(encoding="utf-8")))]
        bare += [
            f"{inner}:{line}: {name}" for line, name in found if name.strip("_").casefold() in BARE
        ]
    assert not bare, "name them by what is in them:\n" + "\n".join(bare)
