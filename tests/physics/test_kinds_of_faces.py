"""Faces of twenty kinds, measured and drawn, and kept scans, against boundary elements."""

from __future__ import annotations

import numpy as np
import pytest
from faces import campaign
from faces.campaign import HARDNESS, KEPT, PRESSURES, SCANS, compared, compared_scan
from faces.elements import solve
from faces.kinds import KINDS, made
from faces.other_kinds import OTHER_KINDS, other

_TENTH = 1
"""Place of the energy at 0.1 mu N/k_t among the numbers of a row."""
_THIRD = 2
"""Place of the energy at 0.3 mu N/k_t among the numbers of a row."""


@pytest.mark.slow
def test_twenty_kinds_of_machined_faces() -> None:
    """Stiffness of a scan within 5 %, energy within 25 %; bands of drawings hold 90 %.

    Faces of ten kinds at other seeds set the errors of the bands, the other ten kinds did not. At
    more seeds see ``python -m faces``. The energy at 0.1 mu N/k_t, which depends on the pixel of
    the solved faces, is tested on all kinds together.
    """
    smallest = []
    for kinds in (KINDS, OTHER_KINDS):
        rows = [compared(kind, 0, p) for p in PRESSURES for kind in kinds]
        for measured, _ in rows:
            assert measured.ratios[0] == pytest.approx(1.0, abs=0.05)
            assert measured.ratios[_THIRD] == pytest.approx(1.0, abs=0.25)
        held = np.array([drawn.inside for _, drawn in rows]).sum(axis=0)
        smallest.append(held[_TENTH])
        assert (np.delete(held, _TENTH) >= 0.9 * len(rows)).all(), held
    assert sum(smallest) >= 0.9 * 40, smallest


@pytest.mark.slow
@pytest.mark.parametrize("pressure", PRESSURES)
@pytest.mark.parametrize("name", KEPT)
def test_joints_of_kept_scans(name: str, pressure: float) -> None:
    if not (SCANS / name).exists():
        pytest.skip("the folder of shared scans is not beside the repository")
    row = compared_scan(name, pressure)
    assert row.ratios[0] == pytest.approx(1.0, abs=0.05)
    assert row.ratios[_THIRD] == pytest.approx(1.0, abs=0.25)


@pytest.mark.slow
@pytest.mark.parametrize("key", ["turned 0 8e+07", "etched 0 2.5e+08"])
def test_stored_truths_are_solved_again(key: str) -> None:
    """To the residual of the solver; the others change with the programs that made them alone."""
    kind, _, pressure = key.rsplit(" ", 2)
    face = other(kind, 0) if kind in OTHER_KINDS else made(kind, 0)
    modulus = campaign.pair().composite_modulus
    found = solve(face.heights / face.pixel, float(pressure) / modulus, HARDNESS / modulus)
    stored = campaign.truth(key, face.heights, face.pixel, float(pressure), HARDNESS)
    assert found.stiffness * modulus / face.pixel == pytest.approx(stored.stiffness, rel=1e-6)
    assert found.energies == pytest.approx(stored.energies, rel=1e-4)
