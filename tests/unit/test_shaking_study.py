"""A structure of a study on a ground that moves, and one that bends: numbers, files, refusals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import microslip as ms
from microslip.report.predicted.numbers import files
from microslip.study.build import at_middle, build_surface

EXAMPLE = Path(__file__).parents[2] / "examples" / "shaker.toml"
COARSE = ("structure.element_size=20 mm", "structure.patches=[2, 1]",
          "structure.amplitude.points=3", "structure.base.points=21")  # fmt: skip


@pytest.fixture(scope="module")
def study() -> str:
    return EXAMPLE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def result(study: str) -> ms.Result:
    return ms.Study.from_toml(study, overrides=COARSE).run()


@pytest.mark.slow
def test_the_ground_carries_what_the_library_says(result: ms.Result) -> None:
    structure = result.structure
    assert structure is not None
    assert structure.shaking is not None
    joint, shaking, curve = structure.joint, structure.shaking, structure.modes[0].curve
    # The strip of 200 x 20 x 4 mm and its bolts, whatever the ground beneath weighs.
    strip = 7800.0 * 0.2 * 0.02 * 0.004
    assert strip < joint.base_inertia[-1, 2] < 1.15 * strip
    # A weak sweep: |shape^T M R| a = 2 zeta omega^2 q at the peak, and T = 1 far below.
    weak = shaking.sweeps[0]
    at = joint.sensor("sensor")
    push = abs(curve.shape[0].real @ joint.base_inertia[:-3, 2])
    reached = float(weak.response.amplitude(weak.sensor).max())
    (zeta,) = structure.state.modes(0, [reached], at=at, damping_ratio=1e-3).damping_ratio
    omega = 2.0 * np.pi * weak.response.frequency[weak.peak]
    assert reached == pytest.approx(
        push * weak.level / (2.0 * zeta * omega**2) * abs(curve.shape[0] @ at), rel=0.01
    )
    state = joint.on_base(result.joints[0].surface, 0.3, 1e-3)
    slow = state.base_response(**joint.base("z"), acceleration=2.0, frequencies=[4.0, 8.0])
    assert abs(slow.transmissibility(weak.sensor)) == pytest.approx(1.0, abs=2e-4)
    assert abs(slow.base_force[:, 0, 1]) == pytest.approx(2.0 * joint.base_inertia[-1, 2], rel=1e-3)
    # Noise: of the linear mode the variance of the relative displacement in closed form.
    noise = shaking.noise
    assert noise is not None
    one = 2.0 * np.pi * noise.frequency[0]
    sigma = push * abs(curve.shape[0] @ at) * np.sqrt(1.0 / (8.0 * noise.damping_ratio[0] * one**3))
    assert noise.standard_deviation(shaking.sensor) == pytest.approx(sigma, rel=0.02)
    even = np.linspace(210.0, 1990.0, 60_001)
    area = np.trapezoid(noise.spectrum(shaking.sensor, even), even)
    assert np.sqrt(area) == pytest.approx(noise.standard_deviation(shaking.sensor), rel=5e-3)
    # The joints hold: peaks in proportion to the pulses, to a tenth.
    peaks = shaking.peaks("displacement")
    assert (np.diff(peaks / shaking.severity) / (peaks / shaking.severity)[0] < 0.1).all()


@pytest.mark.slow
def test_results_are_written_and_read(result: ms.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "out")
    there = {path.name for path in (tmp_path / "out").iterdir()}
    assert set(files(result.study)) <= there
    assert {"base.csv", "random.csv", "shock.csv", "transmissibility.svg"} <= there
    told = json.loads((tmp_path / "out" / "summary.json").read_text())["structure"]["shaking"]
    assert [row["sweep_level"] for row in told["base"]] == [1.0, 5.0, 15.0]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for title in ("On a shaker", "Random vibration", "Under shocks"):
        assert title in page


def cases(folder: Path) -> None:
    """What lies in a file of static cases: a spring that stiffens, its linear part among it."""
    u = np.linspace(-1e-4, 1e-4, 9)
    rows = np.column_stack([1e6 * u, 3e5 * u + 4e13 * u**3])
    np.savetxt(folder / "cases.csv", rows, "%.9g", ",", header="u [um],F [N]", comments="")


GEOMETRY = """
[structure.geometry]
file = "cases.csv"
coordinates = [{ at = ["0 mm", "0 mm", "4 mm"] }]
"""


@pytest.mark.slow
def test_a_geometry_bends_as_the_library_has_it(study: str, tmp_path: Path) -> None:
    cases(tmp_path)
    text = study[: study.index("[structure.base]")] + GEOMETRY
    bent = ms.Study.from_toml(text, overrides=COARSE[:3], folder=tmp_path)
    assert bent.structure is not None
    assert bent.structure.harmonics == (0, 1, 2, 3, 4, 5)
    structure = bent.run().structure
    assert structure is not None
    curve = structure.modes[0].curve
    assert curve.loss.shape == (3, structure.joint.patches)
    flat = ms.Study.from_toml(study[: study.index("[structure.base]")], overrides=COARSE[:3]).run()
    assert flat.structure is not None
    plain = flat.structure.modes[0].curve
    # By a spring of 3/4 * 4e13 u^2 at the sensor, whose modal mass is 1/shape^2.
    stiffening = (
        3e13 * plain.amplitude**2 * abs(plain.shape @ structure.joint.sensor("sensor")) ** 2
    )
    shift = stiffening / (2.0 * (2.0 * np.pi * plain.frequency) ** 2)
    np.testing.assert_allclose(curve.frequency / plain.frequency - 1.0, shift, rtol=0.03, atol=2e-6)
    far = ms.Study.from_toml(
        text, overrides=(*COARSE[:3], "structure.amplitude.to=0.2 mm"), folder=tmp_path
    )
    with pytest.raises(ms.StudyError, match="must stay within the static cases"):
        far.run()


# ruff: noqa: E501
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('ground = ["left", "right"]', "", "structure.base: wanted a structure on the ground"),
        ("[structure.base]", "[structure.base]\ndirection = 3", 'structure.base.direction: wanted "x", "y" or "z", got 3'),
        ("[structure.base]", '[structure.base]\ncontrol = "sensor"', 'structure.base.control: wanted "base" or "response"'),
        ('["1 m/s^2", ', '["5 mm", ', 'structure.base.acceleration, item 1: wanted an acceleration such as "5 m/s^2"'),
        ("[structure.base]", '[structure.base]\nfrequencies = ["850 Hz", "790 Hz"]', "structure.base.frequencies: wanted the lower one first"),
        ("[1.0, 1.0]", "[1.0]", "structure.random.levels: wanted 2 items such as [0.5, 0.5], got 1"),
        ("[1.0, 1.0]", "[1.0, 1.0, 2.0]", "structure.random.levels: wanted one a frequency, 2 of them, got 3"),
        ("[1.0, 1.0]", "[0.0, 0.0]", "structure.random.levels: wanted some level above zero"),
        ('["200 Hz", "2 kHz"]', '["2 kHz", "200 Hz"]', "structure.random.frequencies: wanted rising frequencies"),
        ('"0.5 ms"', '"-1 ms"', "structure.shock.duration: wanted a positive time"),
    ],
)  # fmt: skip
def test_each_wrong_table_gets_one_line(old: str, new: str, message: str, study: str) -> None:
    assert old in study
    with pytest.raises(ms.StudyError) as error:
        ms.Study.from_toml(study.replace(old, new), "shaker.toml")
    assert str(error.value).startswith(f"shaker.toml: {message}"), str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ('structure.geometry={ file = "cases.csv" }', "wanted both, file and coordinates"),
        ("structure.geometry.reach=-1 mm", "wanted a positive length"),
        ("structure.rise=-1 mm", "wanted a length of zero or more"),
        pytest.param(
            *("structure.geometry.reach=0.5 mm", "must stay within the static cases"),
            marks=pytest.mark.slow,
        ),
    ],
)  # fmt: skip
def test_a_drawn_panel_tells_what_it_wants(override: str, message: str) -> None:
    sets = (override, "structure.element_size=40 mm", "structure.patches=[1, 1]",
            "structure.amplitude.points=2")  # fmt: skip
    text = (EXAMPLE.parent / "panel.toml").read_text("utf-8").split("[structure.base]")[0]
    with pytest.raises(ms.StudyError) as error:
        ms.Study.from_toml(text, "panel.toml", overrides=sets).run()
    assert message in str(error.value), str(error.value)
    assert "\n" not in str(error.value)


def test_a_single_lap_does_not_bend_between_clamps() -> None:
    text = (EXAMPLE.parent / "bolted_beam.toml").read_text("utf-8") + "\n[structure.geometry]\n"
    with pytest.raises(ms.StudyError, match="geometry: the cases are made of a drawing with laps"):
        ms.Study.from_toml(text)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("u [um],F [N]\n1,2\n2,4\n", "must tell all 3 numbers"),
        (
            "u [um],F [mm]\n1,2\n2,4\n",
            'structure.geometry: cases.csv: column "F [mm]": wanted a unit such as "N"',
        ),
        ("v [um],F [N]\n1,2\n", 'structure.geometry: cases.csv: no column "u"'),
    ],
)
def test_each_wrong_file_of_cases_gets_one_line(
    rows: str, message: str, study: str, tmp_path: Path
) -> None:
    (tmp_path / "cases.csv").write_text(rows, encoding="utf-8")
    with pytest.raises(ms.StudyError) as error:
        ms.Study.from_toml(study + GEOMETRY, "shaker.toml", folder=tmp_path)
    assert message in str(error.value), str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.slow
def test_what_is_not_known_spreads_over_what_is_shaken(study: str) -> None:
    """Of one input the ends are what its own 5 and 95 % give, swept and in noise."""
    text = study.replace(
        "friction_coefficient = 0.3", "friction_coefficient = { low = 0.2, high = 0.5 }"
    )
    text = text[: text.index("[structure.shock]")] + text[text.index("[output]") :]
    over = (*COARSE, "structure.base.acceleration=15 m/s^2", "structure.samples=16",
            "structure.amplitude.points=8", "structure.amplitude.from=2 um",
            "structure.amplitude.to=0.15 mm", "surface.stiffness_factor=1")  # fmt: skip
    banded = ms.Study.from_toml(text, overrides=over).run()
    structure = banded.structure
    assert structure is not None
    assert structure.shaking is not None
    bands = structure.shaking.bands
    assert bands is not None
    (level, swept), noise = bands.sweeps[0], bands.noise
    assert level == 15.0
    assert bands.reached < 1.0
    seen, surface = [], build_surface(at_middle(banded.study))
    for friction in (0.485, 0.215):
        state = structure.joint.on_base(surface, friction, 1e-3)
        sensor, on = structure.shaking.sensor, structure.joint.base("z")
        middle = float(swept["resonance"][1])
        sweep = state.base_response(
            acceleration=15.0, frequencies=middle * np.linspace(0.985, 1.015, 121), **on
        )
        size = abs(sweep.transmissibility(sensor))
        random = state.random_response(([200.0, 2000.0], [1.0, 1.0]), **on)
        seen.append((sweep.frequency[size.argmax()], size.max(), random.frequency[0],
                     random.damping_ratio[0], random.standard_deviation(sensor),
                     random.standard_deviation(sensor, "acceleration")))  # fmt: skip
    told = [swept["resonance"], swept["transmissibility"], *noise.values()]
    ends = np.sort(np.array(seen), axis=0).T
    np.testing.assert_allclose(np.array(told)[:, [0, 2]], ends, rtol=5e-3)


@pytest.mark.slow
def test_a_held_sensor_has_bands_of_its_ground(study: str) -> None:
    """Base damping alone, without a balance a sample: against sweeps at its ends."""
    text = study.replace("ratio = 0.001", "ratio = { low = 0.001, high = 0.002 }")
    text = text[: text.index("[structure.random]")] + text[text.index("[output]") :]
    over = (*COARSE, "structure.base.acceleration=1 km/s^2", 'structure.base.control="response"',
            "structure.samples=16", "structure.amplitude.points=8", "surface.stiffness_factor=1",
            "structure.amplitude.to=0.1 mm")  # fmt: skip
    banded = ms.Study.from_toml(text, overrides=over).run()
    assert banded.structure is not None
    shaking = banded.structure.shaking
    assert shaking is not None
    bands = shaking.bands
    assert bands is not None
    ((_, swept),) = bands.sweeps
    surface, joint = build_surface(at_middle(banded.study)), banded.structure.joint
    near = float(swept["resonance"][1]) * np.linspace(0.999, 1.001, 41)
    for end, ratio in ((0, 0.00195), (2, 0.00105)):
        sweep = joint.on_base(surface, 0.3, ratio).base_response(
            acceleration=1.0, frequencies=near, control="response", at=shaking.sensor,
            level=1000.0, quantity="acceleration", **joint.base("z"),
        )  # fmt: skip
        most = abs(sweep.transmissibility(shaking.sensor)).max()
        assert swept["transmissibility"][end] == pytest.approx(most, rel=5e-3)
    assert bands.noise == {}
    page = ms.Study.from_toml(text, overrides=(*over, "structure.amplitude.to=20 um")).run()
    assert page.structure is not None
    assert page.structure.shaking is not None
    short = page.structure.shaking.bands
    assert short is not None
    assert not short.sweeps
    assert short.reached > 1.0
