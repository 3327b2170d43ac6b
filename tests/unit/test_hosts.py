"""Adapters whose host is no package that can be installed: what they compute, not that it fits."""

from __future__ import annotations

import importlib
import sys
import types

import numpy as np
import pytest
from exported import JOINT

import microslip as ms


@pytest.fixture
def force_of_tmdsimpy(monkeypatch):
    """The class on a base that only keeps Q and T; proof of its algebra, none of its host."""

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
