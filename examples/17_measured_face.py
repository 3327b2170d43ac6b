"""
A milled face under a bolt
==========================

Under bolts, contacts yield and merge, which laws of separate summits do not describe. Here the
heights of the scan are pressed point by point by boundary elements, up to the hardness of the
steel, and the joint uses the face as the bolt leaves it.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

# %%
# The scan is 0.64 mm square and was made by a program. An M8 bolt presses 1.6 cm² with 16 kN.

scan = ms.Scan.read("milled.npy", unit="nm", pixel="2.5 um").condition(level="plane")
steel = ms.Material.named("steel-c45")
pair = ms.MaterialPair(steel, steel)
area, load = 1.6e-4, 16e3
face = scan.to_contact(pair, tightening_pressure=load / area, area=area, piece=128)
n = face.numbers
print(f"hardness {n.hardness / 1e9:.2f} GPa, {100 * n.hard_share:.0f} % of the contact is at it")
print(f"{n.points} points touch, {100 * n.contact_share:.1f} % of the face")
print(f"the stiffness of its four pieces scatters by {100 * n.scatter:.0f} %")
face.plot()

# %%
# The lay runs along y, and contacts are longer in that direction: along it the joint is more
# compliant. After tightening and loosening to one half the face stays flattened.

for angle in (0.0, np.pi / 2):
    joint = ms.Interface(face, 0.2, normal_load=load, direction=angle)
    print(
        f"at {np.degrees(angle):2.0f}° from x: {joint.tangential_stiffness / 1e9:.1f} GN/m, "
        f"normal over tangential stiffness {joint.slip_per_indentation / 0.2:.3f}"
    )
loose = joint.at(normal_load=0.5 * load)
print(f"at half of the load: {loose.tangential_stiffness / 1e9:.1f} GN/m")
print("verdicts:", *(verdict.word for verdict in joint.validity))

# %%
# The same scan by its summits, averaged over all directions.

summits = scan.summits(cutoff="10 um")
every = {
    "point by point": face,
    "summits one by one": summits.to_surface(pair, area=area, heights="population"),
    "Gaussian summits": summits.to_surface(pair, area=area),
}
truth = ms.Interface(face, 0.2, normal_load=load)
amplitude = truth.force_limit / truth.tangential_stiffness
fig, ax = plt.subplots(figsize=(7.1, 3.6))
for name, law in every.items():
    joint = ms.Interface(law, 0.2, normal_load=load)
    stiffness = joint.tangential_stiffness / truth.tangential_stiffness
    energy = joint.dissipated_energy(amplitude) / truth.dissipated_energy(amplitude)
    print(f"{name:18s} stiffness {stiffness:.2f}, energy of a cycle {energy:.3f}")
    joint.loop(1.5 * amplitude).plot(ax, label=name)
ax.legend()
plt.show()
