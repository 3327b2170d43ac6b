"""List public names of functions, classes and constants that several modules define."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

SOURCES = Path(__file__).parents[1] / "src" / "microslip"
SHARED = {"KIND"}  # an interface: every result's module defines it


def definitions() -> dict[str, list[str]]:
    """Return the modules that define each public name at their top level."""
    found = defaultdict(list)
    for path in sorted(SOURCES.rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            names: list[str] = []
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                names = [node.name]
            elif isinstance(node, ast.Assign):
                names = [target.id for target in node.targets if isinstance(target, ast.Name)]
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                names = [node.target.id]
            for name in names:
                if not name.startswith("_") and name not in SHARED:
                    found[name].append(str(path.relative_to(SOURCES)))
    return {name: modules for name, modules in found.items() if len(set(modules)) > 1}


if __name__ == "__main__":
    repeated = definitions()
    for name, modules in sorted(repeated.items(), key=lambda item: (-len(item[1]), item[0])):
        print(f"{name}: {', '.join(modules)}")
    print(f"{len(repeated)} public names are defined in more than one module")
