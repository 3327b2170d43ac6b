"""
Several laps: two bars on the ground, with a mass at the end
============================================================

A bar of steel, bolted to rigid ground, and a bar of aluminium, bolted to the first. Each part has a
material and a density of its own, and a mass of 20 g is fixed to the free end.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

steel = ms.Material(young_modulus=200e9, poisson_ratio=0.3)
aluminium = ms.Material(young_modulus=70e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(steel, aluminium), ms.Gaussian(std=1e-6), radius=1e-3, density=5e7, area=1e-4
)
bolts = ms.Bolts([0.0], size="M6", tension=5e3)
beam = ms.BoltedBeam(
    length=0.26,
    width=0.02,
    thickness=0.006,
    style="single-lap",
    ground="left",
    laps=[ms.Lap(-0.115, 0.03, bolts), ms.Lap(0.0, 0.03, bolts)],
)
end = (0.13, 0.0, -0.003)
joint = beam.reduce(
    [steel, aluminium],
    [7800.0, 2700.0],
    (3, 1),
    element_size=0.015,
    sensors={"end": (end, "z")},
    masses={end: 0.02},
)

# %%
# Patches of the first lap, on the ground, are contact 0, those of the second contact 1.

state = joint.tightened(surface, friction_coefficient=0.3)
amplitudes = np.geomspace(1e-6, 2e-4, 7)
figure, (above, below) = plt.subplots(2, 1, sharex=True)
for index in (0, 2):  # the second bends sideways
    curve = state.modes(index, amplitudes, at=joint.sensor("end"), damping_ratio=0.0005)
    on_ground = curve.loss_share[-1, joint.patch_contacts == 0].sum()
    print(
        f"mode {index + 1}: {curve.frequency[0]:.1f} to {curve.frequency[-1]:.1f} Hz, damping "
        f"ratio up to {curve.damping_ratio.max():.5f}, "
        f"{100 * on_ground:.0f}% of the loss on the ground"
    )
    change = 100.0 * (curve.frequency / curve.linear_frequency - 1.0)
    above.plot(1e6 * amplitudes, change, label=f"mode {index + 1}")
    below.plot(1e6 * amplitudes, curve.damping_ratio)
above.set(ylabel="frequency change [%]")
above.legend()
below.set(xscale="log", yscale="log", xlabel="amplitude of the end [µm]", ylabel="damping ratio")

plt.show()
