"""Several laps, laps on the ground, unlike materials: against frames of their own."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from laps import DENSITY, STEEL
from scipy import linalg
from usual import rough

import microslip as ms
from microslip.structures import read_decay
from microslip.structures.reduction_convergence import halved_boxes

WIDTH, HEIGHT = 0.02, 0.004
ALUMINIUM = ms.Material(young_modulus=70e9, poisson_ratio=0.33)
# Thin bolts, which the frame has as beams from head to nut, free in both washers.
SHANK = 0.002
GRIP = HEIGHT + 2.0 * 0.2 * SHANK
BOLT: dict[str, Any] = {
    "shank": SHANK, "hole": 0.0021, "washer": 0.004, "tension": 100.0,
    "material": STEEL, "density": 1.0,
}  # fmt: skip


def upright(length: float) -> Any:
    """Stiffness of a shank along z between (u, w, turn) of its ends, u along x [N/m]."""
    area, inertia = 0.25 * np.pi * SHANK**2, np.pi * SHANK**4 / 64.0
    bend, pull = 200e9 * inertia, 200e9 * area / length
    a, b, c = 12.0 * bend / length**3, 6.0 * bend / length**2, bend / length
    result = np.zeros((6, 6))
    across = [0, 2, 3, 5]  # du/dz is the turn
    result[np.ix_(across, across)] = [
        [a, b, -a, b], [b, 4 * c, -b, 2 * c], [-a, -b, a, -b], [b, 2 * c, -b, 4 * c]
    ]  # fmt: skip
    result[np.ix_([1, 4], [1, 4])] = [[pull, -pull], [-pull, pull]]
    return result


def frame(
    parts: list[tuple[Any, float, bool, list[tuple[float, float, str]]]],
    laps: list[tuple[int, float, float, tuple[float, ...]]],
    springs: tuple[float, float],
    patches: int,
    count: int,
) -> Any:
    """Frequencies [Hz] of Timoshenko beams in a plane, with springs between means over patches.

    ``parts``: material, density, whether it lies below, and stretches (from, to, "whole" or "arm").
    ``laps``: number of the left part, from, to, and its bolts from its middle; what is no part is
    ground. Displacements are those at the height of the faces, z = 0.
    """
    size, springs_at = 2e-3, []

    def lower(left: int) -> int:
        here = parts[left][2] if left >= 0 else not parts[0][2]
        return left if here else left + 1

    def upper(left: int) -> int:
        return 2 * left + 1 - lower(left)

    grids, offsets, total = [], [], 0
    for _, _, _, stretches in parts:
        marks = sorted({x for start, stop, _ in stretches for x in (start, stop)})
        pieces = [np.linspace(a, b, max(2, round((b - a) / size)) + 1) for a, b in pairwise(marks)]
        grids.append(np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])]))
        offsets.append(total)
        total += 3 * len(grids[-1])
    stiffness, mass = np.zeros((2, total, total))
    for (material, density, below, stretches), grid, offset in zip(
        parts, grids, offsets, strict=True
    ):
        for i, (a, b) in enumerate(pairwise(grid)):
            kind = next(k for start, stop, k in stretches if start <= 0.5 * (a + b) <= stop)
            high = HEIGHT if kind != "arm" else 0.5 * HEIGHT
            middle = 0.0 if kind == "whole" else (-0.5 if below else 0.5) * high
            area, inertia = WIDTH * high, WIDTH * high**3 / 12.0
            nu = material.poisson_ratio
            shear = material.shear_modulus * area * 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
            length = b - a
            # Strains in the middle of an element: stretch at the centroid, curvature, shear.
            slope, mean = np.array([-1.0, 1.0]) / length, np.array([0.5, 0.5])
            stretch, bend, slide = np.zeros((3, 6))
            stretch[[0, 3]], stretch[[2, 5]], bend[[2, 5]] = slope, middle * slope, slope
            slide[[1, 4]], slide[[2, 5]] = slope, mean
            young = material.young_modulus
            at = slice(offset + 3 * i, offset + 3 * i + 6)
            for strain, stiff in ((stretch, young * area), (bend, young * inertia), (slide, shear)):
                stiffness[at, at] += length * stiff * np.outer(strain, strain)
            for node in (0, 1):
                u, w, turn = offset + 3 * (i + node) + np.arange(3)
                heavy = 0.5 * density * area * length
                mass[u, u] += heavy
                mass[w, w] += heavy
                mass[u, turn] += heavy * middle
                mass[turn, u] += heavy * middle
                mass[turn, turn] += heavy * middle**2 + 0.5 * density * inertia * length
    for left, start, stop, bolts in laps:
        edges = np.linspace(start, stop, patches + 1)
        for a, b in pairwise(edges):
            for axis in (0, 1):
                row = np.zeros(total)
                for part, sign in ((lower(left), -1.0), (upper(left), 1.0)):
                    if part < 0 or part >= len(parts):
                        continue
                    grid = grids[part]
                    fine = np.linspace(a, b, 201)
                    fine = 0.5 * (fine[1:] + fine[:-1])
                    place = np.clip(np.searchsorted(grid, fine) - 1, 0, len(grid) - 2)
                    share = (fine - grid[place]) / (grid[place + 1] - grid[place])
                    at = offsets[part] + 3 * place + axis
                    np.add.at(row, at, sign * (1.0 - share) / len(fine))
                    np.add.at(row, at + 3, sign * share / len(fine))
                springs_at.append(springs[axis] * np.outer(row, row))
        for place_of_bolt in 0.5 * (start + stop) + np.array(bolts):
            ends = np.zeros((6, total))  # where the heads begin, outside of the washers
            for part, row, z in ((lower(left), 0, -0.5 * GRIP), (upper(left), 3, 0.5 * GRIP)):
                if 0 <= part < len(parts):
                    node = offsets[part] + 3 * int(np.argmin(abs(grids[part] - place_of_bolt)))
                    ends[row, [node, node + 2]] = 1.0, z
                    ends[row + 1, node + 1] = ends[row + 2, node + 2] = 1.0
            stiffness += ends.T @ upright(GRIP) @ ends
    stiffness += sum(springs_at)
    squares = linalg.eigh(stiffness, mass, eigvals_only=True)
    frequency = np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)
    return frequency[frequency > 5.0][:count]


def sprung(joint: ms.ReducedJoint, springs: tuple[float, float], at: str) -> Any:
    """Frequencies of the modes that bend in the plane, of a reduced joint with such springs."""
    index = np.arange(3 * joint.patches).reshape(-1, 3)
    stiffness = joint.stiffness.copy()
    for axis, spring in ((0, springs[0]), (1, springs[0]), (2, springs[1])):
        stiffness[index[:, axis], index[:, axis]] += spring
    squares, shapes = linalg.eigh(stiffness, joint.mass)
    up = abs(joint.sensor(at) @ shapes)
    return np.sqrt(squares[up > 0.2 * up[:8].max()]) / (2.0 * np.pi)


def beam(**changes: Any) -> ms.BoltedBeam:
    """Two laps in a row of three parts."""
    bolts = ms.Bolts([0.0], **BOLT)
    laps = [ms.Lap(-0.1, 0.06, bolts), ms.Lap(0.1, 0.06, bolts)]
    given = {"length": 0.4, "width": WIDTH, "thickness": HEIGHT, "laps": laps}
    return ms.BoltedBeam(**(given | changes))


SPRINGS = (1e7, 1e8)
TIP = {"tip": ((0.2, 0.0, 0.0), "z")}


def stretches(left: bool, right: bool, start: float, stop: float) -> list[Any]:
    """A part with arms in the laps at its ends."""
    inner = [start + 0.06 * left, *[stop - 0.06 * right]]
    result = [(inner[0], inner[1], "whole")]
    result += [(start, inner[0], "arm")] if left else []
    return result + ([(inner[1], stop, "arm")] if right else [])


@pytest.mark.slow
def test_two_laps_bend_as_a_frame_of_beams_with_springs() -> None:
    joint = beam().reduce(
        [STEEL, ALUMINIUM, STEEL], [DENSITY, 2700.0, DENSITY], (6, 1), sensors=TIP,
        element_size=0.0075,
    )  # fmt: skip
    parts = [
        (STEEL, DENSITY, True, stretches(False, True, -0.2, -0.07)),
        (ALUMINIUM, 2700.0, False, stretches(True, True, -0.13, 0.13)),
        (STEEL, DENSITY, True, stretches(True, False, 0.07, 0.2)),
    ]
    laps = [(0, -0.13, -0.07, (0.0,)), (1, 0.07, 0.13, (0.0,))]
    wanted = frame(parts, laps, SPRINGS, 6, 4)
    np.testing.assert_allclose(sprung(joint, SPRINGS, "tip")[:4], wanted, rtol=6e-3)


@pytest.mark.slow
def test_a_lap_on_the_ground_is_a_clamp_with_springs() -> None:
    bolts = ms.Bolts([0.0], **BOLT)
    tip = {"tip": ((0.1, 0.0, 0.0), "z")}
    held = beam(length=0.2, laps=[ms.Lap(-0.07, 0.06, bolts)], ground="left")
    assert held.parts == ("part 1",)
    fine, coarse = (
        held.reduce(STEEL, DENSITY, (6, 1), sensors=tip, element_size=size)
        for size in (0.005, 0.0075)
    )
    found = sprung(coarse, SPRINGS, "tip")[:2]
    parts = [(STEEL, DENSITY, False, stretches(True, False, -0.1, 0.1))]
    wanted = frame(parts, [(-1, -0.1, -0.04, (0.0,))], SPRINGS, 6, 2)
    np.testing.assert_allclose(sprung(fine, SPRINGS, "tip")[:2], wanted, rtol=1e-2)
    # The same as a part so heavy and stiff that it does not move either.
    block = ms.Material(STEEL.young_modulus * 1e4, 0.3)
    lap = beam(length=0.22, laps=[ms.Lap(-0.06, 0.06, bolts)])
    heavy = lap.reduce(
        [block, STEEL], [DENSITY * 1e7, DENSITY], (6, 1), element_size=0.0075,
        sensors={"tip": ((0.11, 0.0, 0.0), "z")},
    )  # fmt: skip
    np.testing.assert_allclose(sprung(heavy, SPRINGS, "tip")[:2], found, rtol=2e-3)
    # And on the right its mirror image.
    mirrored = beam(length=0.2, laps=[ms.Lap(0.07, 0.06, bolts)], ground=["right"])
    end = {"tip": ((-0.1, 0.0, 0.0), "z")}
    turned = mirrored.reduce(STEEL, DENSITY, (6, 1), sensors=end, element_size=0.0075)
    np.testing.assert_allclose(sprung(turned, SPRINGS, "tip")[:2], found, rtol=1e-5)


@pytest.mark.slow
def test_equal_laps_lose_the_same_and_together_twice_what_one_loses() -> None:
    joint = beam().reduce(STEEL, DENSITY, (4, 1), element_size=0.01)
    surface = rough(ms.Gaussian(5e-7), ms.MaterialPair(STEEL, STEEL), 1e-4)
    first = joint.patch_contacts == 0
    lossless = np.where(first, 0.3, 1e4)
    state = joint.with_tension(400.0).tightened(surface, 0.3)
    both = state.modes(0, [1e-8, 1e-7])
    one = joint.with_tension(400.0).tightened(surface, lossless).modes(0, [1e-8, 1e-7])
    shares = both.loss_share[:, first].sum(axis=1)
    np.testing.assert_allclose(shares, 0.5, rtol=1e-5)
    np.testing.assert_allclose(both.damping_ratio, 2.0 * one.damping_ratio, rtol=2e-3)
    np.testing.assert_allclose(state.normal_loads.sum(), 800.0, rtol=1e-9)


@pytest.mark.slow
def test_the_bar_of_the_gallery_rings_down_as_its_mode_says() -> None:
    """Integration in time against harmonic balance, 60 cycles from the largest amplitude.

    Other modes disturb single cycles by 5 % in damping; the decrement over all of them counts.
    """
    example = Path(__file__).parents[2] / "examples" / "18_several_laps.py"
    setup = example.read_text(encoding="utf-8").partition("# %%")[0]
    lines = [line for line in setup.splitlines() if "plt" not in line]
    names: dict[str, Any] = {}
    exec("\n".join(lines), names)
    joint = names["joint"]
    state, end = joint.tightened(names["surface"], friction_coefficient=0.3), joint.sensor("end")
    curve = state.modes(0, np.geomspace(1e-4, 2e-4, 5), at=end)
    release = (curve.shape[-1] * curve.modal_amplitude[-1]).real
    time = np.arange(60 * 160) / (160.0 * curve.frequency[-1])
    motion = state.integrate(lambda t: np.zeros(joint.size), time, displacement=release)
    decay = read_decay(motion.time, motion.displacement @ end)
    logs = np.log(decay.amplitude)
    frequency = np.interp(logs, np.log(curve.amplitude), curve.frequency)
    np.testing.assert_allclose(decay.frequency, frequency, rtol=4e-4)
    predicted = np.interp(logs, np.log(curve.amplitude), curve.decay_damping_ratio)
    slope = np.polyfit(np.arange(logs.size), logs, 1)[0] / (-2.0 * np.pi)
    assert slope == pytest.approx(predicted.mean(), rel=0.02)


def test_a_planar_field_needs_no_direction_across() -> None:
    surface = rough(ms.Gaussian(5e-7), ms.MaterialPair(STEEL, STEEL), 1e-4)
    field = ms.JointField(surface, 0.3, areas=[1e-4, 2e-4], gaps=[0.0, 1e-7])
    mass, stiffness = np.diag([1.0, 1.0, 2.0]), np.diag([1e6, 2e6, 3e6])
    flat = np.zeros((3, 2, 2))
    flat[[0, 1], :, 0], flat[2, :, 1] = [[1.0, 0.5], [0.0, 1.0]], [1.0, 0.8]
    # The same in space, with a mass that only feels the motion across.
    solid = np.zeros((4, 2, 3))
    solid[:3, :, [0, 2]], solid[3, :, 1] = flat, 1.0
    curves = []
    for directions in (flat, solid):
        size = len(directions)
        grown = [np.eye(size) * scale for scale in (1e-3, 1e12)]
        for big, small in zip(grown, (mass, stiffness), strict=True):
            big[:3, :3] = small
        push = np.r_[0.0, 0.0, -300.0, np.zeros(size - 3)]
        state = ms.Structure(*grown).attach(field, directions=directions).preload(push)
        curves.append(state.modes(0, [1e-8, 1e-7, 1e-6]))
        motion = state.integrate(None, np.arange(200) * 1e-5, displacement=1e-7 * np.eye(size)[0])
        curves[-1] = (curves[-1].frequency, curves[-1].damping_ratio, motion.displacement[:, :3])
    for planar, spatial in zip(*curves, strict=True):
        np.testing.assert_allclose(planar, spatial, rtol=1e-9, atol=1e-18)
    assert curves[0][1][-1] > 1e-4
    with pytest.raises(ms.InputError, match=r"\(3, nodes, 3\), or \(3, nodes, 2\) in a plane"):
        ms.Structure(mass, stiffness).attach(field, directions=np.ones((3, 2)))


@pytest.mark.slow
def test_a_mesh_with_several_pairs_and_a_held_body_is_the_drawing(tmp_path: Path) -> None:
    import meshio

    bolts = ms.Bolts([0.0], shank=0.004, hole=0.0045, washer=0.008, tension=2e3)
    laps = [ms.Lap(-0.07, 0.06, bolts), ms.Lap(0.05, 0.03, bolts)]
    drawn = beam(length=0.2, laps=laps, ground="left", style="single-lap")
    mesh = drawn.mesh(STEEL, DENSITY, 0.01)
    named: dict[str, Any] = {body.name: body.cells for body in mesh.bodies}
    named |= {shank.name: shank.cells for shank in mesh.shanks}
    faces = {f"{c.name} {s}": getattr(c, s) for c in mesh.contacts for s in ("lower", "upper")}
    quads, path = np.concatenate(list(faces.values())), tmp_path / "beam.msh"
    blocks = [("hexahedron", mesh.cells), ("quad", quads)]
    # A cell of Gmsh has one tag: bolts are their shanks, which are bodies of their own there.
    for body in mesh.bodies:
        if body.name.startswith("bolts"):
            del named[body.name]
    tags, field = np.zeros(len(mesh.cells), dtype=int), {}
    for number, (name, cells) in enumerate(named.items(), start=1):
        tags[cells] = number
        field[name] = np.array([number, 3])
    of_faces = []
    for number, (name, face) in enumerate(faces.items(), start=len(named) + 1):
        of_faces.append(np.full(len(face), number))
        field[name] = np.array([number, 2])
    data = {k: [tags, np.concatenate(of_faces)] for k in ("gmsh:physical", "gmsh:geometrical")}
    file = meshio.Mesh(mesh.points, blocks, cell_data=data, field_data=field)
    file.write(path, file_format="gmsh22")
    steels = {body.name: (STEEL, body.density) for body in mesh.bodies if body.name in named}
    steels |= {shank.name: (STEEL, DENSITY) for shank in mesh.shanks}
    read = ms.MeshedJoint.read(
        path,
        bodies=steels,
        contacts=[("lap 1 lower", "lap 1 upper"), ("lap 2 lower", "lap 2 upper")],
        bolts={"bolt 1": 2e3, "bolt 2": 2e3},
        ground=["left ground"],
    )
    wanted = drawn.reduce(STEEL, DENSITY, (3, 1), element_size=0.01)
    joint = read.reduce((3, 1), along=[1.0, 0.0, 0.0])
    assert joint.patch_contacts.tolist() == [0, 0, 0, 1, 1, 1]
    scale = abs(wanted.stiffness[:20, :20]).max()
    np.testing.assert_allclose(
        joint.stiffness[:20, :20], wanted.stiffness[:20, :20], atol=1e-6 * scale
    )
    # Where each face has an origin of its own, boxes of one pair are none of the other.
    own = read.reduce((3, 1))
    assert abs(own.patch_boxes[0, 0]) < 0.031
    cut = halved_boxes(own.layout, own.patch_contacts == 1, 0)
    finer = read.reduce(cut)
    assert np.bincount(finer.patch_contacts).tolist() == [3, 6]
    np.testing.assert_allclose(finer.patch_areas[:3], own.patch_areas[:3], rtol=1e-12)


ONE = ms.Bolts([0.0], **BOLT)
LAPS = [ms.Lap(-0.1, 0.06, ONE), ms.Lap(0.1, 0.06, ONE)]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"laps": []}, "laps must be a list of .*, got none"),
        ({"laps": LAPS[0]}, "laps must be a list of ms.Lap"),
        ({"laps": LAPS[::-1]}, "laps must follow each other from left to right"),
        ({"laps": [LAPS[0], ms.Lap(-0.05, 0.06, ONE)]}, "with room between them"),
        ({"laps": [ms.Lap(0.18, 0.06, ONE)]}, "laps must lie within the beam"),
        ({"ground": "top"}, 'ground must be among "left" and "right"'),
        ({"ground": "left"}, "must reach to the end of the beam, at -0.2 m: write at=-0.17"),
        ({"laps": [ms.Lap(0.0, 0.4, ONE)], "ground": ["left", "right"]}, "needs two laps, got one"),
        ({"style": "double-lap"}, "style must be"),
        ({"laps": [LAPS[0], ms.Lap(0.1, 0.06, ms.Bolts([[0.0, 1e-3]], **BOLT))]}, "same rows"),
    ],
)
def test_beams_that_cannot_be_built(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ms.InputError, match=message):
        beam(**changes).mesh(STEEL, DENSITY, 0.01)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"material": [STEEL, STEEL]}, "one for each of the 3 parts from left to right, got 2"),
        ({"density": [1.0, 2.0]}, "density must be one, or one for each of the 3 parts"),
    ],
)
def test_parts_that_are_not_there(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ms.InputError, match=message):
        beam().reduce(**({"material": STEEL, "density": DENSITY, "element_size": 0.02} | given))
