"""Joints in PyTorch: backward, grad, jacobians and vmap against differences; `make hosts`."""

import numpy as np
import pytest
from differentiable import CASES, POINT, C, check_field, differences, direct, field_motion, make

import microslip as ms

torch = pytest.importorskip("torch", reason="PyTorch is not installed; make hosts runs this")
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def joint():
    from microslip.export.hosts.torch import DifferentiableJoint

    return DifferentiableJoint(make)


@pytest.mark.parametrize(("name", "x", "options"), CASES)
def test_values_and_gradients_are_those_of_differences(joint, name, x, options):
    leaf = {k: torch.tensor(v, dtype=torch.float64, requires_grad=True) for k, v in POINT.items()}
    at = torch.tensor(x, dtype=torch.float64, requires_grad=True)
    value = getattr(joint, name)(leaf, at, *options)
    np.testing.assert_allclose(value.detach(), direct(name, POINT, x, options), rtol=1e-13)
    weights = np.cos(np.arange(np.size(x))).reshape(np.shape(x))
    (torch.as_tensor(weights) * value).sum().backward()
    differences(
        name, x, options, weights, {k: float(v.grad) for k, v in leaf.items()}, np.asarray(at.grad)
    )


def test_functions_of_functions(joint):
    """Batches of gradients, and jacobians, as torch.func makes them."""
    from torch import func

    loads = torch.tensor([1000.0, 2000.0, 3000.0], dtype=torch.float64)

    def energy(load, amplitude):
        return joint.dissipated_energy({**POINT, "normal_load": load}, amplitude)

    found = func.vmap(func.grad(energy), in_dims=(0, None))(loads, torch.tensor(3e-7).double())
    for load, slope in zip(loads, found, strict=True):
        law = make(**{**POINT, "normal_load": float(load)})
        exact = law.parameter_derivatives("dissipated_energy", float(np.float32(3e-7)))
        assert float(slope) == pytest.approx(exact["normal_load"], rel=1e-12)
    jacobian = func.jacrev(lambda c: joint.harmonics(POINT, c, (0, 1, 3)))(torch.tensor(C))
    exact = make(**POINT).harmonics(C, (0, 1, 3)).jacobian
    np.testing.assert_allclose(jacobian, exact, rtol=1e-12, atol=1e-12 * np.abs(exact).max())
    rows = func.vmap(lambda c: joint.harmonics(POINT, c, (0, 1, 3)))(torch.tensor([C, 2.0 * C]))
    np.testing.assert_allclose(rows[1], make(**POINT).harmonics(2.0 * C, (0, 1, 3)).force)


@pytest.mark.parametrize("varies", [False, True])
def test_fields_have_their_jacobians(varies):
    from torch import func

    from microslip.export.hosts.torch import DifferentiableField

    nodes, motion = field_motion(varies)
    field = DifferentiableField(nodes)
    given = tuple(map(torch.tensor, motion))

    def both(*motion):
        found = field.harmonics(*motion, harmonics=(0, 1, 3))
        return torch.stack(found if varies else [found])

    by = func.jacrev(both, argnums=tuple(range(len(given))))(*given)
    check_field(nodes, motion, both(*given), by)
    rows = func.vmap(lambda c: field.harmonics(c, harmonics=(0, 1, 3)))(
        torch.stack([given[0], 2.0 * given[0]])
    )
    np.testing.assert_allclose(
        rows[1], nodes.harmonics(2.0 * motion[0], (0, 1, 3)).force, rtol=1e-12
    )
    leaf = given[0].clone().requires_grad_()
    (slope,) = torch.autograd.grad(
        field.harmonics(leaf, harmonics=(0, 1, 3)).sum(), leaf, create_graph=True
    )
    with pytest.raises(ms.InputError, match="first derivatives only"):
        slope.sum().backward()


def test_missing_files_and_names_are_refused(joint):
    load = torch.tensor(2000.0, dtype=torch.float64, requires_grad=True)
    energy = joint.dissipated_energy({**POINT, "normal_load": load}, 3e-7)
    (slope,) = torch.autograd.grad(energy, load, create_graph=True)
    with pytest.raises(ms.InputError, match="first derivatives only"):
        (slope**2 + load**2).backward()
    with pytest.raises(ms.InputError, match="first derivatives only"):
        torch.func.grad(torch.func.grad(lambda a: joint.dissipated_energy(POINT, a)))(load * 1e-10)
    for forward in (torch.func.hessian, torch.func.jacfwd):
        with pytest.raises(ms.InputError, match="not by jvp, jacfwd or hessian"):
            forward(lambda a: joint.dissipated_energy(POINT, a))(load * 1e-10)
    with pytest.raises(ms.InputError, match="normal_load must"):
        joint.dissipated_energy({**POINT, "normal_load": -1.0}, 3e-7)
