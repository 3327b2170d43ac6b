"""List the sentences that users see: python tools/list_sentences.py [PACKAGE ...]

Prints every string of at least four words in the sources except docstrings, with values in braces,
grouped by file: errors, help texts, captions, notes, verdicts and remedies. The docstrings of
commands and of the tables of a study, which are shown as help, are listed as well.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

SOURCES = Path(__file__).parents[1] / "src" / "microslip"
LEAST_WORDS = 4
SHOWN_DOCSTRINGS = ("cli", "study")


def text_of(node: ast.AST) -> str | None:
    """Return the text of a string, with formatted values as {…}; None for other nodes."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) or "{…}" for part in node.values)
    return None


def sentences_of(source: str, path: Path) -> Iterator[tuple[int, str]]:
    """Yield line number and text of the sentences in the source of one file, in order."""
    tree = ast.parse(source)
    shown = path.relative_to(SOURCES).parts[0] in SHOWN_DOCSTRINGS
    hidden, found = set(), {}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            hidden.update(map(id, ast.walk(node)))
            hidden.remove(id(node))
        elif isinstance(node, ast.Expr) and text_of(node.value) is not None:
            hidden.add(id(node.value))
        if shown and isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            is_command = any("command" in ast.unparse(d) for d in node.decorator_list)
            bases = " ".join(map(ast.unparse, node.bases)) if isinstance(node, ast.ClassDef) else ""
            is_table = "Part" in bases
            if (doc := ast.get_docstring(node)) and (is_command or is_table):
                found[node.lineno] = doc if is_command else doc.split("\n")[0]
    for node in ast.walk(tree):
        text = None if id(node) in hidden else text_of(node)
        if text and len(re.findall(r"[^\W\d_]{2,}", text)) >= LEAST_WORDS and " " in text.strip():
            found[node.lineno] = f"{found[node.lineno]} | {text}" if node.lineno in found else text
    for line, text in sorted(found.items()):
        yield line, " ".join(text.split())


if __name__ == "__main__":
    packages = sys.argv[1:] or [""]
    for package in packages:
        for path in sorted((SOURCES / package).rglob("*.py")):
            if listed := list(sentences_of(path.read_text(encoding="utf-8"), path)):
                print(f"\n{path.relative_to(SOURCES)}")
                for line, text in listed:
                    print(f"{line:5d}  {text}")
