"""Tests of modes: frequency and damping against amplitude, as a document and as files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from microslip._core.units import engineering, prefix
from microslip._core.wording import shorten
from microslip.report import cells
from microslip.report.document import Column, Document, Items, Picture, Section, Table
from microslip.report.files import header, standard_files, text_cell, text_file, write_all
from microslip.report.plot import COLORS, DASHES, Axis, Entry, Panel, Plot
from microslip.structures import ModalTest

KIND = "microslip-modal-test"
"""What summary.json says of a folder of tests of modes."""


def file_names(kinds: Sequence[str] = ("svg",)) -> tuple[str, ...]:
    """Names of the files of a folder, the figure in each of some formats."""
    figures = (f"modal_curves.{kind}" for kind in kinds)
    return ("report.html", "modal_curves.csv", *figures, "summary.json")


def document(tests: Sequence[ModalTest], files: Sequence[str] = ()) -> Document:
    """What tests of modes say."""
    names = [shorten(test.name, 100) for test in tests]
    title = names[0] if len(names) == 1 else f"{len(names)} tests of modes"
    data = {
        **header(KIND, 1, title),
        "tests": [
            {
                "name": test.name,
                "amplitude": test.amplitude.tolist(),
                "modal_frequency": test.frequency.tolist(),
                "modal_damping_ratio": test.damping_ratio.tolist(),
                "notes": list(test.notes),
            }
            for test in tests
        ],
        "files": list(files),
    }
    sections = [_section(test) for test in tests]
    caption = (
        "Frequency and damping ratio against the displacement amplitude at the sensor. A joint "
        "that slips lowers the frequency and raises the damping as the amplitude grows."
    )
    picture = Picture(
        "modal_curves",
        caption,
        lambda: curve_plot(tests),
        "Frequency and damping of the tests against amplitude",
    )
    sections.append(Section("Curves", (picture,), brief=False))
    return Document(KIND, title, _answer(tests), tuple(sections), data)


def write(document: Document, tests: Sequence[ModalTest], folder: Path) -> None:
    """Write every file of a document into an existing folder."""
    table = text_file("modal_curves.csv", lambda: _csv(tests))
    write_all(standard_files(document, document.data["files"], [table]), folder)


def _answer(tests: Sequence[ModalTest]) -> str:
    said = []
    for test in tests:
        first, last = int(test.amplitude.argmin()), int(test.amplitude.argmax())
        sizes = [engineering(float(test.amplitude[i]), "m", 3) for i in (first, last)]
        name = "" if len(tests) == 1 else f"{shorten(test.name, 40)}: "
        said.append(
            f"{name}from {sizes[0]} to {sizes[1]} at the sensor the frequency goes from "
            f"{test.frequency[first]:.5g} to {test.frequency[last]:.5g} Hz and the damping ratio "
            f"from {cells.ratio(float(test.damping_ratio[first]))} to "
            f"{cells.ratio(float(test.damping_ratio[last]))}."
        )
    return " ".join([said[0][0].upper() + said[0][1:] if len(tests) == 1 else said[0], *said[1:]])


def _section(test: ModalTest) -> Section:
    columns = (
        Column("amplitude", "Amplitude at the sensor", "m", 3),
        Column("modal_frequency", "Frequency", "Hz", write=lambda f: f"{f:.5g}"),
        Column("modal_damping_ratio", "Damping ratio ζ", "", write=cells.ratio),
    )
    order = test.amplitude.argsort(kind="stable")
    rows = tuple(
        (float(test.amplitude[i]), float(test.frequency[i]), float(test.damping_ratio[i]))
        for i in order
    )
    name = shorten(test.name, 100)
    return Section(name, (Table(name, columns, rows, noun="amplitudes"), Items(test.notes)))


def _csv(tests: Sequence[ModalTest]) -> str:
    """One line for each amplitude; the headers are those that a study reads."""
    lines = ["test,amplitude [m],frequency [Hz],damping_ratio"]
    for test in tests:
        name = text_cell(test.name)
        for row in zip(test.amplitude, test.frequency, test.damping_ratio, strict=True):
            lines.append(",".join([name, *(repr(float(value)) for value in row)]))
    return "\n".join(lines) + "\n"


def curve_plot(tests: Sequence[ModalTest]) -> Plot:
    """Frequency and damping ratio against amplitude, of each test."""
    scale, letter = prefix(max(float(test.amplitude.max()) for test in tests))
    label = f"Amplitude at the sensor [{letter}m]"
    alone = len(tests) == 1
    upper = Panel(
        Axis(label, log=True, bare=True),
        Axis("Frequency [Hz]" if alone else "Frequency over the first [%]"),
        cell=(0, 0, 0, 0),
    )
    lower = Panel(Axis(label, log=True), Axis("Damping ratio ζ [–]", log=True), cell=(1, 1, 0, 0))
    legend = []
    for index, test in enumerate(tests):
        color, dash = COLORS[index % len(COLORS)], DASHES[index % len(DASHES)]
        order = test.amplitude.argsort(kind="stable")
        x, f = test.amplitude[order] / scale, test.frequency[order]
        for panel, y in (
            (upper, f if alone else 100.0 * f / f[0]),
            (lower, test.damping_ratio[order]),
        ):
            panel.line(x, y, color, dash=dash)
            panel.marks(x, y, color)
        rest = f"{f[0]:.5g} Hz" if math.isfinite(f[0]) else ""
        legend.append(Entry(f"{shorten(test.name, 40)}, {rest}", color, dash, marker="o"))
    return Plot([upper, lower], 5.6, heights=(1.0, 1.3), legend=tuple(legend))
