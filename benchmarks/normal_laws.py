"""Compare the normal law of rough surfaces by boundary elements and by summits.

`python benchmarks/normal_laws.py [FOLDER]` prints, for a self-affine surface and for a piece of
each measured scan in FOLDER, separations and stiffness under loads: of an elastic half space by
boundary elements (`real_area.py`), and of the summits that are counted, with Gaussian heights and
one by one. Pieces of scans are mirrored at their sides, so that
they are periodic. The figure of the page on normal laws is `docs/images/normal_laws.svg`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from real_area import LENGTH, MODULUS, solve, surface

import microslip as ms

LOADS = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)  # pressure over E* and rms slope
WAYS = {
    "solved": "boundary elements",
    "gaussian": "Gaussian summits",
    "population": "summits one by one",
}
SCANS = {
    "plu-1.plu": "machined, with a lay",
    "mnt-1.mnt": "polished, with pits",
    "al3d-1.al3d": "focus variation",
}
STEP = 1.02
PAIR = ms.MaterialPair(ms.Material(MODULUS, 0.0), ms.Material.rigid())


def measured(path: Path, points: int = 128, cutoff: float = 8.0) -> np.ndarray:
    """The middle of a scan without waves below some pixels, mirrored: heights [m].

    Scaled to the side that the boundary elements have; ratios do not know it.
    """
    scan = ms.Scan.read(path).condition(level="plane", fill="interpolate")
    pixel = float(np.mean(scan.pixel))
    scan = scan.condition(cutoff=cutoff * pixel)
    row, column = (max((n - points) // 2, 0) for n in scan.heights.shape)
    z = scan.heights[row : row + points, column : column + points]
    z = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
    return np.asarray((z - z.mean()) * (LENGTH / (z.shape[0] * pixel)))


def compare(z: np.ndarray, loads: tuple[float, ...] = LOADS) -> dict[str, np.ndarray]:
    """Of each way a row a load: separation over rms height, stiffness times rms height over load.

    In the middle between a load and one that is two per cent larger.
    """
    scan = ms.Scan(z, pixel=LENGTH / z.shape[0])
    rms = float(z.std())
    q = 2.0 * np.pi * np.fft.fftfreq(z.shape[0], LENGTH / z.shape[0])
    rms_slope = float(np.linalg.norm(np.hypot(q[:, None], q) * np.fft.fft2(z)) / z.size)
    summits = scan.summits(None, prominence=0.0)
    laws: dict[str, Any] = {
        "gaussian": summits.to_surface(PAIR),
        "population": summits.to_surface(PAIR, heights="population"),
    }
    curves: dict[str, list[tuple[float, float]]] = {way: [] for way in WAYS}
    p = None
    for share in loads:
        pressure = share * MODULUS * rms_slope
        p, far = solve(z, pressure, p)
        _, near = solve(z, STEP * pressure, p)
        middle = 0.5 * (1.0 + STEP) * pressure * scan.area
        rise = (STEP - 1.0) * pressure * scan.area / middle
        curves["solved"].append((0.5 * (far + near) / rms, rise * rms / (far - near)))
        for way, law in laws.items():
            d = float(law.separation(middle))
            curves[way].append((d / rms, float(law.stiffness(d)) * rms / middle))
    return {way: np.array(rows) for way, rows in curves.items()}


def all_surfaces(folder: Path | None) -> dict[str, np.ndarray]:
    """A self-affine surface, and pieces of the scans that are there."""
    surfaces = {"self-affine, H = 0.8": surface(256, 4, 32, 1)}
    for name, title in SCANS.items():
        if folder is not None and (folder / name).is_file():
            surfaces[title] = measured(folder / name)
    return surfaces


def draw(curves: dict[str, dict[str, np.ndarray]], path: Path) -> None:
    """Stiffness over load of every surface, by each way."""
    from microslip.figures.plot import COLORS, DASHES, Axis, Entry, Panel, Plot
    from microslip.figures.svg import svg

    panels = []
    for place, (name, ways) in enumerate(curves.items()):
        row, column = divmod(place, 2)
        below = row == 0 and len(curves) > 2
        panel = Panel(
            Axis("" if below else "Mean pressure over E* h′ [–]", log=True, bare=below),
            Axis("" if column else "Stiffness × rms height / load [–]", log=True),
            note=name[:1].upper() + name[1:],
            cell=(row, row, column, column),
        )
        for index, way in enumerate(WAYS):
            values = ways[way][:, 1]
            if way == "solved":
                panel.marks(np.array(LOADS), values, "#222222", marker="o")
            else:
                panel.line(np.array(LOADS), values, COLORS[index - 1], dash=DASHES[index - 1])
        panels.append(panel)
    legend = [Entry(WAYS["solved"], "#222222", marker="o", line=False)]
    legend += [
        Entry(title, COLORS[i], DASHES[i]) for i, title in enumerate(list(WAYS.values())[1:])
    ]
    rows = (len(panels) + 1) // 2
    plot = Plot(
        panels,
        2.9 * rows + 0.6,
        "",
        heights=(1.0,) * rows,
        widths=(1.0,) * min(len(panels), 2),
        legend=tuple(legend),
    )
    path.write_bytes(svg(plot))


def main() -> None:
    """Print the comparison of every surface and draw it."""
    curves = {}
    for name, z in all_surfaces(Path(sys.argv[1]) if len(sys.argv) > 1 else None).items():
        curves[name] = compare(z)
        print(f"{name}: kurtosis {float((z**4).mean() / (z**2).mean() ** 2):.3g}")
        print("  p/E*h'   " + "".join(f"{title:>22}" for title in WAYS.values()))
        for index, share in enumerate(LOADS):
            cells = (
                f"{ways[index, 0]:>12.3f} {ways[index, 1]:>9.3f}" for ways in curves[name].values()
            )
            print(f"  {share:<9g}" + "".join(cells))
    draw(curves, Path(__file__).parents[1] / "docs/images/normal_laws.svg")


if __name__ == "__main__":
    main()
