#!/usr/bin/env python3
"""Make Jupyter notebooks of the gallery's scripts: text cells of their comments, code as it is.

The tests run the scripts; a notebook's code is its script's, cell by cell, so it runs as well.

Usage: make_notebooks.py FOLDER
"""

from __future__ import annotations

import ast
import json
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted((ROOT / "examples").glob("[0-9]*.py"))
_TITLE = re.compile(r"^(.+)\n[=~-]{3,}$", re.MULTILINE)


def cell(kind: str, text: str, number: int) -> dict[str, Any]:
    """One cell of a notebook, version 4.5."""
    lines = text.strip("\n").splitlines(keepends=True)
    own: dict[str, Any] = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}}
    if kind == "code":
        own |= {"execution_count": None, "outputs": []}
    return own | {"source": lines}


def notebook(script: str) -> dict[str, Any]:
    """A script of the gallery as a notebook; ``# %%`` begins a text, and what follows is code."""
    tree = ast.parse(script)
    first = tree.body[0]
    title = ast.get_docstring(tree) or ""
    rest = script.splitlines(keepends=True)[first.end_lineno or 0 :] if title else [script]
    cells = [cell("markdown", _TITLE.sub(r"# \1", title), 0)] if title else []
    for block in re.split(r"(?m)^# %%.*\n", "".join(rest)):
        text = re.match(r"(?:#.*\n)*", block)
        words = text[0] if text is not None and len(cells) > 1 else ""
        code = block[len(words) :]
        if words.strip():
            said = re.sub(r"(?m)^# ?", "", words)
            cells.append(cell("markdown", _TITLE.sub(r"## \1", said), len(cells)))
        if code.strip():
            cells.append(cell("code", code, len(cells)))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }


def main(folder: Path) -> None:
    """Write a notebook for each script."""
    folder.mkdir(parents=True, exist_ok=True)
    for script in SCRIPTS:
        made = notebook(script.read_text(encoding="utf-8"))
        text = json.dumps(made, indent=1, ensure_ascii=False) + "\n"
        (folder / f"{script.stem}.ipynb").write_text(text, encoding="utf-8", newline="\n")
        print(folder / f"{script.stem}.ipynb")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
