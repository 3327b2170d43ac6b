"""Figures: what they say, that nothing is cut or covered, and that both renderers show it."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from matplotlib import style
from matplotlib.figure import Figure
from studies import AMPLITUDES, LOADS, edited

import microslip as ms
from microslip.figures.kit import envelope, linear, logarithmic
from microslip.figures.layout import SMALL, TEXT, TITLE, PanelFrame, lay_out, text_width
from microslip.figures.matplotlib_figure import STYLE, to_matplotlib
from microslip.figures.plot import (
    DASHED,
    Guide,
    Line,
    Panel,
    Pixels,
    Plot,
)
from microslip.figures.svg import svg
from microslip.report.predicted.document import prediction_pictures
from microslip.report.predicted.history_figure import MOST_DRAWN_SAMPLES

PICTURES = ('["csv"]', '["svg", "png"]')


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> ms.Result:
    """One with everything: two loads and a history."""
    folder = tmp_path_factory.mktemp("record")
    record = np.sin(np.linspace(0.0, 4.0 * np.pi, 200)).tolist()
    (folder / "record.csv").write_text("x [um]\n" + "\n".join(map(repr, record)) + "\n")
    history = '[excitation]\nhistory = { file = "record.csv", column = "x" }'
    return ms.Study.from_toml(edited(PICTURES, ("[excitation]", history)), folder=folder).run()


def draw(result: ms.Result, name: str) -> Plot:
    return next(picture for picture in prediction_pictures(result) if picture.name == name).plot()


def lines(panel: Panel, dash: tuple[float, ...] = ()) -> list[Line]:
    return [item for item in panel.items if isinstance(item, Line) and item.dash == dash]


def by_label(plot: Plot, word: str) -> Panel:
    return next(panel for panel in plot.panels if word in panel.y.label)


# -- what they draw -----------------------------------------------------------------------------


def test_the_backbone_and_its_stiffnesses_are_drawn(result: ms.Result) -> None:
    plot = draw(result, "backbone")
    force, stiffness = by_label(plot, "Force"), by_label(plot, "Stiffness")
    assert "[kN]" in force.y.label
    assert "[GN/m]" in stiffness.y.label
    assert "[µm]" in stiffness.x.label
    secants = lines(stiffness, DASHED)
    for joint, line, tangent, secant in zip(
        result.joints, lines(force), lines(stiffness), secants, strict=True
    ):
        x = line.x * 1e-6
        np.testing.assert_allclose(line.y, joint.backbone(x) / 1e3, rtol=1e-12)
        np.testing.assert_allclose(tangent.y, joint.backbone_stiffness(x) / 1e9, rtol=1e-12)
        np.testing.assert_allclose(secant.y, joint.secant_stiffness(x) / 1e9, rtol=1e-12)


# -- that it can be read ------------------------------------------------------------------------

MANY = str([f"{100 * i} N" for i in range(1, 30)]).replace("'", '"')
ODD: dict[str, tuple[tuple[str, str], ...]] = {
    "many": ((LOADS, MANY), ("A joint", "A long title of many words, " * 7)),
    "far": ((LOADS, '["1 mN", "1 N", "100 kN"]'), ("A joint", "$x_1$ <b>漢字 ∑ µ")),
    "one": ((LOADS, '"2 kN"'), (AMPLITUDES, '["1 um"]'), ("A joint", "W" * 200)),
}


@pytest.mark.parametrize("case", ["usual", *ODD])
def test_nothing_is_cut_off_or_covered(case: str, result: ms.Result) -> None:
    """Titles, legends and panels with their labels, by their boxes."""
    for picture in prediction_pictures(
        result if case == "usual" else ms.Study.from_toml(edited(PICTURES, *ODD[case])).run()
    ):
        page = lay_out(picture.plot())
        boxes = [around(frame) for frame in page.frames]
        for number, line in enumerate(page.title):
            half, top = 0.5 * text_width(line, TITLE), 6.0 + 1.25 * TITLE * number
            boxes.append((0.5 * page.width - half, top, 0.5 * page.width + half, top + TITLE))
        for entry, left, middle in page.legend:
            right = left + 25.0 + text_width(entry.label, SMALL)
            boxes.append((left, middle - 0.5 * SMALL, right, middle + 0.5 * SMALL))
        for left, top, right, bottom in boxes:
            assert left >= -1.0 <= top, picture.name
            assert right <= page.width + 1.0, picture.name
            assert bottom <= page.height + 1.0, picture.name
        for one, other in itertools.combinations(boxes, 2):
            apart = one[2] <= other[0] + 0.5 or other[2] <= one[0] + 0.5
            assert apart or one[3] <= other[1] + 0.5 or other[3] <= one[1] + 0.5, picture.name


def around(frame: PanelFrame) -> tuple[float, float, float, float]:
    """A panel with its ticks and labels: left, top, right, bottom [pt]."""
    half = 0.6 * TEXT
    left, top = frame.left, frame.top
    right, bottom = left + frame.width, top + frame.height
    if not frame.panel.y.bare and frame.panel.y.label:
        left, right = min(left, frame.label_left - half), max(right, frame.label_left + half)
    top -= 12.0 if frame.panel.note else 0.0
    bottom += 0.0 if frame.panel.x.bare else 7.0 + 1.25 * SMALL + TEXT
    return left, top, right, bottom


@pytest.mark.parametrize("name", ["loops", "energy_damping", "history"])
def test_matplotlib_draws_the_same(name: str, result: ms.Result) -> None:
    plot = draw(result, name)
    with style.context(["default", STYLE]):
        made, page = to_matplotlib(plot, Figure()), lay_out(plot)
    made.draw_without_rendering()
    for axes, frame in zip(made.axes, page.frames, strict=True):
        assert axes.get_ylabel().replace(r"\$", "$") == frame.panel.y.label
        drawn = [line for line in axes.lines if line.get_marker() == "None"]
        curves = [item for item in frame.panel.items if isinstance(item, (Line, Guide))]
        assert len(drawn) == len(curves)
        for line, item in zip(drawn, curves, strict=True):
            if isinstance(item, Line):
                np.testing.assert_array_equal(line.get_ydata(), item.y)
        # Labels are on the page.
        tight = axes.get_tightbbox()
        assert tight is not None
        assert tight.x0 >= -1.0
        assert tight.x1 <= made.bbox.x1 + 1.0


# -- ticks ---------------------------------------------------------------------------------------


def test_ticks_are_round_numbers_that_say_where_they_stand() -> None:
    """Each label read back, with the power that all leave out, is its place."""
    rng = np.random.default_rng(0)
    powers = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    for _ in range(500):
        low = float(rng.normal()) * 10.0 ** int(rng.integers(-9, 9))
        high = low + abs(low) * 10.0 ** float(rng.uniform(-2.0, 2.0))
        most = int(rng.integers(2, 10))
        ticks = linear(low, high, most)
        scale = float("1e" + ticks.offset[3:].translate(powers)) if ticks.offset else 1.0
        assert 1 <= len(ticks.major) <= most + 1
        for value, text in ticks.major:
            assert low - 1e-9 * abs(low) <= value <= high + 1e-9 * abs(high)
            read = float(text.replace("−", "-")) * scale
            assert read == pytest.approx(value, rel=1e-9, abs=1e-9 * (high - low))
    for decades in np.linspace(0.05, 20.0, 100).tolist():
        least = 10.0 ** float(rng.uniform(-12.0, 6.0))
        ticks = logarithmic(least, least * 10.0**decades, 7)
        labelled = [value for value, text in (*ticks.major, *ticks.minor) if text]
        assert 2 <= len(labelled) <= 14


# -- long records -------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [MOST_DRAWN_SAMPLES + 1, 100_000, 123_457])
def test_the_envelope_of_a_long_record_has_all_its_extremes(size: int) -> None:
    values = np.random.default_rng(0).normal(size=size)
    values[size // 3], values[-1] = 50.0, -60.0
    places = envelope(values)
    drawn = values[places]
    assert drawn.size < 4000
    assert (np.diff(places) >= 0.0).all()
    assert drawn.max() == 50.0
    assert drawn.min() == -60.0
    width = size // 500
    for start in range(0, size - width, width):
        seen = (places >= start - width) & (places <= start + 2 * width)
        assert drawn[seen].max() >= values[start : start + width].max()
        assert drawn[seen].min() <= values[start : start + width].min()


# -- files --------------------------------------------------------------------------------------


def test_curves_are_where_the_ticks_say(result: ms.Result) -> None:
    """A point of a curve, read from the file against two ticks, is the value it stands for."""
    plot = Plot([Panel()])
    panel = plot.panels[0]
    panel.x.log, panel.x.low, panel.x.high = True, 0.1, 1000.0
    panel.y.low, panel.y.high = -2.0, 3.0
    panel.line([1.0, 100.0], [0.0, 2.0])
    frame = lay_out(plot).frames[0]
    text = svg(plot).decode()
    found = re.search(r'<path d="M([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+)" fill="none"', text)
    assert found
    x0, y0, x1, y1 = map(float, found.groups())
    assert x0 == pytest.approx(frame.left + 0.25 * frame.width, abs=0.01)
    assert x1 == pytest.approx(frame.left + 0.75 * frame.width, abs=0.01)
    assert y0 == pytest.approx(frame.top + 0.6 * frame.height, abs=0.01)
    assert y1 == pytest.approx(frame.top + 0.2 * frame.height, abs=0.01)


def test_pixels_are_whole_pictures() -> None:
    """A map in a figure is a PNG that reads back as it was."""
    import base64
    import io

    from PIL import Image

    values = np.random.default_rng(0).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    plot = Plot([Panel()])
    plot.panels[0].add(Pixels(values, 0.0, 7.0, 0.0, 5.0))
    found = re.search(r"data:image/png;base64,([^\"]+)", svg(plot).decode())
    assert found
    picture = Image.open(io.BytesIO(base64.b64decode(found[1])))
    each = 640 // 7  # few fields are drawn large, since browsers blur what they enlarge
    large = values.repeat(each, axis=0).repeat(each, axis=1)
    np.testing.assert_array_equal(np.asarray(picture), large)
