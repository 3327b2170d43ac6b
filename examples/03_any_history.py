"""
Any history
===========

The memory of a joint is its open reversals. When a minor loop closes, its reversals are removed
and the interrupted branch continues. This is exact for any record, and costs nanoseconds for each
sample.
"""

from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)

# %%
# Loading, unloading, and on reloading a minor loop from 0.1 to -0.35 µm. It closes at 0.1 µm, and
# the major loop continues from there.

corners = np.array([0.0, 0.9, -0.9, 0.1, -0.35, 0.9]) * 1e-6
print("turns:", *(f"{force:.1f}" for force in joint.force(corners)), "N")

rise = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 80))
record = np.concatenate([a + (b - a) * rise for a, b in pairwise(corners)])
force = joint.force(record)

without = joint.force([0.0, 0.9e-6, -0.9e-6, 0.5e-6])[-1]
detour = joint.force([0.0, 0.9e-6, -0.9e-6, 0.1e-6, -0.35e-6, 0.5e-6])[-1]
print(f"at 0.5 µm: {without:.3f} N without the detour, {detour:.3f} N after it")

# %%
# Band-limited noise with a million samples, as in a measured record. It has many nested loops.

rng = np.random.default_rng(7)
noise = rng.standard_normal(1_000_000)
spectrum = np.fft.rfft(noise)
spectrum[4000:] = 0.0
noise = np.fft.irfft(spectrum)
noise *= 0.2e-6 / noise.std()
response = joint.force(noise)
work = np.trapezoid(response, noise)
turns = np.count_nonzero(np.diff(np.sign(np.diff(noise))))
largest = abs(response).max() / joint.force_limit
print(f"{noise.size} samples, {turns} turns")
print(f"work put in: {work:.3f} J; largest force: {largest:.4f} of the limit")

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.6), sharey=True)
left.plot(record * 1e6, force / 1e3)
left.set(xlabel="Displacement [µm]", ylabel="Force [kN]", title="A loop that closes on the way")
right.plot(noise[:6000] * 1e6, response[:6000] / 1e3, linewidth=0.7)
right.set(xlabel="Displacement [µm]", title="Noise, its first 6000 samples")
plt.show()
