"""Floor 8: measured loops in the manner of Fig. 19.7: normalised force against displacement."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import style
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microslip._core.units import engineering, prefix
from microslip._core.wording import shorten
from microslip.study.drawing import _LINES as LINES
from microslip.study.drawing import STYLE, length_prefix, new_figure, note, settle
from microslip.study.result import some
from microslip.tribometer import Measurement

MOST_LOOPS = 6


def loops(measurements: Sequence[Measurement]) -> Figure:
    """Draw the mean loop of each record, and beside it what its cycles dissipate.

    Parameters
    ----------
    measurements : sequence of Measurement
        What was measured, at least one.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas. Forces are over the mean normal load where every record has one.
    """
    shown = [measurements[i] for i in some(len(measurements), MOST_LOOPS)]
    figure = new_figure(3.9, "")
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1.0])
    normalised = all("normal_load" in m.mean for m in shown)
    x_unit, x_letter = length_prefix(max(m.mean["amplitude"].value for m in shown))
    y_unit, y_letter = prefix(max(m.mean["force_amplitude"].value for m in shown))
    energies = np.concatenate([m.cycles["dissipated_energy"] for m in shown])
    e_unit, e_letter = prefix(float(np.abs(energies).max()))
    colors = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    handles = []
    for i, measured in enumerate(shown):
        look = {"color": colors[i % len(colors)], "linestyle": LINES[i % len(LINES)]}
        x, force = measured.loop
        x = x - measured.mean["displacement_offset"].value
        force = force - measured.mean["force_offset"].value
        scale = measured.mean["normal_load"].value if normalised else y_unit
        left.plot(x / x_unit, force / scale, **look)
        energy = measured.cycles["dissipated_energy"] / e_unit
        single = "o" if energy.size == 1 else ""
        right.plot(np.arange(1, energy.size + 1), energy, marker=single, **look)
        load = measured.mean.get("normal_load")
        label = shorten(measured.name, 40).replace("$", r"\$")
        if load is not None:
            label += f", {engineering(load.value, 'N')}"
        handles.append(Line2D([], [], label=label, **look))
    left.set_xlabel(f"Displacement [{x_letter}m]")
    left.set_ylabel("Force / normal load, T/N [-]" if normalised else f"Force [{y_letter}N]")
    right.set_xlabel("Cycle")
    right.set_ylabel(f"Dissipated energy [{e_letter}J]")
    right.xaxis.get_major_locator().set_params(integer=True)
    right.set_ylim(min(0.0, 1.1 * float(energies.min()) / e_unit), None)
    note(left, "Mean cycles, offsets taken off")
    note(right, "Each cycle")
    for line in (left.axhline, left.axvline):
        line(0.0, color="#888888", linewidth=0.6, zorder=1)
    left.margins(0.06)
    more = len(measurements) - len(shown)
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=min(2, len(handles)),
        title=f"{more} more records are in the tables" if more else None,
        title_fontsize=8.5,
    )
    return figure


def write(measurements: Sequence[Measurement], folder: Path) -> list[str]:
    """Draw the figure and write it as SVG and PNG.

    Parameters
    ----------
    measurements : sequence of Measurement
        What was measured, at least one.
    folder : pathlib.Path
        An existing folder.

    Returns
    -------
    list of str
        The names of the files.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    names = ["loops.svg", "loops.png"]
    # From matplotlib's own defaults, whatever the user's matplotlibrc says.
    with style.context(["default", STYLE]):
        figure = loops(measurements)
        settle(figure)
        # No dates: the same records give the same files.
        figure.savefig(folder / names[0], metadata={"Date": None, "Creator": None})
        figure.savefig(folder / names[1], metadata={"Software": None})
    return names
