"""The check of docstrings, messages and commit subjects in ``make lint``."""

from __future__ import annotations

import check_words
import pytest

MADE_UP = check_words.ROOT / "src" / "microslip" / "made_up.py"


def test_problems_are_found() -> None:
    words = "word " * 41
    text = (
        f'"""As before."""\nx = 1\n"""One-sided spectrum."""\nraise ValueError(f"{words}{{x}}")\n'
        'y = 2\n"""The same [m]."""\nz = "the file says so"\n'
        'a = "an error of 561 % by hand"\n'
        f'note = "{words} in a help text | a table of other words"\n'
        f'x = "{"word " * 25}; {"word " * 25}"\n'  # a semicolon does not end a sentence
    )
    wanted = ('starts with "As"', 'starts with "The same"', '"says" makes a person of a thing',
              '"561 %" is an idiom', "42 words in a sentence", "45 words in a sentence",
              "51 words in a sentence")  # fmt: skip
    for problem, words in zip(check_words.problems_of(text, MADE_UP), wanted, strict=True):
        assert words in problem


@pytest.mark.parametrize(
    ("text", "unclear"),
    [
        *((text, True) for text in ("Says the file", "an error of 561.5 %", "an error of 1,234 %")),
        ("the share of the energy", True),
        *((text, False) for text in ("100.0 % of it", "0.1234 %", "![3.11](a%20b-203.12%20c)")),
    ],
)
def test_words_in_any_case_and_large_ratios_are_found(text: str, unclear: bool) -> None:
    assert bool([*check_words.unclear_words("here", text)]) == unclear


def test_prose_of_pages_is_checked_and_code_is_not() -> None:
    page = "# Page\n\n```python\nsays = 1  # it says so\n```\n\nThe scan says so.\n"
    (found,) = check_words.problems_of_page(page, "docs/page.md")
    assert found.startswith('docs/page.md:7: "says"')
