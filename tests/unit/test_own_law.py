"""A user's own law and heights: on surfaces, in fits, in studies and in commands."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from own_laws import Ramp
from usual import PAIR, rough

import microslip as ms
from microslip.identification.interface_model import InterfaceModel, Materials


def test_heights_of_ones_own_stand_on_surfaces_and_in_fits() -> None:
    surface = rough(Ramp(2e-6))
    joint = ms.Interface(surface, 0.5, normal_load=500.0)
    model = InterfaceModel.of_shape(Ramp(1e-3), [500.0])
    values = {
        "friction_coefficient": 0.5,
        "slip_scale": joint.slip_per_indentation * surface.heights.spread,
        "standardised_separation": joint.separation / surface.heights.spread,
    }
    again = model.build(values, 500.0, Materials(PAIR, 2e-4, 1e-3))
    assert again.surface.heights.highest == pytest.approx(2e-6, rel=1e-12)
    u = joint.force_limit / joint.tangential_stiffness * np.geomspace(1e-3, 30.0, 40)
    assert again.backbone(u) == pytest.approx(joint.backbone(u), rel=1e-9)
    assert model.curve(u, values, 500.0) == pytest.approx(joint.backbone(u), rel=1e-9)


TESTS = Path(__file__).parents[1]

EXPORT = """
import json
import sys

from click.testing import CliRunner

from microslip import friction
from microslip.friction import laws
from own_laws import Hyperbola

# What an entry in the exported tuple does, before anything has read it.
laws.LAWS = friction.LAWS = (*laws.LAWS, Hyperbola)
assert not any(name.startswith("microslip.study") for name in sys.modules)

from microslip.cli import main


def run(*words, code=0):
    found = CliRunner().invoke(main, words)
    assert found.exit_code == code, found.output
    return found.output


LAW = Hyperbola(stiffness=2e7, force_limit=300.0)
"""

STUDIES = """
friction.save_law(LAW, "law.json")
open("law.toml", "w").write('''schema = 1
[joint]
law_file = "law.json"
[excitation]
amplitudes = ["2 um", "30 um"]
[output]
formats = ["csv"]
''')
assert run("check", "law.toml")
(joint,) = json.loads(run("predict", "law.toml", "--json"))["joints"]
energies = [row["dissipated_energy"] for row in joint["amplitudes"]]
assert energies == list(LAW.dissipated_energy([2e-6, 3e-5])), energies
assert "Friction law: hyperbola." in open("law-result/report.html").read()
"""


def run(tmp_path: Path, *parts: str) -> None:
    paths = os.pathsep.join(filter(None, (str(TESTS), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(parts)], cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"}, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_one_export_makes_a_law_a_file_of_studies(tmp_path: Path) -> None:
    run(tmp_path, EXPORT, STUDIES)
