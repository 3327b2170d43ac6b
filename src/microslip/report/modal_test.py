"""Document and files of modal tests: frequency and damping against amplitude."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, Quantity, dimensionless, hertz, named
from microslip._core.units import engineering
from microslip._core.wording import shorten
from microslip.figures.kit import axis_of, line_style
from microslip.figures.picture import Picture
from microslip.figures.plot import Panel, Plot, stacked
from microslip.report import cells
from microslip.report.document import Document, Items, Section, Table
from microslip.report.files import csv_file, header
from microslip.report.structure.tested import MOTIONS
from microslip.structures import ModalTest

_AT_SENSOR = Quantity("m", label="Amplitude at the sensor", form="3")
_NAMES = ("amplitude", "modal_frequency", "modal_damping_ratio")


def modal_test_document(tests: Sequence[ModalTest]) -> Document:
    """Return the document of modal tests."""
    names = [shorten(test.name, 100) for test in tests]
    title = names[0] if len(names) == 1 else f"{len(names)} tests of modes"
    data = {
        **header("modal-test", 1, title),
        "tests": [
            {
                "name": test.name,
                **{n: v.tolist() for n, v in zip(_NAMES, _columns(test), strict=True)},
                **named(test, "motion", "notes"),
            }
            for test in tests
        ],
        "files": [],
    }
    sections = [_section(test) for test in tests]
    caption = (
        "Frequency and damping ratio against the displacement amplitude at the sensor. A joint "
        "that slips lowers the frequency and raises the damping as the amplitude grows."
    )
    picture = Picture(
        "modal_curves",
        caption,
        lambda: modal_test_plot(tests),
        "Frequency and damping of the tests against amplitude",
    )
    sections.append(Section("Curves", (picture,), brief=False))
    table = csv_file("modal_curves.csv", lambda: points_data(tests))
    return Document(title, _answer(tests), tuple(sections), data, files=(table,))


def _answer(tests: Sequence[ModalTest]) -> str:
    sentences = []
    for test in tests:
        ends = [int(test.amplitude.argmin()), int(test.amplitude.argmax())]
        sizes = " to ".join(engineering(float(a), "m", 3) for a in test.amplitude[ends])
        ratios = " to ".join(cells.ratio(float(ratio)) for ratio in test.damping_ratio[ends])
        low, high = test.frequency[ends]
        begin = "From" if len(tests) == 1 else f"{shorten(test.name, 40)}: from"
        sentences.append(
            f"{begin} {sizes} at the sensor the frequency changes from {low:.5g} to {high:.5g} Hz "
            f"and the damping ratio from {ratios}."
        )
    return " ".join(sentences)


def _section(test: ModalTest) -> Section:
    order, damping = test.amplitude.argsort(kind="stable"), f"ζ, {MOTIONS[test.motion]}"
    quantities = (
        _AT_SENSOR,
        hertz("Frequency"),
        dimensionless(damping),
    )
    columns = zip(quantities, (values[order] for values in _columns(test)), strict=True)
    data = DataSet.of_rows(dict(zip(_NAMES, columns, strict=True)))
    name = shorten(test.name, 100)
    return Section(name, (Table(name, data, noun="amplitudes"), Items(test.notes)))


def _columns(test: ModalTest) -> tuple[Floats, ...]:
    return test.amplitude, test.frequency, test.damping_ratio


def points_data(tests: Sequence[ModalTest]) -> DataSet:
    """Return all points of all tests."""
    amplitude, frequency, damping = map(np.concatenate, zip(*map(_columns, tests), strict=True))
    return DataSet.of_rows(
        {
            "test": (Quantity(""), [test.name for test in tests for _ in test.amplitude]),
            "amplitude": (Quantity("m"), amplitude),
            "frequency": (Quantity("Hz"), frequency),
            "damping_ratio": (Quantity(""), damping),
        }
    )


def modal_test_plot(tests: Sequence[ModalTest]) -> Plot:
    """Plot frequency and damping ratio against amplitude for each test."""
    largest = max(float(test.amplitude.max()) for test in tests)
    alone = len(tests) == 1
    frequency = axis_of(hertz("Frequency"))
    if not alone:
        frequency = axis_of(dimensionless("Frequency relative to the first"), (0.01, "%"))
    upper, lower = (
        Panel(axis_of(_AT_SENSOR, largest, log=True), y)
        for y in (frequency, axis_of(QUANTITIES["damping_ratio"], log=True))
    )
    legend = []
    for index, test in enumerate(tests):
        style = line_style(index)
        order = test.amplitude.argsort(kind="stable")
        x, f = test.amplitude[order] / upper.x.unit, test.frequency[order]
        for panel, y in (
            (upper, f if alone else 100.0 * f / f[0]),
            (lower, test.damping_ratio[order]),
        ):
            panel.line(x, y, style.color, dash=style.dash)
            panel.marks(x, y, style.color, marker=style.marker)
        first = f"{f[0]:.5g} Hz" if math.isfinite(f[0]) else ""
        legend.append(style.entry(f"{shorten(test.name, 40)}, {first}"))
    return stacked([upper, lower], 5.6, (1.0, 1.3), legend)
