"""The law of a measured face: what it takes and refuses, what it tells, files, patches, lay."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from usual import slope

import microslip as ms
from microslip.contact import measured_face
from microslip.contact.boundary_elements import HalfSpace, closing, press
from microslip.contact.face_solution import cycle_energies
from microslip.contact.figures import face_plot
from microslip.friction.input_slopes import input_slopes
from microslip.surfaces.joints import contact_words

STEEL = ms.Material(210e9, 0.3, hardness=2.5e9)
PAIR = ms.MaterialPair(STEEL, STEEL)
(LAW,) = ms.MeasuredContact.examples()
PIXEL = 2e-6


def heights(points: int = 64, seed: int = 2, lay: float = 1.0) -> np.ndarray:
    """Waves of H = 0.8 between 16 pixels and half of the face, 0.3 um rms."""
    qx, qy = np.fft.rfftfreq(points) * points, np.fft.fftfreq(points) * points * lay
    q = np.hypot(qy[:, None], qx)
    size = np.where((q > 1.5) & (q < points / 8), np.maximum(q, 3.0) ** -1.8, 0.0)
    waves = size * np.exp(2j * np.pi * np.random.default_rng(seed).random(q.shape))
    z = np.fft.irfft2(waves, s=(points, points))
    return 3e-7 * z / z.std()


def solve(z: np.ndarray | None = None, **how) -> ms.MeasuredContact:
    z = heights() if z is None else z
    return ms.MeasuredContact(z, PAIR, **({"pixel": PIXEL, "piece": None} | how))


def plane_of(z: np.ndarray) -> np.ndarray:
    """Coefficients of the least-squares plane over the indices."""
    rows, columns = np.indices(z.shape)
    ones = np.ones(z.size)
    plane = np.stack([ones, rows.ravel(), columns.ravel()], axis=1)
    offset, down, across = np.linalg.lstsq(plane, z.ravel(), rcond=None)[0]
    return np.array([[offset, across], [down, 0.0]])


def test_a_scan_gives_the_law_and_its_plane_does_not_matter() -> None:
    z = heights()
    tilt = 1e-3 * PIXEL * np.arange(64) + 4e-4 * PIXEL * np.arange(64)[:, None] + 5e-6
    scan = ms.Scan(z + tilt, PIXEL)
    law, bare = scan.to_contact(PAIR, piece=None), solve(z)
    d = np.asarray(bare.separations)
    assert law.load(d[20:]) == pytest.approx(bare.load(d[20:]), rel=1e-2)
    assert law.area == pytest.approx((64 * PIXEL) ** 2)
    assert law.numbers.relative_pressure == pytest.approx(0.05)
    twice = solve(z, area=2.0 * law.area)
    assert twice.load(d[30:]) == pytest.approx(2.0 * bare.load(d[30:]), rel=1e-12)


def test_loads_meet_the_solutions_and_are_convex() -> None:
    law = solve(tightening_pressure=2e8, loads=12)
    solution, unit = law.solution, PAIR.composite_modulus * law.area
    d = solution.separation * PIXEL
    assert law.load(d) == pytest.approx(unit * solution.pressure[:, 0], rel=1e-5)
    slopes = unit / PIXEL * solution.slope[:, 0]
    assert law.stiffness(d[1:-1]) == pytest.approx(slopes[1:-1], rel=0.01)
    assert law.stiffness(d[0]) == pytest.approx(slopes[0], rel=0.02)
    # Twice as many loads: the same between them.
    fine = solve(tightening_pressure=2e8, loads=24)
    between = np.geomspace(0.9, 2e-3, 40) * 2e8 * law.area
    assert law.separation(between) == pytest.approx(fine.separation(between), rel=5e-3)
    joint, other = (ms.Interface(s, 0.3, normal_load=0.5 * 2e8 * law.area) for s in (law, fine))
    u = np.geomspace(1e-9, 1e-6, 9)
    assert joint.backbone(u) == pytest.approx(other.backbone(u), rel=0.02)  # few contacts
    assert np.all(np.diff(law.stiffness(np.linspace(d[0], d[-1] * 1.2, 3000))) <= 0.0)


@pytest.mark.slow
def test_small_cycles_lose_what_the_face_loses_pressed_at_every_step() -> None:
    """The trapezoidal rule on loads at 44 separations, for loops of 1/20 to 1 of mu N/k_t.

    By twelve loads alone the energy at 1/20 is off by 25 % rms, up to 1.5 times.
    """
    shares, pressure = np.concatenate((np.linspace(0.0, 0.1, 15), np.linspace(0.12, 1.0, 29))), 1e8
    errors = []
    for seed in range(3):
        law = solve(z := heights(128, seed), tightening_pressure=pressure)
        z = (z - np.polynomial.polynomial.polyval2d(*np.indices(z.shape), plane_of(z))) / PIXEL
        space, tolerance = HalfSpace(z.shape), 1e-8 * z.std()
        hardness, d = 2.5e9 / PAIR.composite_modulus, float(law.solution.separation[0])
        p = press(space, z, d, hardness=hardness, tolerance=tolerance)
        gap = space.displacement(p) - z + d
        z = z + np.where(p >= hardness, np.minimum(gap, 0.0), 0.0)
        p, loads = press(space, z, d, p, tolerance=tolerance), []
        opening = float(p.mean() / closing(space, p > 0.0).mean())
        for share in shares:
            p = press(space, z, d + share * opening, p, tolerance=tolerance)
            loads.append(float(p.mean()))
        drops = 1.0 - np.array(loads) / loads[0]
        joint = ms.Interface(law, 0.3, normal_load=pressure * law.area)
        u = joint.force_limit / joint.tangential_stiffness
        for i in (7, 14, 22, 43):
            truth = 8.0 * np.trapezoid(drops[: i + 1], shares[: i + 1]) - 4.0 * shares[i] * drops[i]
            found = joint.dissipated_energy(shares[i] * u) / (joint.force_limit * u)
            errors.append(math.log(found / truth))
    assert np.all(np.abs(np.reshape(errors, (3, 4))) < [0.1, 0.05, 0.02, 0.01])


def test_the_hardness_is_that_of_the_pair_and_bounds_the_pressure() -> None:
    law = solve(tightening_pressure=4e8)
    assert law.numbers.hardness == 2.5e9
    assert law.numbers.hard_share > 0.3
    assert float(law.solution.map.max()) <= 1.001 * 2.5e9 / PAIR.composite_modulus
    elastic = solve(tightening_pressure=4e8, hardness=math.inf)
    assert elastic.numbers.hardness is None
    assert elastic.numbers.hard_share == 0.0
    assert elastic.contact_area(elastic.separation(1.0)) < law.contact_area(law.separation(6.0))
    load = 4e8 * law.area
    stiff, soft = (s.stiffness(s.separation(load)) for s in (law, elastic))
    assert stiff > soft
    # Real area times hardness carries at least the load.
    assert law.contact_area(law.separation(load)) * 2.5e9 >= 0.99 * load


def test_a_lay_changes_the_slip_by_direction() -> None:
    law = solve(heights(96, lay=0.2), area=1e-4)
    along, across = (ms.Interface(law, 0.3, normal_load=500.0, direction=a) for a in (0.0, 1.5708))
    assert across.surface.direction == 1.5708
    assert along.slip_per_indentation > 1.08 * across.slip_per_indentation
    assert math.sin(law.numbers.stiffest_direction) ** 2 > 0.95
    least, largest = law.numbers.stiffness_ratios
    assert least < law.stiffness_ratio < largest
    assert law.stiffness_ratio == pytest.approx(PAIR.stiffness_ratio, rel=0.03)
    assert across.at(normal_load=100.0).surface.direction == 1.5708


def test_fields_in_the_plane_have_both_stiffnesses_of_a_lay() -> None:
    law = solve(heights(96, lay=0.2), area=1e-4)
    joints = [ms.Interface(law, 0.3, normal_load=500.0, direction=a) for a in (0.0, 0.5 * math.pi)]
    stiff = [joint.tangential_stiffness for joint in joints]

    def field(direction: float | None) -> ms.JointField:
        return ms.JointField(law.along(direction), 0.3, areas=[4e-5, 6e-5], loads=[200.0, 300.0])

    x_first, y_first, mean = (field(a) for a in (0.0, 0.5 * math.pi, None))
    assert x_first.tangential_stiffnesses.sum() == pytest.approx(stiff[0])
    across = x_first.along([[0.0, 2.0], [0.0, -1.0]])
    assert across.tangential_stiffnesses.sum() == pytest.approx(stiff[1], rel=1e-9)
    assert across.rigid().backbone(1e-7) == pytest.approx(joints[1].backbone(1e-7), rel=1e-9)
    loads = across.at(loads=[100.0, 400.0])
    assert loads.tangential_stiffnesses[1] == pytest.approx(
        y_first.at(loads=[100.0, 400.0]).tangential_stiffnesses[1]
    )
    assert mean.along([[0.0, 1.0]] * 2) is mean
    with pytest.raises(ms.InputError, match="directions must have the shape"):
        x_first.along([1.0, 0.0])
    with pytest.raises(ms.InputError, match="directions must not be zero, got zero at node 1"):
        x_first.along([[1.0, 0.0], [0.0, 0.0]])
    # Two axes of one face: the same cycle, its derivatives by differences, energies by work.
    t = 2.0 * math.pi * np.arange(40) / 40
    path = np.stack([2e-7 * np.cos(t), 1.5e-7 * np.sin(t)], axis=1) + np.zeros((2, 1, 1))
    opening = x_first.separations[:, None] + 2e-8 * np.sin(2.0 * t + 0.3)
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])  # of axes along y and against x
    one, other = (f.two_directions(48, nearest=opening.min() - 1e-9) for f in (x_first, y_first))
    force = one.periodic(path, opening).force
    assert other.periodic(path @ turn, opening).force @ turn.T == pytest.approx(
        force, rel=1e-6, abs=1e-6 * abs(force).max()
    )
    values = 1e-7 * np.random.default_rng(3).normal(size=(2, 2, 3))
    _, jacobian = one.harmonics(values, samples=32)
    for k, way in enumerate(np.eye(6).reshape(6, 2, 3)):
        found = slope(
            lambda s, e=way: one.harmonics(values + s * e, samples=32, tolerance=1e-9)[0], 1e-12
        )
        wanted = jacobian[:, :, k // 3, :, k % 3]
        assert found == pytest.approx(wanted, abs=1e-4 * abs(jacobian).max())
    state, work, last, before = one.start(energies=True), np.zeros(2), 0.0, np.zeros((2, 2))
    fine = 2.0 * math.pi * np.arange(1, 401) / 200
    for x in np.stack([2e-7 * np.sin(fine), 1.5e-7 * (1.0 - np.cos(fine))], axis=1):
        answer = state.try_(x)
        state.commit()
        work += 0.5 * ((answer.force + before) * (x - last)).sum(axis=1)
        last, before = x, answer.force
    assert state.stored_energy + state.dissipated_energy == pytest.approx(work, rel=2e-3)
    # Modes of a mass on it: 1.31 times is a lay, along and across.
    shaker = ms.Structure(np.eye(3), 1e3 * np.eye(3)).attach(
        x_first, directions=np.stack([np.eye(3), np.eye(3)], axis=1)
    )
    k = (2.0 * math.pi * shaker.linear_modes(3).frequency) ** 2
    assert np.sort(k)[:2] == pytest.approx(np.sort(stiff) + 1e3, rel=1e-6)
    response = shaker.modes(int(np.argmax(stiff)), [1e-9]).frequency[0]
    assert (2.0 * math.pi * response) ** 2 == pytest.approx(max(stiff) + 1e3, rel=0.02)


def test_a_cache_solves_once(tmp_path) -> None:
    counts = []
    for _ in range(2):
        measured_face._remembered.clear()
        calls: list[int] = []
        solve(cache=tmp_path / "c", progress=lambda done, total, c=calls: c.append(total))
        counts.append(len(calls))
    assert counts[0] > 12
    assert counts[1] == 0
    assert len(list((tmp_path / "c").iterdir())) == 1
    (kept,) = (tmp_path / "c").iterdir()
    content = kept.read_bytes()
    assert len(content) < 30_000
    for damaged in (content[:-400], b"", b"PK\x03\x04 nothing"):
        kept.write_bytes(damaged)
        measured_face._remembered.clear()
        with pytest.warns(UserWarning, match="the face is solved again"):
            solve(cache=tmp_path / "c")
        measured_face._remembered.clear()
        solve(cache=tmp_path / "c")  # without a warning: the file was replaced


def test_modulus_hardness_and_heights_have_slopes() -> None:
    """A stiffer body stiffens the joint, a harder one and higher heights soften it."""
    joint = ms.Interface(LAW, 0.3, normal_load=0.5 * LAW.numbers.pressure * LAW.area)
    amplitude = 0.3 * joint.force_limit / joint.tangential_stiffness
    slopes = input_slopes(joint, amplitude)["tangential_stiffness"]
    assert 0.0 < slopes["young_modulus"] < 1.0
    assert -1.0 < slopes["hardness"] < 0.0
    assert slopes["young_modulus"] + slopes["hardness"] == pytest.approx(0.0, abs=0.3)
    assert slopes["heights"] < 0.0


@pytest.mark.slow
def test_slopes_of_the_loss_factor_are_those_of_faces_solved_again() -> None:
    """Of one face of 128 x 128 points near gross slip, by changes of 10 % of each input."""

    def joint(name: str = "", change: float = 0.0) -> ms.Interface:
        factors = {"E": 1.0, "H": 1.0, "z": 1.0} | {name: math.exp(change)}
        body = ms.Material(210e9 * factors["E"], 0.3, hardness=2.5e9 * factors["H"])
        law = ms.MeasuredContact(
            factors["z"] * heights(128), ms.MaterialPair(body, body), tightening_pressure=1.5e8,
            pixel=PIXEL, piece=None,
        )  # fmt: skip
        return ms.Interface(law, 0.3, normal_load=1.49e8 * law.area)

    here = joint()
    amplitude = 0.9 * here.force_limit / here.tangential_stiffness
    found = input_slopes(here, amplitude)
    for name, of in (("E", "young_modulus"), ("H", "hardness"), ("z", "heights")):
        low, high = (joint(name, change) for change in (-0.1, 0.1))
        stiff = math.log(high.tangential_stiffness / low.tangential_stiffness) / 0.2
        loss = math.log(high.loss_factor(amplitude) / low.loss_factor(amplitude)) / 0.2
        assert found["tangential_stiffness"][of] == pytest.approx(stiff, abs=0.2)
        assert found["loss_factor"][of] == pytest.approx(loss, abs=0.4)


def test_energies_of_nearly_linear_unloading_have_logarithms() -> None:
    """Where they are zero but for rounding, or few points are in contact; the rest is exact."""
    d = np.array([0.0, 0.5, 0.6])
    linear: Any = SimpleNamespace(
        separation=d, pressure=1.0 - d[:, None], slope=np.array([[0.99], [1.0], [1.01]])
    )
    assert (cycle_energies(linear, np.geomspace(0.01, 1.0, 9)) > 0.0).all()
    # p = exp(-d): 8 a - 8 (1 - exp(-a)) - 4 a (1 - exp(-a)), also beyond the last load at d = 0.6.
    p = np.exp(-d)[:, None]
    a = np.array([0.1, 0.5, 1.0])
    exponential: Any = SimpleNamespace(separation=d, pressure=p, slope=p)
    found = cycle_energies(exponential, a)
    lost = -np.expm1(-a)
    np.testing.assert_allclose(found, 8.0 * (a - lost) - 4.0 * a * lost, rtol=1e-4)


@pytest.mark.slow
def test_numbers_and_verdicts_go_with_it() -> None:
    law = solve(heights(128), piece=32, tightening_pressure=5e8, coarser=True)
    numbers = law.numbers
    assert numbers.pieces == 16
    assert 0.05 < numbers.scatter < 1.5
    assert numbers.coarser == pytest.approx(1.0, abs=0.2)
    # Every second point by hand; and the doubled face without waves below the one that is told.
    z = heights(128)
    z = z - np.polynomial.polynomial.polyval2d(*np.indices(z.shape), plane_of(z))
    stiffness = float(law.stiffness(law.closest))
    second = solve(z[::2, ::2], piece=16, pixel=2.0 * PIXEL, tightening_pressure=5e8)
    assert second.stiffness(second.closest) / stiffness == pytest.approx(numbers.coarser, rel=0.02)
    joints = [
        ms.Interface(one, 0.3, normal_load=5e8 * one.area * (1.0 - 1e-9)) for one in (law, second)
    ]
    scale = joints[0].force_limit / joints[0].tangential_stiffness
    amplitudes = scale * np.array(measured_face.ENERGY_AMPLITUDES[-3:])
    energies = [joint.dissipated_energy(amplitudes) / joint.force_limit for joint in joints]
    assert numbers.coarser_energies[-3:] == pytest.approx(energies[1] / energies[0], rel=0.1)
    # The maps of the figure are of one piece, and say so.
    notes = [str(panel.note) for panel in face_plot(law).panels]
    assert notes[0].startswith("Pressure, piece 1 of 16: 0 to ")
    assert notes[1].startswith("Contact, piece 1 of 16: ")
    named = [
        a
        for a, ratio in zip(measured_face.ENERGY_AMPLITUDES, numbers.coarser_energies, strict=True)
        if not 0.8 < ratio < 1.25
    ]
    assert numbers.unresolved_amplitude == max(named)
    assert f"up to an amplitude of {max(named):g} μN/k_t" in contact_words(numbers)
    both = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
    q = np.hypot(np.fft.fftfreq(256, PIXEL)[:, None], np.fft.rfftfreq(256, PIXEL))
    waves = np.fft.rfft2(both)
    kept = q <= (1.0 + 1e-9) / numbers.cutoff
    twice = np.where((np.arange(129) % 128) > 0, 2.0, 1.0)  # those of the other half plane
    squares = twice * (q * np.abs(waves)) ** 2
    assert squares[kept].sum() / squares.sum() == pytest.approx(0.5, abs=0.02)
    smooth = np.fft.irfft2(np.where(kept, waves, 0.0), s=both.shape)[:128, :128]
    other = solve(smooth, piece=32, tightening_pressure=5e8)
    assert other.stiffness(other.closest) / stiffness == pytest.approx(numbers.smoother, rel=0.02)
    assert "without waves below" in contact_words(numbers)
    verdicts = {v.name: v for v in ms.Interface(law, 0.3, normal_load=20.0).validity}
    assert verdicts["tightening pressure over hardness"].word == "ok"
    change = max(abs(numbers.coarser - 1.0), abs(numbers.smoother - 1.0))
    assert verdicts["change of stiffness by pixel and cut-off"].value == pytest.approx(change)
    assert 0.02 < verdicts["height variance between pieces"].value < 0.2
    assert not any("real over apparent" in name for name in verdicts)
    (one,) = (
        v
        for v in ms.Interface(solve(), 0.3, normal_load=0.1).validity
        if v.name == "scatter of the pieces"
    )
    assert one.word == "not judged"
    assert "mean contact pressure over hardness" in {
        v.name for v in ms.Interface(solve(), 0.3, normal_load=0.1).validity
    }


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"z": heights().astype(float) * np.nan}, "no missing points"),
        ({"z": heights()[0]}, "an area"),
        ({"z": heights() * 1e6}, "in metres"),
        ({"z": heights()[:8]}, "16 points"),
        ({"pixel": None}, "pixel=2e-06"),
        ({"hardness": 1e9}, "tightening_pressure=1"),
        ({"hardness": 1e9, "tightening_pressure": 8e8}, "0.7 of the hardness"),
        ({"tightening_pressure": 1e6}, "points into contact"),
        ({"tightening_pressure": 1e11, "hardness": math.inf}, "full contact"),
    ],
)
def test_mistakes_are_reported(change, words) -> None:
    with pytest.raises(ms.InputError, match=words):
        solve(change.pop("z", None), **change)


def test_lengths_and_pressures_only_scale() -> None:
    heights = np.random.default_rng(2).normal(size=(32, 32)) * 1e-6
    laws = []
    for length, pressure in ((1.0, 1.0), (20.0, 0.3)):
        body = ms.Material(70e9 * pressure, 0.3)
        pair = ms.MaterialPair(body, body)
        laws.append(
            ms.MeasuredContact(heights * length, pair, pixel=1e-6 * length, piece=32, loads=4)
        )
    one, other = laws
    d = one.separations[5]
    assert other.load(20.0 * d) == pytest.approx(20.0**2 * 0.3 * one.load(d), rel=1e-6)
    assert other.stiffness(20.0 * d) == pytest.approx(20.0 * 0.3 * one.stiffness(d), rel=1e-6)


@pytest.mark.slow
def test_patches_of_a_structure_are_tightened_by_their_own_pressure() -> None:
    """As laws of their own tightening in fields and uneven joints; at rest in a lap as before."""
    z = heights(128)
    law = solve(z, tightening_pressure=3e8, area=1e-4)
    places = np.array([3e8, 1.5e8, 6e7])
    field = ms.JointField(law, 0.3, areas=1e-4, pressures=places)
    for i, p in enumerate(places):
        own = ms.Interface(
            solve(z, tightening_pressure=float(p), area=1e-4), 0.3, normal_load=p * 1e-4
        )
        assert field.tangential_stiffnesses[i] == pytest.approx(own.tangential_stiffness, rel=0.06)
        assert field.separations[i] == pytest.approx(own.separation, abs=0.05 * law.numbers.rms)
        u = own.force_limit / own.tangential_stiffness * np.array([0.1, 0.5, 1.0, 2.0])
        found = np.array([field.start().try_(x).force[i] for x in u])
        assert found == pytest.approx(own.backbone(u), rel=0.1)
        place = ms.Interface(law._patch(1e-4, p / 3e8), 0.3, normal_load=p * 1e-4)
        assert place.backbone(u) == pytest.approx(found, rel=2e-3)
    bolts = ms.Bolts([0.0], shank=8e-3, hole=9e-3, washer=17e-3, tension=16e3)
    lap = ms.LapJoint(length=0.2, width=0.03, thickness=0.02, lap=0.06, bolts=bolts)
    joint = lap.reduce(STEEL, 7800.0, patches=(4, 1), kept_modes=6, element_size=8e-3)
    each = joint.tightened(law, 0.3)
    tension = joint.tensions(each.displacement, each.static_force)
    assert tension == pytest.approx(joint.bolt_tension, rel=1e-6)
    # Each patch is where first loading brings it.
    first = law.first_loading
    many = each.pressures > first.pressure[0]
    assert each.gaps[many] == pytest.approx(
        np.interp(each.pressures[many], first.pressure, first.separation),
        abs=0.02 * law.numbers.rms,
    )
    loaded = each.pressures > 1e-3 * each.pressures.max()
    nodes = each.attachments[0].field.at(separations=each.gaps)
    slip = nodes.force_limits[loaded] / nodes.tangential_stiffnesses[loaded]
    assert slip.max() / slip.min() < 2.0
    with pytest.raises(ms.InputError, match="tightening_pressure must be at least"):
        joint.with_tension(4e5).tightened(law, 0.3)


def test_first_loading_is_the_path_of_tightening() -> None:
    """Its separations are those of faces tightened to each pressure, from one mean plane."""
    how = {"hardness": 1.2e9, "tightening_pressure": 2e8}
    law = solve(**how)
    first = law.first_loading
    assert first.pressure[-1] == pytest.approx(2e8, rel=2e-6)
    assert first.separation[-1] == pytest.approx(law.closest, rel=1e-9)
    assert np.all(np.diff(first.separation) < 0.0)
    assert first.stiffness[-1] < law.stiffness(law.closest)
    many = (first.pressure > 4e7) & (first.pressure < 1.9e8)  # enough points in contact
    assert many.any()
    for pressure, separation in zip(first.pressure[many], first.separation[many], strict=True):
        lighter = solve(**how | {"tightening_pressure": float(pressure)})
        assert lighter.closest == pytest.approx(float(separation), abs=1e-5 * law.numbers.rms)
        # Relieved from more it stands closer, or as far where nothing yielded.
        assert law.separation(pressure * law.area) <= lighter.closest
