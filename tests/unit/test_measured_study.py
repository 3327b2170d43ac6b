"""A study of a measured face: its keys, what it says, what it refuses, and its uncertainty."""

from __future__ import annotations

from collections import OrderedDict

import numpy as np
import pytest
from made_surfaces import rough

import microslip as ms
from microslip.contact import measured_face
from microslip.study.build import build_surface

TEXT = """
schema = 1
title = "A face point by point"
[material.steel]
young_modulus = "210 GPa"
poisson_ratio = 0.3
hardness = "2.5 GPa"
[surface]
law = "face"
materials = ["steel", "steel"]
scan = "face.npy"
unit = "um"
pixel = "2 um"
tightening_pressure = "100 MPa"
area = "2 cm^2"
piece = 48
[joint]
friction_coefficient = 0.3
normal_load = "15 kN"
[excitation]
amplitudes = ["30 nm"]
"""


@pytest.fixture
def study(tmp_path):
    face = rough((96, 96), 2e-6, 5e-7, longest=6e-5, shortest=1.77e-5, seed=3)
    np.save(tmp_path / "face.npy", 1e6 * face.heights)

    def loaded(*changes: tuple[str, str]) -> ms.Study:
        text = TEXT
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "joint.toml").write_text(text, encoding="utf-8")
        return ms.Study.load(tmp_path / "joint.toml")

    loaded.face = face
    return loaded


def test_a_study_of_a_scan_equals_the_same_in_python(study, monkeypatch) -> None:
    monkeypatch.setattr(measured_face, "_remembered", OrderedDict())
    shares: list[float] = []
    result = study(("piece = 48", "piece = 48\ncoarser = true")).run(shares.append)
    assert shares == sorted(shares)
    assert sum(0.0 < share < 0.8 for share in shares) > 20  # while it is solved, and solved again
    steel = ms.Material(210e9, 0.3, hardness=2.5e9)
    how = {"area": 2e-4, "piece": 48}
    law = study.face.to_contact(ms.MaterialPair(steel, steel), tightening_pressure=1e8, **how)
    joint = ms.Interface(law, 0.3, normal_load=15e3)
    data = result.summary
    assert data["scan"]["hard_share"] == pytest.approx(law.numbers.hard_share, rel=1e-2)
    (own,) = data["joints"]
    assert own["tangential_stiffness"] == pytest.approx(joint.tangential_stiffness, rel=1e-4)
    words = {verdict["name"]: verdict["word"] for verdict in own["validity"]}
    assert words["tightening pressure over hardness"] == "ok"


TIGHTENING = 'tightening_pressure = "100 MPa"\n'


@pytest.mark.parametrize("hardness", ["2.5 GPa", "3 GPa"])
def test_the_largest_load_tightens_a_face_of_known_hardness(study, hardness) -> None:
    alone = (
        study((TIGHTENING, ""), ("2.5 GPa", hardness), ('"15 kN"', '["5 kN", "15 kN"]'))
        .run()
        .summary
    )
    typed = study(("100 MPa", "75 MPa"), ("2.5 GPa", hardness)).run().summary
    numbers = alone["scan"]
    assert numbers["pressure"] == pytest.approx(75e6)
    assert numbers["hardness"] == pytest.approx(3e9 if hardness == "3 GPa" else 2.5e9)
    assert numbers["hard_share"] > 0.5
    stiffness = [run["joints"][-1]["tangential_stiffness"] for run in (alone, typed)]
    assert stiffness[0] == pytest.approx(stiffness[1], rel=1e-6)
    assert alone["joints"][0]["tangential_stiffness"] < 0.8 * stiffness[0]


def test_pieces_drawn_anew_are_a_range_of_their_own(study) -> None:
    table = "[uncertainty]\nsamples = 64\n"
    sure = "friction_coefficient = { mean = 0.3, cv = 0.01 }"
    result = study(("friction_coefficient = 0.3", sure), ("[excitation]", table + "[excitation]"))
    design = result.run().summary["uncertainty"]
    assert design["inputs"]["surface.scan"] == "4 pieces, resampled together"


@pytest.mark.slow
def test_a_structure_splits_form_and_roughness_at_its_patches(study) -> None:
    bolted = """[structure]
length = "60 mm"
width = "4 mm"
thickness = "4 mm"
lap = "16 mm"
density = "7800 kg/m^3"
patches = [4, 1]
modes = [1]
amplitude = { from = "0.1 um", to = "1 um", points = 2 }
[structure.bolts]
positions = ["0 mm"]
shank = "1 mm"
hole = "1.2 mm"
washer = "2 mm"
tension = "200 N"
"""
    alone = TEXT[TEXT.index("[excitation]") :]
    load = 'normal_load = "15 kN"\n'
    description = study((load, ""), (alone, bolted))
    notes = {}
    for patch in ("whole", "small"):
        build_surface(description)
        surface = description.surface
        law, notes[patch] = surface._law, surface.sentences()
        assert law.solution.lighter_tightenings.size
        description = study((load, ""), (alone, bolted.replace("[4, 1]", "[100, 100]")))
    assert "the side of a patch, 4.00 mm, are not modelled" in notes["whole"][1]
    assert (
        "are form, and are in the model only if structure.form includes them" in notes["small"][1]
    )
    assert surface.face.long_cutoff == pytest.approx(79.3e-6, rel=0.01)
    result = study((load, ""), (alone, bolted)).run().structure
    assert result.state.pressures.max() > 0.0
    description = study((load, ""), (alone, bolted), (TIGHTENING, ""))
    build_surface(description)
    ring = np.pi / 4 * (description.structure.washers[0][2] ** 2 - 1.2e-3**2)
    assert 1.0 <= description.surface._law.numbers.pressure * ring / 200.0 <= 1.25
    assert "bolts press the face under their washers" in description.surface.sentences()[1]
    assert description.run().structure.state.pressures.max() > 0.0


def test_keys_are_those_of_the_reading_and_the_conditioning(study, tmp_path) -> None:
    np.savez(tmp_path / "two.npz", z=1e6 * study.face.heights, other=np.eye(40))
    loaded = study(
        ('"face.npy"', '"two.npz"\nformat = "npz"\nchannel = "z"'),
        ('"2 um"', '["1 um", "2 um"]\nvalid = ["-5 um", "0.5 um"]'),
        (
            "piece",
            'cutoff = "6 um"\nlong_cutoff = "60 um"\nlevel = "quadratic"\npiece',
        ),
    )
    scan = ms.Scan.read(
        tmp_path / "two.npz", unit="um", pixel=(1e-6, 2e-6), channel="z", valid=(-5e-6, 5e-7)
    )
    assert scan.missing > 0.0
    scan = scan.repaired().condition(level="quadratic", long_cutoff=6e-5)
    np.testing.assert_array_equal(loaded.surface.face.heights, scan.condition(cutoff=6e-6).heights)
