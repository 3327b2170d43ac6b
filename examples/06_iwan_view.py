"""
The joint as an Iwan model
==========================

Every joint is a parallel Iwan model: springs in series with sliders, whose yield displacements are
distributed as the curvature of the backbone. They follow without a fit.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
rough = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)
sphere = ms.SphereOnFlat(ms.MaterialPair(al, al), radius=5e-3)
ball = ms.Interface(sphere, friction_coefficient=0.55, normal_load=10.0)

# %%
# The density of sliders of the rough joint, and that of a single asperity, which ends at its slip
# limit with a singularity.

yields = np.linspace(0.0, 1.6e-6, 400)
density = rough.sliders().density(yields)
limit = -ball.slip_per_indentation * ball.separation
share = np.linspace(0.0, 0.995, 400)
one = ball.sliders().density(share * limit)
print(f"slip limit of the ball: {limit * 1e6:.4f} µm")

# %%
# ``to_iwan`` makes discrete cells for codes that have no other hysteretic element. Twice as many
# cells have a quarter of the error.

displacement = np.linspace(0.0, 2e-6, 400)
for count in (5, 10, 20, 40):
    cells = rough.to_iwan(count)
    off = abs(cells.backbone(displacement) - rough.backbone(displacement)).max()
    print(f"{count:2d} cells: backbone off by {off / rough.force_limit:.1e} of the limit")

few = rough.to_iwan(5)
loop, polygon = rough.loop(6e-7), few.loop(6e-7)
print(
    f"stiffness at rest {few.tangential_stiffness / rough.tangential_stiffness:.6f} of the joint's"
)
print(f"energy at 0.6 µm  {few.dissipated_energy(6e-7) / rough.dissipated_energy(6e-7):.4f} of it")

fig, (left, middle, right) = plt.subplots(1, 3, figsize=(7.1, 2.9))
left.plot(yields * 1e6, density / 1e15)
left.set(xlabel="Yields at [µm]", ylabel="Slider density [PN/m²]", title="Rough joint, 2 kN")
middle.plot(share, one * limit / ball.tangential_stiffness)
middle.set(
    xlabel="Yields at / slip limit [–]",
    ylabel="Slider density, scaled [–]",
    title="One asperity",
    ylim=(0.0, 6.0),
)
right.plot(loop.displacement * 1e6, loop.force / 1e3, label="joint")
right.plot(polygon.displacement * 1e6, polygon.force / 1e3, "--", linewidth=1.0, label="5 cells")
right.set(xlabel="Displacement [µm]", ylabel="Force [kN]", title="A loop", ylim=(-1.2, 1.7))
right.legend(loc="upper left")
plt.show()
