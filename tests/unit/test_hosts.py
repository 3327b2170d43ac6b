"""Adapters whose host is on no package index: run by stand-ins that make the calls of the hosts.

The stand-ins follow the published interfaces alone: the order and scaling of unknowns, and which
method is called with what.
"""

import importlib
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from exported import JOINT
from scipy import linalg

import microslip as ms

M = np.diag([10.0, 5.0])
K = np.array([[3e9, -2e9], [-2e9, 2.5e9]])
C = np.diag([2e3, 1e3])
H = np.array([0, 1, 3])
OMEGA = 0.95 * np.sqrt(linalg.eigvalsh(K + np.diag([0.0, JOINT.tangential_stiffness]), M).min())
FREQUENCIES = np.array([1.0, 1.001]) * OMEGA / (2.0 * np.pi)
STRUCTURE = ms.Structure(M, K, C).attach(JOINT, directions=[0.0, 1.0])


def linear(m, c, k, w, h):
    """Dynamic stiffness of coefficients, those of all displacements harmonic by harmonic."""
    blocks = [
        np.block([[k - (n * w) ** 2 * m, n * w * c], [-n * w * c, k - (n * w) ** 2 * m]])
        if n
        else k
        for n in h
    ]
    size = sum(map(len, blocks))
    whole, at = np.zeros((size, size)), 0
    for block in blocks:
        whole[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return whole


class StandIn:
    """A vibrating system that calls its forces as TMDSimPy's does."""

    def __init__(self, m, k, C):
        self.M, self.K, self.C, self.nonlinear_forces = m, k, C, []

    def add_nl_force(self, force):
        self.nonlinear_forces.append(force)

    def total_aft(self, U, w, h, Nt=128, aft_tol=1e-7, calc_grad=True):
        if not calc_grad:
            return (sum(f.aft(U, w, h, Nt, aft_tol, calc_grad=False)[0]
                        for f in self.nonlinear_forces),)  # fmt: skip
        found = [force.aft(U, w, h, Nt, aft_tol) for force in self.nonlinear_forces]
        return tuple(sum(parts) for parts in zip(*found, strict=True))

    def static_res(self, U, F):
        found = [force.force(U) for force in self.nonlinear_forces]
        return self.K @ U + sum(f for f, _ in found) - F, self.K + sum(k for _, k in found)

    def hbm_res(self, Uw, Fl, h, Nt=128, aft_tol=1e-7, calc_grad=True):
        U, w = Uw[:-1], Uw[-1]
        E = linear(self.M, self.C, self.K, w, h)
        found = self.total_aft(U, w, h, Nt, aft_tol, calc_grad)
        R = E @ U + found[0] - Fl
        return (R, E + found[1], None) if calc_grad else (R,)


def test_the_forced_response_of_tmdsimpy_is_that_of_structure(force_of_tmdsimpy):
    system = StandIn(M, K, C=C)
    system.add_nl_force(
        force_of_tmdsimpy(np.array([[0.0, 1.0]]), np.array([[0.0], [1.0]]), JOINT, rest=0.0)
    )
    drive = np.zeros(10)
    drive[2] = 300.0
    U = np.zeros(10)
    for _ in range(30):
        R, dRdU = system.hbm_res(np.append(U, OMEGA), drive, H)[:2]
        U = U - np.linalg.solve(dRdU, R)
    assert np.abs(R).max() < 1e-8 * 300.0
    own = STRUCTURE.forced_response([300.0, 0.0], FREQUENCIES, harmonics=[0, 1, 3])
    wanted = np.abs(own.displacement[own.requested][0, :, 1])
    np.testing.assert_allclose(np.hypot(U[2:4], U[4:6]), wanted, rtol=1e-8)
    assert wanted[1] > 5e-8, "well into slip"
    only = system.hbm_res(np.append(U, OMEGA), drive, H, calc_grad=False)[0]
    np.testing.assert_allclose(only, R, atol=1e-9 * 300.0)


def test_friction_of_tmdsimpy_begins_where_a_system_was_preloaded(force_of_tmdsimpy):
    force = force_of_tmdsimpy([[1.0, -1.0]], [[1.0], [-1.0]], JOINT)
    U = np.array([3e-7, 0.0, 2e-7, 0.0, 0.0, 0.0])  # mean, cos and sin of two displacements
    there = force.aft(U, 1.0, np.array([0, 1]))[0]
    assert abs(there[0]) < 1e-9, "about its mean it has no mean force"
    force.set_aft_initialize(np.array([1e-7, 0.0]))
    force.set_prestress_mu()
    held, slope = force.force(np.array([1e-7, 0.0]))
    assert not held.any(), "no friction while it is preloaded"
    assert not slope.any()
    force.reset_real_mu()
    assert force.force(np.array([1e-7, 0.0]))[0][0] == pytest.approx(JOINT.backbone(1e-7))
    moved = force.aft(U, 1.0, np.array([0, 1]))[0]
    wanted = JOINT.harmonics(np.array([3e-7, 2e-7, 0.0]), [0, 1], 1e-7).force
    np.testing.assert_allclose(moved[::2], wanted, rtol=1e-12, atol=1e-9)


def contact_on_a_block(nodes):
    """A field under a block: gaps, what takes its 6 motions to (x, y, opening) a node, a structure.

    The block moves rigidly on soft springs; opening is counted upwards.
    """
    gaps = 1e-6 + 1e-7 * np.arange(nodes)
    field = ms.JointField(JOINT.surface, 0.4, areas=np.full(nodes, 2e-4 / nodes), gaps=gaps)
    places = 0.05 * np.random.default_rng(3).uniform(-1.0, 1.0, size=(nodes, 2))
    motions = np.zeros((nodes, 3, 6))
    motions[:, :, :3] = np.eye(3)
    motions[:, 2, 3], motions[:, 2, 4] = places[:, 1], -places[:, 0]
    motions[:, 0, 5], motions[:, 1, 5] = -places[:, 1], places[:, 0]
    mass = np.diag([3.0, 3.0, 3.0, 4e-3, 4e-3, 5e-3])
    stiffness = np.diag([2e7, 2e7, 1e6, 1e4, 1e4, 2e4])
    structure = ms.Structure(mass, stiffness, 2e-5 * stiffness)
    return field, motions, structure.attach(field, directions=motions.transpose(2, 0, 1))


@pytest.mark.parametrize("tangential", [1, 2])
def test_contacts_in_tmdsimpy_balance_steps_in_time(force_of_tmdsimpy, tangential):
    """Pressed without friction as by `Structure`, then driven: slip, and faces that breathe."""
    from microslip.export.hosts.tmdsimpy import FieldForce

    field, motions, structure = contact_on_a_block(8)
    taken = [0, 2] if tangential == 1 else [0, 1, 2]
    system = StandIn(structure.mass, structure.stiffness, C=structure.damping)
    # A quadrature as theirs: the field bears tractions, T has the areas; approaches are positive.
    Q = motions[:, taken] * np.array([1.0, 1.0, -1.0])[None, taken, None]
    tractions = ms.JointField(field.surface, 0.4, areas=np.ones(8), gaps=field.gaps)
    to_local = Q.reshape(-1, 6)
    back = (Q * field.areas[:, None, None]).reshape(-1, 6).T
    contact = FieldForce(to_local, back, tractions, sliders=300)
    system.add_nl_force(contact)
    press = np.array([0.0, 0.0, -3000.0, 20.0, 0.0, 0.0])
    state = structure.preload(press)
    contact.set_prestress_mu()
    X = state.displacement * 1.001
    for _ in range(20):
        R, slope = system.static_res(X, press)
        X = X - np.linalg.solve(slope, R)
    np.testing.assert_allclose(X, state.displacement, rtol=1e-9, atol=1e-14)
    contact.force(X, update_hist=True)
    contact.set_aft_initialize(X)
    contact.reset_real_mu()
    R, slope = system.static_res(X, press)
    assert np.abs(R).max() < 1e-6 * 3000.0, "at rest there is no tangential force"
    lowest = np.sqrt(linalg.eigvalsh(slope, structure.mass)[:2])
    own = state.linear_modes(2).frequency
    if tangential == 2:
        np.testing.assert_allclose(lowest / (2.0 * np.pi), own, rtol=1e-2)  # 300 sliders
    h, drive, w = [0, 1, 2, 3], np.zeros(6), 0.7 * lowest[0]
    drive[:3] = 240.0, 120.0 * (tangential == 2), 240.0
    load, U = np.zeros(42), np.append(X, np.zeros(36))
    load[:6] = press
    for share in (0.1, 0.3, 0.6, 1.0):
        load[6:12] = share * drive
        for _ in range(20):
            R, slope = system.hbm_res(np.append(U, w), load, np.array(h))[:2]
            U = U - np.linalg.solve(slope, R)
    assert np.abs(R).max() < 1e-6
    # Equations in time: the same field, its forces from small steps of its own states.
    samples = 512 if tangential == 1 else 256
    t = 2.0 * np.pi * np.arange(samples) / samples
    waves = np.stack([np.ones(samples), *(f(k * t) for k in h[1:] for f in (np.cos, np.sin))])
    x = U.reshape(7, 6).T @ waves
    law = field.at(separations=field.gaps + (motions[:, 2] @ X))
    law = law if tangential == 1 else law.two_directions(300)
    path = motions[:, taken] @ x
    begin = motions[:, taken] @ X
    marching, pulled = law.start(), np.zeros((6, samples))
    for k in [*range(samples)] * 8:
        place = path[:, :-1, k] - begin[:, :-1]
        trial = marching.try_(
            place[:, 0] if tangential == 1 else place, separations=field.gaps + path[:, -1, k]
        )
        marching.commit()
        local = np.column_stack((trial.force, -trial.load))
        pulled[:, k] = np.einsum("nd,ndi->i", local, motions[:, taken])
    back = waves / (waves**2).sum(axis=1)[:, None]
    forces = (pulled @ back.T).T.ravel()
    linear_part = linear(structure.mass, structure.damping, structure.stiffness, w, h) @ U
    miss = np.abs(linear_part + forces - load).max()
    share = 2e-4 if tangential == 1 else 3e-3  # 128 samples, sliders that settle slowly
    assert miss < share * np.abs(forces[6:]).max()
    slips = np.hypot(*U[6:18].reshape(2, 6)[:, :1]) / law_slip(field)
    assert slips > 0.02, slips


def law_slip(field):
    """Displacement [m] at which the first tangent of the pressed field meets its limit."""
    pressed = field.at(loads=3000.0 / field.size)
    return pressed.force_limits.sum() / pressed.tangential_stiffnesses.sum()


def test_rows_of_a_field_in_tmdsimpy_are_laws_of_their_own(force_of_tmdsimpy):
    """One force a row, a field in one call, and the same placed by whole Kronecker products."""
    field = ms.JointField(JOINT.surface, 0.5, areas=[1e-4, 2e-4], loads=[700.0, 900.0])
    laws = [ms.Interface(JOINT.surface, 0.5, normal_load=load) for load in (2 * 700.0, 900.0)]
    laws[0] = ms.Parallel([ms.JointField(JOINT.surface, 0.5, areas=[1e-4], loads=[700.0]).rigid()])
    Q = np.random.default_rng(4).normal(size=(2, 5)) * (np.arange(5) < 4)
    T, h = Q.T * [2.0, 1.0], np.array([0, 1, 2])
    U = 2e-7 * np.random.default_rng(5).normal(size=25)
    F, J, _ = force_of_tmdsimpy(Q, T, field).aft(U, 1.0, h)
    alone = [force_of_tmdsimpy(Q[[i]], T[:, [i]], laws[i]) for i in range(2)]
    other = [sum(parts) for parts in zip(*(one.aft(U, 1.0, h) for one in alone), strict=True)]
    np.testing.assert_allclose(F, other[0], rtol=1e-9, atol=1e-9 * np.abs(F).max())
    np.testing.assert_allclose(J, other[1], rtol=0.0, atol=1e-8 * np.abs(J).max())
    found = field.harmonics(Q @ U.reshape(5, 5).T, [0, 1, 2], rest="mean")
    whole = np.zeros((10, 10))
    for i in range(2):
        whole[i::2, i::2] = found[1][i]
    wanted = np.kron(np.eye(5), T) @ whole @ np.kron(np.eye(5), Q)
    np.testing.assert_allclose(J, wanted, rtol=0.0, atol=1e-12 * np.abs(J).max())
    X = np.array([1e-7, -2e-7, 3e-7, 1e-8, 0.0])
    there = [one.force([x, -x])[-1] for one, x in zip(laws, Q @ X, strict=True)]
    for forces in ([force_of_tmdsimpy(Q, T, field)], alone):
        for force in forces:
            force.force(X, update_hist=True)
        T2 = sum(force.force(-X)[0] for force in forces)
        np.testing.assert_allclose(T2, T @ there, rtol=1e-9)
    with pytest.raises(ms.InputError, match="Q must have 2 rows for the 2 nodes"):
        force_of_tmdsimpy(Q[:1], T[:, :1], field)
    from microslip.export.hosts.tmdsimpy import FieldForce

    with pytest.raises(ms.InputError, match="Q must have 4 or 6 rows for the 2 nodes"):
        FieldForce(Q, T, field)
    with pytest.raises(ms.InputError, match="must be a JointField"):
        FieldForce(Q, T, JOINT)
    contact = FieldForce(np.eye(4), np.eye(4), field)
    with pytest.raises(ms.InputError, match="must begin with the mean, 0"):
        contact.aft(np.zeros(8), 1.0, np.array([1]))


RECIPE = (Path(__file__).parents[2] / "docs" / "hosts-nlvib.md").read_text(encoding="utf-8")


def test_the_recipe_of_nlvib_is_that_of_structure():
    """The page's own function, called as harmonic balance with differences calls it."""
    code = "def eval_batch" + RECIPE.split("def eval_batch")[1].split("\n\n\n")[0]
    names = {"np": np, "joint": JOINT}
    exec(code, names)  # the recipe of the page
    units, size = 1e-6, 14  # micrometres: matrices in N/um
    t = 2.0 * np.pi * np.arange(256) / 256
    rows = [np.ones(256), *(f(k * t) for k in (1, 2, 3) for f in (np.cos, np.sin))]
    basis = np.array(rows)
    back = np.array([row / (row @ row) for row in rows])

    def forces(Q):
        """As its alternation between frequency and time: shape (n, samples), one call a period."""
        q_time = Q.reshape(7, 2).T @ basis
        return (names["eval_batch"](q_time, None, dof=1) @ back.T).T.ravel()

    E, Q = linear(M * units, C * units, K * units, OMEGA, [0, 1, 2, 3]), np.zeros(size)
    F = np.zeros(size)
    F[2] = 300.0
    for _ in range(30):
        step = np.sqrt(np.finfo(float).eps) * np.maximum(np.abs(Q), 1.0)
        columns = [(forces(Q + d) - forces(Q - d)) / (2.0 * d.max()) for d in np.diag(step)]
        R, J = E @ Q + forces(Q) - F, E + np.array(columns).T
        Q = Q - np.linalg.solve(J, R)
    assert np.abs(R).max() < 1e-6 * 300.0
    own = STRUCTURE.forced_response([300.0, 0.0], FREQUENCIES, harmonics=[0, 1, 2, 3])
    wanted = np.abs(own.displacement[own.requested][0, :, 1])
    # Samples at equal times miss the turns: 4e-4 with 64 a period, a sixteenth of it with 256.
    np.testing.assert_allclose(1e-6 * np.hypot(Q[2:4], Q[4:6]), wanted, rtol=4e-5)


@pytest.fixture
def force_of_tmdsimpy(monkeypatch):
    """The class on a base that only keeps Q and T, as theirs does."""

    class HystereticForce:
        def __init__(self, Q, T):
            self.Q, self.T = Q, T

    for name in ("tmdsimpy", "tmdsimpy.nlforces", "tmdsimpy.nlforces.nonlinear_force"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    sys.modules["tmdsimpy.nlforces.nonlinear_force"].HystereticForce = HystereticForce
    monkeypatch.delitem(sys.modules, "microslip.export.hosts.tmdsimpy", raising=False)
    yield importlib.import_module("microslip.export.hosts.tmdsimpy").JointForce
    sys.modules.pop("microslip.export.hosts.tmdsimpy", None)
