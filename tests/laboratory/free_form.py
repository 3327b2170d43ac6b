"""Records of known joints made slider by slider, and how often intervals hold the true values.

Nothing of the package takes part but :class:`microslip.Record`. A joint is a list of parallel
sliders, each with a stiffness and the displacement at which it yields. A lower normal load lowers
the yield displacements of all sliders by one number, which is exact for elastic contacts whose
normal load depends on the approach alone; a rig in series is solved at every step.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import microslip as ms

Floats = NDArray[np.float64]

LAWS = ("sphere", "jenkins", "exponential", "gaussian", "iwan", "segalman", "summits")
DRIVES = ("sine", "triangle", "asymmetric")
NOISES = (0.001, 0.003, 0.01)
"""Standard deviation of a sample of force, relative to its amplitude; a third for displacement."""
RIGS = ("none", "unknown", "given")
"""No rig; a rig in series that stays part of the result; a rig of measured stiffness."""
RIPPLES = (0.0, 0.02, 0.1)
"""Amplitude of the normal load within the cycle, relative to its mean."""
RIG_ERROR = 0.02
FREQUENCY = 10.0


@dataclass(frozen=True)
class Sliders:
    """Parallel sliders at one normal load: yield displacements [m] and stiffnesses [N/m]."""

    y: Floats
    k: Floats

    @classmethod
    def through(cls, u: Floats, force: Floats) -> Sliders:
        """Return the sliders whose first loading curve joins points, the first of which is 0."""
        slope = np.append(np.diff(force) / np.diff(u), 0.0)
        k = slope[:-1] - slope[1:]
        keep = k > 1e-12 * slope[0]
        return cls(u[1:][keep], k[keep])

    @property
    def stiffness(self) -> float:
        """Tangential stiffness at rest [N/m]."""
        return float(self.k.sum())

    @property
    def force_limit(self) -> float:
        """Force of gross slip [N]."""
        return float(self.k @ self.y)

    def force(self, a: float) -> float:
        """Force of first loading at a displacement [N]."""
        return float(self.k @ np.minimum(a, self.y))

    def dissipated_energy(self, a: float) -> float:
        """Energy of a cycle of an amplitude [J]."""
        return float(self.k @ (4.0 * self.y * np.maximum(a - self.y, 0.0)))

    def damping_ratio(self, a: float) -> float:
        """Energy over 2 pi times amplitude times force [-]."""
        return self.dissipated_energy(a) / (2.0 * np.pi * a * self.force(a))

    def amplitude_at(self, share: float) -> float:
        """Displacement at which first loading reaches a share of the force limit [m]."""
        u = np.append(0.0, self.y)
        return float(np.interp(share, [self.force(v) / self.force_limit for v in u], u))

    def shift(self, limit: Floats) -> Floats:
        """Return the change of all yield displacements [m] at which the force limit is another."""
        order = np.argsort(self.y)[::-1]
        y, k = self.y[order], np.cumsum(self.k[order])
        # Force limits at which the next slider enters, which has the next lower yield point.
        at = np.append(0.0, np.cumsum(k[:-1] * (y[:-1] - y[1:])))
        row = np.searchsorted(at, limit, side="right") - 1
        return (limit - at[row]) / k[row] - y[row]

    def at(self, limit: float) -> Sliders:
        """Return the sliders at the normal load of another force limit [N]."""
        y = self.y + self.shift(np.array([limit]))[0]
        return Sliders(y[y > 0.0], self.k[y > 0.0])

    def behind(self, rig: float) -> Sliders:
        """Return the sliders of this joint and a spring of a stiffness [N/m] in series."""
        u = np.unique(np.append(0.0, self.y))
        force = np.array([self.force(v) for v in u])
        return Sliders.through(u + force / rig, force)

    def respond(self, u: Floats, limit: Floats, rig: float = np.inf) -> Floats:
        """Return the force along displacements [m] from rest, at the force limit of each step.

        Parameters
        ----------
        u : ndarray of shape (n,)
            Displacement at the far end of the rig [m]. Between its values the motion is straight.
        limit : ndarray of shape (n,)
            Force limit at each step [N].
        rig : float
            Stiffness in series [N/m].
        """
        if np.all(limit == limit[0]):
            same = self if limit[0] == self.force_limit else self.at(float(limit[0]))
            return (same if np.isinf(rig) else same.behind(rig))._steps(u)
        shift, c = self.shift(limit), 1.0 / rig
        state, force, x = np.zeros_like(self.k), np.zeros(u.size), 0.0
        before = self.y + shift[0]
        for i in range(1, u.size):
            now = self.y + shift[i]
            a = np.maximum(now, 0.0)
            # A slider that enters during the step moves only after its entry.
            entered = (before <= 0.0) & (now > 0.0)
            part = np.where(entered, now / np.where(entered, now - before, 1.0), 1.0)
            new = x + (u[i] - u[i - 1])
            for _ in range(60):  # Newton's method on the rig's elongation
                trial = state + part * (new - x)
                held = np.clip(trial, -a, a)
                total = float(self.k @ held)
                free = float((self.k * part)[held == trial].sum())
                step = (new + c * total - u[i]) / (1.0 + c * free)
                new -= step
                if abs(step) <= 1e-13 * abs(u).max():
                    break
            state = np.clip(state + part * (new - x), -a, a)
            x, before, force[i] = new, now, float(self.k @ state)
        return force

    def _steps(self, u: Floats) -> Floats:
        state, force = np.zeros_like(self.k), np.zeros(u.size)
        for i in range(1, u.size):
            state = np.clip(state + (u[i] - u[i - 1]), -self.y, self.y)
            force[i] = float(self.k @ state)
        return force


def sliders_of(law: str, rng: np.random.Generator, length: float, limit: float) -> Sliders:
    """Return sliders of a law with a length scale [m] and a force limit [N]."""
    near = np.geomspace(1e-3, 0.05, 40)
    if law == "jenkins":
        return Sliders(np.array([length]), np.array([limit / length]))
    if law == "sphere":  # Mindlin
        u = np.concatenate(([0.0], near, np.linspace(0.05, 1.0, 200)[1:]))
        u[-60:] = 1.0 - (1.0 - u[-60]) * np.linspace(1.0, 0.0, 60) ** 2
        share = 1.0 - np.maximum(1.0 - u, 0.0) ** 1.5
    elif law == "exponential":
        u = np.concatenate(([0.0], near, np.linspace(0.05, 14.0, 280)[1:]))
        share = 1.0 - np.exp(-u)
    elif law == "iwan":  # yield displacements uniform from zero or from a first one on
        first = float(rng.choice([0.0, 0.15]))
        u = np.concatenate(
            ([0.0], first + (1.0 - first) * np.append(near, np.linspace(0.06, 1, 200)))
        )
        v = np.clip(u, first, 1.0)
        share = 2.0 * (u - (v - first) ** 2 / (2.0 * (1.0 - first))) / (1.0 + first)
    elif law == "segalman":  # k(y) = y^chi up to 1 and a last slider there
        chi, last = float(rng.uniform(-0.7, -0.2)), float(rng.uniform(0.0, 0.4))
        u = np.concatenate(([0.0], np.geomspace(1e-4, 1.0, 300)))
        share = u / (1.0 + chi) - u ** (2.0 + chi) / ((1.0 + chi) * (2.0 + chi)) + last * u
    elif law in ("gaussian", "summits"):
        h = float(rng.uniform(0.3, 2.2))
        u = np.concatenate(([0.0], near, np.linspace(0.05, 6.5, 260)[1:]))
        if law == "summits":
            z = rng.normal(size=int(rng.choice([2_000, 20_000])))
            u = np.append(u[u < z.max() - h], max(z.max() - h, 0.1))
            normal = np.array([np.sum(np.maximum(z - h - v, 0.0) ** 1.5) for v in u])
        else:
            s = np.linspace(0.0, 3.2, 1201)
            z = h + u[:, None] + s**2
            normal = np.trapezoid(2.0 * s**4 * np.exp(-0.5 * z**2), s, axis=1)
        share = 1.0 - normal / normal[0]
    else:
        raise ValueError(law)
    return Sliders.through(length * u, limit * share / share[-1])


@dataclass(frozen=True)
class Loops:
    """Records of one joint, the options of the fit, and the sliders that made them."""

    sources: dict[str, str]
    records: list[ms.Record]
    options: dict[str, Any]
    truth: list[tuple[float, Sliders, list[float], bool]] = field(repr=False)
    """For each load [N]: the sliders, the amplitudes of the records [m], and gross slip or not."""


def loops_of(seed: int) -> Loops:
    """Return the set of a seed."""
    rng = np.random.default_rng([42, seed])
    law, drive = LAWS[seed % len(LAWS)], DRIVES[seed // 7 % 3]
    noise, rig_kind = NOISES[seed // 21 % 3], RIGS[seed // 2 % 3]
    ripple = float(rng.choice(RIPPLES, p=[0.5, 0.25, 0.25]))
    count = int(rng.integers(1, 4))
    slips = bool(rng.random() < 0.75)
    mu = float(rng.uniform(0.15, 0.8))
    load = float(np.exp(rng.uniform(np.log(500.0), np.log(5000.0))))
    length = float(np.exp(rng.uniform(np.log(0.1e-6), np.log(2e-6))))
    own = sliders_of(law, rng, length, mu * load)
    rig = np.inf if rig_kind == "none" else own.stiffness * float(np.exp(rng.uniform(-1.2, 1.2)))
    loads = load * np.array([1.0, 0.5, 0.25])[:count]
    samples, cycles = float(rng.uniform(80, 250)), int(rng.integers(7, 11))
    records, truth = [], []
    for at in loads:
        joint = own.at(mu * float(at))
        series = joint if np.isinf(rig) else joint.behind(rig)
        full = series.amplitude_at(0.98)
        sizes = [full * float(rng.uniform(0.25, 0.45)), full * float(rng.uniform(1.3, 2.5))]
        if not slips:
            sizes[1] = full * float(rng.uniform(0.55, 0.8))
        for size in sizes:
            records.append(
                _record(rng, own, mu, float(at), rig, drive, size, noise, ripple, samples, cycles)
            )
        if rig_kind == "given":
            # The joint's own amplitudes behind the spring.
            sizes = [size - series.force(size) / rig for size in sizes]
            truth.append((float(at), joint, sizes, slips))
        else:
            truth.append((float(at), series, sizes, slips))
    options: dict[str, Any] = {}
    if rig_kind == "given":
        error = RIG_ERROR * rig
        options["rig_stiffness"] = (rig + error * float(rng.normal()), error)
    sources = {
        "law": law,
        "drive": drive,
        "noise": f"{100 * noise:g} %",
        "rig": rig_kind,
        "ripple": f"{100 * ripple:g} %",
        "loads": str(count),
        "gross slip": "yes" if slips else "no",
    }
    return Loops(sources, records, options, truth)


def _record(
    rng: np.random.Generator,
    own: Sliders,
    mu: float,
    load: float,
    rig: float,
    drive: str,
    size: float,
    noise: float,
    ripple: float,
    samples: float,
    cycles: int,
) -> ms.Record:
    """Return the record of one amplitude [m] at one mean load [N]."""
    fine = 1 if ripple == 0.0 else 2  # steps a sample: a load that varies is straight in a step
    start = float(rng.uniform(0.0, 1.0))
    turn = np.concatenate(
        ([0.0], (start + np.arange(int(samples * cycles) * fine)) / samples / fine)
    )
    corners = np.arange(0.25, cycles, 0.5)
    if drive == "asymmetric":
        lag = float(rng.uniform(0.0, 2.0 * np.pi))
        grid = np.linspace(0.0, 1.0, 20001)
        way = _way(drive, grid, lag)
        corners = (
            np.array([[np.argmax(way)], [np.argmin(way)]]) / 20000 + np.arange(cycles)
        ).ravel()
    else:
        lag, way = 0.0, np.array([-1.0, 1.0])
    steps = np.union1d(turn, corners[corners < turn[-1]])
    middle, half = 0.5 * (way.max() + way.min()), 0.5 * float(np.ptp(way))
    u = size * (_way(drive, steps, lag) - middle) / half
    angle = 2.0 * np.pi * int(rng.integers(1, 3)) * steps + float(rng.uniform(0.0, 2.0 * np.pi))
    normal = load * (1.0 + ripple * np.cos(angle))
    first = np.linspace(0.0, 1.0, 65)[:-1]  # from rest to the first point of the motion
    u_all = np.concatenate((first * u[0], u))
    limit = mu * np.concatenate((np.full(first.size, normal[0]), normal))
    force = own.respond(u_all, limit, rig)[first.size :]
    rows = np.searchsorted(steps, turn[1::fine])
    u, force, normal = u[rows], force[rows], normal[rows]
    u = u + noise / 3.0 * size * rng.normal(size=u.size)
    force = force + noise * float(np.abs(force).max()) * rng.normal(size=u.size)
    channel = normal * (1.0 + 0.001 * rng.normal(size=u.size)) if ripple else load
    return ms.Record(u, force, normal_load=channel, sample_rate=samples * FREQUENCY)


def _way(drive: str, turn: Floats, lag: float) -> Floats:
    """Displacement of a drive at turns, of a size near 1."""
    angle = 2.0 * np.pi * turn
    if drive == "triangle":
        return 1.0 - 4.0 * np.abs((turn + 0.25) % 1.0 - 0.5)
    return np.sin(angle) + (0.12 * np.sin(2.0 * angle + lag) if drive == "asymmetric" else 0.0)


QUANTITIES = ("dissipated_energy", "force", "damping_ratio", "stiffness", "force_limit")


@dataclass
class Coverage:
    """Counts of intervals that hold the true value, by source and by quantity."""

    sets: int = 0
    held: Counter[tuple[str, str]] = field(default_factory=Counter)
    given: Counter[tuple[str, str]] = field(default_factory=Counter)
    errors: dict[str, list[float]] = field(default_factory=dict)
    """Relative errors of the energy at the largest amplitude and at half the smallest."""
    failures: list[str] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    """Processor time of each fit [s]."""

    def add(self, other: Coverage) -> None:
        """Add the counts of other sets."""
        self.sets += other.sets
        self.held += other.held
        self.given += other.given
        for name, values in other.errors.items():
            self.errors.setdefault(name, []).extend(values)
        self.failures += other.failures
        self.seconds += other.seconds

    def share(self, source: str, quantity: str = "all") -> float:
        """Return the share of intervals that hold the true value; 1 where there are none."""
        given = self.given[source, quantity]
        return self.held[source, quantity] / given if given else 1.0


def covered(seed: int) -> Coverage:
    """Identify the set of a seed and compare its intervals with the sliders that made it."""
    loops, counts = loops_of(seed), Coverage(sets=1)
    label = f"{seed} ({', '.join(f'{k} {v}' for k, v in loops.sources.items())})"
    begin = time.process_time()
    try:
        found: Any = ms.identify(loops.records, **loops.options)
    except ms.InputError as error:
        counts.failures.append(f"{label}: refused: {error}")
        return counts
    counts.seconds.append(time.process_time() - begin)

    def count(quantity: str, where: str, estimate: Any, truth: float) -> None:
        low, value, high = (float(v) for v in (estimate.low, estimate.value, estimate.high))
        holds = low <= truth <= high
        for source in ("all", *(f"{k}: {v}" for k, v in loops.sources.items())):
            for name in ("all", quantity):
                counts.given[source, name] += 1
                counts.held[source, name] += holds
        if not holds:
            counts.failures.append(
                f"{label}: {quantity} {where}: {low:.6g} to {high:.6g}, true {truth:.6g}"
            )
        if not (np.isnan(value) or low <= value <= high):
            counts.failures.append(f"{label}: {quantity} {where}: the value is not in its interval")

    top = loops.truth[0]
    for load, sliders, sizes, _ in loops.truth:
        at = {} if len(loops.truth) == 1 else {"normal_load": load}
        name = f"at {load:.4g} N"
        smallest, largest = min(sizes), max(sizes)
        if loops.options:
            # Amplitudes of a joint behind an uncertain rig are known as well as the rig.
            largest = min(0.98 * largest, found.amplitudes[1])
            smallest = min(smallest, largest)
        places = {"at most": largest, "middle": 0.5 * (smallest + largest), "least": smallest}
        if (load, sliders) == top[:2]:
            places["half the least"] = 0.5 * smallest
        for word, a in places.items():
            for quantity in QUANTITIES[:3]:
                truth = float(getattr(sliders, quantity)(a))
                estimate = getattr(found, quantity)(a, **at)
                count(quantity, f"{word} {name}", estimate, truth)
                if quantity == "dissipated_energy" and truth > 0.0:
                    error = float(estimate.value) / truth - 1.0
                    counts.errors.setdefault(word, []).append(abs(error))
    _, sliders, _, slips = top
    count("stiffness", "at rest", found.stiffness, sliders.stiffness)
    if slips:
        count("force_limit", "", found.force_limit, sliders.force_limit)
    return counts


def coverage(seeds: Iterable[int]) -> Coverage:
    """Return the counts of several sets."""
    whole = Coverage()
    for seed in seeds:
        whole.add(covered(seed))
    return whole


def table(counts: Coverage) -> list[str]:
    """Return rows of a page: the share of intervals that hold the true value, by source."""
    heads = ("E", "T", "ζ", "k at rest", "force limit", "all")
    lines = [f"| records | {' | '.join(heads)} |", f"| --- |{' ---: |' * len(heads)}"]
    for source in dict.fromkeys(source for source, _ in sorted(counts.given)):
        cells = []
        for quantity in (*QUANTITIES, "all"):
            given = counts.given[source, quantity]
            share = (
                f" ({100.0 * counts.share(source, quantity):.0f} %)" if quantity == "all" else ""
            )
            cells.append(f"{counts.held[source, quantity]}/{given}{share}" if given else "–")
        lines.append(f"| {source} | {' | '.join(cells)} |")
    return lines
