"""Draw the pictures of the README and of the pages again: python docs/make_images.py [NAME...]

The chapter's figures are those of make_figures.py, measured_face.svg and normal_laws.svg those of
benchmarks/measured_faces.py and benchmarks/normal_laws.py.
"""

from __future__ import annotations

import math
import re
import runpy
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import chdir
from functools import partial
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import style
from matplotlib.figure import Figure

import microslip as ms

ROOT = Path(__file__).parents[1]
FOLDER = Path(__file__).with_name("images")
STYLE = Path(ms.__file__).with_name("style.mplstyle")
LOADS = (500.0, 2000.0, 5000.0)
MICRO = 1e-6


def al2017(normal_load: float) -> ms.Interface:
    """The joint of examples/al2017.toml."""
    al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
    )
    return ms.Interface(surface, friction_coefficient=0.55, normal_load=normal_load)


def path(*corners: float) -> np.ndarray:
    """Displacements through the corners, denser near them as a sine is."""
    rise = 0.5 - 0.5 * np.cos(np.linspace(0.0, math.pi, 60))
    pieces = [a + (b - a) * rise for a, b in pairwise(corners)]
    return np.concatenate(pieces)


def name_line(axes, text: str, x: float, y: float) -> None:
    axes.annotate(text, (x, y), (0, 3), textcoords="offset points", va="bottom", fontsize=8.5)


def draw_loops(axes, joint: ms.Interface) -> None:
    record = path(0.0, 0.9, -0.9, 0.1, -0.35, 0.9)
    axes.plot(record, joint.force(record * MICRO) / 1e3, label="from rest, with a minor loop")
    for amplitude in (0.4, 0.15):
        loop = joint.loop(amplitude * MICRO)
        label = f"±{amplitude:g} µm"
        axes.plot(loop.displacement / MICRO, loop.force / 1e3, label=label)
    limit = joint.force_limit / 1e3
    for sign in (-1.0, 1.0):
        axes.axhline(sign * limit, color="#666666", linestyle=(0, (4, 2)), linewidth=0.9)
    name_line(axes, "gross slip, μN", -0.95, limit)
    axes.set(title="Al 2017, milled, 2 kN", xlabel="Displacement [µm]", ylabel="Force [kN]")
    axes.set_ylim(-1.35, 1.35)
    axes.set_xticks([-0.5, 0.0, 0.5])
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower right", ncols=3)


def draw_damping(axes) -> None:
    amplitude = np.geomspace(1e-9, 1e-4, 300)
    for load in LOADS:
        label = f"{load / 1e3:g} kN"
        axes.plot(amplitude / MICRO, al2017(load).loss_factor(amplitude), label=label)
    top = 4.0 / math.pi
    axes.axhline(top, color="#666666", linestyle=(0, (4, 2)), linewidth=0.9)
    name_line(axes, "rigid–plastic, 4/π", 1.2e-3, top)
    axes.set_xscale("log")
    axes.set(title="Damping of the interface", xlabel="Amplitude [µm]", ylabel="Loss factor η [–]")
    axes.set_ylim(0.0, 1.45)
    right = axes.secondary_yaxis("right", functions=(lambda y: y / 2.0, lambda y: 2.0 * y))
    right.set_ylabel("Damping ratio ζ = η/2 [–]")
    axes.legend(loc="center left", title="Normal load")


def predict_beam() -> ms.Result:
    """The beam of examples/bolted_beam.toml; takes half a minute."""
    return ms.Study.load(Path(__file__).parents[1] / "examples/bolted_beam.toml").run()


def draw_beam_files(result: ms.Result) -> None:
    names = {"modal_curves": "bolted_beam_curves", "loss_map": "bolted_beam_loss"}
    with tempfile.TemporaryDirectory() as folder:
        result.save(Path(folder) / "beam")
        for name, own in names.items():
            shutil.copy(Path(folder) / f"beam/{name}.svg", FOLDER / f"{own}.svg")


def draw_band(axes, result: ms.Result) -> None:
    """Damping of the first mode of the beam: the median and the band of 5 to 95 %."""
    mode = result.structure.modes[0]
    amplitude = mode.curve.amplitude / MICRO
    low, middle, high = (100.0 * values for values in mode.bands.damping_ratio)
    axes.fill_between(amplitude, low, high, alpha=0.3, label="5 to 95 %")
    axes.plot(amplitude, middle, label="median")
    axes.set(xscale="log", yscale="log", xlabel="Amplitude at the end [µm]")
    title = f"Bolted beam, {mode.curve.linear_frequency:.0f} Hz"
    axes.set(title=title, ylabel="Damping ratio ζ [%]")
    axes.legend(loc="upper left")


def draw_overview() -> None:
    beam = predict_beam()
    draw_beam_files(beam)
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(7.1, 3.4))
        left, right = figure.subplots(1, 2)
        draw_band(left, beam)
        draw_loops(right, al2017(2000.0))
        figure.savefig(FOLDER / "overview.png", dpi=130, metadata={"Software": None})


def draw_al2017() -> None:
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(7.1, 3.4))
        left, right = figure.subplots(1, 2)
        draw_loops(left, al2017(2000.0))
        draw_damping(right)
        # The version of matplotlib in the file would change it for nothing.
        figure.savefig(FOLDER / "al2017.png", dpi=130, metadata={"Software": None})


# -- one picture a page ---------------------------------------------------------------------------


def save(figure: Figure, name: str, kind: str = "svg") -> None:
    """The figure as SVG with text as text, or as PNG where there are many points."""
    extra = {"Date": None} if kind == "svg" else {"Software": None}
    with style.context({"svg.fonttype": "none", "svg.hashsalt": "microslip"}):
        figure.savefig(FOLDER / f"{name}.{kind}", dpi=110, metadata=extra)


GALLERY = {
    "any_history": ("03", 1, "svg"),
    "cells": ("06", 1, "svg"),
    "time_integration": ("07", 1, "svg"),
    "heights": ("08", 1, "svg"),
    "oscillator": ("09", 1, "svg"),
    "sweep": ("10", 1, "png"),
    "laws": ("11", 1, "svg"),
    "asperity": ("12", 1, "svg"),
    "summits": ("13", 1, "png"),
    "identified": ("14", 1, "png"),
    "structure": ("16", 1, "svg"),
    "pressed_face": ("17", 1, "svg"),
    "shaker": ("19", 1, "svg"),
}
"""Script of the gallery, number of its figure, format."""


def draw_gallery(name: str) -> None:
    start, number, kind = GALLERY[name]
    (script,) = (ROOT / "examples").glob(f"{start}_*.py")
    with style.context("default"), chdir(ROOT / "examples"):
        plt.close("all")
        runpy.run_path(str(script))
        save(plt.figure(number), name, kind)


COMMANDS = {
    "first_joint": ("predict examples/al2017.toml", "loops"),
    "bolt_pressure": ("predict examples/bolted_joint.toml", "pressure"),
    "measured_loops": ("measure run0.csv run1.csv run2.csv run3.csv", "loops"),
}
"""A command, and the figure of its result."""


def draw_command(name: str) -> None:
    line, figure = COMMANDS[name]
    with tempfile.TemporaryDirectory() as scratch, chdir(scratch):
        Path("examples").symlink_to(ROOT / "examples")
        loads = [
            f"{load} N,{friction}" for load in range(250, 5001, 250) for friction in (0.4, 0.6)
        ]
        rows = ["joint.normal_load,joint.friction_coefficient", *loads]
        Path("changes.csv").write_text("\n".join(rows), encoding="utf-8")
        for number, (load, amplitude) in enumerate(RUNS):
            rig = ms.VirtualTribometer(al2017(load), rig_stiffness=5e8, noise=0.003, seed=number)
            record = rig.record(amplitude=amplitude, frequency=10.0, cycles=20)
            record.to_csv(f"run{number}.csv")
        words = [sys.executable, "-m", "microslip", *line.split(), "-o", "out"]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        shutil.copy(f"out/{figure}.svg", FOLDER / f"{name}.svg")


RUNS = ((500.0, 1.5e-6), (500.0, 6e-6), (2000.0, 1.5e-6), (2000.0, 6e-6))
"""Normal load [N] and amplitude [m] of the records."""


def draw_record() -> None:
    """A record as a rig gives it: its beginning over time."""
    rig = ms.VirtualTribometer(
        al2017(2000.0), rig_stiffness=2e8, noise=0.005, load_ripple=0.02, sample_rate=5120, seed=1
    )
    record = rig.record(amplitude=20e-6, frequency=10.0, cycles=4)
    with style.context(["default", STYLE]):
        axes = record.plot()
        save(np.ravel(axes)[0].figure, "record")


def draw_nodes() -> None:
    """Loops of four nodes under 1100, 600, 300 and 0 N, moved together."""
    surface = al2017(2000.0).surface
    loads = [1100.0, 600.0, 300.0, 0.0]
    state = ms.JointField(surface, 0.55, areas=[5e-5] * 4, loads=loads).start()
    record = path(0.0, 0.9, -0.9, 0.9) * MICRO
    forces = []
    for displacement in record:
        forces.append(state.try_(float(displacement))[0])
        state.commit()
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(7.1, 3.2))
        axes = figure.subplots()
        for load, force in zip(loads, np.transpose(forces), strict=True):
            axes.plot(record / MICRO, force, label=f"{load:g} N")
        axes.set(xlabel="Displacement [µm]", ylabel="Force of the node [N]")
        axes.legend(title="Load of the node")
        save(figure, "nodes")


def draw_resonance() -> None:
    """The solver of the page on harmonic balance, at four forces."""
    page = (ROOT / "docs/harmonic-balance.md").read_text(encoding="utf-8")
    first, solver = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[:2]
    names: dict[str, object] = {}
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(7.1, 3.2))
        axes = figure.subplots()
        for drive in (20, 100, 300):
            exec(first + solver.replace("2e9, 100.0", f"2e9, {drive}.0", 1), names)
            curve = names["amplitudes"]
            assert isinstance(curve, dict)
            axes.plot(list(curve), [1e9 * x / drive for x in curve.values()], label=f"{drive} N")
        axes.set(xlabel="Frequency over that of small motions [%]")
        axes.set(ylabel="Amplitude over force [nm/N]")
        axes.legend(title="Force")
        save(figure, "resonance")


def draw_drawn_face() -> None:
    """Stiffness and energies of drawn faces against their hardness, and the nodes of the table."""
    from microslip.contact import face_table

    nodes = face_table.stored()
    h = np.geomspace(0.03, 1.0, 80)
    with style.context(["default", STYLE]):
        figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.2), layout="constrained")
        for level in (0.01, 0.1, 0.35):
            found = face_table.values(h, level * h)
            left.loglog(h, found.stiffness, label=f"{level:g}")
            here = (nodes["level"] == np.float32(level)) & (nodes["hardness"] <= 1.0)
            left.loglog(nodes["hardness"][here], np.exp(nodes["stiffness"][here]), "k.", ms=2)
        left.legend(title="p/H")
        left.set(xlabel="H/(E*h′)", ylabel="kₙ Rq/p")
        found = face_table.values(h, 0.03 * h)
        for amplitude in (0.1, 0.3, 1.0):
            energies = []
            for bends in found.bends:
                form = face_table.shape(bends)
                u = np.linspace(0.0, amplitude, 400)
                lost = 1.0 - np.interp(u, form.distance, form.share)
                energies.append(
                    8.0 * (np.trapezoid(lost, u) - 0.5 * amplitude * lost[-1]) / amplitude**2
                )
            right.loglog(h, energies, label=f"{amplitude:g}")
        right.legend(title="Amplitude a over μN/kₜ")
        right.set(xlabel="H/(E*h′)", ylabel="Energy of a cycle over kₜa²")
        save(figure, "drawn_face")


def draw_plots() -> None:
    """The last figure of the page on figures."""
    page = (ROOT / "docs/figures-in-python.md").read_text(encoding="utf-8")
    names: dict[str, Figure] = {}
    with (
        style.context(["default", STYLE]),
        tempfile.TemporaryDirectory() as scratch,
        chdir(scratch),
    ):
        for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL)[:2]:
            exec(block, names)
        save(names["fig"], "plots")


def draw_explorer() -> None:
    """The explorer, as Chromium shows it."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        print("no chromium: explorer.png is left as it is")
        return
    with tempfile.TemporaryDirectory() as scratch:
        page = Path(scratch, "explorer.html")
        subprocess.run([sys.executable, "-m", "microslip", "explore", "-o", page], check=True)
        subprocess.run(
            [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
             "--window-size=1280,800", f"--screenshot={FOLDER / 'explorer.png'}", page.as_uri()],
            check=True, stderr=subprocess.DEVNULL,
        )  # fmt: skip


DRAWN: dict[str, Callable[[], None]] = {
    "overview": draw_overview,
    "al2017": draw_al2017,
    **{name: partial(draw_gallery, name) for name in GALLERY},
    **{name: partial(draw_command, name) for name in COMMANDS},
    "record": draw_record,
    "nodes": draw_nodes,
    "resonance": draw_resonance,
    "drawn_face": draw_drawn_face,
    "plots": draw_plots,
    "explorer": draw_explorer,
}


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:] or DRAWN:
        print(name)
        DRAWN[name]()


if __name__ == "__main__":
    main()
