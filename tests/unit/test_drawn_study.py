"""A study of a face by its drawing: the law, what the drawing leaves open, and mistakes."""

from __future__ import annotations

import pytest

import microslip as ms
from microslip.contact.finish import Finish

TEXT = """
schema = 1
[surface]
law = "face"
materials = ["steel-c45", "steel-c45"]
ra = "0.8 um"
second = { rq = "1 um", rdq = 0.1 }
area = "2 cm^2"
tightening_pressure = "100 MPa"
[joint]
friction_coefficient = 0.2
normal_load = "16 kN"
"""


def test_a_study_of_a_drawing_equals_the_same_in_python() -> None:
    study = ms.Study.from_toml(TEXT)
    (joint,) = study.run().joints
    steel = ms.Material.named("steel-c45")
    law = ms.DrawnFace.from_finish(
        ms.MaterialPair(steel, steel), Finish(ra=0.8e-6), Finish(rq=1e-6, rdq=0.1),
        area=2e-4, tightening_pressure=1e8,
    )  # fmt: skip
    wanted = ms.Interface(law, 0.2, normal_load=16e3)
    assert joint.tangential_stiffness == pytest.approx(wanted.tangential_stiffness, rel=1e-9)
    # Rq and Rdq are drawn as far as Ra and the correlations of slopes leave them open.
    spreads = study.surface.model_spreads
    for name in ("rms", "slope"):
        spread = spreads[f"{name}_factor"]
        assert spread.cv == pytest.approx(law.spreads[name], rel=1e-9)
    assert {"stiffness_factor", "shape_factor"} < spreads.keys()


def test_a_table_of_uncertainty_alone_adds_the_bands_of_a_drawing() -> None:
    amplitudes = '[excitation]\namplitudes = ["10 nm"]\n[uncertainty]\nsamples = 64\n'
    result = ms.Study.from_toml(TEXT + amplitudes).run()
    assert result.scatter is not None
    low, _, high = result.scatter.bands["dissipated_energy"].values.ravel()
    assert high > 2.0 * low


def test_a_face_without_a_tightening_pressure_is_tightened_by_its_load() -> None:
    free = TEXT.replace('tightening_pressure = "100 MPa"\n', "")
    by_load = TEXT.replace('"100 MPa"', '"80 MPa"')
    found = [
        ms.Study.from_toml(text).run().joints[0].tangential_stiffness for text in (free, by_load)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-6)
