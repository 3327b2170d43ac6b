"""Names, keys and values of earlier versions: each is refused with its replacement."""

from __future__ import annotations

import pytest

import microslip as ms
from microslip.study.part import LOCATED_TABLES
from microslip.study.removed import REMOVED_KEYS, REMOVED_VALUES, removed_key, removed_value


def test_removed_names_are_refused_with_their_replacement() -> None:
    assert not set(ms.REMOVED) & set(ms.__all__)
    for name, remedy in ms.REMOVED.items():
        with pytest.raises(AttributeError) as caught:
            getattr(ms, name)
        assert str(caught.value).endswith(f"removed in 0.3: {remedy}")


def test_removed_keys_are_not_accepted_any_more() -> None:
    tables = dict(LOCATED_TABLES)
    for path in REMOVED_KEYS:
        table, _, name = path.rpartition(".")
        model = tables.get(f"[{table}]" if table else "the top level")
        assert model is None or name not in model.keys, path
        assert removed_key(path) == f"removed in 0.3; {REMOVED_KEYS[path]}"
    for path, value in REMOVED_VALUES:
        assert "removed in 0.3" in str(removed_value(path, value))


def test_a_number_that_followed_another_is_refused() -> None:
    text = OLD.replace("= 0.2", '= { of = "surface.rq", factor = 2.0 }')
    text = text.replace('law = "rough"', 'law = "face"').replace('roll_off = "0.8 mm"\n', "")
    with pytest.raises(ms.StudyError, match=r"friction_coefficient: .* was removed in 0\.3"):
        ms.Study.from_toml(text.replace('shortest = "8 um"', "rdq = 0.1"))


OLD = """
schema = 1
[surface]
law = "rough"
materials = ["steel", "steel"]
rq = "1.6 um"
roll_off = "0.8 mm"
shortest = "8 um"
area = "2 cm^2"
[joint]
friction_coefficient = 0.2
normal_load = "1 kN"
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("", "", 'write law = "face" with rq = "1.6 um", rdq = 0.0410, area = "2 cm^2"'),
        ('shortest = "8 um"', "slope = 0.12", 'rq = "1.6 um", rdq = 0.12, area'),
        ('rq = "1.6 um"', 'ra = "1.2 um"', 'with ra = "1.2 um", rdq = 0.0385, area'),
        ('"1.6 um"', '{ low = "1 um", high = "2 um" }', "with rq or ra, and rdq"),
        ('"rough"', '"drawing"', "with the same ra, rq, rz, rsm and process"),
        ('"rough"', '"measured"', 'write law = "face" with the same keys'),
    ],
)
def test_numbers_of_removed_laws_are_converted(old: str, new: str, words: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(OLD.replace(old, new) if old else OLD)
    assert words in str(caught.value)
