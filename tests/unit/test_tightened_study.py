"""Studies of joints that were tightened once: keys, verdicts, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from studies import LOADS, MATERIAL, edited

import microslip as ms

TIGHTENED = (LOADS, f'{LOADS}\ntightening_load = "4 kN"')
YIELDS = (LOADS, f'{LOADS}\ntightening_load = "4 kN"\nyield_stress = "250 MPa"')
HARD = (MATERIAL, f'{MATERIAL}hardness = "0.71 GPa"\n')


@pytest.mark.slow
def test_a_study_equals_the_same_in_python() -> None:
    result = ms.Study.from_toml(edited(YIELDS)).run()
    al = ms.Material(69e9, 0.33)
    rough = ms.GreenwoodWilliamson(ms.MaterialPair(al, al), ms.Gaussian(5e-7), 1e-3, 1e8, 2e-4)
    law = rough.tightened(4000.0, yield_stress=250e6)
    for joint, load in zip(result.joints, (500.0, 2000.0), strict=True):
        wanted = ms.Interface(law, 0.55, normal_load=load)
        assert joint.tangential_stiffness == wanted.tangential_stiffness
        assert joint.dissipated_energy(1e-7) == wanted.dissipated_energy(1e-7)
    said = result.summary["tightening"]
    assert said["yielded_share"] == law.yielded_share
    assert said["contact_area"] == law.contact_area(law.closest_separation)
    assert said["contact_area_fraction"] == pytest.approx(said["contact_area"] / 2e-4)
    assert any(
        note.startswith("joint.tightening_load: at 4 kN ") for note in result.summary["notes"]
    )
    names = [verdict["name"] for verdict in result.summary["joints"][0]["validity"]]
    assert {"contacts", "indentation over yield", "real over apparent area at tightening"} < set(
        names
    )
    assert "plasticity index" not in names


@pytest.mark.slow
def test_hardness_and_model_decide() -> None:
    by_hardness = ms.Study.from_toml(edited(TIGHTENED, HARD)).run().joints[0].surface
    assert by_hardness.yield_stress == pytest.approx(0.71e9 / 2.84)
    other = edited((LOADS, f'{YIELDS[1]}\ntightening_model = "fully-plastic"'))
    assert ms.Study.from_toml(other).run().joints[0].surface.model == "fully-plastic"


@pytest.mark.slow
def test_a_heavier_load_tightens_further() -> None:
    """The last load is above the tightening: its joint is that of a surface tightened to it."""
    joints = ms.Study.from_toml(edited(YIELDS, ("2 kN", "5 kN"))).run().joints
    again = joints[0].surface.tightened(5000.0)
    assert [joint.surface.tightening_load for joint in joints] == [4000.0, 5000.0]
    wanted = ms.Interface(again, 0.55, normal_load=5000.0).tangential_stiffness
    assert joints[1].tangential_stiffness == wanted


def test_indentation_over_yield_is_the_mean_over_the_load() -> None:
    """Against a sum over a million summits, and of one summit its own."""
    al = ms.Material(69e9, 0.33)
    pair = ms.MaterialPair(al, al)
    law = ms.GreenwoodWilliamson(pair, ms.Exponential(5e-7), 1e-3, 1e8, 2e-4).tightened(
        4000.0, yield_stress=250e6
    )
    unit = law._model.yield_indentation * law.radius
    # Exponential heights: the indentations are exponential again.
    r = (np.arange(1_000_000) + 0.5) * 2e-5 * (5e-7 / unit)
    loads = law._model.load_of(r) * np.exp(-r * unit / 5e-7)
    assert law.mean_indentation == pytest.approx(float(loads @ r / loads.sum()), rel=1e-6)
    alone = ms.AsperityPopulation(pair, [0.0], [1e-3]).tightened(40.0, yield_stress=250e6)
    depth = -alone.closest_separation / (alone._model.yield_indentation * 1e-3)
    assert alone.mean_indentation == pytest.approx(depth, rel=1e-12)


ROUGH_FACE = """
schema = 1
[surface]
law = "rough"
materials = ["al", "al"]
rq = "0.8 um"
roll_off = "0.8 mm"
shortest = "8 um"
area = "2 cm^2"
[material.al]
young_modulus = "69 GPa"
poisson_ratio = 0.33
hardness = "1.2 GPa"
[joint]
friction_coefficient = 0.5
normal_load = LOADS
[excitation]
amplitudes = ["0.3 um"]
curve = { from = "10 nm", to = "1 um", points = 3 }
"""


def test_a_rough_face_is_independent_of_the_load_before() -> None:
    """Each load is the first one, in whatever order they stand; and no record goes above it."""
    for loads in ('["500 N", "5 kN"]', '["5 kN", "500 N"]'):
        joints = ms.Study.from_toml(ROUGH_FACE.replace("LOADS", loads)).run().joints
        assert {joint.surface.tightening_load for joint in joints} == {500.0, 5000.0}
    with pytest.raises(ms.InputError, match="at most the tightening load 500 N"):
        joints[1].coupled_force([0.0, 1e-7], normal_load=[500.0, 600.0])
