"""Tables of measurements, between markers of a page of the documentation."""

from __future__ import annotations

from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


def markers(name: str, script: str) -> tuple[str, str]:
    """The lines around the section that a script writes."""
    return f"<!-- {name}: written by benchmarks/{script} --page -->", f"<!-- {name}: end -->"


def write_section(page: str, name: str, script: str, text: str) -> None:
    """Put a text between the markers of a section."""
    begin, end = markers(name, script)
    path = DOCS / page
    content = path.read_text(encoding="utf-8")
    if content.count(begin) != 1 or content.count(end) != 1:
        raise SystemExit(f"error: docs/{page} must hold these two lines once each:\n{begin}\n{end}")
    before, after = content.split(begin)[0], content.split(end)[1]
    path.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
