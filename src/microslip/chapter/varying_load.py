"""What a cycle costs while the normal load varies; the chapter holds it."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip.chapter.contact import assumed as one_summit
from microslip.chapter.contact import summit
from microslip.chapter.joint import COLORS, LINES
from microslip.chapter.joint import assumed as worked_out
from microslip.chapter.plate import LIGHT, Drawing, Plate, as_plate, cross
from microslip.chapter.surface import worked_example
from microslip.friction import CoupledResponse, Interface
from microslip.report.drawing import DASHES

MICRO, NANO, MILLI = 1e-6, 1e-9, 1e-3
SAMPLES = 180


def _last(response: CoupledResponse) -> float:
    """What its last cycle costs [J]."""
    lost = response.dissipated_energy
    return float(lost[-1] - lost[-1 - SAMPLES])


def cycles(joint: Interface, amplitude: float, ripple: float, phase: float) -> CoupledResponse:
    """Two cycles of a displacement and of a load that is ahead of it by a phase [degrees].

    All largest loads and displacements lie in the first, so the second has settled.
    """
    turn = 2.0 * math.pi * np.arange(1, 2 * SAMPLES + 1) / SAMPLES
    load = joint.normal_load * (1.0 + ripple * np.sin(turn + math.radians(phase)))
    # The least load of a full ripple is none, not rounding below it.
    load[load < 1e-12 * joint.normal_load] = 0.0
    return joint.coupled_response(amplitude * np.sin(turn), normal_load=load)


@as_plate(
    "coupled-phase",
    "energy",
    "What a cycle costs while the normal load varies, too",
    "Out of phase it costs more, as Putignano, Ciavarella and Barber (2011) found: most where "
    "the load is ahead by a little less than a quarter cycle, least where it is nearly in step "
    "or opposed. The smaller the displacement the more so; in gross slip it hardly matters.",
    worked_out("Displacement amplitude · sin θ, load N (1 + ripple · sin(θ + ψ)); settled cycle."),
)
def _by_phase(plate: Plate) -> Drawing:
    joint = worked_example()
    phases: Floats = np.arange(0.0, 181.0, 4.5)
    figure, body = plate.page(4.2)
    first, right = body.subplots(1, 2, sharey=True)
    columns = {"phase [deg]": phases}
    cases = (
        (first, [(a, 0.5) for a in (1e-7, 2e-7, 5e-7, 1e-6)], "(a) ripple 50 %"),
        (right, [(2e-7, r) for r in (0.75, 0.5, 0.25)], "(b) amplitude 0.2 µm"),
    )
    for axes, pairs, title in cases:
        for (amplitude, ripple), color, line in zip(pairs, COLORS, LINES, strict=False):
            constant = float(joint.dissipated_energy(amplitude))
            lost = [_last(cycles(joint, amplitude, ripple, phase)) for phase in phases]
            share = np.array(lost) / constant
            columns[f"energy ratio at {amplitude:g} m with ripple {ripple:g}"] = share
            label = (
                f"{amplitude / MICRO:g} µm" if axes is first else f"{ripple:.0%}".replace("%", " %")
            )
            axes.plot(phases, share, color=color, linestyle=line, label=label)
        axes.axhline(1.0, color=LIGHT, linestyle=DASHES, linewidth=0.9, zorder=1)
        axes.set(xlabel="Phase ψ of the load before δ [°]", title=title)
        axes.set_xlim(0.0, 180.0)
        axes.set_xticks(np.arange(0.0, 181.0, 45.0))
        axes.legend(loc="upper right", title="Amplitude" if axes is first else "Ripple")
    first.set(ylabel="Energy per cycle over that at constant load [–]")
    first.set_ylim(0.0, 4.0)
    return Drawing(figure, columns)


@as_plate(
    "coupled-ripple",
    "energy",
    "One asperity under a normal load that varies up to lift-off",
    "Where the load is ahead by an eighth or a quarter of the cycle its ripple makes the "
    "cycle cost more, in step less (a). At full ripple the contact parts once a cycle; there "
    "the force is 0, wherever the displacement is (b).",
    one_summit("Amplitude 0.8 δL, load N (1 + ripple · sin(θ + ψ)); settled cycle."),
)
def _by_ripple(plate: Plate) -> Drawing:
    joint = summit()
    top = 0.8 * joint.slip_limit
    constant = float(joint.dissipated_energy(top))
    ripples: Floats = np.linspace(0.0, 1.0, SAMPLES // 2 + 1)
    figure, body = plate.page(4.2)
    first, right = body.subplots(1, 2)
    columns = {"ripple": ripples}
    looks = list(zip(COLORS, LINES, strict=True))
    for phase, (color, line) in zip((0.0, 45.0, 90.0, 135.0), looks[1:], strict=True):
        share = (
            np.array([_last(cycles(joint, top, ripple, phase)) for ripple in ripples]) / constant
        )
        columns[f"energy ratio at {phase:g} deg"] = share
        first.plot(ripples, share, color=color, linestyle=line, label=f"{phase:g}°")
    first.axhline(1.0, color=LIGHT, linestyle=DASHES, linewidth=0.9, zorder=1)
    first.set(xlabel="Load ripple ΔN/N [–]", title="(a) what a cycle costs")
    first.set(ylabel="Energy per cycle over that at constant load [–]")
    first.set(xlim=(0.0, 1.0), ylim=(0.0, 3.5))
    first.legend(loc="upper left", title="ψ, load before δ")
    for ripple, phase, (color, line) in (
        (0.0, 0.0, looks[0]),
        (1.0, 0.0, looks[1]),
        (1.0, 90.0, looks[3]),
    ):
        response = cycles(joint, top, ripple, phase)
        x, force = (v[SAMPLES - 1 :: 2] for v in (response.displacement, response.force))
        name = f"ripple 1, {phase:g} deg" if ripple else "constant load"
        columns[f"displacement: {name} [m]".replace(",", "")] = x
        columns[f"force: {name} [N]".replace(",", "")] = force
        label = f"lift-off, {phase:g}°" if ripple else "constant load"
        right.plot(x / NANO, force / MILLI, color=color, linestyle=line, label=label)
    cross(right)
    right.set(xlabel="Tangential displacement δ [nm]", ylabel="Tangential force T [mN]")
    right.set_title("(b) loops, up to full ripple")
    right.legend(loc="upper left")
    return Drawing(figure, columns)
