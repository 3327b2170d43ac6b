"""Names, keys and values of earlier versions: each is refused with its replacement."""

from __future__ import annotations

import pytest

import microslip as ms
from microslip.study.part import HOMES
from microslip.study.removed import REMOVED_KEYS, REMOVED_VALUES, removed_key, removed_value


def test_removed_names_are_refused_with_their_replacement() -> None:
    assert not set(ms.REMOVED) & set(ms.__all__)
    for name, remedy in ms.REMOVED.items():
        with pytest.raises(AttributeError) as caught:
            getattr(ms, name)
        assert str(caught.value).endswith(f"removed in 0.3: {remedy}")


def test_removed_keys_are_not_accepted_any_more() -> None:
    tables = dict(HOMES)
    for path in REMOVED_KEYS:
        table, _, name = path.rpartition(".")
        model = tables.get(f"[{table}]" if table else "the top level")
        assert model is None or name not in model.keys, path
        assert removed_key(path) == f"removed in 0.3; {REMOVED_KEYS[path]}"
    for path, value in REMOVED_VALUES:
        assert "removed in 0.3" in str(removed_value(path, value))
