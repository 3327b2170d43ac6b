"""A force for TMDSimPy: a law on each local displacement, its harmonics exact.

TMDSimPy is not on PyPI; it is fetched by its users. This module was written after its published
sources; a stand-in that makes their calls runs it here, not TMDSimPy. Their hysteretic forces begin
at the mean of a cycle, and so does this one unless ``rest`` says otherwise.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from tmdsimpy.nlforces.nonlinear_force import HystereticForce

from microslip._core.checks import Floats, floats, show
from microslip.errors import InputError
from microslip.friction import BackboneLaw


class JointForce(HystereticForce):  # type: ignore[misc]
    """A backbone law on each local displacement Q x, its force back through T.

    Parameters
    ----------
    Q : array_like
        Takes displacements of the system to local ones [-], shape (local, n).
    T : array_like
        Takes local forces to those of the system [-], shape (n, local).
    law : BackboneLaw
        The law of each of them.
    rest : float or "mean", optional
        Displacement [m] at which the joint began, or the mean of the cycle.
    """

    def __init__(self, Q: ArrayLike, T: ArrayLike, law: BackboneLaw, rest: Any = "mean") -> None:
        if not isinstance(law, BackboneLaw):
            raise InputError(f"`law` must be a backbone law, got {show(law)}")
        to_local, to_system = floats("Q", Q), floats("T", T)
        if to_local.ndim != 2 or to_system.shape != to_local.shape[::-1]:
            raise InputError(
                "Q and T must have the shapes (local, n) and (n, local), "
                f"got {to_local.shape} and {to_system.shape}"
            )
        super().__init__(to_local, to_system)
        self.law, self.rest = law, [rest] * len(to_local)
        self.slides_freely = False
        self.init_history()

    def set_aft_initialize(self, X: ArrayLike) -> None:
        """Let the joints begin at displacements X [m], shape (n,), in place of ``rest``.

        A system calls it with what it was preloaded to.
        """
        self.rest = (self.Q @ np.asarray(X, dtype=float)).tolist()

    def set_prestress_mu(self) -> None:
        """Hold nothing, as a system asks while it is preloaded: there is no friction then."""
        self.slides_freely = True

    def reset_real_mu(self) -> None:
        """Hold again, after the preload."""
        self.slides_freely = False

    def init_history(self, unlth0: Any = None, h: Any = None) -> None:
        """Put every joint at rest, for :meth:`force`."""
        self.states = [self.law.start() for _ in range(len(self.Q))]

    def force(self, X: ArrayLike, update_hist: bool = False) -> tuple[Floats, Floats]:
        """Forces [N] at displacements X [m], shape (n,), and their derivatives [N/m], (n, n).

        Each call starts from the last one that was told to become part of the history.
        """
        local = self.Q @ np.asarray(X, dtype=float)
        if self.slides_freely:
            return np.zeros(len(self.T)), np.zeros((len(self.T), self.Q.shape[1]))
        trials = [state.try_(float(x)) for state, x in zip(self.states, local, strict=True)]
        if update_hist:
            for state in self.states:
                state.commit()
        stiffness = self.T @ (np.array([[trial.stiffness] for trial in trials]) * self.Q)
        return self.T @ np.array([trial.force for trial in trials]), stiffness

    def aft(
        self, U: ArrayLike, w: float, h: ArrayLike, Nt: int = 128, tol: float = 1e-7, **_: Any
    ) -> tuple[Floats, Floats, Floats]:
        """Coefficients of the forces from those of the displacements, without samples.

        Parameters
        ----------
        U : array_like
            Coefficients [m], those of all n displacements for the mean, then for cos 1, sin 1, ...
        w : float
            Frequency [rad/s], on which nothing depends.
        h : array_like of int
            Harmonics, rising.
        Nt, tol, calc_grad, ... : optional
            Of their interface; there is nothing to sample, and gradients are always there.

        Returns
        -------
        force, jacobian, by_frequency : ndarray
            Coefficients [N], their derivatives [N/m], and zeros.
        """
        coefficients = np.asarray(U, dtype=float)
        numbers = [int(number) for number in np.asarray(h).tolist()]
        local = self.Q @ coefficients.reshape((self.Q.shape[1], -1), order="F")
        n, count = self.Q.shape[1], local.shape[1]
        force, jacobian = np.zeros((count, n)), np.zeros((count, n, count, n))
        for i, motion in enumerate(local):  # a row touches few displacements: only their entries
            harmonics = self.law.harmonics(motion, numbers, self.rest[i])
            to, of = np.flatnonzero(self.T[:, i]), np.flatnonzero(self.Q[i])
            force[:, to] += np.outer(harmonics.force, self.T[to, i])
            block = np.einsum("ab,j,k->ajbk", harmonics.jacobian, self.T[to, i], self.Q[i, of])
            jacobian[:, to[:, None], :, of] += block.transpose(1, 3, 0, 2)
        force, jacobian = force.ravel(), jacobian.reshape(coefficients.size, -1)
        return force, jacobian, np.zeros_like(coefficients)
