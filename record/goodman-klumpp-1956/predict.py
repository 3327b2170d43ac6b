"""Energy of a bar that is pressed on a rigid base along its length and pulled at its end.

The bar is a chain of springs, fine at the pulled end, each node held by a stiff Jenkins slider.
Under one force that rises from rest it follows one curve of displacement u against force F, and a
cycle between -F and F dissipates 4 F u - 8 int_0^F u dF' (Masing's rule). The closed form of rigid
sliders is 2 F^3/(3 EA q), q the friction force a length.
"""

import numpy as np

import microslip as ms

STIFFNESS = 200e9 * 25e-3 * 6.35e-3  # N: modulus times cross section
LENGTH = 0.1  # m
FRICTION_FORCE = 3e4  # N/m: friction coefficient times pressure times width
NODES = 120
FORCES = (200.0, 400.0, 800.0, 1200.0, 1600.0, 2000.0)  # N; the bar slips wholly at 3000 N


def displacement_of(bar: ms.Structure, force: float) -> float:
    """Displacement of the pulled end on first loading [m]."""
    pull = np.zeros(NODES)
    pull[0] = force
    return float(bar.preload(pull).displacement[0])


def around(value: float) -> tuple[float, float, float]:
    """The number with the error of the chain, 0.2 % (its elements are 0.2 to 4 mm long)."""
    return 0.998 * value, value, 1.002 * value


def predict() -> dict[str, tuple[float, float, float]]:
    """Return the energies and the exponent."""
    edges = LENGTH * np.geomspace(0.002, 1.002, NODES) - 0.002 * LENGTH
    steps = np.diff(edges)
    springs = STIFFNESS / steps
    held = np.zeros(NODES)  # the length that a node stands for
    held[:-1] += steps / 2.0
    held[1:] += steps / 2.0
    stiffness = np.zeros((NODES, NODES))
    for k, spring in enumerate(springs):
        stiffness[k : k + 2, k : k + 2] += spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    bar = ms.Structure(np.eye(NODES), stiffness)
    for node, length in enumerate(held):
        slider = ms.Jenkins(stiffness=springs.max(), force_limit=FRICTION_FORCE * length)
        bar = bar.attach(slider, directions=np.eye(NODES)[node])
    places, weights = np.polynomial.legendre.leggauss(4)  # u(F) is a parabola
    energies = []
    for force in FORCES:
        below = [displacement_of(bar, force * (1.0 + place) / 2.0) for place in places]
        work = force / 2.0 * float(weights @ np.array(below))
        energies.append(4.0 * force * displacement_of(bar, force) - 8.0 * work)
    answers = {
        f"energy of a cycle at {force:g} N": around(energy)
        for force, energy in zip(FORCES, energies, strict=True)
    }
    exponent = float(np.polyfit(np.log(FORCES), np.log(energies), 1)[0])
    return answers | {"exponent of the energy in the force": around(exponent)}
