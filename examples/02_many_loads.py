"""
Many loads
==========

The same joint at several normal loads. ``joint.at`` returns the joint at another load and reuses
all that does not change.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=500.0)
joints = [joint.at(normal_load=load) for load in (500.0, 1000.0, 2000.0, 5000.0)]

# %%
# Stiffness and number of contacts grow a little more slowly than the load: a larger load is
# carried mostly by new contacts.

for each in joints:
    print(
        f"{each.normal_load:4.0f} N: {each.contact_count:6.0f} contacts, "
        f"{each.tangential_stiffness / 1e9:.2f} GN/m, gross slip at {each.force_limit:.0f} N"
    )

# %%
# At a given *displacement* amplitude a tighter joint dissipates more, because the force is larger;
# at a given *force* amplitude it dissipates less, because the displacement is smaller. The best
# load therefore depends on which of the two the structure imposes.

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.4))
displacement = np.geomspace(1e-9, 1e-5, 200)
share = np.geomspace(2e-2, 0.999, 200)
for each in joints:
    name = f"{each.normal_load / 1e3:g} kN"
    left.loglog(displacement * 1e6, each.dissipated_energy(displacement), label=name)
    force = share * each.force_limit
    right.loglog(force, each.dissipated_energy(force_amplitude=force), label=name)
left.set(xlabel="Displacement amplitude [µm]", ylabel="Energy per cycle [J]")
right.set(xlabel="Force amplitude [N]", ylabel="Energy per cycle [J]")
left.legend(title="Normal load")
plt.show()

loose, tight = joints[0], joints[-1]
for name, each in (("loose", loose), ("tight", tight)):
    print(
        f"{name}: {each.dissipated_energy(3e-7):.3e} J at 0.3 µm, "
        f"{each.dissipated_energy(force_amplitude=200.0):.3e} J at 200 N"
    )
