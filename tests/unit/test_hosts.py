"""Adapters whose host is on no package index: run by stand-ins that make the calls of the hosts.

The stand-ins follow the published interfaces alone: the order and scaling of unknowns, and which
method is called with what. Where TMDSimPy or NLvib-py is installed the same tests run with it, too.
"""

from __future__ import annotations

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

    def __init__(self, m, k, c):
        self.M, self.K, self.C, self.nonlinear_forces = m, k, c, []

    def add_nl_force(self, force):
        self.nonlinear_forces.append(force)

    def total_aft(self, U, w, h, Nt=128, aft_tol=1e-7, calc_grad=True):
        if not calc_grad:
            return (sum(f.aft(U, w, h, Nt, aft_tol, calc_grad=False)[0]
                        for f in self.nonlinear_forces),)  # fmt: skip
        found = [force.aft(U, w, h, Nt, aft_tol) for force in self.nonlinear_forces]
        return tuple(sum(parts) for parts in zip(*found, strict=True))

    def hbm_res(self, Uw, Fl, h, Nt=128, aft_tol=1e-7, calc_grad=True):
        U, w = Uw[:-1], Uw[-1]
        E = linear(self.M, self.C, self.K, w, h)
        found = self.total_aft(U, w, h, Nt, aft_tol, calc_grad)
        R = E @ U + found[0] - Fl
        return (R, E + found[1], None) if calc_grad else (R,)

    def epmc_res(self, Uwxa, Fl, h, Nt=128, aft_tol=1e-7, calc_grad=True):
        """Extended periodic motion: U of unit modal mass, w, damping and log10 of the amplitude."""
        U, (w, damping, log_a) = Uwxa[:-3], Uwxa[-3:]
        n, a = len(self.M), 10.0**log_a
        grow = np.concatenate([np.full(n if k == 0 else 2 * n, 1.0 if k == 0 else a) for k in h])
        E = linear(self.M, self.C - 2.0 * w * damping * self.M, self.K, w, h)
        force = self.total_aft(grow * U, w, h, Nt, aft_tol)[0]
        first = U[n : 3 * n] if h[0] == 0 else U[: 2 * n]
        mass = first[:n] @ self.M @ first[:n] + first[n:] @ self.M @ first[n:]
        return (np.concatenate([E @ (grow * U) + force, [mass - 1.0, Fl @ U]]),)


@pytest.fixture(params=["stand-in", "TMDSimPy"])
def system_of_tmdsimpy(request):
    """The two masses, in the stand-in and, where it is installed, in TMDSimPy."""
    if request.param == "TMDSimPy":
        reason = "TMDSimPy is not installed, and on no package index"
        host = pytest.importorskip("tmdsimpy.vibration_system", reason=reason)
        from microslip.hosts.tmdsimpy import JointForce

        return host.VibrationSystem(M, K, C=C), JointForce
    return StandIn(M, K, C), request.getfixturevalue("force_of_tmdsimpy")


def test_the_forced_response_of_tmdsimpy_is_that_of_structure(system_of_tmdsimpy):
    system, force = system_of_tmdsimpy
    system.add_nl_force(force(np.array([[0.0, 1.0]]), np.array([[0.0], [1.0]]), JOINT, rest=0.0))
    drive = np.zeros(10)
    drive[2] = 300.0
    U = np.zeros(10)
    for _ in range(30):
        R, dRdU = system.hbm_res(np.append(U, OMEGA), drive, H)[:2]
        U = U - np.linalg.solve(dRdU, R)
    assert np.abs(R).max() < 1e-8 * 300.0
    own = STRUCTURE.forced_response([300.0, 0.0], FREQUENCIES, harmonics=[0, 1, 3])
    wanted = np.abs(own.displacement[own.asked][0, :, 1])
    np.testing.assert_allclose(np.hypot(U[2:4], U[4:6]), wanted, rtol=1e-8)
    assert wanted[1] > 5e-8, "well into slip"
    only = system.hbm_res(np.append(U, OMEGA), drive, H, calc_grad=False)[0]
    np.testing.assert_allclose(only, R, atol=1e-9 * 300.0)


def test_the_mode_of_tmdsimpy_is_that_of_structure(system_of_tmdsimpy):
    """By least squares on its own residual; both solve the same equations."""
    from scipy.optimize import least_squares

    system, force = system_of_tmdsimpy
    system.C = np.zeros((2, 2))
    system.add_nl_force(force(np.array([[0.0, 1.0]]), np.array([[0.0], [1.0]]), JOINT, rest=0.0))
    amplitude = 3e-7
    own = ms.Structure(M, K).attach(JOINT, directions=[0.0, 1.0])
    curve = own.modes(0, [amplitude], harmonics=[1], method="harmonic-balance")
    h, phase = np.array([1]), np.array([0.0, 0.0, 1.0, 0.0])
    w0, shape = 2.0 * np.pi * curve.frequency[0], np.array([0.2, 0.25])
    start = np.concatenate([shape, [0.0, 0.0, 1.01, 0.9 * curve.damping_ratio[0]]])
    units = np.array([1.0, 1.0, 1.0, 1.0, w0, 1.0])

    def residual(x):
        R = system.epmc_res(np.append(x * units, np.log10(amplitude)), phase, h)[0]
        return R / np.array([*[1e9 * amplitude] * 4, 1.0, 1.0])

    found = least_squares(residual, start, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    # The root of differences of the residual: half its digits and more.
    assert found[4] == pytest.approx(1.0, rel=1e-7)
    assert found[5] == pytest.approx(curve.damping_ratio[0], rel=1e-5)


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


RECIPE = (Path(__file__).parents[2] / "docs" / "hosts.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("host", ["stand-in", "NLvib-py"])
def test_the_recipe_of_nlvib_is_that_of_structure(host):
    """The page's own function, called as a balance of harmonics with differences calls it."""
    code = "def eval_batch" + RECIPE.split("def eval_batch")[1].split("\n\n\n")[0]
    names = {"np": np, "joint": JOINT}
    exec(code, names)  # the recipe of the page
    units, size = 1e-6, 14  # micrometres: matrices in N/um
    if host == "NLvib-py":
        reason = "NLvib-py is not installed, and on no package index"
        solver = pytest.importorskip("nlvib.solvers.harmonic_balance", reason=reason)
        from nlvib.nonlinearities.elements import NonlinearElement
        from nlvib.systems.base import MechanicalSystem

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
        if host == "NLvib-py":
            element = NonlinearElement(
                eval=lambda q, dq: (0.0, 0.0 * q, 0.0 * q),
                eval_batch=lambda q, dq: names["eval_batch"](q, dq, dof=1),
            )
            system = MechanicalSystem(M * units, C * units, K * units, [element])
            R, J = solver.hb_residual(Q, OMEGA, system, 3, F, 256)
        else:
            step = np.sqrt(np.finfo(float).eps) * np.maximum(np.abs(Q), 1.0)
            columns = [(forces(Q + d) - forces(Q - d)) / (2.0 * d.max()) for d in np.diag(step)]
            R, J = E @ Q + forces(Q) - F, E + np.array(columns).T
        Q = Q - np.linalg.solve(J, R)
    assert np.abs(R).max() < 1e-6 * 300.0
    own = STRUCTURE.forced_response([300.0, 0.0], FREQUENCIES, harmonics=[0, 1, 2, 3])
    wanted = np.abs(own.displacement[own.asked][0, :, 1])
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
    monkeypatch.delitem(sys.modules, "microslip.hosts.tmdsimpy", raising=False)
    yield importlib.import_module("microslip.hosts.tmdsimpy").JointForce
    sys.modules.pop("microslip.hosts.tmdsimpy", None)


def test_coefficients_and_derivatives_for_tmdsimpy(force_of_tmdsimpy):
    Q = np.array([[1.0, -1.0, 0.0], [0.0, 0.5, 1.0]])
    force = force_of_tmdsimpy(Q, Q.T, JOINT)
    h = np.array([0, 1, 3])
    U = 3e-7 * np.random.default_rng(2).normal(size=15)
    F, J, by_frequency = force.aft(U, 1.0, h)
    local = Q @ U.reshape(5, 3).T
    wanted = Q.T @ [JOINT.harmonics(motion, [0, 1, 3], "mean").force for motion in local]
    np.testing.assert_allclose(F.reshape(5, 3), wanted.T, rtol=1e-12, atol=1e-9)
    step = 1e-12
    for k in (0, 4, 14):
        ends = [force.aft(U + sign * step * np.eye(15)[k], 1.0, h)[0] for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / (2.0 * step)
        np.testing.assert_allclose(J[:, k], slope, rtol=0.0, atol=1e-4 * np.abs(J).max())
    assert not by_frequency.any()


def test_a_history_for_tmdsimpy_moves_only_when_told(force_of_tmdsimpy):
    force = force_of_tmdsimpy([[1.0]], [[1.0]], JOINT, rest=0.0)
    force.force([5e-7])
    T, K = force.force([1e-7], update_hist=True)
    assert T[0] == JOINT.force([1e-7])[0]
    assert K[0, 0] == pytest.approx(JOINT.backbone_stiffness(1e-7))
    assert force.force([0.0])[0][0] == JOINT.force([1e-7, 0.0])[-1]
    force.init_history()
    assert force.force([0.0])[0][0] == 0.0
    for law, Q, says in ((3, [[1.0]], "law must be"), (JOINT, [1.0], "Q and T must have")):
        with pytest.raises(ms.InputError, match=says):
            force_of_tmdsimpy(Q, [[1.0]], law)
