"""Each statement of accuracy in README and docs/ names what shows it.

A sentence with a number of accuracy ("within 3 %", "agrees to 1e-6", "2 % too low") needs in its
own paragraph a row of the record, a test, a benchmark, a command or a published source. Where it is
about a measurement or a publication, that is a row of the record.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from cases import folded

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
# Written by scripts from declarations and measurements, or lists of definitions.
GENERATED = {
    *("record.md", "validation.md", "timings.md", "attack.md", "batches.md", "figures.md"),
    *("study-keys.md", "command-options.md", "results-names.md", "changelog.md", "glossary.md"),
}
PAGES = [
    ROOT / "README.md",
    *sorted(page for page in DOCS.glob("*.md") if page.name not in GENERATED),
]
NUMBER = (
    r"\d\s*%|per cent|10⁻|\d\s*e-\d|factors? of (?:\d|two|three)|\d times\b|\d Hz"
    r"|\d\.\d+ (?:times|to|and)\b"
)
CLAIM = (
    r"within (?:about |some |a factor of )?[\d±−]|in error|differs? by|(?<!cut[- ])\boff\b"
    r"|(?:agree|reproduce)\w*\b[^.;]*? (?:to|within)\b|(?:accurate|right) (?:to|within)\b"
    r"|errors? (?:of|is|are|was|below)\b[^.;]{0,60}\d"
    r"|too (?:high|low|stiff|soft|large|small)|\d % (?:low|high)\b"
    r"|\b(?:[Cc]ompared with|[Cc]ompared to|Against)\b"
)
PROOF = (
    r"record\.md#|tests/\w+/test_\w+\.py|tests/reference/|benchmarks/\w+|tools/\w+\.py"
    r"|`make \w+`|validation\.md|timings\.md|attack\.md|doi\.org|VDI|ISO \d"
)
MEASURED = r"(?i)\bmeasurements? (?:of|by) [A-Z]|published (?:measure|comput|loop|frequenc|damping)"


def paragraphs(text: str) -> Iterator[str]:
    """Paragraphs, list items and rows of tables, without code, each in one line."""
    text = re.sub(r"(?ms)^```.*?^```", "", text)
    text = re.sub(r"(?s)<!--.*?-->", "", text)
    for part in re.split(r"\n\s*\n|\n(?=\s*(?:[-*] |\d+\. |\|))", text):
        yield " ".join(part.split())


def unproved(text: str) -> list[str]:
    """Sentences with a number of accuracy, but nothing in their paragraph that shows it."""
    found = []
    for paragraph in paragraphs(text):
        for sentence in re.split(r"(?<=[.;:])\s+(?=[A-Z`(\[*])", paragraph):
            if re.search(NUMBER, sentence) and re.search(CLAIM, sentence):
                wanted = r"record\.md#|tests/" if re.search(MEASURED, sentence) else PROOF
                if not re.search(wanted, paragraph):
                    found.append(sentence)
    return found


@folded("page", {page.name: page for page in PAGES}, whole=True)
def test_claims_of_accuracy_name_what_shows_them(page: Path) -> None:
    assert unproved(page.read_text("utf-8")) == []


@folded("page", {page.name: page for page in PAGES}, whole=True)
def test_what_is_named_is_there(page: Path) -> None:
    text = page.read_text("utf-8")
    for path in re.findall(r"(?:tests|benchmarks|tools)/[\w/]+\.py", text):
        assert (ROOT / path).is_file(), path
    makefile = (ROOT / "Makefile").read_text("utf-8")
    for target in re.findall(r"`make (\w+)`", text):
        assert re.search(rf"(?m)^{target}:", makefile), target
