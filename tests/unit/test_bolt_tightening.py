"""Bolts by size and grade: preloads, torques and losses against what has been printed of them."""

from __future__ import annotations

import numpy as np
import pytest

import microslip as ms
from microslip.report.predicted.preview import preview
from microslip.report.structure.data import force_rows
from microslip.structures.bolt_tightening import ClampedBolt, Thread, embedding_of, proof_stress
from microslip.study.build import Design, build_surface
from microslip.study.runs.structure import keys_of_model
from microslip.study.uncertain import at_central_values

FACE = """
schema = 1
[surface]
law = "face"
materials = ["steel-c45", "al2017"]
rq = "1.6 um"
rdq = 0.15
area = "40 cm^2"
[joint]
friction_coefficient = 0.3
pressure = { kind = "bolt", size = "M8", count = 4, plates = ["8 mm", "12 mm"], MORE }
"""
# Fine threads by VDI 2230 (2001): diameter, pitch [mm], mu, F_M [kN] of 8.8, 10.9 and 12.9.
PRINTED = (
    (8, 1.0, 0.10, 20.7, 30.4, 35.6), (8, 1.0, 0.12, 20.2, 29.7, 34.7),
    (10, 1.25, 0.14, 30.8, 45.2, 52.9), (12, 1.25, 0.12, 48.0, 70.5, 82.5),
    (16, 1.5, 0.12, 87.6, 128.7, 150.6), (20, 1.5, 0.10, 151.0, 215.0, 252.0),
)  # fmt: skip


@pytest.mark.parametrize(("d", "pitch", "mu", "first", "second", "third"), PRINTED)
def test_assembly_preloads_are_those_of_the_guideline(
    d: float, pitch: float, mu: float, first: float, second: float, third: float
) -> None:
    thread = Thread(1e-3 * d, 1e-3 * pitch)
    for grade, printed in zip(("8.8", "10.9", "12.9"), (first, second, third), strict=True):
        found = 0.9 * proof_stress(grade, thread.diameter) / thread.reduced_stress(1.0, mu)
        assert 1e-3 * found == pytest.approx(printed, rel=5e-3)  # three printed digits


def test_bolts_by_their_size() -> None:
    bolts = ms.Bolts([0.0], size="M8", grade="8.8", torque=25.0, thread_friction=0.12,
                     bearing_friction=0.12)  # fmt: skip
    assert (bolts.shank, bolts.hole, bolts.thread) == pytest.approx((0.008, 0.009, 0.008))
    lever = 0.16 * 1.25e-3 + 0.58 * 7.188e-3 * 0.12 + 0.25 * (0.009 + 0.01163) * 0.12
    assert bolts.tension[0] == pytest.approx(25.0 / lever, rel=5e-3)
    low, high = bolts.tension_range
    assert high[0] / low[0] == pytest.approx(1.6)
    np.testing.assert_allclose(bolts.utilisation, bolts.tension / 18.6e3 * 0.9, rtol=2e-3)
    exact = ms.Bolts([0.0], size="M8", tension=16e3)
    assert exact.tension_range[0] == exact.tension_range[1] == 16e3
    for wrong, says in (
        ({"size": "M9", "tension": 1e4}, "size must be"),
        ({"size": "M8", "grade": "8.9", "tension": 1e4}, "grade must be"),
        ({"size": "M8", "grade": "8.8", "tension": 25e3}, "at which a M8 of grade 8.8 yields"),
        ({"tension": 1e4}, "shank missing"),
        ({"size": "M8", "tension": 1e4, "tightening_factor": 0.5}, "tightening_factor must be"),
    ):
        with pytest.raises(ms.InputError) as caught:
            ms.Bolts([0.0], **wrong)  # type: ignore[arg-type]
        assert says in str(caught.value)


def test_resiliences_and_what_embeds() -> None:
    """Limits: rods in a row, and of long clamps a load factor that falls; losses by the table."""
    bolt = ClampedBolt("M12", 0.06)
    core = 0.25 * np.pi * (0.012 - 1.22687 * 1.75e-3) ** 2
    rods = (0.06 + 0.006) / core + 0.0108 / (0.25 * np.pi * 0.012**2)
    assert bolt.resilience == pytest.approx(rods / 205e9, rel=1e-6)
    # A cone is stiffer than the sleeve under the head, and softer than one of its largest width.
    wide = 0.25 * np.pi * (0.05**2 - 0.0135**2)
    sleeve = 0.25 * np.pi * (0.01663**2 - 0.0135**2)
    assert 0.06 / 205e9 / wide < bolt.plate_resilience < 0.06 / 205e9 / sleeve
    half = ClampedBolt("M12", 0.06, plate_modulus=102.5e9)
    assert half.plate_resilience == pytest.approx(2.0 * bolt.plate_resilience)
    share = bolt.plate_resilience / (bolt.resilience + bolt.plate_resilience)
    assert bolt.load_factor(1.0) == pytest.approx(share)
    assert 0.1 < share < 0.35
    assert embedding_of(16e-6, interfaces=2) == pytest.approx(13e-6)  # 3 + 2 * 3 + 2 * 2 um
    assert bolt.loss(13e-6) * (bolt.resilience + bolt.plate_resilience) == pytest.approx(13e-6)
    with pytest.raises(ms.InputError, match="below 160 um"):
        embedding_of(2e-4)


def test_a_joint_pressed_by_bolts_of_a_grade() -> None:
    """K d F = M by hand, alpha_A as the ratio of its ends, and yield at 640 MPa with torsion."""
    text = FACE.replace("count = 4", 'grade = "8.8"').replace('"40 cm^2"', '"9 cm^2"')
    study = ms.Study.from_toml(text.replace("MORE", 'torque = "20 N m", tightening_factor = 2.0'))
    assert study.joint.normal_load == (pytest.approx(20.0 / (0.2 * 0.008)),)
    design = Design(study)
    place = [one.key for one in design.inputs].index("joint.pressure.torque")
    ends = [
        design.at(sign * 9.0 * np.eye(len(design.inputs))[place]).joint.normal_load[0]
        for sign in (-1.0, 1.0)
    ]
    assert ends == pytest.approx([12500.0 * 2 / 3, 12500.0 * 4 / 3])
    # M8 of 8.8 at mu_G = 0.12: 18.6 kN at 90 % of yield in the guideline's table.
    for more in ('torque = "40 N m"', 'preload = "21 kN"'):
        with pytest.raises(ms.StudyError, match="at which a M8 of grade") as caught:
            ms.Study.from_toml(text.replace("MORE", more))
        most = float(str(caught.value).partition("at most ")[2].partition(" N")[0])
        assert most == pytest.approx(18.6e3 / 0.9, rel=5e-3)


def resiliences(plates: tuple[tuple[float, float], ...]) -> tuple[float, float]:
    """Of an M8 and of its plates, as discs of two whole cones, summed up [m/N]."""
    length, core = sum(t for t, _ in plates), 0.008 - 1.22687 * 1.25e-3
    bolt = 0.9 * 0.008 / (np.pi / 4 * 0.008**2) + (length + 0.004) / (np.pi / 4 * core**2)
    y = 1.0 + 1.2 * length / 0.01163
    slope = 0.362 + 0.032 * np.log(length / 2 / 0.01163) + 0.153 * np.log(y)
    z = (np.arange(20000) + 0.5) / 20000 * 0.5 * length
    discs = 1.0 / (np.pi / 4 * ((0.01163 + 2.0 * z * slope) ** 2 - 0.009**2))
    compliance = sum(t / e for t, e in plates) / length
    return bolt / 205e9, length * float(discs.mean()) * compliance


def test_what_embeds_in_a_study() -> None:
    """F_K = F_M - f_Z/(dS + dP) by hand, in the middle, in draws and told."""
    more = 'torque = "20 N m", grade = "8.8", embedding = EMBEDDED'
    text = FACE.replace("MORE", more)
    study = ms.Study.from_toml(text.replace("EMBEDDED", '"8 um"'))
    bolt, plates = resiliences(((0.008, 210e9), (0.012, study.material["al2017"].young_modulus)))
    left = 12500.0 - 8e-6 / (bolt + plates)
    assert study.joint.normal_load == pytest.approx((4 * left,), rel=1e-4)
    spread = study.joint.pressure.spread()
    largest = 4 * 12500.0 * (spread.shares / spread.areas).max()  # before any of it
    assert build_surface(study).tightening_pressure == pytest.approx(largest)
    (note,) = [n for n in preview(study).data["notes"] if "each bolt" in n]
    assert "12.50 kN, 9.615 kN to 15.38 kN by a tightening factor of 1.6" in note
    assert f"clamp force between the plates, per bolt {1e-3 * left:.2f} kN" in note
    scattered = ms.Study.from_toml(text.replace("EMBEDDED", '{ low = "4 um", high = "12 um" }'))
    design = Design(scattered)
    places = {one.key.rpartition(".")[2]: i for i, one in enumerate(design.inputs)}
    for sign, tightened in ((-1.0, 12500.0 * 2 / 2.6), (1.0, 12500.0 * 3.2 / 2.6)):
        scores = np.zeros(len(design.inputs))
        scores[[places["torque"], places["embedding"]]] = sign * 9.0, -sign * 9.0
        drawn = tightened - (8e-6 - sign * 4e-6) / (bolt + plates)
        assert design.at(scores).joint.normal_load == pytest.approx((4 * drawn,), rel=1e-4)
    # By the table: 3 + 2 * 2.5 + 1.5 um below an Rz of 10 um.
    own = 'preload = "12.5 kN", rz = "6.3 um"'
    found = ms.Study.from_toml(FACE.replace("MORE", own)).joint.normal_load[0]
    assert found == pytest.approx(4 * (12500.0 - 9.5e-6 / (bolt + plates)), rel=1e-4)


BEAM = FACE[: FACE.index("friction")].replace("al2017", "steel-c45")
BEAM += """
friction_coefficient = MU
[structure]
length = "720 mm"
width = "25.4 mm"
thickness = "25.4 mm"
lap = "120 mm"
density = "7784 kg/m^3"
[structure.bolts]
positions = ["-30 mm", "0 mm", "30 mm"]
size = "M8"
grade = "8.8"
torque = "20 N m"
nut_factor = 0.2
"""


def test_a_study_by_size_and_torque() -> None:
    """The tension, and its band where anything else is drawn, or the factor is given."""
    study = ms.Study.from_toml(BEAM.replace("MU", "0.3"))
    np.testing.assert_allclose(study.structure.tension, 20.0 / (0.2 * 0.008))
    assert study.structure.build().bolts.hole == pytest.approx(0.009)
    design = Design(ms.Study.from_toml(BEAM.replace("MU", "{ low = 0.2, high = 0.4 }")))
    keys = {one.key: one.written for one in design.inputs}
    assert set(keys) >= {
        "surface.stiffness_factor", "joint.friction_coefficient", "structure.bolts.torque",
    }  # fmt: skip
    embedded = BEAM.replace("MU", "0.3") + 'embedding = { low = "4 um", high = "12 um" }\n'
    design = Design(ms.Study.from_toml(embedded))
    bolt, plates = resiliences(((0.0254, 210e9),))
    lost = 8e-6 / (bolt + plates)
    np.testing.assert_allclose(
        at_central_values(design.study).structure.tension, 12500.0 - lost, rtol=1e-4
    )
    scores = np.where([one.key.endswith("embedding") for one in design.inputs], 9.0, 0.0)
    np.testing.assert_allclose(design.at(scores).structure.tension, 12500.0 - 1.5 * lost, rtol=1e-4)
    assert keys_of_model(design.study, design.spreads) == []  # no mesh anew
    rows = dict(force_rows(design.study.structure.bolt_forces))
    assert rows["Lost after tightening"].startswith(f"{1e-3 * lost:.2f} kN")
    with pytest.raises(ms.StudyError, match="missing; rz needs the size of the bolts"):
        ms.Study.from_toml(
            BEAM.replace("MU", "0.3").replace(
                'size = "M8"\ngrade = "8.8"',
                'shank = "8 mm"\nhole = "9 mm"\nwasher = "12 mm"\nthread = "8 mm"\nrz = "6 um"',
            )
        )
    wide = ms.Study.from_toml(f"{BEAM.replace('MU', '0.3')}tightening_factor = 2.0\n")
    band = Design(wide).spreads["structure.bolts.torque"]
    assert (band.low, band.high) == pytest.approx((20.0 * 2 / 3, 20.0 * 4 / 3))


# s of ISO 4014 and ISO 4032, k of ISO 4014, greatest m of ISO 4032, d2 and h of ISO 7089 and medium
# holes of ISO 273 [mm], as the open library BOLTS lists them
# (github.com/boltsparts/BOLTS_archive, data/hex.blt, nut.blt and washer.blt).
STANDARD = {
    "M5": (8, 3.5, 4.7, 10, 1, 5.5), "M6": (10, 4, 5.2, 12, 1.6, 6.6),
    "M8": (13, 5.3, 6.8, 16, 1.6, 9), "M10": (16, 6.4, 8.4, 20, 2, 11),
    "M12": (18, 7.5, 10.8, 24, 2.5, 13.5), "M14": (21, 8.8, 12.8, 28, 2.5, 15.5),
    "M16": (24, 10, 14.8, 30, 3, 17.5), "M20": (30, 12.5, 18, 37, 3, 22),
}  # fmt: skip


@pytest.mark.parametrize("size", STANDARD)
def test_heads_nuts_and_washers_are_those_of_the_standards(size: str) -> None:
    flats, head, nut, washer, thickness, hole = (1e-3 * value for value in STANDARD[size])
    bolts = ms.Bolts([0.0], size=size, tension=1e3)
    found = bolts.head, bolts.washer, bolts.washer_thickness, bolts.hole
    assert found == pytest.approx((flats, washer, thickness, hole), rel=1e-12)
    assert bolts.pressed == pytest.approx(min(flats + 1.6 * thickness, washer))
    hexagons = np.sqrt(0.75) * flats**2 * (head + nut)
    # The hole of the nut is left out: half of the shank's section over both heights.
    inside = 0.125 * np.pi * bolts.shank**2 * (head + nut)
    rings = 0.5 * np.pi * (washer**2 - bolts.shank**2) * thickness
    assert bolts.fixing_mass(7850.0) == pytest.approx(7850.0 * (hexagons - inside + rings))
