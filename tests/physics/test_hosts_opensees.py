"""The exported elements in OpenSees; `tools/try_hosts.sh` installs it."""

from __future__ import annotations

import numpy as np
import pytest
from exported import JOINT, records

import microslip as ms
from microslip import export

ops = pytest.importorskip(
    "openseespy.opensees",
    reason="OpenSeesPy is not installed; make hosts runs this",
    exc_type=ImportError,
)
_RANGE = {"smallest_amplitude": 3e-9, "largest_amplitude": 1e-6}


def reactions(make, x: np.ndarray, ends: list[tuple[int, int]]) -> np.ndarray:
    """Forces at the moved nodes, all of which move together."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    nodes = sorted({node for pair in ends for node in pair} | {900})
    for node in nodes:
        ops.node(node, 0.0)
    for fixed, _ in ends:
        ops.fix(fixed, 1)
    make(ops)
    # A free degree of freedom, without which there is nothing to solve.
    ops.uniaxialMaterial("Elastic", 90_000, 1.0)
    ops.element("zeroLength", 90_000, ends[0][0], 900, "-mat", 90_000, "-dir", 1)
    times = [float(i) for i in range(x.size + 1)]
    ops.timeSeries("Path", 1, "-time", *times, "-values", 0.0, *x.tolist())
    ops.pattern("Plain", 1, 1)
    for _, moved in ends:
        ops.sp(moved, 1, 1.0)
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormUnbalance", 1e-6, 10)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static")
    forces = []
    for _ in x:
        assert ops.analyze(1) == 0
        ops.reactions()
        forces.append([-ops.nodeReaction(fixed)[0] for fixed, _ in ends])
    return np.array(forces)


def in_python(file):
    names: dict[str, object] = {}
    exec(file.read_text(), names)
    return names["joint"]


def driven(folder):
    """Forces along two histories, by OpenSees and by the cells."""
    file = folder / "joint.py"
    export.write("opensees", JOINT, file, nodes=[[1, 2]], first_number=101, **_RANGE)
    cells = JOINT.to_iwan(50, **_RANGE)
    x = np.concatenate([record[:250] for record in records(3e-7, 250).values()])
    return reactions(in_python(file), x, [(1, 2)])[:, 0], cells.force(x)


def test_it_is_the_cells_to_rounding(tmp_path):
    found, wanted = driven(tmp_path)
    assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()


def test_each_patch_of_a_field_is_its_own_cells(tmp_path):
    field = ms.JointField(JOINT.surface, 0.55, areas=[5e-5, 5e-5, 1e-4], loads=[1100.0, 0.0, 300.0])
    file = tmp_path / "field.py"
    ends = [(11, 12), (21, 22), (31, 32)]
    export.write("opensees", field, file, nodes=ends, cells=32, **_RANGE)
    x = records(3e-7, 100)["walk"]
    found = reactions(in_python(file), x, [ends[0], ends[2]])
    for i, column in ((0, 0), (2, 1)):
        alone = ms.JointField(
            JOINT.surface, 0.55, areas=[field.areas[i]], loads=[field.normal_loads[i]]
        ).rigid()
        wanted = alone.to_iwan(32, **_RANGE).force(x)
        assert np.abs(found[:, column] - wanted).max() <= 1e-12 * np.abs(wanted).max()
