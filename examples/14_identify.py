"""
From loops to a joint
=====================

Section 4.4 of the chapter compares a theoretical loop with a measured one by eye (Fig. 19.22). Here
the friction law is found from the loops, without an assumption on its shape, and each number has an
interval.
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
# One fit of all records. Loops cannot tell a joint from its rig, so the stiffness of the rig is
# given as it was measured, with its error.

found = ms.identify(records, rig_stiffness=(5e8, 1e7))
for load in found.loads:
    energy = found.dissipated_energy(2e-6, normal_load=load)
    print(f"{load:.0f} N: {energy.low * 1e3:.1f} to {energy.high * 1e3:.1f} mJ a cycle at 2 µm")
print(found.masing.text.partition(":")[0])

# %%
# With the materials the parameters of the interface follow, such as the spread of the heights,
# which was 500 nm.

step = found.interface(pair, area=2e-4)
for name in ("friction_coefficient", "slip_scale", "standardised_separation", "std"):
    print(f"{name}: {step.parameters[name].verdict}")

# %%
# Without the stiffness of the rig only friction is determined, and a lower bound of the rig.

both = ms.identify(records)
print(f"{both.series}: rig above {both.rig.low / 1e6:.0f} N/µm")
for name in ("friction_coefficient", "slip_scale"):
    print(f"{name}: {both.interface(pair).parameters[name].verdict}")

# %%
# Measured and fitted loops, with the residuals below.

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
