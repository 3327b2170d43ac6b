"""Solve synthetic Gaussian faces and fit the law of drawn faces to them.

    python tools/make_face_table.py solve /tmp/faces/solved.jsonl --minutes 120
    python tools/make_face_table.py collect /tmp/faces/solved.jsonl
    python tools/make_face_table.py report

`solve` appends one line a face, nodes with the fewest faces first. It skips the faces of the file
and those of the shipped table, so it can be stopped and started again, and several processes can
share the work with `--part 1/2`. `collect` averages the new faces of each node with those of the
shipped table and writes `src/microslip/contact/face_table.npz`: the nodes, and the coefficients
that `tools/fit_face_table.py` finds for them. `report` compares both.

A face is periodic, isotropic and self-affine between a roll-off and a shortest wave, with random
amplitudes and phases. It is loaded through rising mean pressures with the hardness as the bound of
the pressure. At each it is unloaded elastically, from the shape that it has then. Heights, rms and
gradient are those of the realised face, which takes most of the scatter of a small face away.

Nodes are few, since the fit needs only a smooth dependence on three groups: 11 spectra of different
breadth, seven hardnesses (three for the largest faces) and up to seven pressures. Each stored node
has 20 faces or more, all of which take an hour of one core. Two corrections have faces of their
own. The same waves at 6, 12 and 24 pixels a shortest wave give the pixel limit.
Faces with 2, 4 and 8 roll-off waves along a side give the limit of a large face: at a pressure of
1 % of the hardness two waves are 13 % stiffer than eight, as ln k - ln k_large ~ 1/waves.
Where fewer than 20 faces bring enough points into contact, the lightest pressures have no node. The
array `counts` has the numbers of faces, and `report` prints them.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import os
import sys
import time
from collections import Counter
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402
from scipy import fft  # noqa: E402

from microslip.contact.boundary_elements import HalfSpace, closing, press  # noqa: E402

HARDNESS = (0.03, 0.06, 0.12, 0.25, 0.5, 1.0, math.inf)
"""Hardness over E* and the rms gradient."""
TIGHTENED = (0.003, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5)
"""Tightening pressure over hardness; over E* and the rms gradient where nothing yields."""
SHARES = (0.985, 0.95, 0.87, 0.72, 0.5, 0.3, 0.15, 0.06, 0.02, 0.005)
"""Loads of the unloading, over that of tightening."""
LARGEST = 0.32
"""Mean pressure over E* and the rms gradient beyond which an elastic face nears full contact."""
SPECTRA = (
    (0.7, 4, 8), (0.4, 8, 4), (1.0, 8, 4), (0.7, 16, 2), (1.0, 32, 2), (0.4, 4, 8), (1.0, 4, 8),
    (0.7, 8, 4), (0.4, 16, 3), (0.7, 16, 3), (1.0, 16, 3),
)  # fmt: skip
"""Hurst exponent, ratio of roll-off to shortest wave, and roll-off waves along a side, of nodes:
breadths of 0.93 to 0.73."""
_LARGEST_FACES = (0.06, 0.25, 1.0)
"""Hardnesses of ratio 32, whose faces take six seconds each."""
FINITE = {4: 24, 2: 48}
"""Faces with fewer roll-off waves at ratio 4 and Hurst exponent 0.7, for the effect of the size."""
PIXELS = 6
PIXEL_SIZES = (6, 12, 24)
PIXEL_FACES = 4
"""Faces of a hardness that are solved with each of these pixels a shortest wave."""
FACES = 20
"""Smallest number of faces of a stored node."""
_SPARE = 2
"""Further faces of a node, since some have too few contacts at the lightest pressures."""
GAP = 5e-5
"""Largest residual of the gap, over the rms height."""
GROWTH = 2e-3
"""Residual of the growth of the pressures; the stiffness is wrong by its square."""
FEWEST = 8  # points in contact
VERSION = 4
TABLE = Path(__file__).parents[1] / "src" / "microslip" / "contact" / "face_table.npz"


def face(shape, hurst, waves, ratio, seed, pixels):
    """Return heights [pixels] of rms gradient 1, and their rms and breadth R <q>/h'.

    The waves are the same at any number of pixels a shortest wave.
    """
    n = shape
    highest = waves * ratio  # waves along a side, of the shortest
    rows, columns = np.arange(-highest, highest + 1), np.arange(highest + 1)
    k = np.hypot(rows[:, None], columns)
    inside = (k >= waves * (1.0 - 1e-9)) & (k <= highest * (1.0 + 1e-9))
    random = np.random.default_rng(seed)
    noise = random.standard_normal(k.shape) + 1j * random.standard_normal(k.shape)
    noise[rows < 0, 0] = np.conj(noise[rows > 0, 0][::-1])  # the column k_x = 0 is its own image
    modes = np.where(inside, noise * np.where(inside, k, 1.0) ** (-1.0 - hurst), 0.0)
    spectrum = np.zeros((n, n // 2 + 1), dtype=complex)
    spectrum[rows, : highest + 1] = modes
    z = np.fft.irfft2(spectrum, s=(n, n))
    q = 2.0 * np.pi / n * np.hypot(np.fft.fftfreq(n)[:, None] * n, np.arange(n // 2 + 1))
    weights = np.abs(spectrum) ** 2
    weights[:, 1:] *= 2.0
    rms_q = math.sqrt(np.sum(weights * q * q) / weights.sum())
    mean_q = float(np.sum(weights * q) / weights.sum())
    rms = 1.0 / rms_q
    return z * (rms / z.std()), rms, mean_q / rms_q


class SinglePrecision(HalfSpace):
    """Periodic half-space with transforms of 32 bits, twice as fast as 64.

    Stiffness and energies change by less than 0.1 %, which is less than the tolerances change them.
    """

    def __init__(self, shape):
        super().__init__(shape, mirrored=False)
        self._kernel = self._kernel.astype(np.float32)

    def displacement(self, pressure):
        waves = fft.rfft2(pressure.astype(np.float32, copy=False))
        waves *= self._kernel
        return fft.irfft2(waves, s=self.shape, overwrite_x=True)


class Solver:
    """A face under rising pressures, in units of E* and pixels."""

    def __init__(self, heights, rms, hardness):
        self.heights, self.rms, self.hardness = heights.astype(np.float32), rms, hardness
        self.space = SinglePrecision(heights.shape)
        self.tolerance = GAP * rms
        self.pressure = self.growth = None
        self.separation = 0.0

    def _press(self, heights, separation, hardness, start):
        return press(
            self.space, heights, separation, start, hardness=hardness, tolerance=self.tolerance
        )

    def load_to(self, target):
        """Load to a mean pressure within 0.2 %; return it and the stiffness of first loading."""
        if self.pressure is None:
            share = min(max(target / min(self.hardness, 0.4), 4.0 / self.heights.size), 0.4)
            self.separation = float(np.quantile(self.heights, 1.0 - share))
            self.pressure = self._press(self.heights, self.separation, self.hardness, None)
        for _ in range(60):
            mean = float(self.pressure.mean())
            free = (self.pressure > 0.0) & (self.pressure < self.hardness)
            self.growth = closing(self.space, free, self.growth, GROWTH)
            stiffness = float(self.growth.mean())
            if abs(mean / target - 1.0) < 2e-3:
                return mean, stiffness
            step = 0.3 * self.rms
            if mean > 0.0:
                step = math.log(target / mean) * mean / max(stiffness, 0.2 * mean / self.rms)
            step = min(max(step, -0.4 * self.rms), 0.4 * self.rms)
            self.separation -= step
            start = self.pressure + step * self.growth
            self.pressure = self._press(self.heights, self.separation, self.hardness, start)
        raise ArithmeticError(f"no separation for the pressure {target}")

    def unload(self):
        """Unload elastically; rows of separation, pressure, stiffness and share in contact."""
        pressure, d, heights = self.pressure, self.separation, self.heights
        hard = pressure >= self.hardness
        if hard.any():
            gap = self.space.displacement(pressure) - heights + d
            heights = heights + np.where(hard, np.minimum(gap, 0.0), 0.0)
        first = float(pressure.mean())
        growth = closing(self.space, pressure > 0.0, tolerance=GROWTH)
        rows = [(d, first, float(growth.mean()), float((pressure > 0.0).mean()))]
        last_rate = last_d = None
        for share in SHARES:
            d, mean, stiffness, _ = rows[-1]
            fall = math.log(mean / (share * first))
            rate, change = stiffness / mean, 0.0
            if last_rate is not None:
                change = max((rate - last_rate) / (d - last_d), 0.0)
            last_rate, last_d = rate, d
            d += fall / (rate + 0.5 * change * fall / rate)
            pressure = self._press(heights, d, math.inf, pressure - (d - last_d) * growth)
            if np.count_nonzero(pressure > 0.0) < FEWEST:
                break
            growth = closing(self.space, pressure > 0.0, growth, GROWTH)
            mean, touching = float(pressure.mean()), float((pressure > 0.0).mean())
            rows.append((d, mean, float(growth.mean()), touching))
        return rows


def solved(hurst, ratio, hardness, seed, pixels, waves):
    """Return the solution of one face as numbers for a line of JSON."""
    begin = time.process_time()
    key = (round(1000 * hurst), ratio, waves, round(1000 * min(hardness, 99.0)))
    z, rms, breadth = face(waves * ratio * pixels, hurst, waves, ratio, (*key, seed), pixels)
    solver = Solver(z, rms, hardness)
    unit = hardness if math.isfinite(hardness) else 1.0
    levels = []
    for share in TIGHTENED:
        if share * unit > LARGEST:
            break
        try:
            mean, loading = solver.load_to(share * unit)
        except ArithmeticError:  # too few points in contact
            if levels:
                raise
            continue
        levels.append({
            "pressure": mean, "loading": loading * rms / mean, "level": share,
            "rows": [[x / rms, p / mean, k * rms / p, touching]
                     for x, p, k, touching in solver.unload()],
            "hard": float((solver.pressure >= hardness).sum() / (solver.pressure > 0.0).sum()),
        })  # fmt: skip
    return {
        "hurst": hurst, "ratio": ratio, "hardness": hardness if math.isfinite(hardness) else None,
        "seed": seed, "pixels": pixels, "waves": waves, "breadth": breadth, "levels": levels,
        "seconds": time.process_time() - begin,
    }  # fmt: skip


def plan():
    """Return the faces to solve: nodes with the fewest faces first.

    The faces of a node are numbered from zero, and the shipped table has the first of them.
    """
    have, pixels = stored_counts()
    jobs = []

    def missing(node, count):
        known = have.get(node, 0)
        return range(known, count) if known < FACES else ()

    for (hurst, ratio, waves), h in itertools.product(SPECTRA, HARDNESS):
        if ratio < 32 or h in _LARGEST_FACES:
            for seed in missing(_node(hurst, ratio, h, waves), FACES + _SPARE):
                jobs.append((seed, (hurst, ratio, h, seed, PIXELS, waves)))
    for h, seed, size in itertools.product(HARDNESS, range(PIXEL_FACES), PIXEL_SIZES):
        if seed >= pixels.get(_node(0.7, 4, h, 4), 0):
            jobs.append((0.5 * seed, (0.7, 4, h, 1000 + seed, size, 4)))
    for h, (waves, count) in itertools.product(HARDNESS, FINITE.items()):
        for seed in missing(_node(0.7, 4, h, waves), count):
            jobs.append((seed * FACES / count, (0.7, 4, h, 2000 + seed, PIXELS, waves)))
    # The largest faces are the slowest by far and come last.
    return [job for _, job in sorted(jobs, key=lambda item: (item[1][1] >= 32, item[0]))]


def _node(hurst, ratio, h, waves):
    return round(1000 * hurst), int(ratio), round(1000 * min(h, 99.0)), int(waves)


def stored_counts():
    """Return how many faces the shipped table has at each node, and of how many pixel sizes."""
    from microslip.contact.face_table import stored

    table = stored()
    names = ("hurst", "ratio", "hardness", "waves", "counts")
    have = {}
    for *node, count in zip(*(table[name] for name in names), strict=True):
        have[_node(*node)] = max(have.get(_node(*node), 0), int(count))
    pixels = {}
    levels = zip(table["pixel_hardness"], table["pixel_pressure"], strict=True)
    for (h, _), number in Counter((h, round(p / min(h, 1.0), 2)) for h, p in levels).items():
        node = _node(0.7, 4, h, 4)
        pixels[node] = max(pixels.get(node, 0), number)
    return have, pixels


NODE = ("hurst", "ratio", "hardness", "level", "waves")


def lines(path):
    """Return the solved faces of a file."""
    if not path.exists():
        return []
    found = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            found.append(json.loads(line))
        except json.JSONDecodeError:  # a line that was cut off
            continue
    return found


def _job_of(item):
    h = math.inf if item["hardness"] is None else item["hardness"]
    names = (item[name] for name in ("seed", "pixels", "waves"))
    return (item["hurst"], item["ratio"], h, *names)


def solve(path, minutes, part, parts):
    """Solve what is missing until the time is over."""
    path.parent.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60.0 * minutes
    done = {_job_of(item) for item in lines(path)}
    left = [job for job in plan()[part - 1 :: parts] if job not in done]
    with path.open("a", encoding="utf-8") as file:
        for count, job in enumerate(left):
            if time.monotonic() > end:
                print(f"time is over, {len(left) - count} faces left")
                return
            try:
                item = solved(*job)
            except Exception as error:  # one face must not end two hours of work
                print(f"{job}: {error}", file=sys.stderr)
                continue
            file.write(json.dumps(item) + "\n")
            file.flush()


# -- nodes -----------------------------------------------------------------------------------------


def _numbers(item):
    """Return the numbers of each level of a face: logarithms, but for the separation."""
    h = 1e9 if item["hardness"] is None else item["hardness"]
    points = (item["waves"] * item["ratio"] * item["pixels"]) ** 2
    found = {}
    for level in item["levels"]:
        rows = np.array(level["rows"])
        if len(rows) < 6 or not np.all(np.diff(rows[:, 0]) > 0.0):  # too few contacts
            continue
        stiffness = rows[:, 2] * rows[:, 1] / rows[0, 2]
        bends = np.full(len(SHARES), np.nan)
        contacts = np.full(len(SHARES), np.nan)
        shares = rows[1:, 1]
        for k, wanted in enumerate(SHARES):
            if shares.size and shares[-1] < 1.02 * wanted:
                at = [math.log(wanted)]
                x = np.log(rows[::-1, 1])
                here = math.exp(np.interp(at, x, np.log(stiffness[::-1]))[0])
                bends[k] = (1.0 - here) / (1.0 - wanted)
                contacts[k] = np.interp(at, x, np.log(rows[::-1, 3] / rows[0, 3]))[0]
        found[level["level"]] = {
            "hardness": h, "pressure": level["pressure"], "breadth": item["breadth"],
            "stiffness": math.log(rows[0, 2]), "loading": max(level["loading"], 0.05),
            "separation": rows[0, 0], "contact": math.log(rows[0, 3]), "bends": bends,
            "contacts": contacts, "points": rows[0, 3] * points, "energies": energies(rows),
        }  # fmt: skip
    return found


def energies(rows, amplitudes=(0.1, 0.3, 1.0)):
    """Return the energies of cycles over k_t a^2 at amplitudes a, in units of mu N/k_t."""
    from scipy.interpolate import CubicHermiteSpline

    length = rows[0, 1] / rows[0, 2]
    x = (rows[:, 0] - rows[0, 0]) / length
    curve = CubicHermiteSpline(x, np.log(rows[:, 1]), -rows[:, 2] * length)
    found = []
    for a in amplitudes:
        if a > x[-1]:
            found.append(np.nan)
            continue
        u = np.linspace(0.0, a, 801)
        lost = 1.0 - np.exp(curve(u))
        found.append(8.0 * (np.trapezoid(lost, u) - 0.5 * a * lost[-1]) / a**2)
    return np.array(found)


def nodes_of(items):
    """Return the means over the faces of each node, and the changes by the pixel."""
    by_node, by_pixel = {}, {}
    for item in items:
        h = 1e9 if item["hardness"] is None else item["hardness"]
        for level, numbers in _numbers(item).items():
            if item["seed"] < 1000 or item["seed"] >= 2000:
                key = (item["hurst"], item["ratio"], h, level, item["waves"])
                by_node.setdefault(key, []).append(numbers)
            else:
                key = (item["hurst"], h, level, item["seed"])
                by_pixel.setdefault(key, {})[item["pixels"]] = numbers
    arrays = {}
    rows = []
    for key, group in sorted(by_node.items()):
        row = dict(zip(NODE, key, strict=True))
        row["counts"] = len(group)
        for name in ("pressure", "breadth", "stiffness", "separation", "contact", "points"):
            row[name] = np.mean([g[name] for g in group])
        row["spread"] = (
            np.std([g["stiffness"] for g in group], ddof=1) if len(group) > 1 else np.nan
        )
        row["loading"] = math.log(np.mean([g["loading"] for g in group]))
        for name in ("bends", "contacts", "energies"):
            values = np.array([g[name] for g in group])
            seen = np.isfinite(values)
            total = np.where(seen, values, 0.0).sum(axis=0)
            row[name] = np.where(seen.any(axis=0), total / np.maximum(seen.sum(axis=0), 1), np.nan)
        with np.errstate(invalid="ignore"):
            row["bends"] = np.log(np.where(row["bends"] > 1e-4, row["bends"], np.nan))
        rows.append(row)
    for name in rows[0]:
        arrays[name] = np.array([row[name] for row in rows])
    changes = [sizes for sizes in by_pixel.values() if set(sizes) == set(PIXEL_SIZES)]
    names = ("stiffness", "separation", "contact", "bends", "contacts")
    for name in ("hardness", "pressure"):
        arrays[f"pixel_{name}"] = np.array([sizes[6][name] for sizes in changes])
    for name in names:
        found = []
        for sizes in changes:
            coarse, middle, fine = (np.asarray(sizes[count][name]) for count in PIXEL_SIZES)
            if name == "bends":
                with np.errstate(invalid="ignore", divide="ignore"):
                    coarse, middle, fine = (
                        np.log(np.where(x > 1e-4, x, np.nan)) for x in (coarse, middle, fine)
                    )
            # What is missing falls with the pixel; the bends scatter too much to extrapolate them.
            limit = fine if name == "bends" else 2.0 * fine - middle
            found.append(limit - coarse)
        size = (len(SHARES),) if name in ("bends", "contacts") else ()
        arrays[f"pixel_{name}"] = np.array(found).reshape(len(changes), *size)
    return arrays


def merged(old, new):
    """Return the nodes of two sets of different faces, weighted by their numbers of faces.

    Nodes of fewer than FACES faces are left out.
    """
    names = NODE
    rows = {}
    for arrays in (old, new):
        nodes = zip(*(arrays[name] for name in (*names, "counts")), strict=True)
        for k, (hurst, ratio, h, level, waves, count) in enumerate(nodes):
            key = (*_node(hurst, ratio, h, waves), round(1000 * level))
            rows.setdefault(key, []).append((int(count), arrays, k))
    keys = sorted(key for key, parts in rows.items() if sum(part[0] for part in parts) >= FACES)
    found = {name: np.array([rows[key][0][1][name][rows[key][0][2]] for key in keys])
             for name in names}  # fmt: skip
    found["counts"] = np.array([sum(count for count, _, _ in rows[key]) for key in keys])
    for name in ("pressure", "breadth", "stiffness", "separation", "contact", "points",
                 "loading", "bends", "contacts", "energies"):  # fmt: skip
        means = []
        for key in keys:
            parts = np.array([np.asarray(a[name][k], dtype=float) for _, a, k in rows[key]])
            parts = np.exp(parts) if name in ("loading", "bends") else parts
            counts = np.array([count for count, _, _ in rows[key]], dtype=float)
            counts = np.where(np.isfinite(parts.T), counts, 0.0).T
            with np.errstate(invalid="ignore", divide="ignore"):
                mean = np.nansum(counts * parts, axis=0) / counts.sum(axis=0)
                means.append(np.log(mean) if name in ("loading", "bends") else mean)
        found[name] = np.array(means)
    squares = []
    for key, mean in zip(keys, found["stiffness"], strict=True):
        parts = [(n, a["stiffness"][k] - mean, np.nan_to_num(a["spread"][k]))
                 for n, a, k in rows[key]]  # fmt: skip
        total = sum(n for n, _, _ in parts)
        square = sum(n * off**2 + (n - 1) * spread**2 for n, off, spread in parts)
        squares.append(square / (total - 1) if total > 1 else np.nan)
    found["spread"] = np.sqrt(squares)
    weight = np.sqrt(found["counts"] * found["points"])
    found["weight"] = np.minimum(weight / np.median(weight), 3.0) ** 0.7
    for name in (name for name in old if name.startswith("pixel_")):
        found[name] = np.concatenate([old[name], new[name]])
    return found


def collect(path, target):
    """Average the faces with those of the shipped table, fit the nodes, and write the table."""
    from fit_face_table import fit

    from microslip.contact.face_table import stored

    have, pixels = stored_counts()
    items = []
    for item in lines(path):
        node = _node(*_job_of(item)[:3], item["waves"])
        of_pixels = 1000 <= item["seed"] < 2000
        if item["seed"] % 1000 >= (pixels if of_pixels else have).get(node, 0):
            items.append(item)
    arrays = merged(stored(), nodes_of(items))
    arrays = {
        name: array.astype(np.float32 if array.dtype.kind == "f" else np.int32)
        for name, array in arrays.items()
    }
    fitted = {f"fitted_{name}": array for name, array in fit(arrays).items()}
    np.savez_compressed(target, version=np.array(VERSION), **arrays, **fitted)
    print(f"{len(arrays['counts'])} nodes, {target.stat().st_size} bytes")


def report():
    """Print how far the fit is from the nodes."""
    from microslip.contact import face_table as table

    arrays = table.stored()
    found = table.values(arrays["hardness"], arrays["pressure"], arrays["breadth"])
    for least in (0.0, 0.01, 0.03):
        used = arrays["level"] >= least
        miss = np.log(found.stiffness) - arrays["stiffness"]
        loading = np.log(found.loading) - arrays["loading"]
        apart = found.separation - arrays["separation"]
        print(
            f"A >= {least}: {used.sum()} nodes, ln k rms {_rms(miss[used]):.3f} worst "
            f"{np.abs(miss[used]).max():.3f}, first loading {_rms(loading[used]):.3f}, "
            f"separation {_rms(apart[used]):.3f} R"
        )
        ratios = []
        for i in np.flatnonzero(used):
            form = table.shape(found.bends[i])
            rows = np.stack([form.distance, form.share, form.stiffness / form.share], axis=1)
            ratios.append(np.log(energies(rows)) - np.log(arrays["energies"][i]))
        ratios = np.array(ratios)
        mean, square = np.nanmean(ratios, axis=0), np.sqrt(np.nanmean(ratios**2, axis=0))
        print(f"    E(0.1, 0.3, 1): ln rms {np.round(square, 3)} mean {np.round(mean, 3)}")
    for ratio, waves in sorted(set(zip(arrays["ratio"], arrays["waves"], strict=True))):
        counts = arrays["counts"][(arrays["ratio"] == ratio) & (arrays["waves"] == waves)]
        print(f"ratio {ratio}, {waves} waves: {counts.size} nodes, {counts.min()} to "
              f"{counts.max()} faces")  # fmt: skip


def _rms(values):
    return math.sqrt(np.nanmean(np.asarray(values) ** 2))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("solve")
    command.add_argument("path", type=Path)
    command.add_argument("--minutes", type=float, default=120.0)
    command.add_argument("--part", default="1/1")
    command = commands.add_parser("collect")
    command.add_argument("path", type=Path)
    command.add_argument("--to", type=Path, default=TABLE)
    commands.add_parser("report")
    options = parser.parse_args()
    if options.command == "solve":
        solve(options.path, options.minutes, *map(int, options.part.split("/")))
    elif options.command == "collect":
        collect(options.path, options.to)
    else:
        report()


if __name__ == "__main__":
    main()
