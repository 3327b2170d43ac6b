"""
A normal load that varies
=========================

In many structures the normal load of a joint varies with the motion. The dissipated energy then
depends on the phase between load and displacement, and a constant force makes the joint creep while
the load is low.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, friction_coefficient=0.55, normal_load=2000.0)

# %%
# Cycles of ±0.2 µm under 2 kN ± 1 kN; the second cycle is settled. In phase, the load is high where
# the displacement is large. A quarter cycle ahead it is high during loading and low during
# unloading, so that less energy is recovered.

steps = 500
turn = 2.0 * np.pi * np.arange(1, 2 * steps + 1) / steps
amplitude, held = 0.2e-6, joint.dissipated_energy(0.2e-6)
print(f"constant load: {held * 1e6:.1f} µJ a cycle")

loops = {"constant": joint.coupled_response(amplitude * np.sin(turn), normal_load=2000.0)}
for name, ahead in (("in step", 0.0), ("45° ahead", 45.0), ("90° ahead", 90.0)):
    load = 2000.0 + 1000.0 * np.sin(turn + np.radians(ahead))
    loops[name] = joint.coupled_response(amplitude * np.sin(turn), normal_load=load)
    lost = loops[name].energy_per_step[-steps:].sum()
    print(f"{name}: {lost * 1e6:.1f} µJ a cycle, {lost / held:.3f} of that")

# %%
# A force of 600 N, well below μN = 1100 N, held while the load ripples by ±10 to ±40 %: when the
# load is low, contacts that were stuck slip, and stay displaced. The joint creeps during the first
# cycle only; it does not ratchet.

cycles = np.arange(1, 4 * steps + 1) / steps
start = joint.backbone_displacement(600.0)
print(f"600 N at 2 kN: {start * 1e9:.1f} nm")
creep = {}
for ripple in (0.1, 0.2, 0.4):
    load = 2000.0 * (1.0 + ripple * np.sin(2.0 * np.pi * cycles))
    force = np.full(cycles.size, 600.0)
    creep[ripple] = joint.coupled_response(force=force, normal_load=load)
    ends = creep[ripple].displacement[steps - 1 :: steps]
    crept, more = ends[0], abs(np.diff(ends)).max()
    print(
        f"±{100 * ripple:.0f}%: {crept * 1e9:.1f} nm after a cycle, then {more * 1e9:.1f} nm more"
    )

fig, (left, right) = plt.subplots(1, 2, figsize=(7.1, 3.6))
for (name, response), line in zip(loops.items(), ("--", "-", "-.", ":"), strict=True):
    last = slice(-1 - steps, None)
    left.plot(response.displacement[last] * 1e6, response.force[last] / 1e3, line, label=name)
left.set(xlabel="Displacement [µm]", ylabel="Force [kN]", title="±0.2 µm under 2 kN ± 1 kN")
left.legend(title="Normal load")
for (ripple, response), line in zip(creep.items(), ("-", "-.", ":"), strict=True):
    label = f"±{100 * ripple:.0f} %"
    right.plot(cycles, response.displacement * 1e9, line, label=label)
right.axhline(start * 1e9, color="#666666", linestyle="--", linewidth=0.9, label="constant")
right.set(xlabel="Cycles of the load [–]", ylabel="Displacement [nm]", title="600 N held")
right.legend(title="Normal load, of 2 kN")
plt.show()
