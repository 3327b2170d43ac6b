"""Floor 8: the figures of section 2.1's rig, 19.7 and 19.22, from synthetic records."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._units import engineering
from microslip.chapter.joint import COLORS, LINES
from microslip.chapter.joint import assumed as worked_out
from microslip.chapter.plate import BLUE, DOTS, GREY, INK, LIGHT, RED, Drawn, Plate, cross, words
from microslip.chapter.surface import worked_example
from microslip.friction import Interface
from microslip.study.drawing import DASHES

Floats = NDArray[np.float64]

MICRO, KILO, MILLI = 1e-6, 1e3, 1e-3
RIG = 1e8
NOISE = 0.005
SAMPLES = 400


class Synthetic(NamedTuple):
    """Two cycles from rest on a rig that is not ideal; the second one has settled."""

    displacement: Floats
    """At the transducer [m], with noise."""
    force: Floats
    """At the force cell [N], with noise."""
    normal_load: Floats
    """Normal loads [N]."""
    slip: Floats
    """What the joint itself has moved [m], without noise."""


def synthetic_record(
    joint: Interface,
    amplitude: float,
    *,
    rig_stiffness: float = RIG,
    load_ripple: float = 0.02,
    third_harmonic: float = 0.05,
    noise: float = NOISE,
    samples: int = SAMPLES,
    seed: int = 19,
) -> Synthetic:
    """A joint as the chapter's tribometer would see it, with that rig's imperfections.

    Parameters
    ----------
    joint : Interface
        The joint, at its static normal load.
    amplitude : float
        Amplitude of the sine that the transducer is to follow [m].
    rig_stiffness : float
        Stiffness in series between joint and transducer [N/m].
    load_ripple : float
        By how much the normal load follows the tangential one, in shares of both their limits.
    third_harmonic : float
        Its ratio to the sine.
    noise : float
        Its standard deviation in displacement and force, in shares of their amplitudes.
    samples : int
        A cycle.
    seed : int
        Of the noise.

    Returns
    -------
    Synthetic
        Displacement, force, normal load, and what the joint itself moved.
    """
    from scipy.optimize import brentq

    phase = 2.0 * math.pi * np.arange(1, 2 * samples + 1) / samples
    wanted = amplitude * (np.sin(phase) + third_harmonic * np.sin(3.0 * phase))
    limit = joint.force_limit
    reach = 1.01 * limit / rig_stiffness
    state = joint.start()
    slip, held = np.empty_like(wanted), np.empty_like(wanted)
    for index, x in enumerate(wanted.tolist()):

        def miss(u: float, x: float = x) -> float:
            return state.try_(u)[0] - rig_stiffness * (x - u)

        slip[index] = brentq(miss, x - reach, x + reach, xtol=1e-16)
        held[index], _ = state.try_(float(slip[index]))
        state.commit()
    # The load ripples with the force. What that adds to the force the rig gives way to, as well:
    # the transducer follows the joint, not the other way round.
    load = joint.normal_load * (1.0 + load_ripple * held / limit)
    force = joint.coupled_force(slip, normal_load=load)
    displacement = slip + force / rig_stiffness
    draw = np.random.default_rng(seed).standard_normal((2, wanted.size))
    return Synthetic(
        displacement + noise * amplitude * draw[0], force + noise * limit * draw[1], load, slip
    )


def _assumed(more: str) -> str:
    """What the figures of the rig assume."""
    return worked_out(
        f"Synthetic: the model on a rig of {RIG / KILO**2:g} N/µm in series (assumed), load ripple "
        "2 % in step with the force, third harmonic 5 %, noise "
        f"{100.0 * NOISE:g} % of the amplitudes (assumed). {more}"
    )


def normalised(plate: Plate) -> Drawn:
    """Fig. 19.7."""
    top = 4e-5
    figure, body = plate.page(4.6)
    axes = body.subplots()
    columns: dict[str, Floats] = {}
    for seed, (load, color, line) in enumerate(
        zip((500.0, 1000.0, 2000.0, 5000.0), COLORS, LINES, strict=False)
    ):
        record = synthetic_record(worked_example(load), top, seed=seed)
        x, force = record.displacement[SAMPLES:], record.force[SAMPLES:]
        columns[f"displacement at {load:g} N [m]"] = x
        columns[f"force at {load:g} N [N]"] = force
        axes.plot(
            x / MICRO, force / load, color=color, linestyle=line, linewidth=1.1,
            label=engineering(load, "N", trim=True),
        )  # fmt: skip
    joint = worked_example()
    for sign, text in ((1.0, "μ"), (-1.0, "−μ")):
        place = sign * joint.friction_coefficient
        axes.axhline(place, color=LIGHT, linestyle=DASHES, linewidth=0.9, zorder=1)
        words(axes, text, 43.5, place, color=GREY)
    cross(axes)
    axes.set(
        xlabel="Displacement at the transducer [µm]", ylabel="Tangential over normal load T/N [–]"
    )
    axes.set_xlim(-46.0, 46.0)
    axes.set_ylim(-0.68, 0.68)
    words(axes, "synthetic", -45.0, 0.62, ha="left", color=GREY, fontstyle="italic")
    body.legend(loc="outside lower center", ncols=4, title="Static normal load N")
    return Drawn(figure, columns)


def series_loop(joint: Interface, amplitude: float, rig_stiffness: float) -> tuple[Floats, Floats]:
    """The model's loop with the rig in series, at constant load: displacements and forces."""
    from scipy.optimize import brentq

    def miss(u: float) -> float:
        return u + float(joint.backbone(u)) / rig_stiffness - amplitude

    loop = joint.loop(float(brentq(miss, 0.0, amplitude, xtol=1e-16)), samples=20001)
    return loop.displacement + loop.force / rig_stiffness, loop.force


def overlay(plate: Plate) -> Drawn:
    """Fig. 19.22."""
    joint, top = worked_example(), 2e-5
    record = synthetic_record(joint, top)
    # A cycle that begins at its largest displacement: down to the middle, then up.
    turn = SAMPLES // 4
    x, force = (v[turn - 1 : turn + SAMPLES] for v in (record.displacement, record.force))
    largest = 0.95 * top  # of a sine with 5 % of its third harmonic
    place, model = series_loop(joint, largest, RIG)
    down = int(np.argmin(place)) + 1
    half = SAMPLES // 2 + 1
    theory = np.concatenate(
        (
            np.interp(-x[:half], -place[:down], model[:down]),
            np.interp(x[half:], place[down - 1 :], model[down - 1 :]),
        )
    )
    rest = force - theory
    lost = (
        float(np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(v))) for v, f in ((x, force), (place, model))
    )
    figure, body = plate.page(5.6)
    above, below = body.subplots(2, 1, sharex=True, height_ratios=[2.2, 1.0])
    above.plot(
        x / MICRO, force / KILO, "o", color=BLUE, markersize=3.0, markerfacecolor="none",
        markeredgewidth=0.7, label="synthetic record",
    )  # fmt: skip
    above.plot(place / MICRO, model / KILO, color=INK, label="the model and the rig in series")
    alone = joint.loop(float(np.max(place - model / RIG)), samples=2001)
    above.plot(
        alone.displacement / MICRO, alone.force / KILO, color=RED, linestyle=DOTS, linewidth=1.6,
        label="the joint alone",
    )  # fmt: skip
    for part, color, marker, name in (
        (slice(half), BLUE, "o", "residual, unloading"),
        (slice(half - 1, None), RED, "^", "residual, reloading"),
    ):
        below.plot(
            x[part] / MICRO, rest[part], marker, color=color, markersize=2.6,
            markerfacecolor="none", markeredgewidth=0.6, label=name,
        )  # fmt: skip
    for axes in (above, below):
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    above.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)
    measured, closed = (f"{v / MILLI:.2f} mJ" for v in lost)
    words(above, f"lost in a cycle:\nrecord {measured}\nmodel {closed}", 0.0, -0.1)
    above.set(ylabel="Tangential force T [kN]")
    below.set(xlabel="Displacement at the transducer [µm]", ylabel="Residual [N]")
    body.align_ylabels([above, below])
    body.legend(loc="outside lower center", ncols=3)
    columns = {
        "displacement [m]": x,
        "synthetic force [N]": force,
        "force of model and rig [N]": theory,
        "residual [N]": rest,
    }
    return Drawn(figure, columns)


PLATES = (
    Plate(
        "19.7",
        "normalised-loops",
        "normalised force against displacement (synthetic)",
        "All loads slide at the same μ, 2 % above μ and −μ: the ripple of the load. What "
        "differs is how far the oblique parts reach, and these are the rig's, force over its "
        "stiffness. The contact alone would turn over within a micrometre.",
        _assumed("A sine of 40 µm, 38 µm with its harmonic; other loads: the same surface."),
        normalised,
    ),
    Plate(
        "19.22",
        "measured-and-model",
        "a record over the model (synthetic)",
        "Model and rig in series at constant load, over a record that has the rig's faults as "
        "well; nothing is fitted. What stays is noise and, where the joint slides, the ripple of "
        "the load: 2 % of μN, upwards both ways.",
        _assumed("A sine of 20 µm, 19 µm with its harmonic; second cycle."),
        overlay,
    ),
)
