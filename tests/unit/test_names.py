"""Names say what is in them: no bare pronouns, participles or adverbs for variables."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import microslip

PACKAGE = Path(microslip.__file__).parent
WORDS = """
again also already always any apart asked both caught chosen comes done drawn each even falls felt
few found given goes got heard held it just kept known laid least left less made many meant mended
met missed more most much none now once one ones only other others own picked put rest said same
says seen shown some spoilt stands stays still such sure taken tells that them then these they
thing things this those together told too tried wanted wants what which who whole yet
"""
BARE = frozenset(WORDS.split())
TERMS = {
    # A state at rest; even and odd parts of a polynomial; the left end of an interval or a page;
    # Python's name of what an object is compared with.
    "friction": {"rest", "even", "other"},
    "kernels": {"rest", "even", "left"},
    "hosts": {"rest"},
    "heights": {"left"},
    "normal": {"left"},
    "numerics": {"left"},
    "app": {"left"},
    # Bounds and counts as they are written beside a parameter, an option or a table.
    "_core": {"least", "most", "many", "none"},
    "report": {"least", "most", "few", "none", "left"},
    # Public names, which are a promise.
    "errors.py": {"said"},
    "scans": {"known", "chosen"},
    "identification": {"known", "given", "found", "said"},
    "tribometer": {"said"},
    "structures": {"asked", "what"},
    "runs": {"done"},
}


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
        allowed = TERMS.get(inner.parts[0], set())
        found = [(0, path.stem), *names(ast.parse(path.read_text(encoding="utf-8")))]
        bare += [
            f"{inner}:{line}: {name}"
            for line, name in found
            if name.strip("_").casefold() in BARE - allowed
        ]
    assert not bare, "name them by what is in them:\n" + "\n".join(bare)
