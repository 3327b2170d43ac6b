"""Figures 19.6 and 19.18 of the chapter: roughness of a surface, and heights of its summits."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import SubFigure
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.chapter.plate import (
    BLUE,
    GREY,
    HATCH,
    INK,
    MICRO,
    MILLI,
    RED,
    SLIP,
    STICK,
    STROKE,
    Columns,
    as_plate,
    words,
)
from microslip.contact import GreenwoodWilliamson
from microslip.contact.heights import Gaussian
from microslip.contact.materials import Material, MaterialPair
from microslip.friction import Interface

SPREAD = 5e-7
ROUGHNESS = 4.5e-7
CORRELATION = 4.3e-5
STEP, LENGTH = 1e-6, 8e-3


def worked_example(normal_load: float = 2000.0) -> Interface:
    """Return the chapter's Al 2017 joint, with assumptions where the chapter gives no value."""
    aluminium = Material(young_modulus=69e9, poisson_ratio=0.33)
    surface = GreenwoodWilliamson(
        MaterialPair(aluminium, aluminium), Gaussian(SPREAD), radius=1e-3, density=1e8, area=2e-4
    )
    return Interface(surface, friction_coefficient=0.55, normal_load=normal_load)


def _heights_assumed() -> str:
    joint = worked_example()
    return (
        f"Gaussian summit heights, σ = {engineering(SPREAD, 'm')}, mean 0; at "
        f"N = {engineering(joint.normal_load, 'N')} the separation of the worked example (Al 2017, "
        f"ρ = 1 mm, 1e8 summits per m² on 2 cm²) is δn = {engineering(joint.separation, 'm')}."
    )


@as_plate(
    "19.18",
    3.7,
    "(a) normal distribution of summit heights, (b) its distribution function",
    "The summits above the separation δn are in contact: the hatched area in (a), one "
    "minus the value in (b).",
    _heights_assumed(),
)
def _gaussian_heights(body: SubFigure) -> Columns:
    joint, law = worked_example(), Gaussian(SPREAD)
    d = joint.separation
    share = float(law.probability_above(d))
    y = np.union1d(np.linspace(-3.5, 3.5, 701) * SPREAD, [d])
    density, below = law.pdf(y), law.cdf(y)
    density_axes, right = body.subplots(1, 2)
    density_axes.plot(y / MICRO, density * MICRO, color=BLUE, linewidth=1.8)
    touching = y >= d
    density_axes.fill_between(
        y[touching] / MICRO,
        density[touching] * MICRO,
        linewidth=0.0,
        facecolor=SLIP,
        edgecolor=HATCH,
        hatch="///",
    )
    density_axes.axvline(d / MICRO, color=GREY, linestyle=STROKE, linewidth=1.0)
    words(density_axes, f"{100.0 * share:.1f} % of the\nsummits touch", 1.12, 0.42)
    density_axes.set(ylabel="Probability density φ [1/µm]", title="(a)")
    density_axes.set_ylim(0.0, 0.95)
    right.plot(y / MICRO, below, color=BLUE, linewidth=1.8)
    right.axvline(d / MICRO, color=GREY, linestyle=STROKE, linewidth=1.0)
    right.plot([y[0] / MICRO, d / MICRO], [1.0 - share] * 2, color=GREY, linewidth=0.9)
    words(right, f"{100.0 * (1.0 - share):.1f} %", -1.2, 1.0 - share + 0.06)
    right.set(ylabel="Distribution function Φ [–]", title="(b)")
    right.set_ylim(0.0, 1.05)
    for axes in (density_axes, right):
        axes.set(xlabel="Height of a summit y [µm]")
        axes.set_xlim(y[0] / MICRO, y[-1] / MICRO)
        axes.annotate(
            r"$\delta_n$", (d / MICRO, 1.0), (5, -4), xycoords=axes.get_xaxis_transform(),
            textcoords="offset points", ha="left", va="top", color=GREY,
        )  # fmt: skip
    columns = {"height [m]": y, "density [1/m]": density, "distribution function": below}
    return columns


def synthetic_profile(seed: int = 19) -> tuple[Floats, Floats]:
    """Return a rough profile: positions and heights above the mean line [m].

    White noise filtered by a Gaussian window: heights are normal with the root mean square
    ROUGHNESS and the autocorrelation exp(-x^2/CORRELATION^2).
    """
    reach = round(3.0 * CORRELATION / STEP)
    window = np.exp(-2.0 * (STEP * np.arange(-reach, reach + 1) / CORRELATION) ** 2)
    window *= ROUGHNESS / math.sqrt(float(np.sum(window**2)))
    count = round(LENGTH / STEP) + 1
    noise = np.random.default_rng(seed).standard_normal(count + 2 * reach)
    z: Floats = np.convolve(noise, window, mode="valid")
    z -= z.mean()
    x: Floats = STEP * np.arange(float(count))
    return x, z


def summits() -> tuple[float, float, float]:
    """Return density [1/m^2], radius [m] and height spread [m] of the summits of the surface.

    The surface is isotropic and has the autocorrelation of the profile. The summits follow from its
    spectral moments m0, m2 and m4 (Nayak 1971, McCool 1986).
    """
    m0 = ROUGHNESS**2
    m2, m4 = 2.0 * m0 / CORRELATION**2, 12.0 * m0 / CORRELATION**4
    return (
        m4 / (6.0 * math.pi * math.sqrt(3.0) * m2),
        0.375 * math.sqrt(math.pi / m4),
        math.sqrt((1.0 - 0.8968 * m2**2 / (m0 * m4)) * m0),
    )


def is_peak(z: Floats) -> NDArray[np.bool_]:
    """Return a mask of the local maxima of a profile."""
    inner = (z[1:-1] > z[:-2]) & (z[1:-1] >= z[2:])
    return np.concatenate([[False], inner, [False]])


def peak_density(z: Floats) -> Floats:
    """Return the probability density [1/m] of the peaks of the profile at heights [m].

    The density is that of Cartwright and Longuet-Higgins (1956), DOI 10.1098/rspa.1956.0173. Its
    parameter m2/sqrt(m0 m4) is 1/sqrt(3) for the autocorrelation exp(-x^2/CORRELATION^2).
    """
    ratio = 1.0 / math.sqrt(3.0)
    width = math.sqrt(1.0 - ratio**2)
    x = z / ROUGHNESS
    narrow = width / math.sqrt(2.0 * math.pi) * np.exp(-0.5 * (x / width) ** 2)
    below: Floats = Gaussian(1.0).cdf(x * ratio / width)
    return (narrow + ratio * x * np.exp(-0.5 * x**2) * below) / ROUGHNESS


def _assumed_profile() -> str:
    density, radius, spread = summits()
    return (
        f"Synthetic, no measurement: Gaussian heights, Rq = {engineering(ROUGHNESS, 'm')}, so "
        f"Ra = {engineering(ROUGHNESS * math.sqrt(2.0 / math.pi), 'm')}; autocorrelation "
        f"exp(−x²/β²), β = {engineering(CORRELATION, 'm')}; 8 mm in steps of 1 µm. An "
        f"isotropic surface with this profile has {density:.2g} summits per m², of radius "
        f"{engineering(radius, 'm')} and σ = {engineering(spread, 'm')} (Nayak 1971, McCool 1986)."
    ).replace("e+07", "e7")


@as_plate(
    "19.6",
    3.7,
    "(a) roughness of the surface, (b) probability of asperity heights (synthetic)",
    "A profile as rough as the chapter's milled sample, whose Ra is below 0.4 µm. The asperities "
    "in (b) are the peaks of the profile, above its mean line on average; the heights of all its "
    "points, dashed, are Gaussian about that line. Such a surface has as many summits as the "
    "worked example; they are somewhat sharper, and their heights spread a quarter less.",
    _assumed_profile(),
)
def _roughness(body: SubFigure) -> Columns:
    x, z = synthetic_profile()
    edges = np.linspace(-1.6e-6, 1.6e-6, 17)
    peaks = is_peak(z)
    counts, _ = np.histogram(z[peaks], edges)
    density = counts / peaks.sum() / np.diff(edges)
    law = Gaussian(ROUGHNESS)
    percent = 100.0 * MICRO  # from 1/m to % per micrometre
    profile_axes, right = body.subplots(1, 2, sharey=True, width_ratios=[2.2, 1.0])
    profile_axes.plot(x / MILLI, z / MICRO, color=BLUE, linewidth=0.9)
    profile_axes.plot(
        x[peaks] / MILLI, z[peaks] / MICRO, "o", color=RED, markersize=2.6, label="peaks"
    )
    profile_axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    average = float(np.mean(np.abs(z)))
    words(profile_axes, f"this trace: Ra = {average / MICRO:.2f} µm", 4.0, 1.5)
    profile_axes.set(xlabel="Position along the surface [mm]", ylabel="Height [µm]", title="(a)")
    profile_axes.set(xlim=(0.0, LENGTH / MILLI), ylim=(-1.7, 1.7))
    right.stairs(
        density * percent, edges / MICRO, orientation="horizontal", fill=True, facecolor=STICK,
        edgecolor=BLUE, linewidth=0.8, label=f"the {peaks.sum()} peaks of this trace",
    )  # fmt: skip
    y = np.linspace(edges[0], edges[-1], 401)
    right.plot(
        peak_density(y) * percent, y / MICRO, color=INK, linewidth=1.4, label="peaks of many"
    )
    right.plot(
        law.pdf(y) * percent, y / MICRO, color=GREY, linewidth=1.0, linestyle=STROKE,
        label="all heights",
    )  # fmt: skip
    right.set(xlabel="Probability density [%/µm]", title="(b)")
    right.set_xlim(left=0.0)
    handles, labels = profile_axes.get_legend_handles_labels()
    more_handles, more_labels = right.get_legend_handles_labels()
    body.legend(handles + more_handles, labels + more_labels, loc="outside lower center", ncols=4)
    columns = {
        "position [m]": x,
        "height [m]": z,
        "is a peak": peaks.astype(float),
        "density of peaks at this height [1/m]": peak_density(z),
        "density of heights at this height [1/m]": law.pdf(z),
    }
    return columns
