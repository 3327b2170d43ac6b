"""
From a scan to a joint
======================

From the heights of a profilometer to summits, and from summits to a joint. Number and radius of the
summits depend on the short-wave cut-off; the example shows its effect on the joint.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

# %%
# A generated surface replaces the file, which would be read with ``ms.Scan.read("ground.plu")``.

q = np.hypot(np.fft.fftfreq(400)[:, None], np.fft.rfftfreq(400))  # waves per micrometre
band = (q > 1 / 150) & (q < 1 / 4.9)
phase = np.random.default_rng(7).uniform(0.0, 2.0 * np.pi, q.shape)
heights = np.fft.irfft2(band * np.maximum(q, 1e-3) ** -1.8 * np.exp(1j * phase))
scan = ms.Scan(2e-7 * heights / heights.std(), pixel=1e-6)
summits = scan.summits(cutoff=5e-6)
print(f"rms height {scan.statistics().rms * 1e9:.1f} nm, Nayak's alpha {scan.moments().nayak:.2f}")
print(f"at a cut-off of 5 µm: {summits.statistics()}")

# %%
# The same joint with the summits at other cut-offs. Coarser summits are fewer and rounder.
# Stiffness and damping hardly change: at a given load they depend on the standard deviation of the
# heights. The number of contacts and the real contact area do change.

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
pair = ms.MaterialPair(al, al)
loads = np.geomspace(10.0, 5000.0, 60)
fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.4))
middle = scan.heights[200:260, 200:260] * 1e9
left.imshow(middle, cmap="cividis", origin="lower", extent=(200, 260, 200, 260))
for cutoff, line, marker, size in (
    (None, "-", ".", 5),
    (10e-6, "--", "s", 7),
    (20e-6, ":", "^", 12),
):
    found = scan.summits(cutoff=cutoff)
    surface = found.to_surface(pair, area=2e-4)
    joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=500.0)
    name = "no cut-off" if cutoff is None else f"cut-off {cutoff * 1e6:.0f} µm"
    print(
        f"{name}: {found.count} summits of {found.equivalent_radius * 1e6:.0f} µm; "
        f"{joint.contact_count:.0f} touch, ζ = {joint.damping_ratio(2e-7):.3f} at 0.2 µm"
    )
    x, y = found.positions.T * 1e6
    left.plot(x, y, marker, markersize=size, markerfacecolor="none", color="#D55E00", label=name)
    share = surface.contact_area(surface.separation(loads)) / 2e-4
    right.loglog(loads, 100.0 * share, line, label=name)
left.set(xlabel="x [µm]", ylabel="y [µm]", title="Summits: dots, squares, triangles")
left.set(xlim=(200, 260), ylim=(200, 260))
left.grid(visible=False)
right.set(xlabel="Normal load [N]", ylabel="Real contact area [%]", title="The joint")
right.legend()
plt.show()
