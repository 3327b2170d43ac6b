"""
From loops to a joint
=====================

Section 4.4 of the chapter compares a theoretical loop with a measured one by eye (Fig. 19.22). Here
the joint is fitted, with the rig in series, and each parameter has an interval or the reason why
there is none.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
pair = ms.MaterialPair(al, al)
surface = ms.GreenwoodWilliamson(pair, ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)

# %%
# Records of a virtual tribometer: two amplitudes at each of three loads, with noise and a compliant
# rig.

records = []
for seed, load in enumerate((500.0, 1000.0, 2000.0)):
    rig = ms.VirtualTribometer(
        joint.at(normal_load=load), rig_stiffness=5e8, noise=0.003, seed=seed
    )
    records += [rig.record(amplitude=top, frequency=10.0, cycles=10) for top in (1.5e-6, 6e-6)]

# %%
# Friction, slip scale, separation and rig from all records at once; with the materials also the
# spread of the heights, which was 500 nm. This virtual joint has a continuous height
# distribution; for a real one give `summits`, the number of its summits.

found = ms.identify(records, pair=pair, summits=np.inf)
print(f"{found.law}: {found.status}, reduced chi-squared {found.reduced_chi_squared:.1f}")
for one in (*found.parameters.values(), found.derived["std"]):
    print(f"{one.name}: {one.verdict}")
std = found.derived["std"]
print(f"spread of the heights {std.value * 1e9:.0f} nm")

# %%
# One load on a rig as compliant as that of the chapter determines friction and rig only.

soft = ms.VirtualTribometer(joint, rig_stiffness=1e8, noise=0.01, seed=3)
poor = ms.identify(soft.record(amplitude=20e-6, frequency=10.0, cycles=10), summits=np.inf)
for one in poor.parameters.values():
    print(f"{one.name}: {one.verdict}")

# %%
# Measured and identified loops, with the residuals below.

fig, axes = plt.subplots(
    2, 3, figsize=(7.1, 4.0), height_ratios=[2.2, 1.0], sharex="col", sharey="row"
)
for number, fit in enumerate(found.records):
    above, below = axes[:, number // 2]
    x, load = fit.displacement * 1e6, fit.normal_load
    color = ("#D55E00", "#0072B2")[number % 2]
    above.plot(x[::8], fit.measured[::8] / load, "o", color=color, mfc="none", markersize=3)
    closed = np.append(np.arange(x.size), 0)
    above.plot(x[closed], fit.model[closed] / load, color="black", linewidth=1.0)
    below.plot(x, fit.residual / fit.error, ".", color=color, markersize=2)
    above.set_title(f"{load:.0f} N")
    below.set_xlabel("Displacement [µm]")
axes[0, 0].set_ylabel("Force / normal load [–]")
axes[1, 0].set_ylabel("Residual / noise [–]")
plt.show()
