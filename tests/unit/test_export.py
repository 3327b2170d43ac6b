"""Files for other programs: what they say, what they refuse, and the command that writes them."""

from __future__ import annotations

import re
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from command import STUDY, run
from exported import JOINT

import microslip as ms
from microslip import export
from microslip.export.request import ELEMENTS, checked_patches
from microslip.study.build import build_joints

_RANGE = {"smallest_amplitude": 1e-8, "largest_amplitude": 1e-6}
_FIELD = ms.JointField(JOINT.surface, 0.55, areas=[5e-5, 5e-5, 1e-4], loads=[900.0, 0.0, 300.0])


@pytest.fixture(autouse=True)
def folder(here):
    (here / "joint.toml").write_text(STUDY)
    return here


def nodes_for(kind: str) -> dict[str, object]:
    return {"nodes": [[7, 9]], "first_number": 101} if kind in ELEMENTS else {}


def test_exact_kinds_are_exact_and_cells_tell_their_own_error():
    exact = export.write("c", JOINT, "a.c", **_RANGE).accuracy
    assert exact.backbone_error < 1e-14
    assert exact.energy_error < 1e-11
    fit = JOINT.to_iwan(25, **_RANGE).fit
    cells = export.write("calculix", JOINT, "a.inp", cells=25, nodes=[[1, 2]], **_RANGE).accuracy
    assert (cells.backbone_error, cells.energy_error) == (fit.backbone_error, fit.energy_error)


@pytest.mark.parametrize(
    ("kind", "pattern", "digits"),
    [
        ("calculix", r"\*ELASTIC\n(\S+), 0\.\n\*PLASTIC\n(\S+), 0\.", 1e-13),
    ],
)
def test_text_writers_hold_the_cells(kind, pattern, digits):
    done = export.write(kind, JOINT, "out", cells=24, direction=2, **_RANGE, **nodes_for(kind))
    found = np.array(re.findall(pattern, done.files[0].read_text()), dtype=float)
    cells = JOINT.to_iwan(24, **_RANGE)
    np.testing.assert_allclose(found[:, 0], cells.stiffnesses, rtol=digits)
    np.testing.assert_allclose(found[:, 1], cells.force_limits, rtol=digits)


@pytest.mark.parametrize("kind", ELEMENTS)
def test_a_field_is_sets_of_elements_between_the_nodes_of_a_mesh(kind):
    ends = [[11, 12], [21, 22], [31, 32]]
    done = export.write(kind, _FIELD, "field", nodes=ends, cells=24, first_number=500, **_RANGE)
    text = done.files[0].read_text()
    assert "2 patch(es)" in text
    for pair, there in zip(ends, (True, False, True), strict=True):
        whole = [rf"(?<![\d.]){node}(?![\d.])" for node in pair]
        assert all(bool(re.search(number, text)) == there for number in whole), pair
    worst = max(
        ms.JointField(JOINT.surface, 0.55, areas=[area], loads=[load]).rigid()
        .to_iwan(24, **_RANGE).fit.energy_error
        for area, load in ((5e-5, 900.0), (1e-4, 300.0))
    )  # fmt: skip
    assert done.accuracy.energy_error == pytest.approx(worst, rel=1e-9)


@pytest.mark.parametrize(("kind", "first"), [("calculix", 1), ("calculix", 40)])
def test_nodes_of_the_mesh_are_not_made_anew(kind, first):
    given = {"nodes": [[3, 41]], "cells": 24, "first_number": first}
    with pytest.raises(
        ms.InputError, match=r"first_number.* connects \d.*first_number=42"
    ) as caught:
        export.write(kind, JOINT, "taken", **given, **_RANGE)
    assert f"adds nodes {first} to" in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "law", "options", "says"),
    [
        ("d", JOINT, {}, "kind must be one of c, abaqus-user, fmu"),
        ("c", ms.Coulomb(3.0), {}, "need a finite stiffness at rest"),
        ("c", ms.IsotropicJoint(JOINT, 8), {}, "law must have enough sliders for cycles"),
        ("fmu", ms.IsotropicJoint(JOINT), {}, "fmu supports one direction, and Isotropic"),
        ("opensees", _FIELD.two_directions(16), {"nodes": [[1, 2]]}, "opensees supports one dir"),
        ("fmu", _FIELD, {}, "fmu supports one law, got a field of patches; use opensees, calcul"),
        ("c", ms.Gaussian(1e-6), {}, "law must be a backbone law"),
        ("c", JOINT, {"nodes": [[1, 2]]}, "nodes must not be given for c"),
        ("calculix", _FIELD, {}, "nodes must be given for a field, two numbers per patch"),
        ("calculix", _FIELD, {"nodes": [[1, 2]]}, "nodes must be two different node numbers"),
        ("calculix", JOINT, {"nodes": [[1, 1]]}, "nodes must be two different node numbers"),
        ("calculix", JOINT, {"nodes": [[1.5, 2]]}, "nodes must be two different node numbers"),
        ("c", JOINT, {"largest_amplitude": 1e-12}, "largest_amplitude must be above the smallest"),
        ("c", JOINT, {"smallest_amplitude": 0.0}, "smallest_amplitude must be above zero"),
        ("c", JOINT, {"smallest_amplitude": 1e-7, "largest_amplitude": 1e-7}, "above the smallest"),
        ("calculix", JOINT, {"cells": 1}, "cells must be an integer from 2 to"),
        ("c", JOINT, {"depth": 3}, "depth must be an integer from 4 to"),
        ("c", JOINT, {"name": "1st"}, "name must begin with a letter"),
        ("c", JOINT, {"direction": 4}, "direction must be an integer from 1 to 3"),
        ("c", JOINT, {"first_number": 0}, "first_number must be an integer from 1"),
    ],
)  # fmt: skip
def test_impossible_requests_are_refused_and_leave_nothing(folder, kind, law, options, says):
    before = sorted(folder.iterdir())
    with pytest.raises(ms.InputError, match=re.escape(says)):
        export.write(kind, law, "out.x", **options)
    assert sorted(folder.iterdir()) == before


def test_a_unit_is_the_same_archive_each_time_with_its_sources():
    first, second = (export.write("fmu", JOINT, name).files[0] for name in ("a.fmu", "b.fmu"))
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
        source = archive.read("sources/joint.c").decode()
        assert archive.testzip() is None
    assert f'"{description.get("guid")}"' in source
    told = {item.get("name"): item.get("causality") for item in description.iter("ScalarVariable")}
    assert told == {
        "displacement": "input", "force": "output", "stiffness": "local", "error_bound": "local",
    }  # fmt: skip
    assert export.write("fmu", JOINT.at(normal_load=900.0), "c.fmu").accuracy.backbone_error < 1e-14
    with zipfile.ZipFile("c.fmu") as archive:
        other = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert other.get("guid") != description.get("guid")


def test_nothing_is_replaced_unasked_and_files_come_together(folder):
    (folder / "joint.h").write_text("mine")
    with pytest.raises(ms.InputError, match=r"joint\.h: exists"):
        export.write("c", JOINT, "joint.c")
    assert not (folder / "joint.c").exists()
    assert (folder / "joint.h").read_text() == "mine"
    assert len(export.write("c", JOINT, "joint.c", overwrite=True).files) == 3


def test_the_command_writes_what_python_writes(folder):
    outcome = run("export", "c", "joint.toml", "-o", "a.c")
    assert outcome.exit_code == 0, outcome.output
    assert "Written: a.c, a.h, a.f90" in outcome.output
    (joint,) = build_joints(ms.Study.load("joint.toml"))
    export.write("c", joint, "b.c")
    assert (folder / "a.c").read_bytes() == (folder / "b.c").read_bytes()
    outcome = run(
        "export", "opensees", "joint.toml", "-o", "a.py", "--cells", "32",
        "--smallest-amplitude", "10 nm", "--largest-amplitude", "1 um",
    )  # fmt: skip
    assert "Written: a.py\nFrom 1e-08 to 1e-06 m the error is at most" in outcome.output


def test_too_few_sliders_are_refused_with_a_number_that_is_enough(tmp_path):
    options = {"element": "planar-contact", "smallest_amplitude": 1e-7}
    with pytest.raises(ms.InputError, match="cells=") as refused:
        export.write("c", JOINT, tmp_path / "a.c", cells=20, **options)
    cells = int(re.search(r"cells=(\d+)", str(refused.value))[1])
    done = export.write("c", JOINT, tmp_path / "a.c", cells=cells, **options)
    assert done.accuracy.energy_error <= 0.05


@pytest.mark.parametrize("kind", [*ELEMENTS, "c", "fmu"])
@pytest.mark.parametrize("law", [JOINT, ms.Jenkins(1e7, 10.0)], ids=["joint", "jenkins"])
def test_all_kinds_have_one_limit_of_the_energy_error(kind, law):
    """Five cells miss the energy of small cycles by 100 %; code without cells misses nothing."""
    options = {"cells": 5, "nodes": nodes_for(kind).get("nodes")}
    if kind in ELEMENTS and law is JOINT:
        with pytest.raises(ms.InputError, match=r"5 cells have a relative error .*; give cells="):
            export.write(kind, law, "out", **options)
    else:
        assert export.write(kind, law, "out", **options).accuracy.energy_error < 1e-10


def test_patches_of_a_face_are_exported_as_each_was_tightened():
    """Stiffness and limit of every patch as in the field, whose nodes have laws of their own."""
    steel = ms.Material(210e9, 0.3, hardness=2.4e9)
    face = ms.DrawnFace(ms.MaterialPair(steel, steel), 8e-7, 0.12, 1e-4, 8e7)
    field = ms.JointField(face, 0.2, areas=1e-5, pressures=[8e7, 2e7, 1e6])
    patches = checked_patches("opensees", field, [[1, 2], [3, 4], [5, 6]])
    stiffness = [patch.law.tangential_stiffness for patch in patches]
    assert stiffness == pytest.approx(field.tangential_stiffnesses.tolist(), rel=1e-9)
    limits = [patch.law.force_limit for patch in patches]
    assert limits == pytest.approx(field.force_limits.tolist(), rel=1e-12)
