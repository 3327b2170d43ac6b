"""Figures 19.7 and 19.22 of the chapter: records of a virtual tribometer.

The tribometer resembles that in section 2.1 of the chapter.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from matplotlib.figure import SubFigure

from microslip._core.checks import Floats
from microslip._core.units import engineering, significant
from microslip.chapter.joint import joint_note as worked_out
from microslip.chapter.plate import (
    BLUE,
    DOTS,
    GREY,
    INK,
    KILO,
    LIGHT,
    MICRO,
    MILLI,
    PENS,
    RED,
    STROKE,
    Columns,
    as_plate,
    cross,
    words,
)
from microslip.chapter.surface import worked_example
from microslip.friction import Interface
from microslip.identification import Identification, identify
from microslip.laboratory import VirtualTribometer

RIG = 1e8
NOISE = 0.005
RIPPLE = 0.02
HARMONIC = 0.05
SAMPLES = 256
"""Samples per cycle."""
_FREQUENCY = 10.0
OVERLAY, CYCLES = 2e-5, 6
"""Amplitude [m] and cycles of the record of Fig. 19.22."""
RIG_ERROR = 0.02
"""Relative standard error of the rig stiffness."""
NOISY = "#e6e6e6"


def virtual_rig(joint: Interface, seed: int = 0) -> VirtualTribometer:
    """Return a simulation of a tribometer like that of the chapter, with ``joint``.

    The rig stiffness, the noise, the ripple of the load and the third harmonic of the motion are
    assumed values.
    """
    return VirtualTribometer(
        joint,
        rig_stiffness=RIG,
        noise=NOISE,
        load_ripple=RIPPLE,
        third_harmonic=HARMONIC,
        sample_rate=SAMPLES * _FREQUENCY,
        seed=seed,
    )


def _assumed(addition: str) -> str:
    return worked_out(
        f"Synthetic: a virtual tribometer, rig of {RIG / KILO**2:g} N/µm in series, load ripple "
        f"{100.0 * RIPPLE:g} % in step with the force, third harmonic {100.0 * HARMONIC:g} %, "
        f"noise {100.0 * NOISE:g} % of the amplitudes (all assumed). {addition}"
    )


@as_plate(
    "19.7",
    4.6,
    "normalised force against displacement (synthetic)",
    "At all loads gross slip has the same T/N, here 2 % beyond μ and −μ because of the ripple of "
    "the load. The oblique parts, which differ in length, are the deflection of the rig. The "
    "contact alone would reach gross slip within a micrometre.",
    _assumed("Amplitude 40 µm, 10 Hz; other loads: the same surface."),
)
def _normalised_loops(body: SubFigure) -> Columns:
    top = 4e-5
    axes = body.subplots()
    columns: dict[str, Floats] = {}
    for seed, (load, look) in enumerate(zip((500.0, 1000.0, 2000.0, 5000.0), PENS, strict=False)):
        rig = virtual_rig(worked_example(load), seed)
        record = rig.record(amplitude=top, frequency=_FREQUENCY, cycles=1)
        # From peak to peak, without the initial loading.
        x, force = record.displacement[-SAMPLES - 1 :], record.force[-SAMPLES - 1 :]
        columns[f"displacement at {load:g} N [m]"] = x
        columns[f"force at {load:g} N [N]"] = force
        label = engineering(load, "N", trim=True)
        axes.plot(x / MICRO, force / load, linewidth=1.1, label=label, **look)
    joint = worked_example()
    for sign, text in ((1.0, "μ"), (-1.0, "−μ")):
        place = sign * joint.friction_coefficient
        axes.axhline(place, color=LIGHT, linestyle=STROKE, linewidth=0.9, zorder=1)
        words(axes, text, 43.5, 0.88 * place, color=GREY)
    cross(axes)
    axes.set(
        xlabel="Displacement at the transducer [µm]", ylabel="Tangential over normal load T/N [–]"
    )
    axes.set(xlim=(-46.0, 46.0), ylim=(-0.68, 0.68))
    words(axes, "synthetic", -45.0, 0.62, ha="left", color=GREY, fontstyle="italic")
    body.legend(loc="outside lower center", ncols=4, title="Static normal load N")
    return columns


@lru_cache(maxsize=1)
def identified() -> Identification:
    """Return the worked example's joint as identified from one synthetic record.

    The rig stiffness is taken as measured with the relative standard error RIG_ERROR.
    """
    rig = virtual_rig(worked_example(), seed=19)
    record = rig.record(amplitude=OVERLAY, frequency=_FREQUENCY, cycles=CYCLES)
    return identify(record, law="interface", rig_stiffness=(RIG, RIG_ERROR * RIG))


@as_plate(
    "19.22",
    5.8,
    "a record over the model (synthetic)",
    "The law of the joint and the rig in series, fitted to one record at one load; the joint "
    "alone follows from the stiffness of the rig, which is given to 2 %. The interval of the "
    "friction coefficient is narrow. The slip scale is only bounded, because the rig is softer "
    "than the joint by a factor of 57; a second load or a stiffer rig would determine it. The fit "
    "includes the ripple of the load: the residual is noise (reduced χ² 1.09), as it is with a rig "
    "of 10 000 N/µm and 1.5 µm, where the ripple bends the branches.",
    _assumed(
        f"Amplitude {OVERLAY / MICRO:g} µm, {_FREQUENCY:g} Hz, {CYCLES} cycles, the first left out."
    ),
)
def _measured_and_model(body: SubFigure) -> Columns:
    result = identified()
    record = result.records[0]
    x, force, model, residual = record.displacement, record.measured, record.model, record.residual
    above, below = body.subplots(2, 1, sharex=True, height_ratios=[2.2, 1.0])
    above.plot(
        x / MICRO, force / KILO, "o", color=BLUE, markersize=3.0, markerfacecolor="none",
        markeredgewidth=0.7, label="synthetic record, mean cycle",
    )  # fmt: skip
    closed = np.append(np.arange(x.size), 0)
    above.plot(
        x[closed] / MICRO, model[closed] / KILO, color=INK, label="fitted law, rig in series"
    )
    middle = 0.5 * float(model.max() + model.min())
    above.plot(
        (x - (model - middle) / RIG)[closed] / MICRO, model[closed] / KILO, color=RED,
        linestyle=DOTS, linewidth=1.6, label="the joint alone",
    )  # fmt: skip
    rising = np.gradient(x) > 0.0
    for part, color, marker, name in (
        (~rising, BLUE, "o", "residual, unloading"),
        (rising, RED, "^", "residual, reloading"),
    ):
        below.plot(
            x[part] / MICRO, residual[part], marker, color=color, markersize=2.6,
            markerfacecolor="none", markeredgewidth=0.6, label=name,
        )  # fmt: skip
    band = 2.0 * float(np.median(record.error))
    below.axhspan(-band, band, facecolor=NOISY, edgecolor="none", zorder=0, label="noise, ±2σ")
    for axes in (above, below):
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    above.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)
    words(above, _identified_text(result), -20.8, 0.96, ha="left", va="top")
    energy = result.dissipated_energy(result.amplitudes[1])
    ends = " … ".join(f"{v / MILLI:.1f}" for v in (energy.low, energy.high))
    text = f"energy per cycle:\nrecord {record.measured_energy / MILLI:.1f} mJ\njoint {ends} mJ"
    words(above, text, 20.8, -0.8, ha="right")
    above.set(ylabel="Tangential force T [kN]")
    below.set(xlabel="Displacement at the transducer [µm]", ylabel="Residual [N]")
    body.align_ylabels([above, below])
    body.legend(loc="outside lower center", ncols=3)
    columns = {
        "displacement [m]": x,
        "synthetic force [N]": force,
        "force of model and rig [N]": model,
        "residual [N]": residual,
    }
    return columns


def _identified_text(result: Identification) -> str:
    lines = []
    for name, symbol, unit, scale in (
        ("friction_coefficient", "μ", "", 1.0),
        ("slip_scale", "κσ", " nm", 1e-9),
        ("standardised_separation", "h", "", 1.0),
    ):
        number = result.parameters[name]
        ends = [significant(end / scale, 3) for end in (number.low, number.high)]
        if number.verdict == "identified":
            ends = [significant(end / scale, 4) for end in (number.low, number.high)]
            lines.append(f"{symbol}: {' … '.join(ends)}{unit}")
        else:
            lines.append(f"{symbol}: {number.verdict}")
    truth = f"made with μ {worked_example().friction_coefficient:g},\nrig {MICRO * RIG:g} N/µm"
    return "\n".join(["95 % intervals:", *lines, truth])
