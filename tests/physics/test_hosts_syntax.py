"""Text files read by others' readers of their formats; `tools/try_hosts.sh` installs these."""

from __future__ import annotations

import numpy as np
import pytest
from exported import JOINT

from microslip import export

_RANGE = {"smallest_amplitude": 1e-8, "largest_amplitude": 1e-6}
_OPTIONS = {**_RANGE, "cells": 24, "nodes": [[1, 2]], "direction": 3, "first_number": 101}
CELLS = JOINT.to_iwan(24, **_RANGE)


def test_nastran_reads_its_cards(tmp_path):
    bdf = pytest.importorskip(
        "pyNastran.bdf.bdf", reason="pyNastran is not installed; make hosts runs this"
    )
    export.write("nastran", JOINT, tmp_path / "joint.bdf", **_OPTIONS)
    deck = tmp_path / "deck.bdf"
    deck.write_text(
        "SOL 106\nCEND\nMPC = 101\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,0.,0.,0.\n"
        "INCLUDE 'joint.bdf'\nENDDATA\n"
    )
    model = bdf.BDF(debug=False)
    model.read_bdf(str(deck))
    rods = [model.elements[101 + i] for i in range(24)]
    assert [rod.node_ids for rod in rods] == [[101, 102]] * 24
    areas = np.array([model.properties[rod.pid].A for rod in rods])
    moduli = np.array([model.materials[rod.Mid()].e for rod in rods])
    yields = np.array([model.MATS1[rod.Mid()].limit1 for rod in rods])
    length = model.nodes[102].xyz[0] - model.nodes[101].xyz[0]
    np.testing.assert_allclose(areas * moduli / length, CELLS.stiffnesses, rtol=1e-11)
    np.testing.assert_allclose(areas * yields, CELLS.force_limits, rtol=1e-11)
    tied = [(m.node_ids, m.components, m.coefficients) for m in model.mpcs[101]]
    assert tied == [([101, 1], ["1", "3"], [1.0, -1.0]), ([102, 2], ["1", "3"], [1.0, -1.0])]


def test_lsdyna_reads_its_keywords(tmp_path):
    dyna = pytest.importorskip(
        "ansys.dyna.core", reason="ansys-dyna-core is not installed; make hosts runs this"
    )
    done = export.write("lsdyna", JOINT, tmp_path / "joint.k", **_OPTIONS)
    deck = dyna.Deck()
    deck.loads(done.files[0].read_text())
    assert not list(deck.string_keywords)
    materials = list(deck.get_kwds_by_full_type("MAT", "SPRING_ELASTOPLASTIC"))
    np.testing.assert_allclose([m.k for m in materials], CELLS.stiffnesses, rtol=1e-5)
    np.testing.assert_allclose([m.fy for m in materials], CELLS.force_limits, rtol=1e-5)
    assert all(m.kt == 0.0 for m in materials)
    elements = list(deck.get_kwds_by_full_type("ELEMENT", "DISCRETE"))
    rows = [element.elements.iloc[0] for element in elements]
    assert [(int(row.n1), int(row.n2), int(row.vid)) for row in rows] == [(1, 2, 101)] * 24
    (way,) = deck.get_kwds_by_full_type("DEFINE", "SD_ORIENTATION")
    assert str(way).splitlines()[-1].split()[:5] == ["101", "0", "0.0", "0.0", "1.0"]
    card = export.write_card("ls-dyna", JOINT, tmp_path / "card.k", units="mm", density=2700.0)
    deck = dyna.Deck()
    deck.loads("*KEYWORD\n" + card.file.read_text() + "*END\n")
    (layer,) = deck.get_kwds_by_full_type("MAT", "COHESIVE_ELASTIC")
    assert layer.en * 1e9 == pytest.approx(card.card.normal_stiffness, rel=5e-5)
    assert layer.et * 1e9 == pytest.approx(card.card.layer.shear_modulus / 1e-3, rel=5e-5)
    assert layer.ro * 1e12 == pytest.approx(2700.0, rel=1e-4)
