"""Patches of contact faces: sample points that both sides share, boxes of them, their gaps."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact, floats, show
from microslip._core.errors import InputError
from microslip.structures.mesh import FACETS, ContactFaces, Indices, JointMesh
from microslip.structures.reduction_elements import Elements, Points

_SAMPLES = 6  # along each side of a facet
_MOST_PATCHES = 2000
_NEIGHBOURS = 8  # patches tried for a merger


class ContactFrame(NamedTuple):
    """Directions of a contact: along, across, and the normal from the lower to the upper side."""

    origin: Floats
    axes: Floats
    """Directions of the frame, one per row."""


class Samples(NamedTuple):
    """Points of quadrature on the faces of all contacts, and the patch of each."""

    places: Floats
    """Positions in the frame of the contact, along and across [m]."""
    weights: Floats
    """Area represented by each point [m^2]."""
    patches: Indices
    """Patch of each point."""


class Surface(NamedTuple):
    """Outer surface of the bodies, and its displacement per unit of each degree of freedom."""

    points: NDArray[np.float32]
    facets: NDArray[np.int32]
    motion: NDArray[np.float32]
    """Displacements of the points per degree of freedom, (points, 3, degrees of freedom)."""


class Patches(NamedTuple):
    """Patches, and their relative displacements as functionals of the nodal displacements."""

    samples: Samples
    areas: Floats
    boxes: Floats
    """Extent of each patch in the frame of its contact: x from, x to, y from, y to [m]."""
    contacts: Indices
    """Index of the contact of each patch."""
    functionals: Any
    """Sparse, (3 patches, displacements): along, across, opening."""
    left_out: float
    """Fraction of the faces without an opposite face."""


def patches_of(mesh: JointMesh, elements: Elements, layout: Any, along: Floats | None) -> Patches:
    """Return the patches of all contacts: sample points, grouped by boxes of the ``layout``.

    The displacement of a patch is the mean relative displacement of its two faces. ``along`` is the
    first direction of the patches.
    """
    from scipy import sparse

    parts, offset, left_out, total = [], 0, 0.0, 0.0
    for number, contact in enumerate(mesh.contacts):
        frame = contact_frame(mesh, contact, along)
        places, weights = sample(mesh.points[contact.lower])
        lower = elements.locate(places, owners_of(mesh, contact.lower))
        upper = _opposite(elements, places, owners_of(mesh, contact.upper), frame.axes[2])
        extent = float(np.ptp(places, axis=0).max())
        offsets = upper.places - places
        meet = np.linalg.norm(offsets @ frame.axes[:2].T, axis=1) < 1e-6 * extent
        meet &= abs(offsets @ frame.axes[2]) < 0.02 * extent
        total += float(weights.sum())
        left_out += float(weights[~meet].sum())
        if not meet.any():
            raise InputError(
                f'the two faces of contact "{contact.name}" do not meet: no point of the first '
                "lies on the second"
            )
        flat = (places - frame.origin) @ frame.axes.T
        boxes = _boxes(layout, number, *shared_extent(mesh, contact, frame))
        group = _box_of(boxes, flat[:, :2])
        group[~meet] = -1
        area = np.bincount(group[group >= 0], weights[group >= 0], minlength=len(boxes))
        filled = area > 1e-3 * area.sum() / len(boxes)
        if not filled.any():
            raise InputError(f'no patch holds any of the faces of contact "{contact.name}"')
        renamed = np.where(filled, np.cumsum(filled) - 1, -1)
        group = np.where(group >= 0, renamed[group], -1)
        used = group >= 0
        area, boxes = area[filled], boxes[filled]
        share = weights[used] / area[group[used]]
        above, below = (
            elements.rows(side.at(used), share, group[used], len(area)) for side in (upper, lower)
        )
        parts.append(
            (
                Samples(flat[used, :2], weights[used], group[used] + offset),
                area,
                boxes,
                np.full(len(area), number),
                sparse.kron(sparse.identity(len(area)), frame.axes, format="csr") @ (above - below),
            )
        )
        offset += len(area)
    samples = Samples(*(np.concatenate(part) for part in zip(*(p[0] for p in parts), strict=True)))
    areas, boxes, numbers = (np.concatenate([p[k] for p in parts]) for k in (1, 2, 3))
    functionals = sparse.vstack([p[4] for p in parts]).tocsr()
    return Patches(samples, areas, boxes, numbers, functionals, left_out / total)


def merging(patches: Patches, dependent: Floats) -> tuple[Patches, Any]:
    """Merge patches that the elements cannot resolve with neighbouring patches into larger boxes.

    ``dependent`` (patches,) is the squared participation of each patch in displacements that
    depend on each other [-]. A neighbour is the patch of the same contact whose box leaves the
    least area when both are joined; patches that overlap the joined box are merged too. Also return
    the sparse weights (merged, patches) of mean displacements.
    """
    from scipy import sparse

    count, boxes = len(patches.areas), patches.boxes.copy()
    owner, taken = np.arange(count), np.zeros(count, dtype=bool)
    low, high = patches.boxes[:, [0, 2]], patches.boxes[:, [1, 3]]
    area = np.prod(high - low, axis=1)
    for i in np.argsort(-dependent):
        if taken[i] or dependent[i] < 0.3 * dependent.max():
            continue
        beside = patches.contacts == patches.contacts[i]
        both = np.minimum(low[i], low), np.maximum(high[i], high)
        spare = np.prod(both[1] - both[0], axis=1) / (area + area[i]) - 1e-3 * dependent
        spare[taken | ~beside] = np.inf
        spare[i] = np.inf
        for j in np.argsort(spare)[: np.isfinite(spare).sum()][:_NEIGHBOURS]:
            corner, end, group = both[0][j], both[1][j], np.zeros(count, dtype=bool)
            while True:
                shared = np.minimum(high, end) - np.maximum(low, corner)
                wider = beside & (shared > 1e-6 * (high - low)).all(axis=1)
                if (wider == group).all():
                    break
                group, corner, end = wider, low[wider].min(axis=0), high[wider].max(axis=0)
            merged = boxes[np.unique(owner[taken & beside])]
            shared = np.minimum(merged[:, [1, 3]], end) - np.maximum(merged[:, [0, 2]], corner)
            wide = (shared > 1e-6 * (end - corner)).all(axis=1)
            if not (taken[group].any() or wide.any()):  # joined boxes may span holes
                owner[group], taken[group] = i, True
                boxes[i] = np.stack([corner, end], axis=1).ravel()
                break
    if not taken.any():
        raise InputError("a contact has too few elements for a patch; take smaller elements")
    kept, owner = np.unique(owner, return_inverse=True)
    areas: Floats = np.bincount(owner, patches.areas).astype(np.float64)
    share = patches.areas / areas[owner]
    turn = sparse.csr_matrix((share, (owner, np.arange(count))), (kept.size, count))
    samples = patches.samples._replace(patches=owner[patches.samples.patches])
    merged = patches._replace(
        samples=samples, areas=areas, boxes=boxes[kept], contacts=patches.contacts[kept],
        functionals=(sparse.kron(turn, sparse.identity(3)) @ patches.functionals).tocsr(),
    )  # fmt: skip
    return merged, turn


def _opposite(elements: Elements, places: Floats, cells: Indices, normal: Floats) -> Points:
    """Return the points of the other face along the normal; the faces may be slightly apart."""
    points = elements.locate(places, cells)
    for _ in range(2):
        lifted = places + ((points.places - places) @ normal)[:, None] * normal
        points = elements.locate(lifted, cells)
    return points


def shared_extent(
    mesh: JointMesh, contact: ContactFaces, frame: ContactFrame
) -> tuple[Floats, Floats]:
    """Return the smallest and largest position along and across that both faces reach [m]."""
    sides = [
        ((mesh.points[facets].reshape(-1, 3) - frame.origin) @ frame.axes.T)[:, :2]
        for facets in (contact.lower, contact.upper)
    ]
    low = np.max([side.min(axis=0) for side in sides], axis=0)
    return low, np.min([side.max(axis=0) for side in sides], axis=0)


def contact_frame(mesh: JointMesh, contact: ContactFaces, along: Floats | None) -> ContactFrame:
    """Return the frame of a contact, with the normal outwards from the lower body.

    The first tangent is ``along`` projected onto the faces, or their longest direction if None.
    """
    corners = mesh.points[contact.lower]
    middle = corners.mean(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
    # Facets of files turn either way; outwards is away from the middle of their cell.
    owners = owners_of(mesh, contact.lower)
    outwards = middle - mesh.points[mesh.cells[owners]].mean(axis=1)
    normals *= np.sign((normals * outwards).sum(axis=1))[:, None]
    normal = normals.sum(axis=0)
    if np.linalg.norm(normal) < 0.5 * np.linalg.norm(normals, axis=1).sum():
        raise InputError(f'the faces of contact "{contact.name}" must be nearly flat')
    normal /= np.linalg.norm(normal)
    weight = np.linalg.norm(normals, axis=1)
    origin = (0.5 * (middle.min(axis=0) + middle.max(axis=0))) if along is None else np.zeros(3)
    if along is None:
        spread = (middle - middle.mean(axis=0)) * np.sqrt(weight)[:, None]
        spread -= np.outer(spread @ normal, normal)
        along = np.linalg.svd(spread, full_matrices=False)[2][0]
        along = along * np.sign(along[np.argmax(abs(along))])
    first = along - (along @ normal) * normal
    length = np.linalg.norm(first)
    if length < 1e-6:
        raise InputError("along must not be normal to the contact faces")
    first = first / length
    return ContactFrame(origin, np.stack([first, np.cross(normal, first), normal]))


def owners_of(mesh: JointMesh, facets: Indices) -> Indices:
    """Return the index of the cell to which each facet belongs."""
    patterns = FACETS[mesh.kind]
    width = len(patterns[0])
    keys = np.sort(mesh.cells[:, patterns], axis=2).reshape(-1, width)
    sides = np.sort(facets, axis=1)
    _, inverse = np.unique(np.concatenate([keys, sides]), axis=0, return_inverse=True)
    inverse = inverse.ravel()
    cell = np.full(inverse.max() + 1, -1)
    cell[inverse[: len(keys)]] = np.arange(len(keys)) // len(patterns)
    owners = cell[inverse[len(keys) :]]
    if (owners < 0).any():
        raise InputError("contact faces must be sides of the cells of the bodies")
    return np.asarray(owners, dtype=np.int64)


def sample(corners: Floats) -> tuple[Floats, Floats]:
    """Return points spread evenly over facets, with the areas that they represent."""
    n = _SAMPLES
    step = (np.arange(n) + 0.5) / n
    if corners.shape[1] == 4:
        u, v = (part.ravel() for part in np.meshgrid(step, step, indexing="ij"))
        shape = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
        du = np.stack([v - 1, 1 - v, v, -v], axis=1)
        dv = np.stack([u - 1, -u, u, 1 - u], axis=1)
        tangents = [np.einsum("pc,fca->fpa", part, corners) for part in (du, dv)]
        areas = np.linalg.norm(np.cross(*tangents), axis=2) / n**2
    else:
        up = [(i + 1 / 3, j + 1 / 3) for i in range(n) for j in range(n - i)]
        down = [(i + 2 / 3, j + 2 / 3) for i in range(n - 1) for j in range(n - 1 - i)]
        u, v = np.array(up + down).T / n
        shape = np.stack([1 - u - v, u, v], axis=1)
        sides = corners[:, 1:] - corners[:, :1]
        areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2 / len(u)
        areas = np.repeat(areas[:, None], len(u), axis=1)
    places = np.einsum("pc,fca->fpa", shape, corners)
    return places.reshape(-1, 3), areas.ravel()


def usual_counts(length: float, width: float) -> tuple[int, int]:
    """Return the usual numbers of patches along and across a face: some 60, longer across."""
    across = max(2, round(math.sqrt(20.0 * width / length)))
    return max(4, round(60 / across)), across


def _boxes(layout: Any, contact: int, low: Floats, high: Floats) -> Floats:
    boxes = floats("patches", usual_counts(*(high - low)) if layout is None else layout)
    if boxes.ndim == 2 and boxes.shape[1] == 5:  # each with the number of its contact
        boxes = boxes[boxes[:, 0] == contact, 1:]
    if boxes.ndim == 1:
        if boxes.size != 2 or boxes.min() < 1.0 or np.any(boxes != np.floor(boxes)):
            raise InputError(_layout_error(layout))
        if boxes.prod() > _MOST_PATCHES:
            raise InputError(
                f"patches must be at most {_MOST_PATCHES}, got {boxes[0]:.9g} x {boxes[1]:.9g}"
            )
        counts = [int(count) for count in boxes]
        edges = [np.linspace(low[k], high[k], counts[k] + 1) for k in (0, 1)]
        return np.array([(*x, *y) for x in pairwise(edges[0]) for y in pairwise(edges[1])])
    if boxes.ndim != 2 or boxes.shape[1] != 4:
        raise InputError(_layout_error(layout))
    if len(boxes) > _MOST_PATCHES:
        raise InputError(f"patches must be at most {_MOST_PATCHES}, got {len(boxes)}")
    wrong = np.flatnonzero((boxes[:, 0] >= boxes[:, 1]) | (boxes[:, 2] >= boxes[:, 3]))
    if wrong.size:
        row = ", ".join(exact(float(value)) for value in boxes[wrong[0]])
        raise InputError(f"the bounds of a patch must increase, got [{row}] m")
    return boxes


def _layout_error(layout: Any) -> str:
    return (
        "patches must be two whole numbers, along and across, such as (15, 2), or boxes of "
        f"[x from, x to, y from, y to], got {show(layout)}"
    )


def _box_of(boxes: Floats, places: Floats) -> Indices:
    group = np.full(len(places), -1, dtype=np.int64)
    for number in range(len(boxes) - 1, -1, -1):
        x0, x1, y0, y1 = boxes[number]
        within = (places[:, 0] >= x0) & (places[:, 0] <= x1)
        group[within & (places[:, 1] >= y0) & (places[:, 1] <= y1)] = number
    return group


def mean_over(samples: Samples, values: Floats, count: int) -> Floats:
    """Return means of values at the sample points over each patch; NaN without known values."""
    finite = np.isfinite(values)
    weights = np.where(finite, samples.weights, 0.0)
    total = np.bincount(samples.patches, weights * np.where(finite, values, 0.0), minlength=count)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(total / np.bincount(samples.patches, weights, minlength=count))


def gaps_at(form: Any, places: Floats) -> Floats:
    """Return gaps [m] at positions along and across (points, 2) [m]; NaN where unknown.

    ``form`` is a function of arrays x and y [m], or a table with the columns x, y and gap [m] at
    scattered points, NaN where nothing was measured.
    """
    if callable(form):
        try:
            values = np.asarray(form(places[:, 0], places[:, 1]), dtype=float)
        except Exception as error:
            raise InputError(
                "form must be a function of arrays x and y [m] that gives gaps [m]; it failed: "
                f"{type(error).__name__}: {error}"
            ) from None
        if values.ndim == 0:
            values = np.full(len(places), float(values))
        if values.shape != (len(places),):
            raise InputError(
                "form must be a function that gives one gap [m] per position, got shape "
                f"{values.shape} for {len(places)} positions"
            )
        return values
    if form.ndim != 2 or form.shape[1] != 3:
        raise InputError(
            "form must be a function of x and y, or a table with the columns x, y and gap [m], got "
            f"shape {form.shape}"
        )
    measured = form[np.isfinite(form).all(axis=1)]
    if len(measured) < 4:
        raise InputError(f"form must have at least 4 positions, got {len(measured)}")
    return _interpolated(measured, places)


def _interpolated(table: Floats, places: Floats) -> Floats:
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import Delaunay, cKDTree

    scale = np.ptp(table[:, :2], axis=0)
    if not (scale > 0.0).all():
        raise InputError("form must have positions that differ along and across the faces")
    flat = table[:, :2] / scale
    values = np.asarray(LinearNDInterpolator(Delaunay(flat), table[:, 2])(places / scale))
    missing = np.flatnonzero(np.isnan(values))
    if missing.size:
        distance, nearest = cKDTree(flat).query(places[missing] / scale)
        close = distance < 0.05
        values[missing[close]] = table[nearest[close], 2]
    return values
