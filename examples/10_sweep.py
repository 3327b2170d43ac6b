"""
A map of damping
================

``evaluate`` computes a joint at many loads and amplitudes at once: here forty thousand points, in a
fraction of a second.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)

# %%
# Two axes and the quantities wanted. The arguments broadcast as in NumPy: loads along the rows,
# amplitudes along the columns.

loads, amplitudes = np.geomspace(100.0, 10e3, 200), np.geomspace(1e-8, 1e-5, 200)
grid = ms.evaluate(
    surface=surface,
    friction_coefficient=0.55,
    normal_load=loads[:, None],
    amplitude=amplitudes,
    quantities=["dissipated_energy", "loss_factor", "force_amplitude"],
)
print(*(f"{name} {values.shape}" for name, values in grid.items()))

# %%
# At a given force amplitude a joint dissipates most at the smallest load that still holds the
# force; at larger loads less of it slips. Force amplitudes need loads whose force limit is above
# them.

pushed = ms.evaluate(
    surface=surface,
    friction_coefficient=0.55,
    normal_load=np.linspace(750.0, 5000.0, 400),
    force_amplitude=400.0,
)
energy = pushed["dissipated_energy"]
print(f"pushed with ±400 N: {energy[0] * 1e6:.0f} µJ at 750 N, {energy[-1] * 1e6:.2f} µJ at 5 kN")

# %%
# At a given displacement the largest load dissipates most, but has the smallest loss factor.

at = np.searchsorted(amplitudes, 3e-7)
losses = grid["loss_factor"][:, at]
print(f"moved by ±0.3 µm: loss factor {losses[0]:.3f} at 100 N, {losses[-1]:.3f} at 10 kN")

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.5), sharey=True)
fig.get_layout_engine().set(wspace=0.08)
x, y = amplitudes * 1e6, loads / 1e3
for axes, name, norm, label in (
    (left, "loss_factor", None, "Loss factor η [–]"),
    (right, "dissipated_energy", LogNorm(), "Energy per cycle [J]"),
):
    image = axes.pcolormesh(x, y, grid[name], norm=norm, cmap="cividis", rasterized=True)
    lines = axes.contour(
        x, y, grid["force_amplitude"], levels=[10, 100, 1000], colors="white", linewidths=0.8
    )
    axes.clabel(lines, fmt="%g N", fontsize=7)
    fig.colorbar(image, ax=axes, location="top", label=label)
    axes.set(xscale="log", yscale="log", xlabel="Displacement amplitude [µm]")
    axes.grid(visible=False)
left.set_ylabel("Normal load [kN]")
plt.show()
