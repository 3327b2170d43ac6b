"""The check of docstrings, messages and commit subjects in ``make lint``."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "check_words.py"


sys.path.insert(0, str(TOOL.parent))

check_words = importlib.import_module("check_words")


def test_problems_are_found() -> None:
    words = "word " * 41
    text = (
        f'"""As before."""\nx = 1\n"""One-sided spectrum."""\nraise ValueError(f"{words}{{x}}")\n'
        'y = 2\n"""The same [m]."""\nz = "the file says so"\n'
        'a = "an error of 561 % by hand"\n'
        f'note = "{words} in a help text | a table of other words"\n'
    )
    path = check_words.ROOT / "src" / "microslip" / "made_up.py"
    found = list(check_words.problems_of(text, path))
    assert len(found) == 6
    assert 'starts with "As"' in found[0]
    assert 'starts with "The same"' in found[1]
    assert '"says" makes a person of a thing' in found[2]
    assert '"561 %" is an idiom' in found[3]
    assert "42 words in a sentence" in found[4]
    assert "45 words in a sentence" in found[5]


@pytest.mark.parametrize(
    "text",
    ["Says the file", "an error of 561.5 %", "an error of 1,234 %", "the share of the energy"],
)
def test_words_in_any_case_and_ratios_with_decimals_are_found(text: str) -> None:
    assert list(check_words.unclear_words("here", text))


@pytest.mark.parametrize("text", ["100.0 % of it", "0.1234 %", "![3.11](a%20b-203.12%20c)"])
def test_plain_ratios_are_not_reported(text: str) -> None:
    assert not list(check_words.unclear_words("here", text))


def test_a_semicolon_does_not_end_a_sentence() -> None:
    text = f'"""Doc."""\nx = "{"word " * 25}; {"word " * 25}"\n'
    path = check_words.ROOT / "src" / "microslip" / "made_up.py"
    (found,) = check_words.problems_of(text, path)
    assert "51 words in a sentence" in found


def test_prose_of_pages_is_checked_and_code_is_not() -> None:
    page = "# Page\n\n```python\nsays = 1  # it says so\n```\n\nThe scan says so.\n"
    (found,) = check_words.problems_of_page(page, "docs/page.md")
    assert found.startswith('docs/page.md:7: "says"')
