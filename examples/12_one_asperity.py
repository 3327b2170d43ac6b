"""
One asperity
============

The stick circle, the slip ring and the tractions of a single contact: the solution of
Cattaneo and Mindlin (Figs. 19.2 and 19.3 of the chapter), for any history.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
ball = ms.Asperity(
    ms.MaterialPair(al, al), radius=5e-3, friction_coefficient=0.55, normal_load=10.0
)
radius, slip_limit = ball.contact_radius, ball.slip_limit
print(f"contact radius {radius * 1e6:.2f} µm, slip limit {slip_limit * 1e6:.4f} µm")

# %%
# Loaded half-way to gross slip, then unloaded to zero force. The ring that slips back is thinner
# than the one that slipped first; tractions of both signs balance.

pushed = ball.fields(0.5 * slip_limit)
released = ball.fields(force=[pushed.force, 0.0])
print(f"pushed:   {pushed.force:.4f} N, sticks within {pushed.stick_radius / radius:.4f}")
print(
    f"released: {released.displacement * 1e9:.2f} nm remain, "
    f"slips back outside {released.reversed_slip_radius / radius:.4f}"
)
for zone in released.zones:
    print(f"  {zone.inner / radius:.3f} to {zone.outer / radius:.3f}: {zone.kind}")

# %%
# The traction in the contact, and the displacement of the surface along the force. Within the
# circle that has never slipped the displacement is uniform.

r = np.linspace(0.0, 1.0, 800) * radius
x = np.linspace(-3.0, 3.0, 600) * radius
fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.4))
left.plot(r / radius, 0.55 * ball.pressure(r) / 1e6, "--", color="#666666", label="μ × pressure")
for name, state in (("pushed", pushed), ("released", released)):
    left.plot(r / radius, state.traction(r) / 1e6, label=name)
    right.plot(x / radius, state.surface_displacement(x)[0] * 1e6, label=name)
left.set(xlabel="r / a [–]", ylabel="Traction [MPa]", title="In the contact")
right.set(xlabel="x / a [–]", ylabel="Displacement of the surfaces [µm]", title="Along the force")
left.legend()
plt.show()
