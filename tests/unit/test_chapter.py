"""The figures of the chapter: complete, readable, with their data, and their command."""

from __future__ import annotations

import csv
import json
import math
import xml.etree.ElementTree as ET
from functools import lru_cache
from pathlib import Path

import make_figures
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import microslip as ms
from microslip.chapter import LEFT_OUT, PLATES, Plate, select, write_figures
from microslip.chapter.joint import with_summits
from microslip.chapter.rig import (
    HARMONIC,
    NOISE,
    RIG,
    RIPPLE,
    SAMPLES,
    identified,
)
from microslip.chapter.surface import (
    CORRELATION,
    ROUGHNESS,
    is_peak,
    peak_density,
    synthetic_profile,
    worked_example,
)

NUMBERS = {plate.number: plate for plate in PLATES}
all_plates = pytest.mark.parametrize("plate", PLATES, ids=lambda plate: plate.number)


@lru_cache
def drawn(number: str) -> tuple[Figure, dict[str, np.ndarray]]:
    return NUMBERS[number].draw()


def columns(number: str) -> dict[str, np.ndarray]:
    return drawn(number)[1]


# -- the list --------------------------------------------------------------------------------------


def test_every_figure_is_drawn_or_named() -> None:
    numbers = [plate.number for plate in PLATES]
    assert sorted({*numbers, *LEFT_OUT}, key=lambda n: int(n[3:])) == [
        f"19.{n}" for n in range(1, 25)
    ]
    assert not {*numbers} & {*LEFT_OUT}
    assert numbers == sorted(numbers, key=lambda n: int(n[3:]))
    assert len(NUMBERS) == len({plate.stem for plate in PLATES}) == len(PLATES)


# -- the pictures ----------------------------------------------------------------------------------


@pytest.mark.slow
@all_plates
def test_nothing_is_clipped(plate: Plate) -> None:
    figure = drawn(plate.number)[0]
    figure.draw_without_rendering()
    box = figure.get_tightbbox()  # of all that is drawn [in]
    width, height = figure.get_size_inches()
    assert box.x0 > -0.01
    assert box.y0 > -0.01
    assert box.x1 < width + 0.01
    assert box.y1 < height + 0.01
    # On a page of 18 cm.
    assert min(text.get_fontsize() for text in figure.findobj(Text)) >= 7.0


# -- what they show --------------------------------------------------------------------------------


def test_number_of_asperities_figure() -> None:
    """From one asperity on; the numbers of the caption are those of the joints drawn."""
    joints = [with_summits(worked_example(), count) for count in (1.0, 20_000.0)]
    assert joints[0].contact_count == pytest.approx(1.0, rel=1e-12)
    sphere = ms.Asperity(
        joints[0].surface.pair, radius=1e-3, normal_load=2000.0, friction_coefficient=0.55
    )
    assert joints[0].tangential_stiffness == pytest.approx(sphere.tangential_stiffness, rel=1e-5)
    growth = joints[1].tangential_stiffness / joints[0].tangential_stiffness
    ratios = [joint.energy_ratio(1e-6) for joint in joints]
    caption = NUMBERS["19.20"].caption
    assert f"to the {joints[1].contact_count:.0f} of 20 000" in caption
    assert f"grows {growth:.0f}-fold" in caption
    assert f"from {ratios[0]:.3f} to {ratios[1]:.3f}" in caption
    forces = [values for name, values in columns("19.20").items() if name.startswith("force")]
    np.testing.assert_array_less([f.max() for f in forces[:-1]], [f.max() for f in forces[1:]])


def test_roughness_figure() -> None:
    """As rough as the chapter's sample, and with the statistics that the figure states."""
    places, z = synthetic_profile()
    data = columns("19.6")
    np.testing.assert_array_equal(data["height [m]"], z)
    assert abs(z.mean()) < 1e-20
    average = float(np.mean(np.abs(z)))
    texts = [t.get_text() for t in drawn("19.6")[0].findobj(Text)]
    assert f"this trace: Ra = {average / 1e-6:.2f} µm" in texts
    assert 0.3e-6 < average < 0.4e-6
    # The asperities are the peaks of the trace.
    np.testing.assert_array_equal(data["is a peak"], is_peak(z))
    assert f"the {is_peak(z).sum()} peaks of this trace" in texts
    # Many traces: root mean square and autocorrelation at one correlation length.
    traces = np.array([synthetic_profile(seed)[1] for seed in range(60)])
    assert np.sqrt(np.mean(traces**2)) == pytest.approx(ROUGHNESS, rel=0.02)
    lag = round(CORRELATION / (places[1] - places[0]))
    ratio = np.mean(traces[:, lag:] * traces[:, :-lag]) / np.mean(traces**2)
    assert ratio == pytest.approx(math.exp(-1.0), abs=0.03)
    # Heights of their peaks against the density that the figure draws.
    heights = np.concatenate([trace[is_peak(trace)] for trace in traces])
    assert heights.size > 4000
    y = np.linspace(-5.0, 6.0, 4001) * ROUGHNESS
    density = peak_density(y)
    assert density.sum() * (y[1] - y[0]) == pytest.approx(1.0, rel=1e-6)
    mean = (y * density).sum() * (y[1] - y[0])
    std = math.sqrt(((y - mean) ** 2 * density).sum() * (y[1] - y[0]))
    assert heights.mean() == pytest.approx(mean, abs=0.02 * ROUGHNESS)
    assert heights.std() == pytest.approx(std, rel=0.03)


@pytest.mark.slow
def test_the_overlay_is_identified() -> None:
    """What the caption of 19.22 says of the fit is so, and its intervals hold the truth."""
    result = identified()
    caption = NUMBERS["19.22"].caption
    assert f"(reduced χ² {result.reduced_chi_squared:.2f})" in caption
    softness = worked_example().tangential_stiffness / RIG
    assert f"by a factor of {softness:.0f}" in caption
    assert result.masing.holds
    verdicts = {name: one.verdict for name, one in result.parameters.items()}
    assert verdicts["friction_coefficient"] == "identified"
    assert verdicts["slip_scale"] == "bounded"
    assert verdicts["rig_stiffness"] == "assumed"
    joint = worked_example()
    slip_scale = joint.slip_per_indentation * 5e-7
    for name, truth in (("slip_scale", slip_scale), ("friction_coefficient", 0.55)):
        one = result.parameters[name]
        # The load in step with the force moves its middle alone: its mean is the joint's.
        assert one.low < truth < one.high
    energy = result.dissipated_energy(result.amplitudes[1])
    assert energy.low < joint.dissipated_energy(result.amplitudes[1]) < energy.high
    texts = [t.get_text() for t in drawn("19.22")[0].findobj(Text)]
    assert any("κσ: bounded" in text for text in texts)
    assert any(text.endswith("made with μ 0.55,\nrig 100 N/µm") for text in texts)


@pytest.mark.slow
def test_the_ripple_bends_the_loop_of_a_stiff_rig() -> None:
    """With the stiff rig of the caption of 19.22 the ripple of the load shows in the branches."""
    rig = ms.VirtualTribometer(
        worked_example(), rig_stiffness=1e10, noise=NOISE, load_ripple=RIPPLE,
        third_harmonic=HARMONIC, sample_rate=SAMPLES * 10.0, seed=19,
    )  # fmt: skip
    record = rig.record(amplitude=1.5e-6, frequency=10.0, cycles=6)
    assert "where the ripple bends the branches" in NUMBERS["19.22"].caption
    assert ms.identify(record).masing.holds
    bare = ms.Record(record.displacement, record.force, 2000.0, sample_rate=SAMPLES * 10.0)
    assert not ms.identify(bare).masing.holds


# -- files -----------------------------------------------------------------------------------------


def test_files(tmp_path: Path) -> None:
    progress: list[float] = []
    summary = write_figures(select(["19.13", "19.9"]), tmp_path, progress.append)
    assert progress == [0.5, 1.0]
    assert summary == json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(summary["files"])
    assert (summary["kind"], summary["version"]) == ("microslip-figures", ms.__version__)
    assert [figure["number"] for figure in summary["figures"]] == ["19.9", "19.13"]
    assert [len(figure["files"]) for figure in summary["figures"]] == [2, 3]
    assert summary["left_out"]["19.5"] == "a photograph of the sample"
    stem = tmp_path / NUMBERS["19.13"].stem
    root = ET.parse(f"{stem}.svg").getroot()
    assert root.tag.endswith("svg")
    assert Path(f"{stem}.png").read_bytes().startswith(b"\x89PNG")
    with Path(f"{stem}.csv").open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == list(columns("19.13"))
    back = np.array(rows, dtype=float).T
    np.testing.assert_array_equal(back, list(columns("19.13").values()))


@pytest.mark.slow
def test_the_same_files_each_time(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("first", "second")]
    # Alone, and after another one.
    drawn_twice = ["19.12", "19.22", "19.23"]
    for folder, numbers in zip(folders, (drawn_twice, ["19.9", *drawn_twice]), strict=True):
        folder.mkdir()
        write_figures(select(numbers), folder)
    stems = [NUMBERS[number].stem for number in drawn_twice]
    for name in (f"{stem}.{kind}" for stem in stems for kind in ("svg", "png", "csv")):
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes(), name


def test_the_page_is_in_step() -> None:
    """docs/figures.md shows what the figures say of themselves now, and each picture is there."""
    place = Path(__file__).parents[2] / "docs"
    text = (place / "figures.md").read_text(encoding="utf-8")
    assert text == make_figures.page(), "python docs/make_figures.py makes it again"
    pictures = {path.name for path in (place / "images" / "chapter").iterdir()}
    assert pictures == {f"{plate.stem}.svg" for plate in PLATES}
