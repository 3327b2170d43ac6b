"""Forces for TMDSimPy: laws on local displacements, and fields of contact nodes.

TMDSimPy is not on PyPI and must be installed from its repository. The tests use a substitute with
its published interface, and TMDSimPy itself if it is installed. The hysteretic elements of TMDSimPy
begin each cycle without force at its mean displacement, and so does :class:`JointForce` unless
``rest`` is given.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from tmdsimpy.nlforces.nonlinear_force import HystereticForce

from microslip._core.checks import Floats, floats, positive, show
from microslip._core.errors import InputError
from microslip.friction import BackboneLaw, JointField
from microslip.friction.vector_cycles import SETTLED

_SPARSE = 0.1  # fraction of nonzero entries below which a matrix is stored as sparse


class _Force(HystereticForce):  # type: ignore[misc]
    """Base class: transforms displacements and forces between the system and the nodes."""

    def __init__(self, Q: ArrayLike, T: ArrayLike, nodes: int | None, widths: tuple[int, ...]):
        to_local, to_system = floats("Q", Q), floats("T", T)
        if to_local.ndim != 2 or to_system.shape != to_local.shape[::-1]:
            raise InputError(
                "Q and T must have the shapes (local, n) and (n, local), "
                f"got {to_local.shape} and {to_system.shape}"
            )
        super().__init__(to_local, to_system)
        size = nodes or len(to_local)
        if len(to_local) not in [size * width for width in widths]:
            rows = " or ".join(str(size * width) for width in widths)
            raise InputError(
                f"Q must have {rows} rows for the {size} nodes of the field, got {len(to_local)}"
            )
        self._width = len(to_local) // size
        self._rows, self._columns = (np.flatnonzero(m.any(axis=1)) for m in (to_system, to_local.T))
        self._back: Any = to_system[self._rows]
        if np.count_nonzero(self._back) < _SPARSE * self._back.size:
            from scipy.sparse import csr_array

            self._back = csr_array(self._back)
        self._to_nodes = to_local[:, self._columns].reshape(size, self._width, -1)
        self.slides_freely = False

    def set_prestress_mu(self) -> None:
        """Disable friction; TMDSimPy calls this method before it computes the preload."""
        self.slides_freely = True

    def reset_real_mu(self) -> None:
        """Enable friction again after the preload."""
        self.slides_freely = False

    def _node_motion(self, X: ArrayLike) -> Floats:
        """Return the motion of each node [m], shape (nodes, directions, ...)."""
        local = self.Q @ np.asarray(X, dtype=float)
        return np.asarray(local.reshape(-1, self._width, *local.shape[1:]))

    def _to_system(self, tangent: Floats) -> Floats:
        """Convert tangents of the nodes to derivatives of forces of the system [N/m]."""
        return np.asarray(self._back @ (tangent @ self._to_nodes).reshape(len(self.Q), -1))

    def _settled(self, motion: Floats, numbers: list[int], samples: int) -> tuple[Floats, Floats]:
        raise NotImplementedError

    def _stepped(self, motion: Floats, commit: bool) -> tuple[Floats, Floats]:
        raise NotImplementedError

    def force(self, X: ArrayLike, update_hist: bool = False) -> tuple[Floats, Floats]:
        """Return forces [N] at displacements X [m], shape (n,), and derivatives [N/m], (n, n).

        The step to X begins at the displacements of the last call with ``update_hist=True``.
        """
        force, tangent = self._stepped(self._node_motion(X), update_hist)
        matrix = np.zeros(self.T.shape[:1] * 2)
        matrix[np.ix_(self._rows, self._columns)] = self._to_system(tangent)
        return np.asarray(self.T @ force.ravel()), matrix

    def aft(
        self, U: ArrayLike, w: float, h: ArrayLike, Nt: int = 128, tol: float = 1e-7,
        calc_grad: bool = True, **_: Any,
    ) -> tuple[Floats, ...]:  # fmt: skip
        """Return Fourier coefficients of the settled forces for those of the displacements.

        Parameters
        ----------
        U : array_like
            Coefficients [m], for each harmonic those of all n displacements: mean, cos 1, sin 1,
            ...
        w : float
            Frequency [rad/s], unused.
        h : array_like of int
            Orders of the harmonics, increasing.
        Nt : int, optional
            Samples per period, used only by contacts in three directions.
        tol, ... : optional
            Arguments of TMDSimPy's interface, unused.
        calc_grad : bool, optional
            Compute derivatives.

        Returns
        -------
        force, jacobian, by_frequency : ndarray
            Coefficients of forces [N], derivatives by U [N/m], and derivatives by w, which are
            zero; only the first without ``calc_grad``.
        """
        coefficients, n = np.asarray(U, dtype=float), self.Q.shape[1]
        numbers = [int(number) for number in np.asarray(h).tolist()]
        motion = self._node_motion(coefficients.reshape((n, -1), order="F"))
        force, jacobian = self._settled(motion, numbers, int(Nt))
        count = force.shape[-1]
        out = (self.T @ force.reshape(-1, count)).ravel(order="F")
        if not calc_grad:
            return (out,)
        matrix = np.zeros((count, n, count, n))
        for i in range(count):
            for k in range(count):
                block = self._to_system(np.ascontiguousarray(jacobian[..., i, k]))
                matrix[i, :, k][np.ix_(self._rows, self._columns)] = block
        return out, matrix.reshape(out.size, -1), np.zeros_like(out)


class JointForce(_Force):
    """Laws of one direction at constant loads, one for each local displacement Q x.

    Parameters
    ----------
    Q : array_like
        Matrix from displacements x of the system to local displacements [-], shape (local, n).
    T : array_like
        Matrix from local forces to forces of the system [-], shape (n, local).
    law : BackboneLaw or JointField
        One law for all local displacements, or a field with as many nodes, which is evaluated in
        one compiled call.
    rest : float or "mean", optional
        Displacement [m] at which the force of the joints is zero before the motion, or "mean" for
        the mean of the cycle.
    """

    def __init__(self, Q: ArrayLike, T: ArrayLike, law: Any, rest: Any = "mean") -> None:
        if not isinstance(law, (BackboneLaw, JointField)):
            raise InputError(f"`law` must be a backbone law or a JointField, got {show(law)}")
        super().__init__(Q, T, law.size if isinstance(law, JointField) else None, (1,))
        self.law, self.rest = law, [rest] * len(self.Q)
        self.init_history()

    def set_aft_initialize(self, X: ArrayLike) -> None:
        """Set ``rest``, where the force of the joints is zero, to displacements X [m], shape (n,).

        TMDSimPy calls this method with the displacements under preload.
        """
        self.rest = self._node_motion(X)[:, 0].tolist()

    def init_history(self, unlth0: Any = None, h: Any = None) -> None:
        """Start every joint at rest, for :meth:`force`."""
        count = 1 if isinstance(self.law, JointField) else len(self.Q)
        self.states: list[Any] = [self.law.start() for _ in range(count)]

    def _stepped(self, motion: Floats, commit: bool) -> tuple[Floats, Floats]:
        x = motion[:, 0]
        if self.slides_freely:
            return np.zeros(x.size), np.zeros((x.size, 1, 1))
        places = [x] if isinstance(self.law, JointField) else x.tolist()
        trials = [state.try_(place) for state, place in zip(self.states, places, strict=True)]
        if commit:
            for state in self.states:
                state.commit()
        force, stiffness = (np.ravel([trial[k] for trial in trials]) for k in (0, 1))
        return force, stiffness[:, None, None]

    def _settled(self, motion: Floats, numbers: list[int], samples: int) -> tuple[Floats, Floats]:
        x = motion[:, 0]
        if isinstance(self.law, JointField):
            rest = "mean" if "mean" in self.rest else self.rest
            force, jacobian = self.law.harmonics(x, numbers, rest=rest)
            return force[:, None], jacobian[:, None, None]
        rows = zip(x, self.rest, strict=True)
        found = [self.law.harmonics(row, numbers, rest) for row, rest in rows]
        jacobians = np.array([response.jacobian for response in found])
        return np.array([[response.force] for response in found]), jacobians[:, None, None]


class FieldForce(_Force):
    """Field of contact nodes that slip, open and close, in place of rough-contact elements.

    Parameters
    ----------
    Q : array_like
        Matrix from displacements of the system to local displacements [-], shape (local, n). Each
        node has one or two tangential displacements, then the approach of the faces, positive if
        they close.
    T : array_like
        Matrix from local forces to forces of the system [-], shape (n, local). If it contains areas
        [m^2], as for a quadrature of tractions, set ``areas`` of the field to 1.
    field : JointField
        The nodes; their ``gaps`` are the separations at zero displacement.
    sliders, nearest : optional
        Number of sliders [-] and smallest separation [m], see
        :meth:`microslip.JointField.two_directions`; used only with two tangential directions.
        Cycles below the amplitude ``resolution`` [m] hardly dissipate energy; more sliders make
        ``resolution`` smaller.
    tolerance : float, optional
        Largest estimated difference of computed forces from exactly periodic ones, relative to the
        force limit [-]; used only with two tangential directions.

    Attributes
    ----------
    converged : ndarray of bool
        True for each node whose ``residual`` after :meth:`aft` is within the tolerance, shape
        (nodes,).
    residual : ndarray
        Estimated error of the last forces [N], see :class:`microslip.FieldHarmonics`.
    """

    def __init__(
        self, Q: ArrayLike, T: ArrayLike, field: JointField, *, sliders: int = 512,
        nearest: float | None = None, tolerance: float = SETTLED,
    ) -> None:  # fmt: skip
        if not isinstance(field, JointField):
            raise InputError(f"`field` must be a JointField, got {show(field)}")
        super().__init__(Q, T, field.size, (2, 3))
        self.field = field
        self._options: dict[str, Any] = {"sliders": sliders, "nearest": nearest}
        self._tolerance = positive("tolerance", tolerance, example=SETTLED)
        self.converged, self.residual = np.ones(field.size, dtype=bool), np.zeros(field.size)
        self._zero = field.separations if field.gaps is None else field.gaps
        self._signs = np.append(np.ones(self._width - 1), -1.0)  # a positive approach closes
        self.init_history()

    @property
    def resolution(self) -> Floats:
        """Tangential amplitudes [m], shape (nodes,), below which sliders hardly dissipate."""
        if self._width == 2:
            return np.zeros(self.field.size)
        return np.asarray(self._law.resolution)

    def _opened(self, motion: Floats) -> Floats:
        return np.asarray(motion * self._signs.reshape(-1, *[1] * (motion.ndim - 2)))

    def _rest_at(self, motion: Floats) -> None:
        """Start all nodes without tangential force at motions with opening [m] (nodes, width)."""
        self._begin, opened = motion[:, :-1].copy(), motion[:, -1]
        field = self.field
        if opened.any() or field.gaps is not None:
            field = field.at(separations=self._zero + opened)
        self._law: Any = field if self._width == 2 else field.two_directions(**self._options)
        self._state = self._law.start()

    def set_aft_initialize(self, X: ArrayLike) -> None:
        """Start the nodes without tangential force at displacements X [m], shape (n,)."""
        self._rest_at(self._opened(self._node_motion(X)))

    def init_history(self, unlth0: Any = None, h: Any = None) -> None:
        """Start all nodes at rest at zero displacement."""
        self._rest_at(np.zeros((self.field.size, self._width)))

    def _stepped(self, motion: Floats, commit: bool) -> tuple[Floats, Floats]:
        motion = self._opened(motion)
        separations = self._zero + motion[:, -1]
        force, tangent = np.zeros(motion.shape), np.zeros((*motion.shape, self._width))
        if self.slides_freely:
            load, tangent[:, -1, -1] = self.field.load(separations)
            if commit:
                self._rest_at(motion)
        else:
            place = motion[:, :-1] - self._begin
            if self._width == 2:
                place = place[:, 0]
            pulled, load, slopes = self._state.try_(place, separations=separations)
            force[:, :-1], tangent = pulled.reshape(len(pulled), -1), slopes.copy()
            if commit:
                self._state.commit()
        force[:, -1] = -load
        tangent[:, -1] *= -1.0
        return self._opened(force), tangent * np.outer(self._signs, self._signs)

    def _settled(self, motion: Floats, numbers: list[int], samples: int) -> tuple[Floats, Floats]:
        if 0 not in numbers:
            raise InputError(f"harmonics of a contact must begin with the mean, 0, got {numbers}")
        motion = self._opened(motion)
        separations = motion[:, -1].copy()
        separations[:, 0] += self._zero
        place = motion[:, :-1].copy()
        place[:, :, 0] -= self._begin
        if self._width == 2:
            found = self._law.harmonics(place[:, 0], numbers, separations=separations)
            tangential = found[0][:, None]
        else:
            found = self._law.harmonics(
                place,
                numbers,
                separations=separations,
                samples=samples,
                tolerance=self._tolerance,
            )
            tangential = found[0]
        self.converged, self.residual = found.converged, found.residual
        force, jacobian = np.concatenate((tangential, -found[1][:, None]), axis=1), found[2]
        jacobian[:, -1] *= -1.0
        signs = np.outer(self._signs, self._signs)[:, :, None, None]
        return self._opened(force), jacobian * signs
