"""Stiffness, mass and stresses of linear elastic bodies by quadratic finite elements."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.packages import needed_for
from microslip.structures.mesh import Indices, JointMesh

_CHUNK = 256  # elements at once: a bound on memory


class Points(NamedTuple):
    """Points in the mesh, each given by its cell and the values of the shape functions there."""

    cells: Indices
    values: Floats
    """Shape functions at the points, (points, functions of a cell)."""
    places: Floats
    """Positions of the points, or of the nearest points of their cells [m]."""
    distances: Floats
    """Distances between the requested positions and ``places`` [m]."""

    def at(self, index: Any) -> Points:
        """Return the points selected by an index array or a mask."""
        return Points(*(part[index] for part in self))


class Elements:
    """Finite elements of the bodies, with three displacements per node.

    Component i (0, 1, 2) of the displacement of node s has the index 3 s + i of ``size`` in all.
    """

    def __init__(self, mesh: JointMesh) -> None:
        with needed_for("finite elements need"):
            import skfem
        self.mesh = mesh
        self._skfem = skfem
        grid, element, order = skfem.MeshTet, skfem.ElementTetP2, [0, 1, 2, 3]
        if mesh.kind != "tetra":  # scikit-fem's own order of corners
            grid, element, order = skfem.MeshHex, skfem.ElementHexS2, [6, 2, 5, 7, 1, 3, 4, 0]
        corners = (mesh.points.T, mesh.cells[:, order].T)
        self._grid, self._element = grid(*map(np.ascontiguousarray, corners)), element()
        numbered = skfem.Dofs(self._grid, self._element)
        self._on_edges: Indices = np.asarray(numbered.edge_dofs[0], dtype=np.int64)
        self._dofs: Indices = np.asarray(numbered.element_dofs.T, dtype=np.int64)
        self.size = 3 * (int(self._dofs.max()) + 1)

    def _chunks(self, cells: Indices) -> Any:
        """Yield cells, gradients and values of their shape functions, and quadrature weights."""
        for start in range(0, len(cells), _CHUNK):
            part = np.sort(cells[start : start + _CHUNK])
            basis = self._skfem.CellBasis(self._grid, self._element, intorder=4, elements=part)
            fields = [pair[0] for pair in basis.basis]
            gradients = np.stack([np.asarray(f.grad) for f in fields]).transpose(2, 0, 1, 3)
            values = np.stack([np.broadcast_to(np.asarray(f), basis.dx.shape) for f in fields])
            yield part, gradients, values.transpose(1, 0, 2), np.asarray(basis.dx)

    def matrices(self) -> tuple[Any, Any]:
        """Return stiffness [N/m] and mass [kg] as sparse matrices (size, size)."""
        from scipy import sparse

        count = self._dofs.shape[1]
        total = sum(len(body.cells) for body in self.mesh.bodies)
        stiff = np.empty((total, 3 * count, 3 * count))
        heavy = np.empty((total, count, count))
        order = np.empty(total, dtype=np.int64)
        filled = 0
        identity = np.eye(3)
        for body in self.mesh.bodies:
            shear, lame = _lame(body.material)
            for part, gradients, values, weights in self._chunks(np.asarray(body.cells)):
                flat = gradients.reshape(len(part), 3 * count, -1)
                products = np.matmul(flat * weights[:, None], flat.transpose(0, 2, 1))
                products = products.reshape(len(part), count, 3, count, 3)
                block = lame * products + shear * products.transpose(0, 1, 4, 3, 2)
                trace = np.trace(products, axis1=2, axis2=4)
                block += shear * trace[:, :, None, :, None] * identity[None, None, :, None, :]
                here = slice(filled, filled + len(part))
                stiff[here] = block.reshape(len(part), 3 * count, 3 * count)
                heavy[here] = body.density * np.matmul(
                    values * weights[:, None], values.transpose(0, 2, 1)
                )
                order[here] = part
                filled += len(part)
        dofs = self._dofs[order]
        mass = _assembled(sparse, dofs, heavy, self.size // 3)
        displacements = (3 * dofs[:, :, None] + np.arange(3)).reshape(total, -1)
        stiffness = _assembled(sparse, displacements, stiff, self.size)
        return stiffness, sparse.kron(mass, sparse.identity(3), format="csc")

    def volume(self, cells: Indices) -> float:
        """Return the volume of some cells [m^3]."""
        return float(sum(chunk[3].sum() for chunk in self._chunks(np.asarray(cells))))

    def axial_force(self, cells: Indices, material: Any, axis: Floats, length: float) -> Floats:
        """Return f such that f^T u is the mean axial force [N] in a shank at displacements u."""
        shear, lame = _lame(material)
        result: Floats = np.zeros(self.size)
        for part, gradients, _, weights in self._chunks(np.asarray(cells)):
            integrals = np.einsum("eiaq,eq->eia", gradients, weights)
            along = integrals @ axis
            force = lame * integrals + 2.0 * shear * along[:, :, None] * axis
            indices = 3 * self._dofs[part][:, :, None] + np.arange(3)
            np.add.at(result, indices.ravel(), force.ravel())
        return result / float(length)

    @property
    def _corner_element(self) -> Any:
        linear = "ElementTetP1" if self.mesh.kind == "tetra" else "ElementHex1"
        return getattr(self._skfem, linear)()

    @cached_property
    def _corner_places(self) -> Floats:
        places = np.asarray(self._grid.p, dtype=float).T
        corners: Floats = places[np.asarray(self._grid.t).T]
        return corners

    @cached_property
    def rigid_motion(self) -> Floats:
        """Translations by 1 m and rotations by 1 rad about the centre of the nodes, (size, 6)."""
        places = self.places - self.places.mean(axis=0)
        motion = np.zeros((len(places), 3, 6))
        for axis, unit in enumerate(np.eye(3)):
            motion[:, axis, axis] = 1.0
            motion[:, :, 3 + axis] = np.cross(unit, places)
        return motion.reshape(self.size, 6)

    @cached_property
    def places(self) -> Floats:
        """Positions of the nodes [m], shape (nodes, 3)."""
        values = self._shape(np.asarray(self._element.doflocs, dtype=float), corners=True)
        places = np.empty((self.size // 3, 3))
        places[self._dofs] = np.einsum("fc,eca->efa", values, self._corner_places)
        return places

    def _shape(self, local: Floats, corners: bool = False) -> Floats:
        """Return shape functions (points, functions); with ``corners`` those of linear elements."""
        element = self._corner_element if corners else self._element
        count = len(element.doflocs)
        return np.stack(
            [np.broadcast_to(element.lbasis(local.T, i)[0], (len(local),)) for i in range(count)],
            axis=1,
        )

    def _map(self, local: Floats, cells: Indices) -> tuple[Floats, Floats]:
        element = self._corner_element
        corners = self._corner_places[cells]
        places, jacobians = np.zeros((len(cells), 3)), np.zeros((len(cells), 3, 3))
        for i in range(corners.shape[1]):
            value, slope = element.lbasis(local.T, i)
            slope = np.broadcast_to(np.asarray(slope, dtype=float).reshape(3, -1), (3, len(cells)))
            places += np.broadcast_to(value, (len(cells),))[:, None] * corners[:, i]
            jacobians += corners[:, i][:, :, None] * slope.T[:, None, :]
        return places, jacobians

    def locate(self, places: Floats, cells: Indices, nearest: int = 8) -> Points:
        """Find the cell of each point among some cells, and the shape functions there.

        The ``nearest`` cells by their centres are tried. A point outside all of them is replaced by
        the nearest point of these cells, and its distance is returned.
        """
        from scipy.spatial import cKDTree

        cells = np.unique(cells)
        nearest = min(nearest, len(cells))
        _, near = cKDTree(self._corner_places[cells].mean(axis=1)).query(places, nearest)
        near = np.asarray(near).reshape(len(places), nearest)
        owners = np.empty(len(places), dtype=np.int64)
        local = np.empty((len(places), 3))
        distances, reached = np.full(len(places), np.inf), np.empty((len(places), 3))
        for rank in range(nearest):
            open_ = np.flatnonzero(distances > 0.0)
            if open_.size == 0:
                break
            candidate = cells[near[open_, rank]]
            at = self._inverse(places[open_], candidate)
            place, _ = self._map(at, candidate)
            distance = np.linalg.norm(place - places[open_], axis=1)
            size = np.ptp(self._corner_places[candidate], axis=1).max(axis=1)
            distance[distance < 1e-9 * size] = 0.0
            better = distance < distances[open_]
            index = open_[better]
            owners[index], local[index] = candidate[better], at[better]
            distances[index], reached[index] = distance[better], place[better]
        return Points(owners, self._shape(local), reached, distances)

    def _inverse(self, places: Floats, cells: Indices) -> Floats:
        """Return local coordinates of positions, restricted to the cell."""
        simplex = self.mesh.kind == "tetra"
        local = np.full((len(cells), 3), 0.25 if simplex else 0.5)
        for _ in range(1 if simplex else 12):
            at, jacobians = self._map(local, cells)
            step = np.linalg.solve(jacobians, (places - at)[:, :, None])[:, :, 0]
            local = local + np.clip(step, -1.0, 1.0)
            if np.abs(step).max(initial=0.0) < 1e-13:
                break
        local = np.clip(local, 0.0, 1.0)
        if simplex:
            local = local / np.maximum(local.sum(axis=1, keepdims=True), 1.0)
        return np.asarray(local)

    def corner_dofs(self, corners: Indices) -> Indices:
        """Return the node numbers s, see :class:`Elements`, of corners of the mesh."""
        index = np.full(len(self.mesh.points), -1, dtype=np.int64)
        cells = np.asarray(self._grid.t).T
        index[cells] = self._dofs[:, : cells.shape[1]]
        return index[corners]

    @cached_property
    def grounded(self) -> Indices:
        """Indices of displacements at fixed corners, and on edges between two fixed corners."""
        corners = np.zeros(len(self.mesh.points), dtype=bool)
        corners[self.mesh.ground] = True
        edges = self._on_edges[corners[np.asarray(self._grid.edges)].all(axis=0)]
        scalar = np.concatenate([self.corner_dofs(self.mesh.ground), edges])
        return np.asarray((3 * scalar[:, None] + np.arange(3)).ravel())

    def rows(self, points: Points, weights: Floats, groups: Indices, count: int) -> Any:
        """Return the matrix (3 count, size) of weighted displacement sums over groups of points."""
        from scipy import sparse

        functions = points.values.shape[1]
        value = (points.values * weights[:, None])[:, :, None]
        value = np.broadcast_to(value, (*value.shape[:2], 3))
        row = 3 * groups[:, None, None] + np.broadcast_to(np.arange(3), (1, functions, 3))
        column = 3 * self._dofs[points.cells][:, :, None] + np.arange(3)
        return sparse.coo_matrix(
            (value.ravel(), (np.broadcast_to(row, column.shape).ravel(), column.ravel())),
            shape=(3 * count, self.size),
        ).tocsr()


def _lame(material: Any) -> tuple[float, float]:
    shear, ratio = material.shear_modulus, material.poisson_ratio
    return shear, 2.0 * shear * ratio / (1.0 - 2.0 * ratio)


def _assembled(sparse: Any, dofs: Indices, blocks: Floats, size: int) -> Any:
    index = dofs.astype(np.int32)
    rows = np.broadcast_to(index[:, :, None], blocks.shape).ravel()
    columns = np.broadcast_to(index[:, None, :], blocks.shape).ravel()
    return sparse.coo_matrix((blocks.ravel(), (rows, columns)), shape=(size, size)).tocsc()
