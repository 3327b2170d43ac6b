"""How much a boundary-element solution is stiffer than summits that do not feel each other.

`python benchmarks/real_area.py [SEED]` prints, for a periodic Gaussian surface, the interfacial
stiffness of the elastic half space over that of its summits one by one and of Gaussian heights
fitted to them, against the real area that the summits have. The limits of the verdict on the real
area stand on it. Pressures are found by conjugate gradients with a fast Fourier transform (Polonsky
and Keer 1999, DOI 10.1016/S0043-1648(99)00113-1; Stanley and Kato 1997, DOI 10.1115/1.2833523).
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

import microslip as ms

MODULUS = 1e11  # E* [Pa]; results are ratios and do not know it
LENGTH = 1e-3
SLOPE = 0.05
LOADS = (0.0003, 0.001, 0.003, 0.006, 0.01, 0.02, 0.03, 0.05, 0.08)  # pressure over E* slope


def surface(points: int, roll_off: int, shortest: int, seed: int) -> np.ndarray:
    """Heights [m] of a self-affine surface (H = 0.8), wavenumbers in waves a side."""
    q = np.hypot(*np.meshgrid(*[np.fft.fftfreq(points, 1.0 / points)] * 2))
    amplitude = np.where((q > 0.0) & (q <= shortest), np.maximum(q, roll_off) ** -1.8, 0.0)
    noise = np.random.default_rng(seed).standard_normal((points, points))
    z = np.fft.ifft2(np.fft.fft2(noise) * amplitude).real
    step = LENGTH / points
    slope = np.sqrt(np.mean((np.roll(z, -1, 0) - z) ** 2)) / step
    return np.asarray(z * SLOPE / slope)


def solve(
    z: np.ndarray, pressure: float, start: np.ndarray | None = None
) -> tuple[np.ndarray, float]:
    """Pressures [Pa] at a mean pressure, and the separation of the mean planes [m]."""
    points = z.shape[0]
    q = (
        2.0
        * np.pi
        * np.hypot(
            *np.meshgrid(
                np.fft.fftfreq(points, LENGTH / points),
                np.fft.rfftfreq(points, LENGTH / points),
                indexing="ij",
            )
        )
    )
    green = np.divide(2.0 / MODULUS, q, out=np.zeros_like(q), where=q > 0.0)

    def bent(p: np.ndarray) -> np.ndarray:
        return np.fft.irfft2(green * np.fft.rfft2(p), s=z.shape)

    p = np.full(z.shape, pressure) if start is None else start * (pressure / start.mean())
    direction, last, conjugate = np.zeros(z.shape), 1.0, 0.0
    for _ in range(5000):
        touching = p > 0.0
        gap = bent(p) - z
        gap -= gap[touching].mean()
        size = float((gap[touching] ** 2).sum())
        direction = np.where(touching, gap + conjugate * size / last * direction, 0.0)
        last, conjugate, old = size, 1.0, p
        change = bent(direction)
        change -= change[touching].mean()
        step = (gap[touching] @ direction[touching]) / (change[touching] @ direction[touching])
        p = np.maximum(np.where(touching, p - step * direction, p), 0.0)
        inside = (p == 0.0) & (gap < 0.0)
        if inside.any():
            conjugate = 0.0
            p[inside] -= step * gap[inside]
        p *= pressure / p.mean()
        if np.abs(p - old).sum() < 1e-6 * p.sum():
            break
    return p, float((z - bent(p))[p > 0.0].mean())


def compare(
    points: int, roll_off: int, shortest: int, seed: int, loads: tuple[float, ...] = LOADS
) -> list[dict[str, float]]:
    """Of each load the real areas and the stiffness over that of the summits, by both laws."""
    z = surface(points, roll_off, shortest, seed)
    pair = ms.MaterialPair(ms.Material(MODULUS, 0.0), ms.Material.rigid())
    scan = ms.Scan(z, pixel=LENGTH / points)
    summits = scan.summits(None, prominence=0.0)
    laws: dict[str, Any] = {
        "population": summits.to_surface(pair, heights="population"),
        "gaussian": summits.to_surface(pair),
    }
    rows, p = [], None
    for load in loads:
        pressure = load * MODULUS * SLOPE
        p, separation = solve(z, pressure, p)
        _, nearer = solve(z, 1.02 * pressure, p)
        stiffness = 0.02 * pressure / (separation - nearer) * scan.area
        row = {"pressure": pressure, "solved": float((p > 0.0).mean())}
        for name, law in laws.items():
            d = law.separation(pressure * scan.area)
            row[f"{name} area"] = float(law.contact_area(d)) / scan.area
            row[f"{name} ratio"] = stiffness / float(law.stiffness(d))
        rows.append(row)
    return rows


def main() -> None:
    """Print the comparison of one seed for three bands of waves."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    for points, roll_off, shortest in ((256, 8, 24), (512, 8, 48), (512, 4, 48)):
        print(f"{points} points, waves from 1/{roll_off} to 1/{shortest} of the side, seed {seed}")
        for row in compare(points, roll_off, shortest, seed):
            print("  " + ", ".join(f"{name} {value:.4g}" for name, value in row.items()))


if __name__ == "__main__":
    main()
