"""
A joint in a time integration
=============================

A structural code needs the force and the tangent of a joint at *trial* displacements, and a
*commit* once the step has converged. In this example a block on a joint gets one push, and is
integrated with Newmark's method and Newton's iteration.
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
# The block, and a time step of a fortieth of its period when the joint is fully stuck.

mass = 2.0
period = 2.0 * np.pi * np.sqrt(mass / joint.tangential_stiffness)
step = period / 40.0
print(f"{1.0 / period:.0f} Hz while everything sticks")


def push(time: float) -> float:
    """Half a sine of 800 N, four periods long; then nothing."""
    length = 4.0 * period
    return 800.0 * np.sin(np.pi * time / length) if time < length else 0.0


# %%
# Constant average acceleration. ``try_`` does not change the state: a step that does not
# converge can be repeated with half the length.

state = joint.start()
position, velocity, acceleration = 0.0, 0.0, 0.0
times = step * np.arange(1, 1201)
positions, forces, iterations = [], [], 0
for time in times:
    trial = position + step * velocity
    for _ in range(20):
        force, stiffness = state.try_(trial)
        inertia = 4.0 / step**2 * (trial - position) - 4.0 / step * velocity - acceleration
        rest = push(time) - mass * inertia - force
        iterations += 1
        if abs(rest) < 1e-9 * joint.force_limit:
            break
        trial += rest / (4.0 / step**2 * mass + stiffness)
    else:
        raise RuntimeError("no convergence")
    state.commit()
    velocity = 2.0 / step * (trial - position) - velocity
    position, acceleration = trial, inertia
    positions.append(position)
    forces.append(force)

print(f"{iterations / times.size:.2f} iterations a step")
near = np.mean(positions[-400:])
print(f"farthest {max(positions) * 1e6:.4f} µm, rests near {near * 1e6:.4f} µm")
print(f"{state.open_reversals} open reversals are all that the joint remembers")

# %%
# The oscillation decays by friction alone. The loss factor falls with the amplitude, so the decay
# becomes slower. A residual displacement remains.

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.4))
left.plot(times * 1e3, np.array(positions) * 1e6, linewidth=0.9)
left.set(xlabel="Time [ms]", ylabel="Displacement [µm]")
right.plot(np.array(positions) * 1e6, np.array(forces) / 1e3, linewidth=0.9)
right.set(xlabel="Displacement [µm]", ylabel="Force in the joint [kN]")
plt.show()
