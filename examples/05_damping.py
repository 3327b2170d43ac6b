"""
Damping against amplitude, and its limits
=========================================

Energy and damping come from a closed form, without sampled loops, and are accurate at small
amplitudes, too. The energy grows with the cube of small amplitudes and in proportion to large ones;
the power laws fitted to tests lie in between.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)

amplitude = np.geomspace(1e-10, 1e-3, 400)
energy = joint.dissipated_energy(amplitude)

# %%
# Two asymptotes of the curve: (2/3)(μ/κ²) N″ δ³ from the curvature of the normal
# law, and 4μN (δ - δ₀) from gross slip. Neither is
# fitted.

mu, kappa, d = 0.55, joint.slip_per_indentation, joint.separation
step = 1e-4 * 5e-7
curvature = (surface.stiffness(d - step) - surface.stiffness(d + step)) / (2.0 * step)
cubic = 2.0 / 3.0 * mu / kappa**2 * curvature
offset = amplitude[-1] - energy[-1] / (4.0 * joint.force_limit)
share = energy[0] / (cubic * amplitude[0] ** 3)
print(f"small: E = {cubic:.4e} J/m³ δ³, at 0.1 nm it is {share:.5f} of that")
print(f"large: E = 4μN (δ - {offset * 1e6:.4f} µm)")

# %%
# The loss factor is (19.30) of the chapter, which calls it the damping ratio; the equivalent
# viscous damping ratio is half of it. Both belong to the interface, not to a mode of a structure.

loss, ratio = joint.loss_factor(1e-6), joint.damping_ratio(1e-6)
print(f"at 1 µm: loss factor {loss:.5f}, damping ratio {ratio:.5f}")
print(f"at 1 mm: loss factor {joint.loss_factor(1e-3):.5f}; in the limit {4 / np.pi:.5f}")

# %%
# The local exponent is that of a power law fitted at this amplitude.

exponents = joint.dissipation_exponent([1e-9, 1e-8, 1e-7, 3e-7, 1e-6, 1e-5])
print("exponent from 1 nm to 10 µm:", *(f"{value:.3f}" for value in exponents))

fig, (top, middle, bottom) = plt.subplots(3, 1, figsize=(7.1, 7.2), sharex=True)
top.loglog(amplitude * 1e6, energy)
top.loglog(amplitude * 1e6, cubic * amplitude**3, "--", color="#666666", linewidth=0.9)
past = amplitude > 1.05 * offset
linear = 4.0 * joint.force_limit * (amplitude[past] - offset)
top.loglog(amplitude[past] * 1e6, linear, "--", color="#666666", linewidth=0.9)
top.set(ylabel="Energy per cycle [J]", ylim=(energy[0] / 3.0, 10.0 * energy[-1]))
middle.semilogx(amplitude * 1e6, joint.loss_factor(amplitude))
middle.axhline(4.0 / np.pi, color="#666666", linestyle="--", linewidth=0.9)
middle.annotate("rigid–plastic, 4/π", (1.2e-4, 4.0 / np.pi), (0, 3), textcoords="offset points")
middle.set(ylabel="Loss factor η [–]", ylim=(0.0, 1.5))
bottom.semilogx(amplitude * 1e6, joint.dissipation_exponent(amplitude))
bottom.set(xlabel="Amplitude [µm]", ylabel="Exponent [–]", ylim=(0.8, 3.2))
plt.show()
