"""The two rules of a fit: what the law leaves, and what the records tell."""

from __future__ import annotations

import pytest

from microslip._core.verdicts import worst
from microslip.identification.rules import verdicts


@pytest.mark.parametrize(
    ("reduced", "is_known", "converged", "words"),
    [
        (1.0, [True, True], True, ["ok", "ok"]),
        (3.0, [True, True], True, ["watch", "ok"]),
        (26.0, [True, False], True, ["outside", "watch"]),
        (1.0, [False, False], True, ["ok", "outside"]),
        (1.0, [True, True], False, ["ok", "outside"]),
        (None, [True], True, ["not judged", "ok"]),
        (1.0, [], True, ["ok", "ok"]),  # all was given
    ],
)
def test_words(
    reduced: float | None, is_known: list[bool], converged: bool, words: list[str]
) -> None:
    found = verdicts(reduced, is_known, converged)
    assert [verdict.word for verdict in found] == words
    assert (worst(found) == "ok") == (words == ["ok", "ok"])
