"""Measured faces at bolt pressures: what boundary elements with yielding say, and what others say.

`python benchmarks/measured_faces.py [FOLDER]` solves two generated faces, and the middle of each
measured scan in FOLDER, of steel tightened to 100 MPa at two hardnesses, and writes the table of
docs/from-a-scan.md: what other normal laws say of stiffness and energy over what the face says
(boundary elements without yielding, summits one by one, Gaussian summits, and summits that have
yielded). With `--figure FILE` it draws the generated face
(`docs/images/measured_face.svg`), with `--milled FILE` it writes the scan that comes with the
examples (`examples/milled.npy`).
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rough_faces import rough

import microslip as ms
from microslip.figures.plot import COLORS, Area, Axis, Entry, Line, Panel, Plot
from microslip.figures.svg import svg

STEEL = ms.Material(210e9, 0.3)
PAIR = ms.MaterialPair(STEEL, STEEL)
FRICTION = 0.3
POINTS = 256
HEADS = (
    *("hardness", "p/E\\*h′", "area", "at the hardness", "scatter", "λ by direction"),
    *("elastic", "summits one by one", "Gaussian"),
)


def generated() -> ms.Scan:
    """A face like a fine-milled one: 0.5 um rms, waves of 18 to 60 um."""
    heights = rough(POINTS, 2e-6, 5e-7, longest=6e-5, shortest=1.77e-5, seed=3)
    return ms.Scan(heights, 2e-6)


def milled(points: int = 256, pixel: float = 2.5e-6, seed: int = 4) -> np.ndarray:
    """Heights [nm] of a face milled by a round nose, 0.1 mm a tooth, with finer roughness.

    Grooves of the nose along the arcs of the cutter, each tooth a little deeper or beside, and
    self-affine waves of 15 to 60 um across the lay, three times as long along it.
    """
    rng = np.random.default_rng(seed)
    x = np.arange(points) * pixel
    y = x[:, None]
    feed, nose, cutter = 0.1e-3, 0.8e-3, 12e-3
    z = np.full((points, points), np.inf)
    for tooth in range(-1, math.ceil(x[-1] / feed) + 2):
        centre = (tooth + 0.37) * feed + (y - 0.4 * x[-1]) ** 2 / (2.0 * cutter)
        centre = centre + rng.normal(scale=4e-6)
        z = np.minimum(z, (x - centre) ** 2 / (2.0 * nose) + rng.normal(scale=0.2e-6))
    n = 2 * points
    q = np.hypot(np.fft.rfftfreq(n, pixel), 3.0 * np.fft.fftfreq(n, pixel)[:, None])
    size = np.where((q > 0.0) & (q < 1.0 / 15e-6), np.maximum(q, 1.0 / 60e-6) ** -1.8, 0.0)
    waves = np.fft.irfft2(size * np.exp(2j * np.pi * rng.random(q.shape)), s=(n, n))
    waves = waves[:points, :points]
    z = z + 0.3e-6 * waves / waves.std()
    return np.round(1e9 * (z - z.mean())).astype(np.int16)


def middle(path: Path) -> ms.Scan:
    """The middle of a scan, levelled, filled and without waves below four pixels."""
    scan = ms.Scan.read(path).condition(level="plane", fill="interpolate")
    scan = scan.condition(cutoff=4.0 * float(np.mean(scan.pixel)))
    row, column = (max((n - POINTS) // 2, 0) for n in scan.heights.shape)
    return ms.Scan(
        scan.heights[row : row + POINTS, column : column + POINTS], scan.pixel
    ).condition(level="plane")


def laws(face: ms.Scan, pressure: float, hardness: float) -> dict[str, Callable[[], ms.NormalLaw]]:
    """The normal law of a face by each way."""
    how = {"tightening_pressure": pressure, "piece": POINTS // 2}
    one_by_one = {"heights": "population"}

    def summits(**kind) -> ms.NormalLaw:
        return face.summits(None, prominence=0.0).to_surface(PAIR, **kind)

    return {
        "measured face": lambda: face.to_contact(PAIR, hardness=hardness, **how),
        "elastic": lambda: face.to_contact(PAIR, hardness=math.inf, **how),
        "summits": lambda: summits(**one_by_one),
        "Gaussian": summits,
    }


def compared(face: ms.Scan, pressure: float, hardness: float) -> str:
    """Stiffness and energy of each law over those of the yielded face: a row of a table."""
    load = pressure * face.area
    every = laws(face, pressure, hardness)
    truth = ms.Interface(every.pop("measured face")(), FRICTION, normal_load=load)
    n = truth.surface.numbers
    amplitude = truth.force_limit / truth.tangential_stiffness
    low, high = n.stiffness_ratios
    cells = [
        f"{hardness / 1e9:g} GPa",
        f"{n.relative_pressure:.2g}",
        f"{100 * n.contact_share:.1f} %",
    ]
    cells += [
        f"{100 * n.hard_share:.0f} %",
        f"{n.scatter or math.nan:.2f}",
        f"{low:.2f} to {high:.2f}",
    ]
    for name, law in every.items():
        try:
            joint = ms.Interface(law(), FRICTION, normal_load=load)
        except ms.InputError as error:
            print(f"{name}: {error}", file=sys.stderr)
            cells.append("–")
            continue
        energy = joint.dissipated_energy(amplitude) / truth.dissipated_energy(amplitude)
        cells.append(f"{joint.normal_stiffness / truth.normal_stiffness:.2f} ({energy:.2f})")
    return " | ".join(cells)


def figure(path: Path) -> None:
    """Loads over separations with the band of pieces, contact at three loads, loops by each way."""
    face, pressure = generated(), 1e8
    load = pressure * face.area
    every = {name: law() for name, law in laws(face, pressure, 2.5e9).items()}
    solved = every["measured face"]
    assert isinstance(solved, ms.MeasuredContact)
    p = np.geomspace(1.0, 3e-3, 60) * 0.999 * load
    count = solved.numbers.pieces
    steps = [
        d - d[0] for d in (np.asarray(solved.of_pieces([i]).separation(p)) for i in range(count))
    ]
    loads = p / face.area / 1e6
    low, high = (1e6 * reach(steps, axis=0) for reach in (np.min, np.max))
    curves = Panel(
        x=Axis("separation, from where it bears 100 MPa [µm]"), y=Axis("pressure [MPa]", log=True)
    )
    curves.items.append(Area(np.append(low, high[::-1]), np.append(loads, loads[::-1])))
    loops = Panel(x=Axis("displacement [nm]"), y=Axis("friction over normal load [-]"))
    truth = ms.Interface(solved, FRICTION, normal_load=load)
    top = 1.5 * truth.force_limit / truth.tangential_stiffness
    entries = []
    for color, (name, law) in zip(COLORS, every.items(), strict=False):
        d = np.asarray(law.separation(p))
        width = 2.2 if law is solved else 1.2
        curves.items.append(Line(1e6 * (d - d[0]), loads, color, width))
        loop = ms.Interface(law, FRICTION, normal_load=load).loop(top, samples=200)
        loops.items.append(Line(1e9 * loop.displacement, loop.force / load, color, width))
        entries.append(Entry(name, color))
    entries.append(Entry("pieces of the face", "#e8e8e8"))
    loops.cell = (0, 0, 1, 1)
    page = Plot([curves, loops], 3.6, widths=(1.0, 1.0), legend=tuple(entries))
    path.write_bytes(svg(page))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--milled", type=Path)
    given = parser.parse_args()
    if given.milled:
        np.save(given.milled, milled())
    elif given.figure:
        figure(given.figure)
    else:
        faces = {"generated": generated(), "milled": ms.Scan(1e-9 * milled(), 2.5e-6)}
        for file in sorted(given.folder.iterdir()) if given.folder else ():
            if file.suffix in (".plu", ".mnt", ".al3d"):
                faces[file.name] = middle(file)
        print(f"| face | rms | {' | '.join(HEADS)} |\n|{' --- |' * (len(HEADS) + 2)}")
        for title, one in faces.items():
            for bound in (2.5e9, 1e9):
                rms = f"{one.statistics().rms * 1e6:.2f} µm"
                print(f"| {title} | {rms} | {compared(one, 1e8, bound)} |", flush=True)
