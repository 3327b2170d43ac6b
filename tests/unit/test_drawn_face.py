"""The law of a face by the numbers of its drawing."""

from __future__ import annotations

import math

import fit_face_table
import numpy as np
import pytest
from made_surfaces import rough

import microslip as ms
from microslip.contact import face_table as table
from microslip.contact.finish import Finish

STEEL = ms.Material(210e9, 0.3, hardness=2.4e9)
PAIR = ms.MaterialPair(STEEL, STEEL)


def ground(**changes: object) -> ms.DrawnFace:
    values = {"rms": 4e-7, "slope": 0.1, "area": 1e-4, "tightening_pressure": 1e8} | changes
    return ms.DrawnFace(values.pop("pair", PAIR), **values)  # type: ignore[arg-type]


def test_the_stored_nodes_give_the_stored_fit() -> None:
    """The coefficients are those of the nodes; single precision of these leaves 1e-6."""
    arrays = table.stored()
    at = arrays["hardness"], arrays["pressure"], arrays["breadth"]
    shipped = table.values(*at)
    fitted = fit_face_table.fit(arrays)
    for name, terms in table._TERMS.items():
        basis = fit_face_table.basis(table._powers(*table.groups(*at[:2]))[0], at[2], terms)
        assert fitted[name] @ basis == pytest.approx(arrays[f"fitted_{name}"] @ basis, abs=1e-6)
    # The fit is a mean over the faces: single nodes of few faces scatter about it.
    heavy = arrays["level"] >= 0.03
    miss = (np.log(shipped.stiffness) - arrays["stiffness"])[heavy]
    assert math.sqrt(np.mean(miss**2)) < 0.09


def test_the_law_has_the_stiffness_of_its_table_and_is_convex() -> None:
    law = ground()
    numbers = table.values(law._groups[0], law._groups[1])
    assert law.stiffness(law.closest) == pytest.approx(
        float(numbers.stiffness[0]) * 1e8 * 1e-4 / 4e-7, rel=2e-3
    )
    assert law.load(law.closest) == pytest.approx(1e4, rel=1e-12)
    d = np.linspace(law.closest, law.closest + 2e-6, 4000)
    fall = law.stiffness(d)
    assert np.all(np.diff(law.load(d)) < 0.0)
    assert np.all(np.diff(fall) <= 1e-9 * fall[0])
    assert law.contact_area(law.closest) / 1e-4 == pytest.approx(1e8 / 2.4e9, rel=0.2)


@pytest.mark.parametrize("hardness", [0.2, 0.5, 1.3, 3.0, 9.0, 1e6])
@pytest.mark.parametrize("pressure", [1e-6, 0.004, 0.05, 0.3, 0.5])
def test_every_law_of_the_table_falls_and_is_convex(hardness: float, pressure: float) -> None:
    """By its groups: hardness over E* h' from 0.01 to elastic."""
    pair = PAIR.with_hardness(hardness * 1e9)
    pressure = min(pressure * hardness * 1e9, 0.3 * 0.14 * PAIR.composite_modulus)
    law = ground(pair=pair, tightening_pressure=pressure)
    d = np.linspace(law.closest, law._span[1], 2000)
    loads, fall = law.load(d), law.stiffness(d)
    assert np.all(np.diff(loads[loads > 0.0]) < 0.0)
    assert np.all(np.diff(fall) <= 1e-9 * fall[0])
    first = law.first_loading
    assert np.all(np.diff(first.separation) < 0.0)
    # Unloading is stiffer than first loading; the spline of the table leaves 0.2 %.
    assert law.stiffness(law.closest) > 0.998 * first.stiffness[-1]


def test_a_lay_turns_the_ratio_of_stiffnesses() -> None:
    """Mean and the two axes: (1 - nu c)/(1 - nu), c the share of the slope along the motion."""
    law = ground(lay=1.0 / 3.0)
    for direction, share in ((0.0, 0.75), (math.pi / 2.0, 0.25)):
        ratio = (1.0 - 0.3 * share) / 0.7
        assert law.slip_per_indentation(direction) == pytest.approx(ratio, rel=1e-12)
        assert law.along(direction).stiffness_ratio == pytest.approx(ratio, rel=1e-12)
    assert ground().slip_per_indentation() == pytest.approx(PAIR.stiffness_ratio, rel=1e-12)
    joint = ms.Interface(law, 0.2, normal_load=5e3, direction=0.0)
    assert joint.normal_stiffness / joint.tangential_stiffness == pytest.approx(0.775 / 0.7)


def test_nodes_are_tightened_by_their_own_pressure() -> None:
    """Stiffness and rest of each exactly, its law as far as the shape depends on the pressure."""
    law, places = ground(), np.array([1e8, 4e7, 1e7, 1e6, 0.0])
    field = ms.JointField(law, 0.3, areas=1e-4, pressures=places)
    slip = field.force_limits[:4] / field.tangential_stiffnesses[:4]
    assert slip.max() / slip.min() < 1.3
    state, u = field.start(), float(slip[0]) * np.array([0.1, 0.5, 1.0, 2.0])
    forces = np.array([state.try_(x).force for x in u]).T
    falls = 0.1 * float(slip[0])
    closer = field.load(field.separations - falls)
    for i, p in enumerate(places[:4]):
        own = ground(tightening_pressure=float(p))
        joint = ms.Interface(own, 0.3, normal_load=p * 1e-4)
        assert field.tangential_stiffnesses[i] == pytest.approx(
            joint.tangential_stiffness, rel=2e-3
        )
        assert field.separations[i] == pytest.approx(joint.separation, rel=1e-3)
        assert forces[i] == pytest.approx(joint.backbone(u), rel=0.03)
        load = p * 1e-4 * math.exp(falls / own.slip_length)
        assert closer[0][i] == pytest.approx(load, rel=0.03)
    with pytest.raises(ms.InputError, match="must be at least 1"):
        law._check_rest(np.array([1e4, 1.5e4]))


def test_nodes_of_own_tightening_have_consistent_tangents() -> None:
    """Against differences, by steps, cycles and harmonics, with separations that vary."""
    field = ms.JointField(ground(), 0.3, areas=1e-4, pressures=[1e8, 3e7, 2e6])
    d, u, step = field.separations - 1e-9, 8e-9, 1e-13
    here = field.start().try_(u, separations=d)
    ends = [field.start().try_(u, separations=d + s) for s in (-step, step)]
    for row, name in enumerate(("force", "load")):
        slope = (getattr(ends[1], name) - getattr(ends[0], name)) / (2.0 * step)
        assert here.tangent[:, row, 1] == pytest.approx(slope, rel=1e-3)
    assert field.start().separation == pytest.approx(field.separations, rel=1e-12)
    both = field.two_directions(sliders=400).start().try_([u, 0.0], separations=d)
    assert both.force[:, 0] == pytest.approx(here.force, rel=1e-2)
    assert both.tangent[:, 2, 2] == pytest.approx(here.tangent[:, 1, 1], rel=1e-9)
    rows = np.tile([0.0, u, 0.0], (3, 1))
    paths = np.column_stack([field.separations, np.full(3, 3e-10), np.full(3, 1e-10)])
    exact = field.harmonics(rows, [0, 1], separations=paths)
    sampled = field.harmonics(rows, [0, 1], separations=paths, samples=4096)
    assert exact.force == pytest.approx(sampled.force, abs=1e-5 * abs(exact.force).max())
    assert exact.jacobian == pytest.approx(sampled.jacobian, abs=1e-3 * abs(exact.jacobian).max())
    moved = paths + np.array([0.0, 1e-13, 0.0])
    other = field.harmonics(rows, [0, 1], separations=moved)
    assert (other.load - exact.load)[:, 1] / 1e-13 == pytest.approx(
        exact.jacobian[:, 1, 1, 1, 1], rel=1e-3
    )


# -- drawings --------------------------------------------------------------------------------------


def test_a_drawing_finds_rq_and_rdq_of_gaussian_profiles_again() -> None:
    """Ra and RSm of long Gaussian profiles, by counting."""
    made = rough((1024, 256), 1e-6, 1e-6, longest=1.65e-4, shortest=2.1e-5, seed=5)
    heights = made.heights - made.heights.mean()
    ra = float(np.abs(heights).mean())
    ups = np.count_nonzero((heights[:, :-1] < 0.0) & (heights[:, 1:] >= 0.0))
    finish = ms.Finish(ra=ra, rsm=heights.shape[0] * (heights.shape[1] - 1) * 1e-6 / ups)
    # One realisation: some hundred waves along each axis.
    assert finish.rms.middle == pytest.approx(made.moments().rms, rel=0.02)
    assert finish.slope.middle == pytest.approx(made.moments().rms_slope, rel=0.05)


# Sampling lengths of 0.8 mm, for an Ra of 1.26 um, and of 2.5 mm.
@pytest.mark.parametrize(
    ("rz", "rsm", "waves"),
    [(6.3e-6, None, 10.0), (6.3e-6, 0.08e-3, 10.0), (6.3e-6, 0.2e-3, 4.0), (6.3e-6, 0.4e-3, 2.0),
     (6.3e-6, 1.6e-3, 2.0), (4e-5, 0.1e-3, 25.0)],
)  # fmt: skip
def test_the_range_of_a_profile_is_that_of_so_many_waves(
    rz: float, rsm: float | None, waves: float
) -> None:
    """Peaks of a narrow band are of Rayleigh's distribution; a sampling length has two or more."""
    x = np.linspace(0.0, 12.0, 200_001)
    peak = np.trapezoid(1.0 - (1.0 - np.exp(-0.5 * x**2)) ** waves, x)
    rms = ms.Finish(rz=rz, rsm=rsm).rms.middle
    assert rms == pytest.approx(rz / (2.0 * peak), rel=0.04)


def test_two_faces_and_what_a_drawing_leaves_open() -> None:
    exact, open_ = ms.Finish(rq=3e-7, rdq=0.06), ms.Finish(rq=4e-7, process="eroded")
    assert open_.process == "eroded"
    law = ms.DrawnFace.from_finish(PAIR, exact, exact, area=1e-4, tightening_pressure=1e8)
    assert law.rms == pytest.approx(math.sqrt(2.0) * 3e-7)
    assert law.slope == pytest.approx(math.sqrt(2.0) * 0.06)
    assert not law.spreads
    known = law.errors
    law = ms.DrawnFace.from_finish(PAIR, exact, open_, area=1e-4, tightening_pressure=1e8)
    assert set(law.spreads) == {"slope"}
    assert law.errors.inputs > 1.5 * known.inputs
    # Mean slopes 0.076 Rq^0.52 and 0.124 Rq^0.743, Rq in um, each 1.5 times beyond.
    ends = math.sqrt(math.pi / 2.0) * np.array([0.076 * 4.0**0.52 / 1.5, 0.124 * 4.0**0.743 * 1.5])
    slope = ms.Finish(rq=4e-6).slope
    quantiles = slope.middle * np.exp(1.6449 * slope.spread * np.array([-1.0, 1.0]))
    assert quantiles == pytest.approx(ends, rel=1e-3)


def test_drawn_faces_scatter_as_their_errors_say() -> None:
    """First order against 400 draws: log-normal inputs of 5 to 20 %."""
    spreads = {"rms": 0.1, "slope": 0.2, "hardness": 0.1, "tightening_pressure": 0.05}
    law, random = ground(breadth=0.84, lay=1.0, spreads=spreads), np.random.default_rng(2)
    logs = [math.log(f.stiffness(f.closest)) for f in (law.drawn(random) for _ in range(400))]
    assert np.std(logs) == pytest.approx(law.errors.total, rel=0.12)


def test_patches_of_a_lay_differ_more() -> None:
    """Waves are longer along the lay, up to the side of the patch."""
    plain, lay = ground(lay=1.0), ground(lay=0.2)
    longer = math.sqrt(2.0) / math.hypot(1.0, 0.2)  # mean wave, at the same slope across the lay
    assert lay.scatter(0.01) / plain.scatter(0.01) == pytest.approx(longer / math.sqrt(0.2))
    assert 0.0 < lay.scatter(1e-4) / plain.scatter(1e-4) < longer / math.sqrt(0.2)


def test_a_heavier_joint_tightens_the_face_anew() -> None:
    joint = ms.Interface(ground(), 0.2, normal_load=3e4)
    assert joint.surface.tightening_pressure == pytest.approx(3e8)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pair": ms.MaterialPair(ms.Material(210e9, 0.3), STEEL.rigid())}, "hardness=2.4e9"),
        ({"tightening_pressure": 1.3e9}, "at most 0.5 of the hardness"),
        ({"slope": 15.0}, "tangent"),
        ({"slope": 0.01, "tightening_pressure": 8e8}, "rms gradient"),
        ({"rms": 0.03}, "check its unit"),
        ({"pair": PAIR.with_hardness(24e9)}, "a tenth of the modulus"),
        ({"plateau": 5e-7}, "at most 4e-07"),
        ({"breadth": 1.5}, "at most 0.95"),
        ({"lay": 3.0}, "lay must be at most 1"),
        ({"rms": -1.0}, "rms must be above zero"),
        ({"spreads": {"ra": 0.1}}, "must name some of rms"),
    ],
)
def test_what_it_refuses(changes: dict[str, object], words: str) -> None:
    with pytest.raises(ms.InputError) as caught:
        ground(**changes)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("drawing", "words"),
    [
        ({"rq": 3e-2}, "rq must give an Rq of at most 0.0002 m"),
        ({"rz": 5e-3}, "rz must give an Rq of at most 0.0002 m"),
        ({"ra": 1e-6, "rdq": 3.0}, "rdq must give an rms slope of at most 1"),
        ({"ra": 1e-6, "rsm": 1e-6}, "rsm must give an rms slope of at most 1"),
    ],
)
def test_drawings_that_no_machined_face_has_are_refused(drawing: dict, words: str) -> None:
    with pytest.raises(ms.InputError, match=words):
        ms.Finish(**drawing)


def test_unloading_is_not_extrapolated_to_breadths_that_no_face_of_the_table_has() -> None:
    least = float(table.stored()["breadth"].min())
    below, at, above = (table.values(0.06, 6e-4, b).bends for b in (0.6, least, 0.8))
    np.testing.assert_allclose(below, at, rtol=5e-3)
    assert not np.allclose(at, above, rtol=0.05)


# -- studies ---------------------------------------------------------------------------------------


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
