"""Draw the pictures of the README and of bolted structures again: python docs/make_images.py"""

from __future__ import annotations

import math
import shutil
import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib import style
from matplotlib.figure import Figure

import microslip as ms

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
    """The beam of examples/bolted_beam.toml; takes a minute."""
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


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    beam = predict_beam()
    draw_beam_files(beam)
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(7.1, 3.4))
        left, right = figure.subplots(1, 2)
        draw_band(left, beam)
        draw_loops(right, al2017(2000.0))
        figure.savefig(FOLDER / "overview.png", dpi=130, metadata={"Software": None})
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(7.1, 3.4))
        left, right = figure.subplots(1, 2)
        draw_loops(left, al2017(2000.0))
        draw_damping(right)
        # The version of matplotlib in the file would change it for nothing.
        figure.savefig(FOLDER / "al2017.png", dpi=130, metadata={"Software": None})


if __name__ == "__main__":
    main()
