"""
Other friction laws
===================

Section 4.3 of the chapter compares with earlier friction laws of structural dynamics. They
have the same methods here: each is given by its first-loading curve, from which everything else
follows.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)

# %%
# All with the joint's own limit and, where they have one, its stiffness at rest. Coulomb's law
# has no stiffness. Jenkins' cell is one spring with one slider, Segalman's model four parameters,
# here those that come closest to the energies of the joint over three decades of amplitude.

limit, stiffness = joint.force_limit, joint.tangential_stiffness
a = np.geomspace(0.01, 10.0, 61) * limit / stiffness


def misfits(point):
    four = ms.SegalmanIwan(limit, stiffness, *point)
    return np.log(four.dissipated_energy(a) / joint.dissipated_energy(a))


fit = least_squares(misfits, [-0.3, 0.1], bounds=([-0.99, 0.0], [5.0, 50.0]), xtol=1e-12)
four, misfit = ms.SegalmanIwan(limit, stiffness, *fit.x), np.sqrt(np.mean(fit.fun**2))
laws = {
    "rough joint": joint,
    "Jenkins": ms.Jenkins(stiffness=stiffness, force_limit=limit),
    "Segalman": four,
    "Coulomb": ms.Coulomb(force_limit=limit),
}
print(f"Segalman's: chi {four.chi:.3f}, beta {four.beta:.3f}, energies {misfit:.1%} off")
for name, law in laws.items():
    energy = law.dissipated_energy(np.array([1e-8, 1e-7, 1e-6]))
    print(f"{name:11s}", *(f"{value:.3e}" for value in energy), "J at 10 nm, 0.1 and 1 µm")

# %%
# The laws differ at small amplitudes. Coulomb's law dissipates far too much there, a Jenkins cell
# nothing below its yield displacement. An Iwan model agrees, but its parameters are fitted, while
# those of the rough joint follow from the surface, at every load.

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.6))
amplitude = np.geomspace(1e-9, 1e-5, 300)
for name, law in laws.items():
    loop = law.loop(4e-7)
    left.plot(loop.displacement * 1e6, loop.force / 1e3, label=name)
    energy = law.dissipated_energy(amplitude)
    energy[energy == 0.0] = np.nan
    right.loglog(amplitude * 1e6, energy)
left.set(xlabel="Displacement [µm]", ylabel="Force [kN]", title="A loop of ±0.4 µm")
right.set(xlabel="Amplitude [µm]", ylabel="Energy per cycle [J]", title="Energy")
fig.legend(loc="outside lower center", ncols=4)
plt.show()
