"""
Shocks: the vibration that a pulse leaves depends on its severity
=================================================================

Half-sine pulses of the base of three masses in a row, a rough joint between the first two,
integrated in time with the state of the joint. Divided by the peak of the pulse the motions of a
linear structure would be the same.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

metal = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(metal, metal), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)
mass = np.diag([2.0, 3.0, 2.0])
stiffness = 2e9 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
bar = ms.Structure(mass, stiffness, 2e-7 * stiffness).attach(joint, directions=[1.0, -1.0, 0.0])

# %%
# Accelerations of the tip over that of the pulse, for three severities.

tip = np.array([0.0, 0.0, 1.0])
figure, axes = plt.subplots()
for severity in (30.0, 300.0, 3000.0):
    pulse = ms.Pulse.half_sine(amplitude=severity, duration=0.5e-3)
    shock = bar.shock(pulse, directions=np.ones(3), duration=5e-3)
    peak = shock.peak(tip, "acceleration")
    motion = shock.history(tip, "acceleration") / severity
    rest = np.abs(motion[shock.time > 5e-3]).max()
    print(
        f"{severity:4.0f} m/s²: {peak / severity:.2f} of the pulse at the tip, {rest:.2f} rms later"
    )
    axes.plot(1e3 * shock.time, motion, label=f"{severity:g} m/s²")
axes.set(xlabel="time [ms]", ylabel="acceleration, tip over peak of the pulse")
axes.legend(title="peak of the pulse")

plt.show()
