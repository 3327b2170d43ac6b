"""
Other height distributions
==========================

Summit heights can be Gaussian or exponential, any continuous distribution of SciPy, or the
measured heights of a scan. The rest of the joint does not change.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy import stats

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
pair = ms.MaterialPair(al, al)
rest = {"radius": 1e-3, "density": 1e8, "area": 2e-4}

# %%
# A worn surface has lost its highest summits, so its heights are skewed, as in a mirrored Weibull
# distribution. All four have the same standard deviation, 0.5 µm.

mirrored = stats.weibull_max(1.6)
kinds = {
    "Gaussian": ms.Gaussian(std=5e-7),
    "exponential": ms.Exponential(scale=5e-7),
    "worn (SciPy)": stats.weibull_max(1.6, scale=5e-7 / mirrored.std()),
    "given summits": np.random.default_rng(3).normal(0.0, 5e-7, size=4000),
}
joints = {}
for name, heights in kinds.items():
    surface = ms.GreenwoodWilliamson(pair, heights, **rest)
    joints[name] = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)
for name, joint in joints.items():
    print(
        f"{name:13s} {joint.contact_count:6.0f} contacts, "
        f"{joint.tangential_stiffness / 1e9:.2f} GN/m, "
        f"loss factor at 0.3 µm {joint.loss_factor(3e-7):.4f}"
    )

# %%
# The heights determine how gradual the transition from stick to gross slip is. Those of the worn
# surface have an upper end: more summits touch, each with a smaller load, and gross slip begins
# at a smaller displacement.

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.4))
displacement = np.linspace(0.0, 1.2e-6, 300)
amplitude = np.geomspace(1e-9, 1e-5, 200)
for name, joint in joints.items():
    left.plot(displacement * 1e6, joint.backbone(displacement) / joint.force_limit, label=name)
    right.semilogx(amplitude * 1e6, joint.loss_factor(amplitude), label=name)
left.set(xlabel="Displacement [µm]", ylabel="T / μN [–]", title="First loading")
right.set(xlabel="Amplitude [µm]", ylabel="Loss factor η [–]", title="Damping")
left.legend()
plt.show()

# %%
# A scan also gives the radius of each summit. Such a population needs no height distribution.

rng = np.random.default_rng(5)
heights = rng.normal(0.0, 5e-7, size=20000)
radii = rng.lognormal(np.log(1e-3), 0.3, size=20000)
population = ms.AsperityPopulation(pair, heights=heights, radii=radii)
scanned = ms.Interface(population, friction_coefficient=0.55, normal_load=2000.0)
print(f"{scanned.contact_count:.0f} contacts, {scanned.tangential_stiffness / 1e9:.2f} GN/m")
