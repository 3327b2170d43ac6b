"""Figures: what they draw, that nothing is cut or covered, and that their files are the same."""

from __future__ import annotations

import io
import re
import struct
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from studies import AMPLITUDES, CURVE, LOADS, SURFACE, SURFACES, edited

import microslip as ms
from microslip.study import drawing, figures
from microslip.study.energy_figure import force_exponent
from microslip.study.history_figure import MOST_SAMPLES, envelope, path
from microslip.study.slider_figure import slipping_share
from microslip.study.summary import files

PICTURES = ('["csv"]', '["svg", "png"]')
OSCILLATOR = '[oscillator]\nmass = "2 kg"\nstiffness = "100 MN/m"\nviscous_damping_ratio = 0.001\n'
STRAIGHT = 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["2 kN", "1 kN", "0 N"]\n'


def study(
    *edits: tuple[str, str],
    record: np.ndarray | None = None,
    quantity: str = "displacement",
    folder: Path = Path(),
) -> ms.Study:
    text = edited(PICTURES, *edits)
    if record is not None:
        unit = "um" if quantity == "displacement" else "N"
        rows = "\n".join(map(repr, record.tolist()))
        (folder / "record.csv").write_text(f"x [{unit}]\n{rows}\n", encoding="utf-8")
        history = f'history = {{ file = "record.csv", column = "x", quantity = "{quantity}" }}'
        text = text.replace("[excitation]", f"[excitation]\n{history}")
    return ms.Study.from_toml(text, folder=folder)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> ms.Result:
    """One with everything: two loads, a history and an oscillator."""
    time = np.linspace(0.0, 4.0 * np.pi, 200)
    folder = tmp_path_factory.mktemp("record")
    text = ("[output]", f"{OSCILLATOR}\n[output]")
    return study(text, record=np.sin(time), folder=folder).run()


@contextmanager
def styled() -> Iterator[None]:
    with matplotlib.style.context(["default", drawing.STYLE]), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        yield


def draw(result: ms.Result, name: str) -> Figure:
    with styled():
        return figures.DRAW[name](result)


def lines(axes: Axes, label: str = "-") -> list[Line2D]:
    """Curves of a panel: no markers, no dashes, nothing across the whole panel."""
    return [
        line
        for line in axes.lines
        if line.get_linestyle() == label and len(line.get_xdata()) > 2 and line.get_lw() > 1.0
    ]


def by_label(figure: Figure, word: str) -> Axes:
    return next(axes for axes in figure.axes if word in axes.get_ylabel())


# -- which figures there are --------------------------------------------------------------------


def test_the_names_of_the_figures() -> None:
    assert tuple(figures.DRAW) == (
        *("loops", "backbone", "energy_damping", "force_damping"),
        *("contact_state", "slider_density", "history", "oscillator"),
    )


@pytest.mark.parametrize("surface", ["sphere", "table"])
def test_what_there_is_to_draw_is_what_the_summary_lists(surface: str, result: ms.Result) -> None:
    plain = study((SURFACE, SURFACES[surface]), (LOADS, '"50 N"')).run()
    for drawn in (result, plain):
        listed = [name[:-4] for name in files(drawn.study) if name.endswith(".png")]
        assert listed == list(figures.names(drawn))
    assert ("contact_state" in figures.names(plain)) == (surface == "sphere")


# -- what they draw -----------------------------------------------------------------------------


def test_the_backbone_and_its_stiffnesses_are_drawn(result: ms.Result) -> None:
    figure = draw(result, "backbone")
    force, stiffness = by_label(figure, "Force"), by_label(figure, "Stiffness")
    assert "[kN]" in force.get_ylabel()
    assert "[GN/m]" in stiffness.get_ylabel()
    assert "[µm]" in stiffness.get_xlabel()
    for joint, line, tangent in zip(result.joints, lines(force), lines(stiffness), strict=True):
        x = np.asarray(line.get_xdata()) * 1e-6
        np.testing.assert_allclose(line.get_ydata(), joint.backbone(x) / 1e3, rtol=1e-12)
        np.testing.assert_allclose(
            tangent.get_ydata(), joint.backbone_stiffness(x) / 1e9, rtol=1e-12
        )
    secants = lines_of_width(stiffness, 0.9)
    for joint, line in zip(result.joints, secants, strict=True):
        x = np.asarray(line.get_xdata()) * 1e-6
        np.testing.assert_allclose(line.get_ydata(), joint.secant_stiffness(x) / 1e9, rtol=1e-12)


def lines_of_width(axes: Axes, width: float) -> list[Line2D]:
    return [line for line in axes.lines if line.get_lw() == width]


def test_energy_damping_and_exponent_are_drawn_over_both_amplitudes(result: ms.Result) -> None:
    for name, column in (("energy_damping", "amplitude"), ("force_damping", "force_amplitude")):
        figure = draw(result, name)
        energy, damping = by_label(figure, "energy"), by_label(figure, "Loss factor")
        exponent = by_label(figure, "exponent")
        for curve, *drawn in zip(
            result.curves, *(lines(axes) for axes in (energy, damping, exponent)), strict=True
        ):
            by_force = column == "force_amplitude"
            wanted = (
                curve.dissipated_energy,
                curve.loss_factor,
                force_exponent(curve) if by_force else curve.dissipation_exponent,
            )
            for line, values in zip(drawn, wanted, strict=True):
                x = getattr(curve, column) / (1e3 if by_force else 1e-6)
                np.testing.assert_allclose(line.get_xdata(), x, rtol=1e-12)
                finite = np.isfinite(line.get_ydata())
                assert finite.sum() > 10
                np.testing.assert_array_equal(np.asarray(line.get_ydata())[finite], values[finite])
        texts = " ".join(text.get_text() for text in energy.texts)
        assert "cubic limit" in texts
        assert ("linear limit" in texts) == (name == "energy_damping")


def test_the_force_limits_are_marked_over_the_force_amplitude(result: ms.Result) -> None:
    for axes in draw(result, "force_damping").axes[:3]:
        marked = [line.get_xdata()[0] for line in axes.lines if list(line.get_ydata()) == [0, 1]]
        limits = [joint.force_limit / 1e3 for joint in result.joints]
        np.testing.assert_allclose(marked, limits, rtol=1e-12)


@pytest.mark.parametrize("joint", ms.Interface.examples()[::4], ids=repr)
def test_the_exponent_in_the_force_is_its_logarithmic_slope(joint: ms.Interface) -> None:
    from microslip.study.result import AmplitudeCurve

    scale = joint.force_limit / joint.tangential_stiffness
    curve = AmplitudeCurve.of(joint, 0.05 * scale * np.array([1.0 - 1e-4, 1.0, 1.0 + 1e-4]))
    rise, run = (np.log(y[2] / y[0]) for y in (curve.dissipated_energy, curve.force_amplitude))
    assert force_exponent(curve)[1] == pytest.approx(rise / run, rel=2e-3)


def test_a_force_that_grows_no_more_has_no_finite_exponent() -> None:
    result = study((SURFACE, STRAIGHT), (LOADS, '"1 kN"')).run()
    assert np.isinf(force_exponent(result.curves[0])[-1])


def test_the_share_of_sliders_is_their_sum() -> None:
    """Exponential heights: the density is known, and its first moment in closed form."""
    result = study((SURFACE, SURFACES["exponential"]), (LOADS, '"50 N"')).run()
    joint, curve = result.joints[0], result.curves[0]
    x = curve.amplitude / (joint.slip_per_indentation * 0.8e-6)
    wanted = 1.0 - (1.0 + x) * np.exp(-x)
    np.testing.assert_allclose(slipping_share(curve), wanted, rtol=1e-7, atol=1e-12)


def test_discrete_sliders_are_stems() -> None:
    result = study((SURFACE, STRAIGHT), (LOADS, '["1 kN", "1.5 kN"]')).run()
    figure = draw(result, "slider_density")
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "Slider stiffness [MN/m]",
        "Share of the force limit",
    ]
    stems = [segment[1] for stem in figure.axes[0].collections for segment in stem.get_segments()]
    for joint, tip in zip(result.joints, stems, strict=True):
        sliders = joint.sliders()
        assert tip[0] == pytest.approx(sliders.yield_displacements[0] / 1e-6)
        assert tip[1] == pytest.approx(sliders.stiffnesses[0] / 1e6)


def test_given_summits_have_densities_that_are_drawn_where_they_are_finite() -> None:
    summits = SURFACES["population"]
    result = study((SURFACE, summits), (LOADS, '["1 N", "3 N"]')).run()
    joint = result.joints[0]
    singular = -joint.slip_per_indentation * (joint.separation - 2e-7)
    curve = result.curves[0]
    density = np.array(curve.slider_density)
    density[3] = np.inf
    object.__setattr__(curve, "slider_density", density)
    assert singular > 0.0
    axes = draw(result, "slider_density").axes[0]
    assert np.isfinite(axes.get_ylim()).all()
    assert axes.get_ylim()[1] < 1e3 * density[np.isfinite(density)].max()
    assert np.isnan(lines(axes)[0].get_ydata()[3])


def test_contacts_are_drawn_over_the_load(result: ms.Result) -> None:
    figure = draw(result, "contact_state")
    count, area, stick = (by_label(figure, word) for word in ("Contacts", "Real", "Sticking"))
    surface = result.joints[0].surface
    loads = np.asarray(count.lines[0].get_xdata()) * 1e3
    assert loads.min() < 500.0 < 2000.0 < loads.max()
    separation = surface.separation(loads)
    np.testing.assert_allclose(count.lines[0].get_ydata(), surface.contact_count(separation))
    np.testing.assert_allclose(
        area.lines[0].get_ydata(), 100.0 * surface.contact_area(separation) / 2e-4
    )
    for joint, mark in zip(result.joints, count.lines[1:], strict=True):
        assert list(mark.get_xdata()) == [joint.normal_load / 1e3]
        assert list(mark.get_ydata()) == [joint.contact_count]
    for curve, line in zip(result.curves, lines(stick), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), curve.stick_share)


def test_a_sphere_has_no_panel_of_its_one_contact() -> None:
    result = study((SURFACE, SURFACES["sphere"]), (LOADS, '"50 N"')).run()
    labels = [axes.get_ylabel() for axes in draw(result, "contact_state").axes]
    assert labels == ["Contact area [mm²]", "Sticking share of the contact area"]


def test_the_history_is_drawn(result: ms.Result) -> None:
    figure = draw(result, "history")
    given, force, energy = (by_label(figure, word) for word in ("Disp", "Force", "Diss"))
    along = next(axes for axes in figure.axes if "Displacement" in axes.get_xlabel())
    assert len(given.lines) == 1, "what was given is the same for all loads"
    for number, response in enumerate(result.histories):
        np.testing.assert_array_equal(force.lines[number].get_ydata(), response.force / 1e3)
        np.testing.assert_allclose(
            energy.lines[number].get_ydata(), response.dissipated_energy / 1e-3
        )
        np.testing.assert_array_equal(along.lines[number].get_ydata(), response.force / 1e3)
        np.testing.assert_array_equal(along.lines[number].get_xdata(), response.displacement / 1e-6)


def test_the_mode_is_drawn_beside_the_interface(result: ms.Result) -> None:
    figure = draw(result, "oscillator")
    ratio = by_label(figure, "Damping ratio")
    for curve, mode, own in zip(
        result.oscillators, lines(ratio), lines_of_width(ratio, 0.9), strict=True
    ):
        np.testing.assert_array_equal(mode.get_ydata(), curve.damping_ratio)
        np.testing.assert_array_equal(own.get_ydata(), curve.interface_damping_ratio)
    shift = by_label(figure, "shift")
    for curve, line in zip(result.oscillators, lines(shift), strict=True):
        wanted = 100.0 * (curve.frequency / curve.frequency[0] - 1.0)
        np.testing.assert_allclose(line.get_ydata(), wanted)
    assert "[kHz]" in by_label(figure, "Frequency [").get_ylabel()


def test_force_amplitudes_are_the_titles_of_their_loops() -> None:
    forces = (f"amplitudes = {AMPLITUDES}", 'force_amplitudes = ["50 N", "270 N"]')
    figure = draw(study(forces, (LOADS, '["500 N", "200 kN"]')).run(), "loops")
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == ["Force amplitude 50 N", "Force amplitude 270 N"]
    assert all("amplitude" in axes.get_xlabel() for axes in figure.axes), "too far apart"
    assert all(axes.get_ylabel() == "Force [N]" for axes in figure.axes)


# -- that it can be read ------------------------------------------------------------------------

MANY = str([f"{100 * i} N" for i in range(1, 30)]).replace("'", '"')
ODD: dict[str, tuple[tuple[str, str], ...]] = {
    "many": ((LOADS, MANY), ("A joint", "A long title of many words, " * 7)),
    "far": ((LOADS, '["1 mN", "1 N", "100 kN"]'), ("A joint", "$x_1$ <b>漢字 ∑ µ")),
    "straight": ((SURFACE, STRAIGHT), (LOADS, '["1 kN", "1.5 kN"]')),
    "one": ((LOADS, '"2 kN"'), (AMPLITUDES, '["1 um"]'), ("A joint", "W" * 200)),
    "summits": (
        (SURFACE, SURFACES["population"]),
        (LOADS, '["1 N", "3 N"]'),
        (f"amplitudes = {AMPLITUDES}\ncurve = {CURVE}", ""),
    ),
    "narrow": (
        (CURVE, '{ from = "1 um", to = "1.001 um", points = 2 }'),
        ("0.55", "0.001"),
    ),
    "varying": (
        (
            CURVE,
            f'{CURVE}\nload_variation = {{ amplitude = "123.456 N", phase = "-123.456 deg", '
            "harmonic = 10 }",
        ),
        (LOADS, MANY.replace('"100 N", ', "")),
    ),
    "tiny": (
        ("0.5 um", "5e-7 um"),
        ("1 mm", "1e-6 mm"),
        ("100 1/mm^2", "1e20 1/mm^2"),
        ("2 cm^2", "1e-18 m^2"),
        (LOADS, '["1e-12 N", "3e-12 N"]'),
        (f"amplitudes = {AMPLITUDES}\ncurve = {CURVE}", ""),
    ),
}


@pytest.mark.parametrize("case", ["usual", *ODD])
def test_nothing_is_cut_off_or_covered(case: str, result: ms.Result, tmp_path: Path) -> None:
    if case != "usual":
        edits = ODD[case]
        if case in ("many", "far"):
            edits = (*edits, ("[output]", f"{OSCILLATOR}\n[output]"))
        record = 0.1 * np.sin(np.linspace(0.0, 20.0, 100)) if case == "far" else None
        result = study(*edits, record=record, folder=tmp_path).run()
    for name in figures.names(result):
        figure = draw(result, name)
        with styled():
            drawing.settle(figure)
            figure.draw_without_rendering()
            check(figure, name)


def check(figure: Figure, name: str) -> None:
    page = figure.bbox
    panels = [axes for axes in figure.axes if axes.get_visible()]
    for text in [*figure.texts, *(figure.legends[0].get_texts())]:
        inside(text.get_window_extent(), page, f"{name}: {text.get_text()}")
    for axes in panels:
        box = axes.get_tightbbox()
        assert box is not None
        inside(box, page, f"{name}: {axes.get_ylabel()}")
        assert axes.get_window_extent().height > 40.0, "a panel squeezed flat"
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or has_unit(label), f"{name}: {label} has no unit"
        for other in panels:
            if other is not axes:
                apart = axes.get_window_extent().overlaps(other.get_window_extent())
                assert not apart, f"{name}: panels over each other"
    legend = figure.legends[0].get_window_extent()
    assert not any(legend.overlaps(axes.get_tightbbox()) for axes in panels), "legend over a panel"
    if figure.get_suptitle():
        title = figure._suptitle.get_window_extent()
        assert not any(title.overlaps(axes.get_tightbbox()) for axes in panels), (
            "title over a panel"
        )


@pytest.mark.parametrize("number", ["coupled-phase", "coupled-ripple"])
def test_panels_under_a_varying_load_say_what_they_show(number: str) -> None:
    """A letter alone is no title, and what stands at an axis is a quantity."""
    from microslip.chapter import PLATES

    plate = next(plate for plate in PLATES if plate.number == number)
    for axes in plate.draw().figure.axes:
        assert re.fullmatch(r"\([ab]\) \w.+", axes.get_title())
        assert "of its" not in axes.get_xlabel()


def inside(box: object, page: object, what: str) -> None:
    x0, y0, x1, y1 = box.extents  # type: ignore[attr-defined]
    assert x0 >= page.x0 - 1.0 and x1 <= page.x1 + 1.0, what  # type: ignore[attr-defined]  # noqa: PT018
    assert y0 >= page.y0 - 1.0 and y1 <= page.y1 + 1.0, what  # type: ignore[attr-defined]  # noqa: PT018


def has_unit(label: str) -> bool:
    plain = ("share", "Share", "factor", "ratio", "exponent", "Contacts", "Sample", " / ")
    return bool(re.search(r"\[(%|[^]]*(m|N|J|Hz)[^]]*)\]", label)) or any(
        word in label for word in plain
    )


def test_loads_differ_in_more_than_colour() -> None:
    result = study((LOADS, MANY)).run()
    with styled():
        for by in ("marker", "linestyle"):
            looks = [str(look[by]) for _, look in drawing.drawn_loads(result, by)]
            colours = [look["color"] for _, look in drawing.drawn_loads(result, by)]
            assert len(set(looks)) == len(set(colours)) == drawing.MOST_LOADS
    legend = draw(result, "backbone").legends[0]
    assert legend.get_title().get_text() == "Normal load (23 more in the tables)"
    assert [text.get_text() for text in legend.get_texts()][::5] == ["100 N", "2.9 kN"]


def test_lines_that_would_hide_each_other_show_side_by_side() -> None:
    """With exponential heights damping does not depend on the load."""
    result = study((SURFACE, SURFACES["exponential"]), (LOADS, '["50 N", "60 N", "70 N"]')).run()
    figure = draw(result, "energy_damping")
    widths = [line.get_lw() for line in lines(by_label(figure, "Loss factor"))]
    assert widths == sorted(set(widths), reverse=True)
    assert len(widths) == 3
    energies = [line.get_lw() for line in lines(by_label(figure, "energy"))]
    assert len(set(energies)) == 1


def test_the_panels_of_loops_have_one_kind_of_axis() -> None:
    """Displacements that are far apart at one force are drawn over their own amplitude at all."""
    by_force = (f"amplitudes = {AMPLITUDES}", 'force_amplitudes = ["100 N", "274.9 N"]')
    result = study((LOADS, '["500 N", "5 kN"]'), by_force).run()
    soft, stiff = (row.amplitude for row in result.rows)
    assert list(soft / stiff > 20.0) == [False, True]
    panels = draw(result, "loops").axes
    assert [axes.get_xlabel() for axes in panels] == [
        r"Displacement / amplitude, $\delta/\delta_m$"
    ] * 2


def test_forces_far_apart_are_in_newtons() -> None:
    figure = draw(study((LOADS, '["1 mN", "100 kN"]')).run(), "backbone")
    assert by_label(figure, "Force").get_ylabel() == "Force of first loading [N]"
    assert by_label(figure, "Stiffness").get_yscale() == "log"


def test_log_axes_have_plain_labels_where_these_are_short() -> None:
    axes = Figure().subplots()
    for low, high, value, label in (
        *((1e-3, 1e3, 1e-3, "0.001"), (1e-3, 1e3, 1e2, "100"), (1e-3, 1e3, 20.0, "")),
        *((1e-9, 1e3, 1.0, "10⁰"), (1e-9, 1e3, 1e-9, "10⁻⁹"), (1e12, 3e12, 2e12, "2·10¹²")),
        *((1.0, 9.0, 5.0, "5"), (1.0, 9.0, 4.0, ""), (1.0, 1.3, 1.1, "1.1")),
    ):
        drawing.log_scale(axes, "y")
        axes.set_ylim(low, high)
        assert axes.yaxis.get_major_formatter()(value) == label


# -- long records -------------------------------------------------------------------------------


def test_a_short_record_is_drawn_sample_by_sample() -> None:
    values = np.sin(np.arange(500.0))
    places, drawn = envelope(values)
    np.testing.assert_array_equal(places, np.arange(500.0))
    assert drawn is values
    assert path(values, values)[0] is values


@pytest.mark.parametrize("size", [MOST_SAMPLES + 1, 100_000, 123_457])
def test_the_envelope_of_a_long_record_has_all_its_extremes(size: int) -> None:
    values = np.random.default_rng(0).normal(size=size)
    values[size // 3], values[-1] = 50.0, -60.0
    places, drawn = envelope(values)
    assert drawn.size < 4000
    assert (np.diff(places) >= 0.0).all()
    np.testing.assert_array_equal(values[places.astype(int)], drawn)
    assert drawn.max() == 50.0
    assert drawn.min() == -60.0
    width = size // 500
    for start in range(0, size - width, width):
        seen = (places >= start - width) & (places <= start + 2 * width)
        assert drawn[seen].max() >= values[start : start + width].max()
        assert drawn[seen].min() <= values[start : start + width].min()


def test_each_stroke_of_a_long_path_is_drawn_once() -> None:
    """Ten thousand equal cycles are one, and a stroke is never drawn where there was none."""
    cycle = np.array([0.0, 1.0, 0.5, -1.0])
    x = np.tile(cycle, 10_000)
    y = np.append(x[1:], 7.0)  # the last stroke is its own
    drawn_x, drawn_y = path(x, y)
    assert drawn_x.size < 20
    strokes = {
        (a, b, c, d)
        for a, b, c, d in zip(drawn_x[:-1], drawn_y[:-1], drawn_x[1:], drawn_y[1:], strict=True)
        if not np.isnan([a, b, c, d]).any()
    }
    wanted = set(zip(x[:-1], y[:-1], x[1:], y[1:], strict=True))
    assert strokes == wanted


def test_a_long_record_is_a_picture_in_a_small_file(tmp_path: Path) -> None:
    record = np.cumsum(np.random.default_rng(0).normal(size=30_000)) / 100.0
    result = study(record=record, folder=tmp_path).run()
    svg = figures.picture(result, "history", "svg")
    assert b"<image" in svg
    assert len(svg) < 400_000
    assert b"<image" not in figures.picture(result, "loops", "svg")


# -- files --------------------------------------------------------------------------------------


def test_each_figure_is_drawn_once_for_all_its_files(
    result: ms.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []

    def counted(drawn: ms.Result) -> Figure:
        calls.append("backbone")
        return backbone(drawn)

    backbone = figures.DRAW["backbone"]
    monkeypatch.setitem(figures.DRAW, "backbone", counted)
    figures._PICTURES.clear()
    for kind in ("svg", "png"):
        figures.write(result, tmp_path / f"backbone.{kind}")
    again = figures.picture(result, "backbone", "svg")
    assert calls == ["backbone"]
    assert (tmp_path / "backbone.svg").read_bytes() == again
    png = (tmp_path / "backbone.png").read_bytes()
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", png[16:24])[0] == 1420
    other = study().run()
    figures.picture(other, "loops", "svg")
    assert result not in figures._PICTURES, "only the last result is kept"


def test_files_do_not_depend_on_what_else_is_drawn(result: ms.Result) -> None:
    first = figures.picture(result, "energy_damping", "svg")
    edits = (PICTURES[1], '["svg"]\nreport = false'), ("[output]", f"{OSCILLATOR}\n[output]")
    alone = study(*edits).run()
    with matplotlib.rc_context({"lines.linewidth": 7.0, "xtick.labelcolor": "red"}):
        assert figures.picture(alone, "energy_damping", "svg") == first
        assert matplotlib.rcParams["lines.linewidth"] == 7.0
        assert matplotlib.rcParams["xtick.labelcolor"] == "red"


def test_svg_files_are_small_and_well_formed(result: ms.Result) -> None:
    for name in figures.names(result):
        svg = figures.picture(result, name, "svg")
        assert len(svg) < 150_000, name
        assert b"<dc:date>" not in svg
        root = ET.parse(io.BytesIO(svg)).getroot()
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        digits = re.findall(rb' d="[^"]*\.\d{3}', svg)
        assert not digits, "finer than a hundredth of a point"


def test_a_file_that_cannot_be_written_is_an_oserror(result: ms.Result, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        figures.write(result, tmp_path / "nowhere" / "loops.svg")
