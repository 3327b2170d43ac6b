"""
A first joint
=============

Two milled aluminium blocks, pressed together with 2 kN and moved to and fro. This is the joint of
the tribometer in chapter 19 of *The Mechanics of Jointed Structures*. The chapter gives no summit
statistics; those used here are plausible for a milled surface.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

# %%
# A joint is a surface, a friction coefficient and a normal load. The surface holds the
# roughness: heights of the summits, their radius, their number per area, and the apparent area.

al = ms.Material.named("al2017")
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)

share = joint.contact_area / surface.area
print(f"{joint.contact_count:.0f} summits touch, on {share:.2%} of the area")
print(f"stiffness at rest {joint.tangential_stiffness / 1e9:.3f} GN/m")
print(f"gross slip at {joint.force_limit / 1e3:.3f} kN")

# %%
# Loops of three amplitudes. Each starts on the first-loading curve (dashed). The larger the
# amplitude, the more summits slip, and the wider the loop.

fig, ax = plt.subplots(figsize=(7.1, 4.2))
for amplitude in (0.15e-6, 0.4e-6, 1e-6):
    loop = joint.loop(amplitude)
    name = f"±{amplitude * 1e6:g} µm"
    ax.plot(loop.displacement * 1e6, loop.force / 1e3, label=name)
    print(
        f"{name}: {joint.dissipated_energy(amplitude) * 1e6:.4g} µJ a cycle, "
        f"loss factor {joint.loss_factor(amplitude):.4f}, "
        f"damping ratio {joint.damping_ratio(amplitude):.4f}"
    )
first = np.linspace(0.0, 1e-6, 200)
ax.plot(first * 1e6, joint.backbone(first) / 1e3, "--", color="#666666", label="first loading")
ax.set(xlabel="Displacement [µm]", ylabel="Force [kN]", title="Al 2017, milled, 2 kN")
ax.legend()
plt.show()

# %%
# Every result includes verdicts on the assumptions of the model.

for verdict in joint.validity:
    print(f"{verdict.name}: {verdict.value:.3g} ({verdict.word})")
