"""
A joint in a structure, the smallest one
========================================

A mass on a spring, and a joint beside the spring: one mode of a jointed structure. Its frequency
and its damping depend on the amplitude, and its damping ratio is far from that of the interface.
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
# The spring is three times as stiff as the joint, and all else damps by half a per cent.

mode = ms.Oscillator(
    mass=2.0, stiffness=3.0 * joint.tangential_stiffness, joint=joint, viscous_damping_ratio=0.005
)
stuck, free = mode.frequency(0.0) / 1e3, mode.frequency(1.0) / 1e3
print(f"{stuck:.2f} kHz while the joint sticks, {free:.2f} kHz when it slides")
for amplitude in (3e-8, 1e-7, 3e-7):
    print(
        f"{amplitude * 1e9:3.0f} nm: {mode.frequency(amplitude) / 1e3:.3f} kHz, damping ratio "
        f"{mode.damping_ratio(amplitude):.5f}, of the interface alone "
        f"{mode.interface_damping_ratio(amplitude):.5f}"
    )

# %%
# Pulled to 0.4 µm and let go. The ring-down is integrated in time, with the memory of the joint;
# the envelope comes from the closed forms alone. Neither knows of the other.

motion = mode.ring_down(4e-7, cycles=40)
envelope = mode.decay(4e-7, cycles=40)
middle = motion.turning_time[1::2][: motion.amplitude.size]
closed = np.interp(middle, envelope.time, envelope.amplitude)
print(f"envelope off by {abs(closed / motion.amplitude - 1.0).max():.1%} at most")
print(f"energy kept to {motion.energy_error:.0e}")

# %%
# Large amplitudes die faster than small ones: on a logarithmic scale the decay of a jointed
# structure is no straight line, and the damping that a test shows depends on how hard it was hit.
# Where the joint slips far, a ring-down shows more than the modal ratio: what a mode loses with its
# amplitude goes with its tangent stiffness, not with its secant.

amplitude = np.geomspace(1e-9, 1e-5, 300)
fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.6))
left.plot(motion.time * 1e3, motion.displacement * 1e6, linewidth=0.6, label="displacement")
left.plot(middle * 1e3, motion.amplitude * 1e6, "o", markersize=3.5, label="amplitude of a cycle")
left.plot(envelope.time * 1e3, envelope.amplitude * 1e6, label="from the closed forms")
left.set(xlabel="Time [ms]", ylabel="Displacement [µm]", ylim=(-0.45, 0.75))
left.legend(loc="upper right")
right.loglog(amplitude * 1e6, mode.interface_damping_ratio(amplitude), "--", label="interface")
right.loglog(motion.amplitude * 1e6, motion.damping_ratio, "o", markersize=3.5, label="ring-down")
right.loglog(amplitude * 1e6, mode.damping_ratio(amplitude), label="mode")
right.set(xlabel="Amplitude [µm]", ylabel="Damping ratio ζ [–]", ylim=(3e-3, 1.0))
right.legend(loc="upper left")
plt.show()
