"""Questions to joints in JAX and in PyTorch, and differences to hold their gradients against."""

import numpy as np
from usual import rough

import microslip as ms

POINT = {"friction_coefficient": 0.55, "normal_load": 2000.0, "std": 5e-7}
X = 4e-7 * np.sin(0.4 * np.arange(40)) * (1.0 + 0.3 * np.sin(0.07 * np.arange(40)))
C = np.array([1e-7, 3e-7, -5e-8, 1e-7, 4e-8])
CASES = [("force", X, ()), ("harmonics", C, ((0, 1, 3),)), ("dissipated_energy", 3e-7, ())]


def make(friction_coefficient, normal_load, std):
    return ms.Interface(rough(ms.Gaussian(std)), friction_coefficient, normal_load=normal_load)


def direct(name, point, x, options):
    law = make(**point)
    result = getattr(law, name)(x, *options)
    return np.asarray(result.force if name == "harmonics" else result)


def differences(name, x, options, weights, by_point, by_x):
    """Gradients of a weighted sum are those of differences; what a way of x changes."""
    for key, number in POINT.items():
        step = 1e-4 * number
        ends = [direct(name, {**POINT, key: number + s * step}, x, options) for s in (1, -1)]
        wanted = (weights * (ends[0] - ends[1])).sum() / (2.0 * step)
        scale = np.abs(weights * ends[0]).sum() / number
        assert abs(by_point[key] - wanted) < 1e-6 * scale, key
    way = np.sin(1.0 + np.arange(np.size(x))).reshape(np.shape(x))
    ends = [direct(name, POINT, x + s * 1e-13 * way, options) for s in (1, -1)]
    wanted = (weights * (ends[0] - ends[1])).sum() / 2e-13
    scale = np.abs(by_x * way).sum()
    assert abs((by_x * way).sum() - wanted) < 2e-5 * scale
    return way


def field_motion(varies):
    """Return two nodes and their motion: displacements, and separations if these vary."""
    nodes = ms.JointField(make(**POINT).surface, 0.4, areas=[1e-5, 2e-5], loads=[100.0, 300.0])
    x = np.stack([C, -0.7 * C])
    d = 0.2 * np.roll(x, 1, axis=1)
    d[:, 0] = nodes.separations
    return nodes, ((x, d) if varies else (x,))


def check_field(nodes, motion, value, by):
    """Values and Jacobians of harmonics are those of the nodes, and no node moves another."""
    varies = len(motion) == 2
    exact = nodes.harmonics(motion[0], (0, 1, 3), separations=motion[1] if varies else None)
    np.testing.assert_allclose(value[0], exact.force, rtol=1e-12)
    if varies:
        np.testing.assert_allclose(value[1], exact.load, rtol=1e-12)
    for k, part in enumerate(by):
        for i in range(2):
            block = exact.jacobian[:, :, k] if varies else exact.jacobian[:, None]
            np.testing.assert_allclose(
                part[:, i, :, i], block[i], rtol=1e-12, atol=1e-12 * np.abs(block).max()
            )
            np.testing.assert_array_equal(part[:, i, :, 1 - i], 0.0)
