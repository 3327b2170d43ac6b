"""The check of docstrings, messages and commit subjects in ``make lint``."""

from __future__ import annotations

import sys
from pathlib import Path

TOOL = Path(__file__).parents[2] / "tools" / "check_words.py"


def test_problems_are_found(tmp_path: Path) -> None:
    sys.path.insert(0, str(TOOL.parent))
    try:
        import check_words
    finally:
        sys.path.remove(str(TOOL.parent))
    words = "word " * 41
    text = (
        f'"""As before."""\nx = 1\n"""One-sided spectrum."""\nraise ValueError(f"{words}{{x}}")\n'
        'y = 2\n"""The same [m]."""\nz = "the file says so"\n'
        'a = "an error of 561 % by hand"\n'
    )
    path = check_words.ROOT / "src" / "microslip" / "made_up.py"
    found = list(check_words.problems_of(text, path))
    assert len(found) == 5
    assert 'starts with "As"' in found[0]
    assert 'starts with "The same"' in found[1]
    assert '"says" makes a person of a thing' in found[2]
    assert '"561 %" is an idiom' in found[3]
    assert "42 words in a sentence" in found[4]
