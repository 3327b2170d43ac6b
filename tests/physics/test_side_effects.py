"""Forces beside a law: told where they would explain what it leaves, and fitted along."""

from __future__ import annotations

import numpy as np
import pytest
from laboratory.wrong_physics import a_wrong_set

import microslip as ms


@pytest.mark.parametrize(
    ("kind", "name", "words"),
    [
        pytest.param(
            *("parallel spring", "parallel", "a spring beside the joint"), marks=pytest.mark.slow
        ),
        ("viscous", "viscous", "a force proportional to velocity"),
    ],
)
def test_what_is_needed_is_reported_and_mends_the_fit(kind: str, name: str, words: str) -> None:
    made = a_wrong_set(kind, 0)
    bare = ms.identify(made.records, held_back=0, summits=np.inf)
    assert any(words in note and f"nuisances=['{name}']" in note for note in bare.notes)
    assert all(fitted.verdict != "identified" for fitted in bare.parameters.values())
    whole = ms.identify(made.records, held_back=0, nuisances=[name], summits=np.inf)
    assert whole.reduced_chi_squared < 1.2
    for parameter, truth in made.truth.items():
        fitted = whole.parameters[parameter]
        assert fitted.verdict == "identified"
        assert fitted.low - 0.5 * (fitted.high - fitted.low) < truth
        assert truth < fitted.high + 0.5 * (fitted.high - fitted.low)
    # Nothing else is asked for then.
    assert not any("would explain" in note for note in whole.notes)


@pytest.mark.slow
def test_clipping_is_no_delay() -> None:
    made = a_wrong_set("clipped force", 0)
    found = ms.identify(made.records, held_back=0, summits=np.inf)
    assert not any("behind the displacement" in note for note in found.notes)
    assert any("clipped" in note for note in found.notes)


def test_wrong_names() -> None:
    made = a_wrong_set("viscous", 1)
    for given in (["springs"], "parallel", 3):
        with pytest.raises(ms.InputError, match="nuisances must be"):
            ms.identify(made.records[:1], nuisances=given)  # type: ignore[arg-type]
