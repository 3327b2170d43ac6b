"""
Force control
=============

For a given force the displacement is the inverse of the same hysteresis. A force of μN or more
does not determine a displacement and is refused.
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
# A force about a mean, growing from cycle to cycle. After each unloading a residual displacement
# remains, which is larger the closer the peak was to gross slip.

turn = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
cycles = [300.0 + 100.0 * n * np.sin(turn) for n in range(1, 8)]
force = np.concatenate([np.linspace(0.0, 300.0, 50), *cycles, [300.0, 0.0]])
displacement = joint.displacement(force)

print(f"peak force {force.max():.0f} N of {joint.force_limit:.0f} N")
print(f"peak displacement {displacement.max() * 1e6:.4f} µm")
print(f"left when the force is gone: {displacement[-1] * 1e6:.4f} µm")

# %%
# The displacement put back into the law gives the force again, to rounding.

again = joint.force(displacement)
print(f"forth and back: {'equal' if np.allclose(again, force, rtol=0, atol=1e-9) else 'not equal'}")

# %%
# At the limit the displacement is not determined.

try:
    joint.displacement([500.0, 1100.0])
except ms.InputError as error:
    print(error)

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.4))
left.plot(force / 1e3)
left.set(xlabel="Sample", ylabel="Force [kN]", title="Applied force")
right.plot(displacement * 1e6, force / 1e3)
right.axhline(joint.force_limit / 1e3, color="#666666", linestyle="--", linewidth=0.9)
right.annotate(
    "gross slip, μN", (0.02, joint.force_limit / 1e3), (0, 3), textcoords="offset points"
)
right.set(xlabel="Displacement [µm]", ylabel="Force [kN]", title="Displacement", ylim=(-0.6, 1.25))
plt.show()
