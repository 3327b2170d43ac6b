"""Check docstrings, messages, pages and commit subjects for plain English: tools/check_words.py

The check is deliberately narrow: it finds docstrings that start with a pronoun or a preposition
instead of a verb or a noun, words that personify, some idioms, ratios above 100 %, overlong
sentences that users see, and overlong commit subjects. It cannot decide whether a sentence is
understood.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from list_sentences import SOURCES, sentences_of

ROOT = Path(__file__).parents[1]
PAGES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs/*.md")
# Pronouns, prepositions and conjunctions that leave the subject of a first sentence open.
UNCLEAR_STARTS = frozenset(
    [
        "about",
        "above",
        "after",
        "against",
        "and",
        "as",
        "at",
        "before",
        "below",
        "beside",
        "besides",
        "between",
        "beyond",
        "but",
        "by",
        "during",
        "few",
        "fewer",
        "for",
        "from",
        "he",
        "how",
        "in",
        "it",
        "its",
        "less",
        "many",
        "more",
        "none",
        "not",
        "nothing",
        "of",
        "one",
        "ones",
        "on",
        "over",
        "same",
        "share",
        "she",
        "since",
        "so",
        "such",
        "that",
        "their",
        "them",
        "then",
        "there",
        "they",
        "thing",
        "things",
        "these",
        "this",
        "those",
        "to",
        "under",
        "until",
        "up",
        "way",
        "what",
        "when",
        "where",
        "which",
        "who",
        "while",
        "whose",
        "with",
        "within",
        "without",
    ]
)
UNCLEAR_OPENINGS = re.compile(r"the (same|rest|others?|former|latter)\b", re.IGNORECASE)
# Words that make a person of a program, a file or a number.
PERSONIFYING = re.compile(
    r"\b(told|tells?|asked|asks|says|said|knows|wants|hangs?|honest|cannot tell|believes?|feels?"
    r"|forgets?|happy|hears?|insists?|likes|pretends?|promises|remembers?|suffers?|thinks?|unasked)\b",
    re.IGNORECASE,
)
# Idioms that a reader with another first language takes literally, and ratios written as percent.
IDIOMS = re.compile(
    r"\b(next to nothing|of before|(?<!-)off by|on top of|show which|stands? on something"
    r"|shares? of|stands? still|to speak of|wrong way round)\b"
    r"|(?<![\d.,])(?!100(\.0+)? ?%)[1-9](\d{2,}|\d{0,2}(,\d{3})+)(\.\d+)? ?%(?!\d)",
    re.IGNORECASE,
)
MOST_WORDS = 40
MOST_LETTERS = 72
FIRST_COMMIT = "086d0aff"


def docstrings(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line number and text of all docstrings, those of fields included."""
    for node in ast.walk(tree):
        value = node.value if isinstance(node, ast.Expr) else None
        if isinstance(value, ast.Constant) and isinstance(value.value, str):
            yield node.lineno, value.value


def texts(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line number and text of all strings of several words, docstrings included."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.lineno, node.value


def problems_of(source: str, path: Path) -> Iterator[str]:
    """Yield the problems of one source file."""
    tree = ast.parse(source)
    place = path.relative_to(ROOT)
    for line, text in docstrings(tree):
        first = re.match(r"\W*([A-Za-z-]+)", text)
        opening = UNCLEAR_OPENINGS.match(text.lstrip())
        if opening or (first and first[1].lower() in UNCLEAR_STARTS):
            start = opening[0] if opening else first and first[1]
            yield f'{place}:{line}: docstring starts with "{start}": start with a verb or noun'
    for line, text in texts(tree):
        yield from unclear_words(f"{place}:{line}", text)
    # A value in braces counts as one word.
    for line, text in sentences_of(source, path):
        for sentence in re.split(r"\. |\| ", text):
            if (count := len(sentence.split())) > MOST_WORDS:
                yield f"{place}:{line}: {count} words in a sentence, at most {MOST_WORDS}"


def unclear_words(place: str, text: str) -> Iterator[str]:
    """Yield words of a text that personify, idioms, and ratios above 100 %."""
    if word := PERSONIFYING.search(text):
        yield f'{place}: "{word[0]}" makes a person of a thing: {text.strip()[:60]!r}'
    if word := IDIOMS.search(text):
        yield f'{place}: "{word[0]}" is an idiom or a ratio in percent: write it plainly'


def problems_of_page(page: str, name: str) -> Iterator[str]:
    """Yield the problems of a page in Markdown, without its code."""
    prose = re.sub(r"```.*?```", lambda code: "\n" * code[0].count("\n"), page, flags=re.DOTALL)
    for line, text in enumerate(prose.splitlines(), 1):
        yield from unclear_words(f"{name}:{line}", text)


def long_subjects() -> Iterator[str]:
    """Yield commit subjects that are too long; nothing without git or its history."""
    command = ["git", "-C", str(ROOT), "log", "--format=%h %s", f"{FIRST_COMMIT}..HEAD"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return
    for line in done.stdout.splitlines() if done.returncode == 0 else ():
        commit, _, subject = line.partition(" ")
        if len(subject) > MOST_LETTERS:
            yield f"commit {commit}: subject of {len(subject)} letters, at most {MOST_LETTERS}"


def main() -> int:
    """Print all problems; return 1 if there are any."""
    found = [
        text
        for path in sorted(SOURCES.rglob("*.py"))
        for text in problems_of(path.read_text(encoding="utf-8"), path)
    ]
    for pattern in PAGES:
        for page in sorted(ROOT.glob(pattern)):
            found += problems_of_page(page.read_text(encoding="utf-8"), str(page.relative_to(ROOT)))
    found += long_subjects()
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
