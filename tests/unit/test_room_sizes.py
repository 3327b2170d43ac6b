"""Lines of Python in each package, at most those of tests/rooms.toml."""

from __future__ import annotations

import tomllib
from collections import Counter
from pathlib import Path

import microslip

SOURCES = Path(microslip.__file__).parent
TABLE = Path(__file__).parents[1] / "rooms.toml"


def test_no_package_exceeds_its_number_of_lines() -> None:
    allowed = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    found: Counter[str] = Counter()
    for path in SOURCES.rglob("*.py"):
        inner = path.relative_to(SOURCES)
        package = inner.parts[0] if len(inner.parts) > 1 else "modules"
        found[package] += path.read_text(encoding="utf-8").count("\n")
    assert found.keys() <= allowed.keys()
    larger = {name: (found[name], allowed[name]) for name in found if found[name] > allowed[name]}
    assert not larger, f"packages larger than tests/rooms.toml allows (lines, allowed): {larger}"
