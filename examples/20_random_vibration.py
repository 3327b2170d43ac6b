"""
Random vibration: the equivalent frequency and damping depend on the level
==========================================================================

Three masses in a row on a base, a rough joint between the first two. Each joint is replaced by the
spring and dashpot that are equivalent over the amplitudes of narrow-band noise, which depend on the
response and are found with it.
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
# The base moves with white noise between 1 and 4 kHz, at three levels.

tip = [0.0, 0.0, 1.0]
frequencies = np.linspace(1000.0, 4000.0, 600)
figure, axes = plt.subplots()
for level in (0.01, 0.1, 1.0):
    noise = bar.random_response(([1000.0, 4000.0], [level, level]), directions=np.ones(3))
    print(
        f"{level:g} (m/s²)²/Hz: {noise.frequency[0]:.0f} Hz, damping ratio "
        f"{noise.damping_ratio[0]:.4f}, {noise.standard_deviation(tip, 'acceleration'):.0f} m/s² "
        f"rms, peaks of {noise.peak(tip, 60.0, 'acceleration'):.0f} m/s² in a minute"
    )
    density = noise.spectrum(tip, frequencies, "acceleration")
    axes.plot(frequencies, density / level, label=f"{level:g} (m/s²)²/Hz")
axes.set(yscale="log", xlabel="frequency [Hz]", ylabel="spectral density, tip over base")
axes.legend(title="level of the base")

plt.show()
