"""
Base excitation: a strip on a shaker table
==========================================

A strip of steel, bolted to the table of a shaker at both ends. Stepped sines at three levels: the
joints slip more at each, so that the resonance falls and the transmissibility with it.
"""

import matplotlib.pyplot as plt
import numpy as np

import microslip as ms

plt.style.use("microslip.style")

steel = ms.Material(young_modulus=200e9, poisson_ratio=0.3)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(steel, steel), ms.Gaussian(std=1e-6), radius=1e-3, density=5e7, area=1e-4
)
bolts = ms.Bolts([0.0], size="M6", tension=5e3)
strip = ms.BoltedBeam(
    length=0.2,
    width=0.02,
    thickness=0.004,
    style="single-lap",
    ground=["left", "right"],
    laps=[ms.Lap(-0.085, 0.03, bolts), ms.Lap(0.085, 0.03, bolts)],
)
joint = strip.reduce(
    steel, 7800.0, (3, 1), element_size=0.015, sensors={"middle": ((0.0, 0.0, 0.004), "z")}
)

# %%
# ``on_base`` adds the motion of the table to the tightened joint. The sensor measures absolute
# motion with ``base=True``.

state = joint.on_base(surface, friction_coefficient=0.3, damping_ratio=0.001)
middle = joint.sensor("middle", base=True)
first = joint.tightened(surface, 0.3).linear_modes(1).frequency[0]
frequencies = first * np.linspace(0.96, 1.02, 41)
figure, axes = plt.subplots()
for level in (1.0, 5.0, 15.0):
    response = state.base_response(acceleration=level, frequencies=frequencies, **joint.base("z"))
    ratio = np.abs(response.transmissibility(middle))
    print(
        f"{level:4.0f} m/s²: {ratio.max():.0f} at {response.frequency[ratio.argmax()]:.1f} Hz, "
        f"unstable points: {np.sum(~response.stable)}"
    )
    color = axes.plot(
        response.frequency, np.where(response.stable, ratio, np.nan), label=f"{level:g} m/s²"
    )[0].get_color()
    axes.plot(response.frequency, np.where(response.stable, np.nan, ratio), ".", color=color)
axes.set(yscale="log", xlabel="frequency [Hz]", ylabel="transmissibility")
axes.legend(title="acceleration of the table")

plt.show()
