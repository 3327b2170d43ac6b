"""The two rules of a fit: what the law leaves, and what the records tell."""

from __future__ import annotations

import pytest

from microslip._core.verdicts import worst
from microslip.identification.verdicts import verdicts


@pytest.mark.parametrize(
    ("stake", "is_known", "converged", "words"),
    [
        (0.0, [True, True], True, ["ok", "ok"]),
        (0.012, [True, True], True, ["watch", "ok"]),
        (0.02, [True, False], True, ["outside", "watch"]),
        (0.0, [False, False], True, ["ok", "outside"]),
        (0.0, [True, True], False, ["ok", "outside"]),
        (None, [True], True, ["not judged", "ok"]),
        (0.0, [], True, ["ok", "ok"]),  # all was given
    ],
)
def test_words(
    stake: float | None, is_known: list[bool], converged: bool, words: list[str]
) -> None:
    found = verdicts(stake, is_known, converged)
    assert [verdict.word for verdict in found] == words
    assert (worst(found) == "ok") == (words == ["ok", "ok"])
