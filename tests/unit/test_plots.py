"""Figures in Python: the same data as the command's, on axes of one's own or on new ones."""

from __future__ import annotations

import base64
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from command import run
from matplotlib import pyplot, style
from matplotlib.figure import Figure
from usual import PAIR

import microslip as ms
from microslip.friction.laws import LAWS
from microslip.study.new import demo_text

JOINT = ms.Interface(ms.SphereOnFlat(PAIR, radius=5e-3), 0.5, normal_load=20.0)


@pytest.fixture(autouse=True)
def _no_window() -> Iterator[None]:
    with mpl.rc_context({"backend": "Agg"}):
        yield
    pyplot.close("all")


def shown(ax, number: int = 0):
    line = ax.lines[number]
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def test_records_cycles_and_fits() -> None:
    rig = ms.VirtualTribometer(JOINT.at(normal_load=200.0), noise=1e-4)
    record = rig.record(amplitude=2e-5, frequency=10.0, cycles=4)
    axes = record.plot()
    assert axes[-1].get_xlabel() == "Time [ms]"
    assert len(shown(axes[0])[0]) == len(record)
    measured = ms.measure(record)
    loop, energies = measured.plot()
    assert energies.get_ylabel() == "Energy per cycle [mJ]"
    assert np.allclose(shown(energies)[1], 1e3 * measured.cycles["dissipated_energy"], rtol=1e-12)
    fit = ms.identify([record])
    assert len(fit.plot()) == 2
    with pytest.raises(ms.InputError, match="ax must be 2 Matplotlib axes"):
        fit.plot(loop)


def test_modes_responses_and_motions() -> None:
    masses, springs = np.diag([2.0, 1.0]), np.array([[2e8, -1e8], [-1e8, 1e8]])
    structure = ms.Structure(masses, springs).attach(JOINT, directions=[1.0, -1.0])
    frequency, damping = structure.modes(0, [1e-9, 1e-8, 1e-7]).plot()
    assert frequency.get_ylabel() == "Frequency [Hz]"
    assert damping.get_yscale() == "log"
    response = structure.forced_response([0.0, 0.5], np.linspace(880.0, 960.0, 9))
    assert np.array_equal(shown(response.plot())[0], response.frequency)
    time = np.linspace(0.0, 2e-3, 50)
    motion = structure.integrate(np.outer(np.sin(6000.0 * time), [0.0, 0.5]), time)
    assert motion.plot(at=1)[0].get_ylabel().startswith("Displacement")
    with pytest.raises(ms.InputError, match="at must be an integer from 0 to 1, got 2"):
        motion.plot(at=2)


def test_the_style_alone_and_an_import_without_matplotlib() -> None:
    with style.context("microslip.style"):
        assert mpl.rcParams["svg.fonttype"] == "none"
    code = (
        "import sys, microslip as ms; ms.Loop; ms.Interface; assert 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_pdf_as_a_format(here) -> None:
    """Of a study and of the other commands."""
    study = ms.Study.from_toml(demo_text().replace('"svg"]', '"pdf"]'))
    names = study.run().summary["files"]
    assert "loops.pdf" in names
    assert not [name for name in names if name.endswith(".svg")]
    rig = ms.VirtualTribometer(JOINT.at(normal_load=200.0), noise=1e-4)
    rig.record(amplitude=2e-5, frequency=10.0, cycles=4).to_csv("run.csv")
    outcome = run("measure", "run.csv", "-o", "out", "--pdf")
    assert outcome.exit_code == 0, outcome.output
    names = sorted(path.name for path in (here / "out").iterdir())
    made = (here / "out" / "loops.pdf").read_bytes()
    assert made.startswith(b"%PDF-")
    assert b"CreationDate" not in made
    assert names == ["cycles.csv", "loops.pdf", "loops.svg", "report.html", "summary.json"]


# -- notebooks -------------------------------------------------------------------------------------


ROOT = Path(__file__).parents[2]
TIME = np.arange(4000) / 1000.0
RECORD = ms.Record(
    time=TIME,
    displacement=1e-5 * np.sin(2 * np.pi * TIME),
    force=9.0 * np.sign(np.cos(2 * np.pi * TIME)),
)


@pytest.mark.parametrize(
    "item",
    [*(kind.examples()[0] for kind in LAWS), RECORD, ms.measure(RECORD)],
    ids=lambda item: type(item).__name__,
)
def test_a_notebook_shows_the_text_and_a_figure(item: Any) -> None:
    if isinstance(item, ms.BackboneLaw):  # and a script any measure
        assert item.plot().get_xscale() == "log"
        damping = item.plot(quantity="loss_factor", amplitudes=[1e-7, 1e-6, 1e-5])
        line = next(line for line in damping.lines if len(line.get_xdata()) > 2)
        assert np.allclose(line.get_ydata(), item.loss_factor([1e-7, 1e-6, 1e-5]))
    shown = item._repr_html_()
    text, image = re.fullmatch(
        r'<pre>(.*)</pre><img src="data:image/svg\+xml;base64,(.*)" alt=".*">', shown, re.DOTALL
    ).groups()  # type: ignore[union-attr]
    assert text.startswith(type(item).__name__)
    assert ElementTree.fromstring(base64.b64decode(image)).tag.endswith("svg")
    assert len(shown) < 400_000


def test_summits_lie_on_the_map_of_their_scan() -> None:
    x, y = np.meshgrid(np.arange(60.0), np.arange(40.0))
    scan = ms.Scan(1e-7 * np.sin(0.5 * x) * np.cos(0.4 * y), pixel=1e-6).condition(level="plane")
    summits = scan.summits(cutoff=None)
    ax = scan.plot(Figure().subplots())
    summits.plot(ax)
    assert ax.images
    assert np.allclose(shown(ax)[0], 1e6 * summits.positions[:, 0])
