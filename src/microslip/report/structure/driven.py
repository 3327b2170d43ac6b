"""Results of a structure that is driven: by a harmonic force, on a moving ground, by shocks."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.netcdf import Variable
from microslip._core.quantities import QUANTITIES, json_value, named
from microslip._core.units import engineering, prefix
from microslip.figures.kit import between, look_of
from microslip.figures.picture import Picture
from microslip.figures.plot import COLORS, DASHED, Axis, Entry, Panel, Plot, stacked
from microslip.report import cells
from microslip.report.document import Block, Column, Facts, Note, Section, Table, Verdicts
from microslip.report.structure.pictures import PALE
from microslip.runs.structure_prediction import (
    ForcedMode,
    ShakenBands,
    Shaking,
    StructurePrediction,
    Sweep,
)
from microslip.structures.forced import response_columns

FORCED_FIGURE = "forced_response"
"""Name of the figure."""
RESPONSES = "frf.uff"
"""Universal file of the responses over the force."""
FORCED_TABLES = ("forced_response", "frf")
"""Names of the CSV files: near each mode with bands, and of all modes together."""


def forced_columns(
    prediction: StructurePrediction,
) -> tuple[dict[str, dict[str, Floats]], dict[str, str]]:
    """Columns of the CSV files, and the units that depend on what the sensor measures."""
    responses = prediction.frequency_responses
    unit = prediction.part.unit
    units = dict.fromkeys(("amplitude", *_BAND), unit)
    if not responses:
        return {}, units
    over_force = response_columns(responses)
    parts = []
    for mode in prediction.modes:
        for forced in mode.forced:
            size = forced.frequency.size
            bands = np.full((3, size), math.nan) if forced.bands is None else forced.bands
            parts.append(
                {
                    "mode": np.full(size, float(mode.number)),
                    "force_amplitude": np.full(size, forced.force),
                    "frequency": forced.frequency,
                    "amplitude": forced.response,
                    **(dict(zip(_BAND, bands, strict=True)) if prediction.inputs else {}),
                }
            )
    near = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    frf = {name: values for name, (_, values) in over_force.items()}
    units |= {name: unit for name, (unit, _) in over_force.items()}
    return dict(zip(FORCED_TABLES, (near, frf), strict=True)), units


_BAND = ("amplitude_low", "amplitude_median", "amplitude_high")


def response_numbers(forced: ForcedMode) -> dict[str, Any]:
    """A response near a mode in the summary."""
    result: dict[str, Any] = {
        "force": forced.force,
        "peak": dict(zip(("amplitude", "frequency"), json_value(forced.peak), strict=True)),
        **json_value(named(forced, "largest_force", "frequency")),
        "amplitude": json_value(forced.response),
    }
    if forced.bands is not None and forced.peak_bands is not None:
        result["amplitude_bands"] = json_value(forced.bands)
        result["peak_bands"] = dict(
            zip(("amplitude", "frequency"), json_value(forced.peak_bands.T), strict=True)
        )
        result["sampling_error"] = json_value(forced.error)
        result["beyond"] = forced.beyond
    return result


def force_section(prediction: StructurePrediction) -> Section:
    """Peaks of the response to each force, with their bands."""
    unit = prediction.part.unit
    listed = [
        Column("mode", "Mode"),
        Column("force", "Force", "N", 3),
        Column("peak_amplitude", "Peak at the sensor", unit, 3),
        Column("peak_frequency", "at", "Hz", write=lambda f: f"{f:.5g}"),
    ]
    modes = [(mode, forced) for mode in prediction.modes for forced in mode.forced]
    banded = any(forced.peak_bands is not None for _, forced in modes)
    if banded:
        listed += [Column("peak_low", "Peak, 5 %", unit, 3), Column("peak_high", "95 %", unit, 3)]
    rows = []
    remarks = [
        "Near each resonance by its modal curve; other modes are left out here, and where a "
        "frequency has several motions the largest is given. Over the force, with the other modes "
        "linear: frf.csv."
    ]
    for mode, forced in modes:
        ends = [] if forced.peak_bands is None else forced.peak_bands[[0, 2], 0].tolist()
        ends += [math.nan] * (2 * banded - len(ends))
        rows.append(
            (mode.number, forced.force, *json_value(forced.peak), *json_value(np.array(ends)))
        )
        name = f"Mode {mode.number} under {engineering(forced.force, 'N', 3)}"
        if not np.isfinite(forced.peak[0]):
            most = engineering(forced.largest_force, "N", 2)
            remarks.append(
                f"{name} moves beyond the largest amplitude, which about {most} reach: give a "
                "larger amplitude.to."
            )
        elif forced.beyond:
            remarks.append(
                f"{name}: {forced.beyond:.0%} of the samples move beyond the largest amplitude, "
                "which replaces theirs: the bands end there; give a larger amplitude.to."
            )
        if np.isfinite(forced.error):
            remarks.append(
                f"{name}: the sampling error of the quantiles of the peak is at most "
                f"±{forced.error:.1%} (90 %)."
            )
    table = Table("Response to the force", tuple(listed), tuple(rows), noun="peaks")
    return Section("Response to the force", (table, Note(" ".join(remarks), small=True)))


def force_plot(prediction: StructurePrediction) -> Plot:
    """Amplitude at the sensor against the frequency of the force, a panel a mode."""
    si = prediction.part.unit.replace("^2", "²")
    panels, legend = [], []
    for mode in prediction.modes:
        highest = [forced.response for forced in mode.forced]
        highest += [forced.bands[2] for forced in mode.forced if forced.bands is not None]
        unit, letter = prefix(float(np.nanmax(np.concatenate(highest), initial=0.0)) or 1.0)
        panel = Panel(
            Axis("Frequency of the force [Hz]", margin=0.0),
            Axis(f"Amplitude at the sensor [{letter}{si}]", log=True),
            note=f"Mode {mode.number}",
        )
        for index, forced in enumerate(mode.forced):
            if forced.bands is not None:
                low, high = forced.bands[[0, 2]] / unit
                pale = PALE[index % len(PALE)]
                panel.add(between(forced.frequency, low, high, pale))
        for index, forced in enumerate(mode.forced):
            look = look_of(index)
            panel.line(forced.frequency, forced.response / unit, look.color, dash=look.dash)
        panels.append(panel)
    for index, force in enumerate(prediction.part.force.amplitude if prediction.part.force else ()):
        look = look_of(index)
        scale, letter = prefix(force)
        legend.append(Entry(f"{force / scale:g} {letter}N", look.color, look.dash))
    return stacked(panels, 2.9 * len(panels) + 0.5, legend=legend)


FIGURES = {"base": "transmissibility", "random": "response_spectrum", "shock": "shock_peaks"}
"""Names of the figures, by the table of the study that asks for them."""


def _acceleration(value: float) -> str:
    return f"{value:.3g} m/s²"


def sections(shaking: Shaking) -> list[Section]:
    """The parts of a document."""
    parts = []
    if shaking.sweeps:
        parts.append(Section("On a shaker", _sweeps(shaking)))
    if shaking.noise is not None:
        parts.append(Section("Random vibration", _noise(shaking)))
    if shaking.shocks:
        parts.append(Section("Under shocks", _shocks(shaking)))
    if shaking.bands is not None:
        parts.append(Section("Bands under base motion", _bands(shaking.bands)))
    return parts


def _sweeps(shaking: Shaking) -> tuple[Block, ...]:
    listed = (
        Column("sweep_level", "Level held", "m/s^2", 3),
        Column("sweep_frequency", "Resonance", "Hz", write=lambda f: f"{f:.5g}"),
        Column("transmissibility", "Transmissibility", "", 3),
        Column("sensor_acceleration", "Sensor", "m/s^2", 3),
        Column("base_acceleration", "Ground", "m/s^2", 3),
        Column("base_force", "Force on the ground", "N", 3),
    )
    rows = []
    for sweep in shaking.sweeps:
        columns = _of_sweep(sweep)
        rows.append(tuple(float(columns[column.key][sweep.peak]) for column in listed))
    folds = [s for s in shaking.sweeps if not bool(s.response.stable.all())]
    text = (
        "Resonance is where the transmissibility is largest: the absolute motion of the sensor "
        "over that of the ground. Damping is that of steady motion."
    )
    if folds:
        text += (
            f" {len(folds)} of {len(shaking.sweeps)} response curves fold over: at a controlled "
            "acceleration of the ground the dashed branches are unstable."
        )
    text += "".join(
        f" At {_acceleration(s.level)}: {s.response.message}."
        for s in shaking.sweeps
        if s.response.status != "solved"
    )
    return Table("Resonances", listed, tuple(rows), noun="sweeps"), Note(text, small=True)


def _noise(shaking: Shaking) -> tuple[Block, ...]:
    noise = shaking.noise
    assert noise is not None  # who calls has looked
    at = shaking.sensor
    modes = zip(noise.frequency, noise.damping_ratio, strict=True)
    rows = (
        ("Standard deviation of the displacement, relative to the ground",
         engineering(noise.standard_deviation(at), "m", 3)),
        ("Standard deviation of the acceleration",
         _acceleration(noise.standard_deviation(at, "acceleration"))),
        (f"Expected largest acceleration in {shaking.duration:g} s",
         _acceleration(noise.peak(at, shaking.duration, "acceleration"))),
        ("Equivalent linear modes",
         ", ".join(f"{f:.5g} Hz at {cells.ratio(float(z))}" for f, z in modes)),
        ("Power dissipated by the joints",
         engineering(float(np.nansum(noise.joint_power)), "W", 3)),
    )  # fmt: skip
    judged = Verdicts(noise.verdicts, caption=f"Statistical linearisation: {noise.message}.")
    return Facts("At the sensor", rows), judged


def _shocks(shaking: Shaking) -> tuple[Block, ...]:
    listed = (
        Column("severity", "Pulse", "m/s^2", 3),
        Column("peak_displacement", "Largest displacement, relative to the ground", "m", 3),
        Column("peak_acceleration", "Largest acceleration", "m/s^2", 3),
    )
    rows = tuple(zip(*(json_value(column) for column in _of_shocks(shaking).values()), strict=True))
    stopped = "".join(f" {s.message}." for s in shaking.shocks if s.status != "solved")
    text = f"By time integration with the states of the joints.{stopped}"
    return Table("Peaks at the sensor", listed, rows, noun="pulses"), Note(text, small=True)


def _bands(bands: ShakenBands) -> tuple[Block, ...]:
    def band(values: Floats, write: Callable[[float], str], unit: str = "") -> str:
        low, middle, high = (write(float(value)) for value in values)
        return f"{low} to {high}{unit}, median {middle}{unit}"

    def hertz(value: float) -> str:
        return f"{value:.5g}"

    rows = []
    for level, of in bands.sweeps:
        at = f"at {_acceleration(level)}"
        rows += [
            (f"Resonance {at}", band(of["resonance"], hertz, " Hz")),
            (f"Damping ratio {at}", band(of["damping_ratio"], cells.ratio)),
            (f"Transmissibility {at}", band(of["transmissibility"], lambda x: f"{x:.3g}")),
        ]
    if of := bands.noise:
        rows += [
            ("Frequency in noise", band(of["equivalent_frequency"], hertz, " Hz")),
            ("Damping ratio in noise", band(of["equivalent_damping_ratio"], cells.ratio)),
            ("Standard deviation of the displacement",
             band(of["displacement_deviation"], lambda x: engineering(x, "m", 3))),
            ("Standard deviation of the acceleration",
             band(of["acceleration_deviation"], _acceleration)),
        ]  # fmt: skip
    text = (
        "5 to 95 % of the uncertain inputs, by the modal curves of the samples: resonances in "
        "closed form, noise for the mode that moves most. Sampling error of the ends "
    )
    text += f"±{bands.error:.1%}." if math.isfinite(bands.error) else "unknown: too few samples."
    if bands.reached > 1.0:
        text += (
            " Some samples move beyond the modal curves, and results that need them are left out: "
            f"raise structure.amplitude.to by a factor of {1.1 * bands.reached:.2g}."
        )
    return Facts("At the sensor", tuple(rows)), Note(text, small=True)


def pictures(shaking: Shaking) -> list[Picture]:
    """The figures."""
    figures = {
        "base": (bool(shaking.sweeps), sweep_plot, "Transmissibility and acceleration of the "
                 "sensor against frequency, a line for each level; dashed: unstable at a "
                 "controlled acceleration of the ground.",
                 "Transmissibility of the structure on a shaker"),
        "random": (shaking.noise is not None, noise_plot, "Power spectral densities of the "
                   "accelerations of the sensor and of the ground, by the equivalent linear "
                   "structure.", "Spectrum of the response to noise"),
        "shock": (bool(shaking.shocks), shock_plot, "Largest displacement and acceleration at the "
                  "sensor against the peak of the pulse; dashed: proportional to the weakest.",
                  "Peaks under shocks against their severity"),
    }  # fmt: skip
    return [
        Picture(FIGURES[name], caption, partial(plot, shaking), alternative)
        for name, (there, plot, caption, alternative) in figures.items()
        if there
    ]


def sweep_plot(shaking: Shaking) -> Plot:
    """Transmissibilities and accelerations."""
    upper = Panel(Axis("Frequency [Hz]", margin=0.0), Axis("Transmissibility [–]", log=True))
    lower = Panel(
        Axis("Frequency [Hz]", margin=0.0), Axis("Acceleration of the sensor [m/s²]", log=True)
    )
    legend = []
    for index, sweep in enumerate(shaking.sweeps):
        look, stable = look_of(index), sweep.response.stable
        near = stable.copy()  # a stretch ends where the next one begins
        near[1:] |= stable[:-1]
        near[:-1] |= stable[1:]
        for panel, y in ((upper, sweep.transmissibility), (lower, sweep.acceleration)):
            x = sweep.response.frequency
            panel.line(x, np.where(near, y, np.nan), look.color)
            panel.line(x, np.where(stable, np.nan, y), look.color, width=0.9, dash=DASHED)
        legend.append(Entry(_acceleration(sweep.level), look.color))
    return stacked([upper, lower], 5.6, legend=legend)


def noise_plot(shaking: Shaking) -> Plot:
    """Spectra of the sensor and of the ground."""
    panel = Panel(
        Axis("Frequency [Hz]", log=True, margin=0.0),
        Axis("Spectral density [(m/s²)²/Hz]", log=True),
    )
    columns = _of_noise(shaking)
    panel.line(shaking.frequency, columns["sensor_density"], COLORS[1])
    panel.line(shaking.frequency, columns["ground_density"], COLORS[0], dash=DASHED)
    legend = (Entry("sensor", COLORS[1]), Entry("ground", COLORS[0], DASHED))
    return Plot([panel], 3.4, legend=legend)


def shock_plot(shaking: Shaking) -> Plot:
    """Peaks against severity."""
    columns = _of_shocks(shaking)
    x = columns["severity"]
    scale, letter = prefix(float(columns["peak_displacement"].max()))
    panels = []
    for label, y in (
        (f"Displacement [{letter}m]", columns["peak_displacement"] / scale),
        ("Acceleration [m/s²]", columns["peak_acceleration"]),
    ):
        panel = Panel(Axis("Peak of the pulse [m/s²]", low=0.0), Axis(label, low=0.0))
        order, weakest = np.argsort(x), int(np.argmin(x))
        ends = np.array([0.0, x.max()])
        panel.line(ends, ends * y[weakest] / x[weakest], COLORS[0], width=0.9, dash=DASHED)
        panel.line(x[order], y[order], COLORS[1])
        panel.marks(x, y, COLORS[1])
        panels.append(panel)
    return stacked(panels, 5.0)


def _of_sweep(sweep: Sweep) -> dict[str, Floats]:
    return {
        "sweep_level": np.full(sweep.response.frequency.size, sweep.level),
        "sweep_frequency": sweep.response.frequency,
        "transmissibility": sweep.transmissibility,
        "sensor_acceleration": sweep.acceleration,
        "base_acceleration": sweep.base_acceleration,
        "base_force": sweep.force,
        "lasts": sweep.response.stable.astype(float),
    }


def _of_noise(shaking: Shaking) -> dict[str, Floats]:
    assert shaking.noise is not None  # who calls has looked
    density = shaking.noise.spectrum(shaking.sensor, shaking.frequency, "acceleration")
    return {
        "noise_frequency": shaking.frequency,
        "ground_density": shaking.level,
        "sensor_density": density,
    }


def _of_shocks(shaking: Shaking) -> dict[str, Floats]:
    return {
        "severity": shaking.severity,
        "peak_displacement": shaking.peaks("displacement"),
        "peak_acceleration": shaking.peaks("acceleration"),
    }


def columns(shaking: Shaking) -> dict[str, dict[str, Floats]]:
    """Columns by the table of the study that asks for them, for CSV files."""
    parts: dict[str, dict[str, Floats]] = {}
    if shaking.sweeps:
        sweeps = [_of_sweep(sweep) for sweep in shaking.sweeps]
        parts["base"] = {n: np.concatenate([s[n] for s in sweeps]) for n in sweeps[0]}
    if shaking.noise is not None:
        parts["random"] = _of_noise(shaking)
    if shaking.shocks:
        parts["shock"] = _of_shocks(shaking)
    return parts


def numbers(shaking: Shaking) -> dict[str, Any]:
    """Summary in plain values, SI units."""
    result: dict[str, Any] = {}
    if shaking.sweeps:
        result["base"] = [
            {
                **{name: float(column[sweep.peak]) for name, column in _of_sweep(sweep).items()},
                "stable": bool(sweep.response.stable.all()),
                "message": sweep.response.message,
            }
            for sweep in shaking.sweeps
        ]
    if (noise := shaking.noise) is not None:
        at = shaking.sensor
        result["random"] = {
            "displacement_deviation": noise.standard_deviation(at),
            "acceleration_deviation": noise.standard_deviation(at, "acceleration"),
            "largest_acceleration": noise.peak(at, shaking.duration, "acceleration"),
            "equivalent_frequency": json_value(noise.frequency),
            "equivalent_damping_ratio": json_value(noise.damping_ratio),
            "joint_power": float(np.nansum(noise.joint_power)),
            "message": noise.message,
            "verdicts": [verdict._asdict() for verdict in noise.verdicts],
        }
    if shaking.shocks:
        result["shock"] = {name: json_value(column) for name, column in _of_shocks(shaking).items()}
    if (bands := shaking.bands) is not None:
        result["bands"] = {
            "base": [
                {"level": level, **{name: json_value(values) for name, values in of.items()}}
                for level, of in bands.sweeps
            ],
            "random": {name: json_value(values) for name, values in bands.noise.items()},
            "error": bands.error,
            "amplitude_reached": bands.reached,
        }
    return result


def labelled(shaking: Shaking | None) -> tuple[dict[str, int], dict[str, Variable]]:
    """Dimensions and variables."""
    dims: dict[str, int] = {}
    variables: dict[str, Variable] = {}
    for name, part in columns(shaking).items() if shaking is not None else ():
        dim = f"{name}_point"
        dims[dim] = next(iter(part.values())).size
        variables |= {
            n: Variable((dim,), np.ascontiguousarray(v), QUANTITIES[n].attributes)
            for n, v in part.items()
        }
    return dims, variables
