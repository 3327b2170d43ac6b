"""What each package of the house weighs: it grows only with a line in tests/rooms.toml."""

from __future__ import annotations

import tomllib
from collections import Counter
from pathlib import Path

import microslip

SOURCES = Path(microslip.__file__).parent
TABLE = Path(__file__).parents[1] / "rooms.toml"


def test_no_room_grows_without_a_line() -> None:
    table = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    allowed = Counter(table["lines"])
    for step, lines in table["growth"].items():
        room, _, purpose = step.partition(": ")
        assert purpose, "growth says what it is for"
        allowed[room] += lines
    found: Counter[str] = Counter()
    for path in SOURCES.rglob("*.py"):
        inner = path.relative_to(SOURCES)
        room = inner.parts[0] if len(inner.parts) > 1 else "modules"
        found[room] += path.read_text(encoding="utf-8").count("\n")
    assert found.keys() == allowed.keys()
    larger = [
        f"{room} has {found[room]} lines, {found[room] - allowed[room]} more than tests/rooms.toml "
        f'allows: take as many out, or add "{room}: what it is for" = lines'
        for room in sorted(found)
        if found[room] > allowed[room]
    ]
    assert not larger, "\n".join(larger)
