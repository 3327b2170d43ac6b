"""Measure the speed of microslip; `make bench` runs this.

    python benchmarks/run.py                a table of what is wanted and what is measured
    python benchmarks/run.py --json FILE    and the numbers as JSON
    python benchmarks/run.py --page       and the tables between the markers in docs/timings.md
    python benchmarks/run.py --strict       exit code 1 where something that is wanted is missed

One process, one thread, the best of several runs each. Beside the library stand two ways that know
nothing of the closed form: every asperity by itself (explicit_population.py), and Masing's rules
sample by sample in plain Python.
"""

from __future__ import annotations

import os

# Before NumPy loads: what is measured is one core.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
os.environ["MKL_NUM_THREADS"] = os.environ["VECLIB_MAXIMUM_THREADS"] = "1"

import argparse
import functools
import json
import math
import platform
import subprocess
import sys
import time
import timeit
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from explicit_population import ExplicitPopulation, gaussian_population
from numpy.typing import NDArray
from pages import write_section
from rough_faces import rough

import microslip as ms

Floats = NDArray[np.float64]

SAMPLES = 1_000_000
ASPERITIES = 100_000
SWEPT = 1_000_000  # points
SWEEP_WANTED = 2.0  # [s]
AMPLITUDE = 1e-6  # [m], nearly three times the slip scale of the joint: T/mu N reaches 0.9998


# -- what is measured -----------------------------------------------------------------------------


def make_surface(std: float = 5e-7) -> ms.GreenwoodWilliamson:
    """The milled Al 2017 surface of examples/al2017.toml."""
    al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
    return ms.GreenwoodWilliamson(
        ms.MaterialPair(al, al), ms.Gaussian(std=std), radius=1e-3, density=1e8, area=2e-4
    )


def sine(samples: int, samples_a_cycle: int) -> Floats:
    return AMPLITUDE * np.sin(2.0 * math.pi / samples_a_cycle * np.arange(1, samples + 1))


def gaussian_noise(samples: int) -> Floats:
    return 0.5 * AMPLITUDE * np.random.default_rng(1).standard_normal(samples)


def turning_noise(samples: int) -> Floats:
    """Noise of alternating sign: every sample is a reversal."""
    sizes = np.random.default_rng(2).uniform(0.05, 1.0, samples)
    return AMPLITUDE * sizes * np.where(np.arange(samples) % 2, -1.0, 1.0)


def turning_share(history: Floats) -> float:
    """Share of the samples at which a history turns."""
    way = np.sign(np.diff(history, prepend=0.0))
    return float(np.mean(way[1:] * way[:-1] < 0.0))


def naive_force(joint: ms.Interface, history: Floats) -> Floats:
    """Masing's and Madelung's rules as one first writes them: a list, a loop, one call a sample."""
    open_reversals: list[tuple[float, float]] = []
    last = force = 0.0
    way = 0
    forces = []
    for x in history.tolist():
        if x != last:
            before, way = way, 1 if x > last else -1
            if before not in (0, way):
                open_reversals.append((last, force))
            while len(open_reversals) > 1 and (x - open_reversals[-2][0]) * way >= 0.0:
                del open_reversals[-2:]
            if len(open_reversals) == 1 and abs(x) >= abs(open_reversals[0][0]):
                open_reversals.clear()
            if open_reversals:
                place, start = open_reversals[-1]
                force = start + 2.0 * way * joint.backbone(0.5 * abs(x - place))
            else:
                force = joint.backbone(x)
            last = x
        forces.append(force)
    return np.array(forces)


def explicit_population(joint: ms.Interface) -> ExplicitPopulation:
    """The same joint as so many asperities in contact, each of which stands for a few alike."""
    surface = joint.surface
    assert isinstance(surface, ms.GreenwoodWilliamson)
    assert joint.contact_count is not None
    heights, _ = gaussian_population(
        ASPERITIES, std=surface.heights.std, separation=joint.separation
    )
    return ExplicitPopulation.from_heights(
        heights,
        surface.radius,
        composite_modulus=surface.pair.composite_modulus,
        composite_shear_modulus=surface.pair.composite_shear_modulus,
        friction_coefficient=joint.friction_coefficient,
        separation=joint.separation,
        summits_per_height=joint.contact_count / ASPERITIES,
    )


# -- how it is measured ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    """One measured number: a time [s], or a rate [samples/s]."""

    task: str
    value: float
    rate: bool = False
    wanted: float | None = None

    @property
    def verdict(self) -> str:
        if self.wanted is None:
            return ""
        reached = self.value >= self.wanted if self.rate else self.value <= self.wanted
        return "ok" if reached else "missed"

    @property
    def measured_text(self) -> str:
        return quantity(self.value, self.rate)

    @property
    def wanted_text(self) -> str:
        if self.wanted is None:
            return ""
        return f"{'≥' if self.rate else '≤'} {quantity(self.wanted, self.rate)}"


def quantity(value: float, rate: bool) -> str:
    units = (
        ((1e6, "M/s"), (1e3, "k/s"), (1.0, "/s"))
        if rate
        else ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
    )
    size, unit = next((u for u in units if value >= 0.9995 * u[0]), units[-1])
    number = round(value / size, 9)
    decimals = 0 if number >= 99.95 or number == round(number) else 1 if number >= 9.995 else 2
    return f"{number:.{decimals}f} {unit}"


def two_digits(value: float) -> str:
    """A large ratio to two digits, in groups of three."""
    return f"{float(f'{value:.1e}'):,.0f}".replace(",", " ")


def best(call: Callable[[], object], repeats: int = 7, number: int = 1) -> float:
    """Shortest time of one call [s]; the first one, which fills caches, does not count."""
    call()
    return min(timeit.repeat(call, repeat=repeats, number=number)) / number


def measure_joint() -> list[Row]:
    surface = make_surface()
    joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)
    rows: list[Row] = []

    def add(task: str, seconds: float, target: float | None = None) -> None:
        rows.append(Row(task, seconds, wanted=target))

    for task, history, target in (
        ("force(), 1e6 samples of a sine", sine(SAMPLES, 1000), 50e6),
        ("force(), 1e6 samples of Gaussian noise", gaussian_noise(SAMPLES), None),
        ("force(), 1e6 samples, each a reversal", turning_noise(SAMPLES), 20e6),
    ):
        seconds = best(lambda x=history: joint.force(x))
        rows.append(Row(task, SAMPLES / seconds, True, target))

    rows += measure_varying_load(joint)
    rows += measure_fields()
    add("loop(), 1024 samples", best(lambda: joint.loop(3e-7, 1024), 7, 200), 50e-6)

    # Many different joints, so that nothing is found ready made; the time is that of a mean one.
    loads, amplitudes = np.geomspace(100.0, 5000.0, 25), np.geomspace(1e-11, 1e-4, 100_000)
    coefficients, roughnesses = np.linspace(0.1, 0.9, 25), np.geomspace(1e-7, 2e-6, 25)

    def energies() -> None:
        for load in loads:
            joint.at(normal_load=load).dissipated_energy(amplitudes)

    variants: dict[str, tuple[Floats, Callable[[float], ms.Interface]]] = {
        "load": (loads, lambda load: joint.at(normal_load=load)),
        "friction coefficient": (coefficients, lambda value: ms.Interface(surface, value, 2000.0)),
        "roughness": (roughnesses, lambda std: ms.Interface(make_surface(std), 0.55, 2000.0)),
    }

    task = "dissipated_energy() of a new joint, 1e5 amplitudes"
    add(task, best(energies, 5) / 25, 20e-3)
    for variant, (values, make) in variants.items():

        def first_loops(values: Floats = values, make: Any = make) -> None:
            for value in values:
                make(value).loop(3e-7, 1024)

        add(f"new Interface of another {variant}, first loop()", best(first_loops, 5) / 25, 1e-3)

    state, path = joint.start(), sine(20_000, 100).tolist()

    def steps() -> None:
        for x in path:
            state.try_(x)
            state.commit()

    add("state.try_() and commit(), a step", best(steps, 3) / len(path))

    mode = ms.Oscillator(mass=10.0, stiffness=5e9, joint=joint)
    seconds = best(lambda: mode.ring_down(AMPLITUDE, cycles=1000), 1)
    add("Oscillator.ring_down(), 1000 cycles of 100 steps", seconds)

    forces = 0.95 * joint.force_limit / AMPLITUDE * sine(100_000, 1000)
    seconds = best(lambda: joint.displacement(forces), 3)
    rows.append(Row("displacement(), 1e5 samples of a sine", forces.size / seconds, True))
    return rows


def measure_varying_load(joint: ms.Interface) -> list[Row]:
    """The engine of a load that varies, here by a half, in quadrature with the displacement."""
    samples = SAMPLES
    x = sine(samples, 1000)
    load = joint.normal_load * (
        1.0 + 0.5 * np.cos(2.0 * math.pi / 1000 * np.arange(1, samples + 1))
    )
    separation = joint.surface.separation(load)
    noise = gaussian_noise(samples)
    noisy_load = joint.normal_load * np.random.default_rng(3).uniform(0.25, 1.75, samples)
    force = 0.4 * joint.force_limit / AMPLITUDE * x
    response = joint.coupled_response

    def losses() -> Floats:
        return response(x, separation=separation).dissipated_energy

    rows = []
    for task, call, target in (
        (
            "coupled_force() of normal loads, a sine",
            lambda: joint.coupled_force(x, normal_load=load),
            5e6,
        ),
        (
            "coupled_force() of separations, a sine",
            lambda: joint.coupled_force(x, separation=separation),
            5e6,
        ),
        (
            "coupled_force() of normal loads, Gaussian noise",
            lambda: joint.coupled_force(noise, normal_load=noisy_load),
            None,
        ),
        ("coupled_response() with dissipated_energy, a sine", losses, None),
        (
            "coupled_response(force=) of separations, a sine",
            lambda: joint.coupled_response(force=force, separation=separation),
            None,
        ),
    ):
        seconds = best(call, 5)
        rows.append(Row(task, samples / seconds, True, target))

    state, path = joint.start(), list(zip(x[:5000].tolist(), load[:5000].tolist(), strict=True))

    def steps() -> None:
        for place, normal_load in path:
            state.try_(place, normal_load)
            state.commit()

    rows.append(Row("state.try_() with a load and commit(), a step", best(steps, 3) / 5000))
    return rows


def measure_fields() -> list[Row]:
    """Thousands of nodes at once, and sliders in two directions."""
    rng = np.random.default_rng(3)
    rows: list[Row] = []

    surface = make_surface()
    pressures = rng.uniform(1e5, 2e7, 100_000)
    build = best(lambda: ms.JointField(surface, 0.3, areas=1e-5, pressures=pressures), 3)
    rows.append(Row("JointField of 100 000 nodes", build, wanted=0.5))
    field = ms.JointField(surface, 0.3, areas=1e-5, pressures=pressures[:1000])
    shape = np.array([0.5, 1.0, 1.0, 0.4, 0.4, 0.3, 0.3])
    x = 4e-7 * shape * rng.normal(size=(1000, 7))
    d = 1e-7 * shape * rng.normal(size=(1000, 7))
    d[:, 0] += field.separations
    for case, options, seconds in (
        ("no samples, a held load", {}, 0.02),
        ("no samples, separations", {"separations": d}, 0.06),
        ("128 samples, separations", {"separations": d, "samples": 128}, 0.06),
    ):
        call = functools.partial(field.harmonics, x, (0, 1, 2, 3), **options)
        task = f"harmonics() with Jacobian, 1000 nodes, {case}"
        rows.append(Row(task, best(call, 5), wanted=seconds))
    moves = 2e-7 * np.sin(0.1 * np.arange(64)[:, None] + rng.uniform(0.0, 6.0, 1000))
    breathing = field.separations + 0.5 * moves
    for case, paths, rate in (("a held load", None, 1e7), ("separations", breathing, 2e6)):

        def steps(paths: Floats | None = paths) -> None:
            state = field.start()
            for i, move in enumerate(moves):
                state.try_(move, None if paths is None else paths[i])
                state.commit()

        task = f"try_() and commit() of 1000 nodes, a node step, {case}"
        rows.append(Row(task, moves.size / best(steps, 5), True, rate))
    two = field.two_directions(64)
    plane = 2e-7 * rng.normal(size=(8, 1000, 2))

    def turns() -> None:
        state = two.start()
        for move in plane:
            state.try_(move)
            state.commit()

    rows.append(
        Row("two directions, 64 sliders, a node step", 8000 / best(turns, 3), True,
            5e5)
    )  # fmt: skip
    plane_waves = 4e-7 * shape * rng.normal(size=(1000, 2, 7))
    both = field.two_directions()
    call = functools.partial(both.harmonics, plane_waves, (0, 1, 2, 3))
    task = "harmonics() with Jacobian, 1000 nodes in two directions, 128 sliders"
    rows.append(Row(task, best(call, 3), wanted=1.0))
    return rows


def measure_varying_laws() -> list[Row]:
    """The same engine on laws that no profile gives: a sphere, a table, given summits, a ramp."""
    pair = make_surface().pair
    grid = np.linspace(0.0, 1e-6, 20)
    heights = np.random.default_rng(5).normal(0.0, 5e-7, 5000)
    bounded = ms.TabulatedHeights(np.linspace(0.0, 2e-6, 40), np.linspace(1.0, 0.0, 40))

    def rough(profile: Any) -> ms.GreenwoodWilliamson:
        return ms.GreenwoodWilliamson(pair, profile, radius=1e-3, density=1e8, area=2e-4)

    rows = []
    for case, law, first, samples in (
        ("a sphere", ms.SphereOnFlat(pair, 5e-3), -1e-7, 200_000),
        (
            "a table of 20 loads",
            ms.TabulatedNormalLaw(pair, grid, 1e3 * (1.0 - grid / 1e-6) ** 2),
            6e-7,
            200_000,
        ),
        ("500 summits", ms.AsperityPopulation(pair, heights[:500], radii=1e-3), 0.0, 20_000),
        ("5000 summits", rough(heights), 0.0, 2000),
        ("heights by a table of 40", rough(bounded), 1.2e-6, 5000),
    ):
        joint = ms.Interface(law, friction_coefficient=0.55, separation=first)
        angle = 2.0 * math.pi / 1000 * np.arange(1, samples + 1)
        x = 0.9 * joint.force_limit / joint.tangential_stiffness * np.sin(angle)
        load = joint.normal_load * (1.0 + 0.5 * np.cos(angle))
        leading = slice(0, min(samples, 2000))  # what takes tens of microseconds a sample
        d = law.separation(load)
        force = 0.4 * joint.coupled_force(x, separation=d)

        def losses(joint: Any = joint, x: Floats = x[leading], d: Floats = d[leading]) -> Floats:
            return joint.coupled_response(x, separation=d).dissipated_energy

        def hold(joint: Any = joint, f: Floats = force[leading], d: Floats = d[leading]) -> Floats:
            return joint.coupled_response(force=f, separation=d).displacement

        for task, call, count in (
            (
                "coupled_force() of normal loads",
                lambda joint=joint, x=x, n=load: joint.coupled_force(x, normal_load=n),
                samples,
            ),
            ("coupled_response() with dissipated_energy", losses, d[leading].size),
            ("coupled_response(force=)", hold, d[leading].size),
        ):
            rows.append(Row(f"{task}, {case}", count / best(call, 2), True))
    return rows


def measure_others() -> tuple[list[list[str]], dict[str, Any]]:
    """Each asperity by itself, and plain Python, against force() on histories of one kind."""
    joint = ms.Interface(make_surface(), friction_coefficient=0.55, normal_load=2000.0)
    population = explicit_population(joint)
    rows, numbers = [], {}
    for kind, short, middle, full in (
        ("sine, 100 samples a cycle", sine(400, 100), sine(20_000, 100), sine(SAMPLES, 100)),
        ("Gaussian noise", *(gaussian_noise(n) for n in (200, 20_000, SAMPLES))),
        ("every sample a reversal", *(turning_noise(n) for n in (200, 20_000, SAMPLES))),
    ):
        begin = time.perf_counter()
        explicit = population.force(short)
        a_step = (time.perf_counter() - begin) / short.size
        python = best(lambda x=middle: naive_force(joint, x), 1) / middle.size
        ours = best(lambda x=full: joint.force(x), 5) / full.size
        forces = joint.force(middle)
        numbers[kind] = {
            "explicit_seconds_a_sample": a_step,
            "explicit_samples": short.size,
            "naive_python_seconds_a_sample": python,
            "microslip_seconds_a_sample": ours,
            "turning_share": turning_share(full),
            "explicit_difference": difference(explicit, forces[: short.size], joint),
            "naive_python_difference": difference(naive_force(joint, middle), forces, joint),
        }
        rows.append(
            [
                f"{kind} ({100.0 * turning_share(full):.0f} % turn)",
                quantity(a_step, False),
                quantity(python, False),
                quantity(ours, False),
                two_digits(a_step / ours),
            ]
        )
    return rows, numbers


def measure_sweeps() -> tuple[list[list[str]], dict[str, Any]]:
    """A million points of energy of many loads, at once and one Interface after the other."""
    surface = make_surface()
    joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)
    rows, numbers = [], {}
    for count in (1000, 100_000, 1_000_000):
        # One amplitude is one of them all: what it costs depends on how large it is.
        loads = np.geomspace(100.0, 5000.0, count)
        amplitudes = np.geomspace(1e-11, 1e-4, SWEPT // count + 1)[1:]

        def swept(loads: Floats = loads, amplitudes: Floats = amplitudes) -> Any:
            return ms.evaluate(
                surface=surface,
                friction_coefficient=0.55,
                normal_load=loads[:, None],
                amplitude=amplitudes,
                quantities=["dissipated_energy"],
            )

        sampled = loads[:: max(1, count // 100)]

        def one_by_one(loads: Floats = sampled, amplitudes: Floats = amplitudes) -> list[Floats]:
            return [joint.at(normal_load=load).dissipated_energy(amplitudes) for load in loads]

        ours = best(swept, 2)
        theirs = best(one_by_one, 2) * count / sampled.size
        energies = swept()["dissipated_energy"][:: max(1, count // 100)]
        shape = f"{count} x {SWEPT // count}"
        numbers[shape] = {
            "sweep_seconds": ours,
            "interfaces_seconds": theirs,
            "interfaces_measured": sampled.size,
            "difference": float(np.abs(energies / np.array(one_by_one()) - 1.0).max()),
        }
        counted = f"{count:,} x {SWEPT // count:,}".replace(",", " ")
        ratio = theirs / ours
        rows.append(
            [
                counted,
                quantity(theirs, False),
                quantity(ours, False),
                two_digits(ratio) if ratio >= 10.0 else f"{ratio:.1f}",
                "ok" if ours <= SWEEP_WANTED else "missed",
            ]
        )
    return rows, numbers


def measure_scan() -> list[Row]:
    """All that there is to know of a scan, from its heights on: nothing is kept between runs."""
    heights = rough(2048, 1e-6, 2e-7, longest=1.5e-4, shortest=4.9e-6, seed=7)

    def parameters() -> None:
        scan = ms.Scan(heights, 1e-6).condition(level="plane")
        scan.statistics()
        scan.moments()
        scan.spectrum()
        scan.summits(5e-6)

    task = "4-megapixel scan, parameters, spectrum and summits"
    return [Row(task, best(parameters, 1), wanted=10.0)]


def measure_identify() -> list[Row]:
    """A joint from the records of a virtual tribometer: one long one, and many at five loads."""
    loads = (200.0, 500.0, 1000.0, 2000.0, 4000.0)
    rigs = [
        ms.VirtualTribometer(
            ms.Interface(make_surface(), friction_coefficient=0.55, normal_load=load),
            rig_stiffness=2e8,
            noise=0.003,
            sample_rate=5120.0,
            seed=number,
        )
        for number, load in enumerate(loads)
    ]
    long = rigs[2].record(amplitude=6e-6, frequency=5.12, cycles=100)
    loops = [
        rig.record(amplitude=top, frequency=10.0, cycles=20)
        for rig in rigs
        for top in np.geomspace(1e-6, 12e-6, 10)
    ]
    tasks = (
        ("identify: one 1e5-sample record", long, 1.0),
        ("identify: 50 loops at 5 loads", loops, 5.0),
    )
    return [
        Row(task, best(lambda r=records: ms.identify(r), 2), wanted=target)
        for task, records, target in tasks
    ]


def difference(forces: Floats, reference: Floats, joint: ms.Interface) -> float:
    return float(np.abs(forces - reference).max()) / joint.force_limit


def measure_starts() -> tuple[list[Row], bool]:
    """Imports and the command, in processes of their own; whether the command loads NumPy."""
    imports = {
        "numpy": "import numpy",
        "microslip": "import microslip",
        "Interface": "from microslip import Interface",
    }
    shortest = dict.fromkeys([*imports, "help"], math.inf)
    for _ in range(5):
        for name, statement in imports.items():
            shortest[name] = min(shortest[name], float(child(_TIMED.format(statement))))
        begin = time.perf_counter()
        child("from microslip.cli import main; main(['--help'])")
        shortest["help"] = min(shortest["help"], time.perf_counter() - begin)
    loads_numpy = child(_HELP).splitlines()[-1] == "True"
    target = shortest["numpy"] + 0.1
    return [
        Row("import numpy", shortest["numpy"]),
        Row("import microslip", shortest["microslip"], wanted=target),
        Row("from microslip import Interface", shortest["Interface"], wanted=target),
        Row("microslip --help, whole process", shortest["help"]),
    ], loads_numpy


_TIMED = "import time; t = time.perf_counter(); {}; print(time.perf_counter() - t)"
_HELP = """
import sys
from microslip.cli import main
try:
    main(["--help"])
finally:
    print("numpy" in sys.modules)
"""


def child(code: str) -> str:
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    return process.stdout.strip()


# -- what is shown --------------------------------------------------------------------------------


def machine() -> dict[str, Any]:
    """What the numbers depend on; nothing that names the machine itself."""
    return {
        "cpu": _cpu_model(),
        "cpu_count": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "numpy": np.__version__,
        "microslip": ms.__version__,
    }


def _cpu_model() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        names = [line.split(":", 1)[1] for line in text.splitlines() if line[:10] == "model name"]
    except OSError:
        names = []
    if not names and sys.platform == "darwin":
        ask = ["sysctl", "-n", "machdep.cpu.brand_string"]
        names = [subprocess.run(ask, capture_output=True, text=True, check=False).stdout]
    name = " ".join(names[0].split()) if names else ""
    return name or platform.processor() or platform.machine()


def plain_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    lines = [head, ["-" * width for width in widths], *rows]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


OTHERS_HEAD = (
    "one sample of",
    f"{ASPERITIES:.0e} asperities, NumPy".replace("e+0", "e"),
    "plain Python",
    "microslip",
    "asperities / microslip",
)
SWEEPS_HEAD = (
    "energies, loads x amplitudes",
    "one Interface a load",
    "evaluate()",
    "interfaces / evaluate",
    f"≤ {quantity(SWEEP_WANTED, False)}",
)


def page_text(
    rows: Sequence[Row],
    comparisons: Sequence[Sequence[str]],
    about: str,
    sweeps: Sequence[Sequence[str]] = (),
) -> str:
    """The tables of the page: a row a task, a column a kernel."""

    def cell(row: Row) -> str:
        return f"**{row.measured_text}** (missed)" if row.verdict == "missed" else row.measured_text

    lines = [[row.task, row.wanted_text, cell(row)] for row in rows]
    head = ("task", "wanted", "measured")
    tables = [(head, lines), (OTHERS_HEAD, comparisons)] + (
        [(SWEEPS_HEAD, sweeps)] if sweeps else []
    )
    return "\n\n".join([about, *(markdown_table(*table) for table in tables)])


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Measure the speed of microslip on one core.")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the numbers, in SI units")
    parser.add_argument("--page", action="store_true", help="write the tables into docs/timings.md")
    parser.add_argument("--strict", action="store_true", help="exit with 1 where one is missed")
    options = parser.parse_args(arguments)

    rows = measure_joint()
    rows += measure_varying_laws()
    comparisons, other_numbers = measure_others()
    sweeps, sweep_numbers = measure_sweeps()
    rows += measure_scan()
    rows += measure_identify()
    starts, loads_numpy = measure_starts()
    rows += starts

    here = machine()
    about = (
        f"{here['cpu']} (one of {here['cpu_count']} cores), {here['system']}, {here['python']}, "
        f"NumPy {here['numpy']}, microslip {here['microslip']}."
    )
    print(about, end="\n\n")
    lines = [[row.task, row.wanted_text, row.measured_text, row.verdict] for row in rows]
    head = ("task", "wanted", "measured", "verdict")
    for table in ((head, lines), (OTHERS_HEAD, comparisons), (SWEEPS_HEAD, sweeps)):
        print(plain_table(*table), end="\n\n")
    error = max(n["explicit_difference"] for n in other_numbers.values())
    print(f"The asperities differ by {error:.1g} of the force limit.")
    print(f"microslip --help {'loads' if loads_numpy else 'does not load'} NumPy.")
    if options.json:
        content = {
            "machine": here,
            "rows": [
                asdict(row) | {"unit": "samples/s" if row.rate else "s", "verdict": row.verdict}
                for row in rows
            ],
            "others": other_numbers,
            "sweeps": sweep_numbers,
            "help_loads_numpy": loads_numpy,
        }
        options.json.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    if options.page:
        write_section(
            "timings.md", "timings", "run.py", page_text(rows, comparisons, about, sweeps)
        )
    misses = sum(row.verdict == "missed" for row in rows) + loads_numpy
    misses += sum(row[-1] == "missed" for row in sweeps)
    return 1 if options.strict and misses else 0


if __name__ == "__main__":
    sys.exit(main())
