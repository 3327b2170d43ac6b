"""
A joint in a structure with one degree of freedom
=================================================

A mass on a spring with a joint in parallel represents one mode of a jointed structure. Its
frequency and damping depend on the amplitude, and its damping ratio is much smaller than that of
the interface.
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

# %%
# The spring is three times as stiff as the joint, and all other damping is half a per cent.

mode = ms.Oscillator(
    mass=2.0, stiffness=3.0 * joint.tangential_stiffness, joint=joint, viscous_damping_ratio=0.005
)
stuck, free = mode.frequency(0.0) / 1e3, mode.frequency(1.0) / 1e3
print(f"{stuck:.2f} kHz while the joint sticks, {free:.2f} kHz when it slides")
for amplitude in (3e-8, 1e-7, 3e-7):
    print(
        f"{amplitude * 1e9:3.0f} nm: {mode.frequency(amplitude) / 1e3:.3f} kHz, damping ratio "
        f"{mode.damping_ratio(amplitude):.5f}, of the interface alone "
        f"{joint.damping_ratio(amplitude):.5f}"
    )

# %%
# Released at 0.4 µm. The ring-down is integrated in time, with the memory of the joint.

motion = mode.ring_down(4e-7, cycles=40)
middle = motion.turning_time[1::2][: motion.amplitude.size]
print(f"energy kept to {motion.energy_error:.0e}")

# %%
# Large amplitudes decay faster than small ones: on a logarithmic scale the decay of a jointed
# structure is not a straight line, and the measured damping depends on the strength of the impact.
# Where the joint slips far, a ring-down shows more damping than the modal ratio, because the decay
# of the amplitude depends on the tangent stiffness of the mode, not on its secant stiffness.

amplitude = np.geomspace(1e-9, 1e-5, 300)
fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.6))
left.plot(motion.time * 1e3, motion.displacement * 1e6, linewidth=0.6, label="displacement")
left.plot(middle * 1e3, motion.amplitude * 1e6, "o", markersize=3.5, label="amplitude of a cycle")
left.set(xlabel="Time [ms]", ylabel="Displacement [µm]", ylim=(-0.45, 0.75))
left.legend(loc="upper right")
right.loglog(amplitude * 1e6, joint.damping_ratio(amplitude), "--", label="interface")
right.loglog(motion.amplitude * 1e6, motion.damping_ratio, "o", markersize=3.5, label="ring-down")
right.loglog(amplitude * 1e6, mode.damping_ratio(amplitude), label="mode")
right.set(xlabel="Amplitude [µm]", ylabel="Damping ratio ζ [–]", ylim=(3e-3, 1.0))
right.legend(loc="upper left")
plt.show()
