"""
A structure with a joint: frequency and damping before it is built
==================================================================

A clamped beam in two lapped and bolted halves that slide on each other at one place. The damping
depends on the amplitude and on the motion of each mode at the joint.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

steel = ms.Material(young_modulus=210e9, poisson_ratio=0.3)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(steel, steel), ms.Gaussian(std=1e-6), radius=1e-3, density=1e8, area=4e-4
)
joint = ms.Interface(surface, friction_coefficient=0.3, normal_load=3000.0)

# %%
# The beam as masses in a row, stretched lengthwise: eight on each side of the joint, clamped at
# one end. Springs and masses are those of a bar of 25 mm x 25 mm and half a metre.

count, length, section = 16, 0.5, 6.25e-4
step = length / count
spring = 210e9 * section / step
stiffness = np.zeros((count, count))
for i in range(count):
    stiffness[i, i] += spring  # to the mass before it, or to the clamp
    if i > 0:
        stiffness[i - 1, i - 1] += spring
        stiffness[i - 1, i] -= spring
        stiffness[i, i - 1] -= spring
# In the middle a quarter of the section is continuous; the joint carries the rest.
left, right = count // 2 - 1, count // 2
across = np.zeros(count)
across[left], across[right] = -1.0, 1.0
stiffness -= 0.75 * spring * np.outer(across, across)
mass = 7850.0 * section * step * np.eye(count)
mass[-1, -1] += 1.0  # a block of 1 kg at the free end
bar = ms.Structure(mass, stiffness).attach(joint, directions=across)
stuck = bar.linear_modes(2).frequency
free = ms.Structure(mass, stiffness).linear_modes(2).frequency
print(f"sticking {stuck[0]:.0f} and {stuck[1]:.0f} Hz, sliding {free[0]:.0f} and {free[1]:.0f} Hz")

# %%
# Nonlinear modes by harmonic balance, compared with the quasi-static estimate.
# Amplitudes are those of the tip; 0.05 % of damping is added for all other causes.

tip = np.zeros(count)
tip[-1] = 1.0
amplitudes = np.geomspace(1e-6, 1e-4, 25)
figure, (above, below) = plt.subplots(2, 1, sharex=True)
for index in (0, 1):
    curve = bar.modes(index, amplitudes, at=tip, damping_ratio=0.0005)
    quick = bar.modes(
        index, amplitudes, at=tip, damping_ratio=0.0005, method="quasi-static"
    ).damping_ratio
    worst = np.abs(quick / curve.damping_ratio - 1.0).max()
    print(
        f"mode {index + 1}: {curve.frequency[0]:.1f} to {curve.frequency[-1]:.1f} Hz, damping up "
        f"to {curve.damping_ratio.max():.4f}; the quick look is off by {100 * worst:.0f}% at most"
    )
    above.plot(
        amplitudes * 1e6, curve.frequency / curve.linear_frequency, label=f"mode {index + 1}"
    )
    line = below.plot(amplitudes * 1e6, curve.damping_ratio)[0]
    below.plot(amplitudes * 1e6, quick, "--", color=line.get_color())
above.set(ylabel="frequency over that fully stuck")
above.legend()
below.set(xscale="log", yscale="log", xlabel="amplitude of the tip [µm]", ylabel="damping ratio")
below.plot([], [], "k--", label="quasi-static")
below.legend()

# %%
# Released at 3 µm at the tip and evaluated like a test: with many cycles of decay the damping is
# close to that of the mode. A ring-down in gross slip, with a large loss in each cycle, shows more.

curve = bar.modes(0, [3e-6], at=tip)
shape = np.real(curve.shape[0])
period = 1.0 / curve.frequency[0]
time = np.arange(0.0, 25 * period, period / 200)
motion = bar.integrate(None, time, displacement=3e-6 * shape / shape[-1])
decay = ms.read_decay(motion.time, motion.displacement @ tip)
along = bar.modes(0, decay.amplitude[8:20:4], at=tip)
ratio = decay.damping_ratio[8:20:4] / along.damping_ratio
print(f"energy kept to {motion.energy_error:.0e}")
print(f"damping read from the ring-down: {ratio.min():.2f} to {ratio.max():.2f} of the mode's")

plt.show()
