"""
Large bending: a thin, curved panel softens, then stiffens
==========================================================

A curved strip of sheet, bolted at both ends to a rigid frame, as in the Tribomechadynamics Research
Challenge (Krack et al. 2025, DOI 10.1016/j.ymssp.2024.112016). Its stiffness changes as it bends:
``bending`` computes static cases of the strip, ``with_geometry`` takes these or those of a
finite-element code.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

steel = ms.Material(young_modulus=206e9, poisson_ratio=0.3)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(steel, steel), ms.Gaussian(std=1e-6), radius=1e-3, density=1e8, area=1e-4
)
bolts = ms.Bolts([0.0], size="M6", tension=8e3)
panel = ms.BoltedBeam(
    length=0.35,
    width=0.025,
    thickness=1.5e-3,
    rise=0.99e-3,
    style="single-lap",
    ground=["left", "right"],
    laps=[ms.Lap(-0.16, 0.03, bolts), ms.Lap(0.16, 0.03, bolts)],
)
bending = panel.bending(steel)
joint = panel.reduce(
    steel,
    7800.0,
    (3, 1),
    element_size=0.02,
    sensors={**bending.sensors, "middle": ((0.0, 0.0, 1.75e-3), "z")},
)

# %%
# The same joint with its geometry and without it: the frequency falls by the curvature of the
# panel, far more than by slip in the joints.

amplitudes = np.geomspace(2e-5, 1.4e-3, 7)
figure, axes = plt.subplots()
for label, model in (("linear", joint), ("with geometry", joint.with_geometry(*bending))):
    state = model.tightened(surface, friction_coefficient=0.3)
    curve = state.modes(0, amplitudes, at=model.sensor("middle"), damping_ratio=0.0046)
    change = 100.0 * (curve.frequency / curve.frequency[0] - 1.0)
    print(f"{label}: {curve.frequency[0]:.1f} Hz, {change[-1]:+.1f}% at 1.4 mm")
    axes.plot(1e3 * amplitudes, change, label=label)
axes.set(xscale="log", xlabel="amplitude of the middle [mm]", ylabel="change of the frequency [%]")
axes.legend()

plt.show()
