#!/usr/bin/env python3
"""Make Jupyter notebooks of the gallery's scripts: text cells of their comments, code as it is.

The tests run the scripts, and hold a notebook's code to be its script's. With --run each notebook
is run by Jupyter, too, and holds what came out; a cell that fails ends it all.
Numbers such as 01 and 13 choose scripts.

Usage: make_notebooks.py FOLDER [--run [NUMBER...]]
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


def run(made: dict[str, Any]) -> dict[str, Any]:
    """A notebook with what its cells print and draw, run where its script lies."""
    import nbformat
    from nbclient import NotebookClient

    own = nbformat.reads(json.dumps(made), 4)
    nbformat.validate(own)
    here = {"metadata": {"path": str(ROOT / "examples")}}
    NotebookClient(own, timeout=600, kernel_name="python3", resources=here).execute()
    return dict(json.loads(nbformat.writes(own)))


def main(folder: Path, execute: bool = False, numbers: tuple[str, ...] = ()) -> None:
    """Write a notebook for each script, or for those of the given numbers."""
    folder.mkdir(parents=True, exist_ok=True)
    for script in SCRIPTS:
        if numbers and script.stem.partition("_")[0] not in numbers:
            continue
        made = notebook(script.read_text(encoding="utf-8"))
        made = run(made) if execute else made
        text = json.dumps(made, indent=1, ensure_ascii=False) + "\n"
        (folder / f"{script.stem}.ipynb").write_text(text, encoding="utf-8", newline="\n")
        print(folder / f"{script.stem}.ipynb")


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[2:3] not in ([], ["--run"]):
        sys.exit(__doc__)
    main(Path(sys.argv[1]), len(sys.argv) > 2, tuple(sys.argv[3:]))
