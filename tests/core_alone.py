"""Joints, fields, harmonics and exports where only NumPy is installed; a program of its own.

.ci/run runs it in such an environment, tests/unit/test_imports.py with all other packages hidden
(``--hide``). With ``--scipy`` SciPy is installed too, and more of the library is run.
Functions that need another package must raise a one-line error that names it.
"""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from importlib.abc import MetaPathFinder
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

BEFORE = set(sys.modules)
ALONE = {"numpy", "microslip"}
COMPILER = {"ziglang"}  # fetched by the build where there is no other
WITH_SCIPY = "--scipy" in sys.argv


class Hidden(MetaPathFinder):
    """Finder that reports all packages as missing, except the few."""

    names = frozenset(packages_distributions()) - ALONE - COMPILER - {"scipy" * WITH_SCIPY}

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> None:
        if name.partition(".")[0] in self.names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


if "--hide" in sys.argv:
    sys.meta_path.insert(0, Hidden())

import numpy as np  # noqa: E402

import microslip as ms  # noqa: E402
from microslip import export  # noqa: E402


def missing(what: str, package: str, use: Any) -> None:
    try:
        use()
    except ms.InputError as error:
        message = str(error)
    else:
        message = "no error"
    assert f"{package}, which is not installed: pip install" in message, (what, message)
    assert "\n" not in message, what


aluminium = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(aluminium, aluminium), ms.Gaussian(5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, 0.55, normal_load=2000.0)
assert abs(joint.loss_factor(3e-7) - 0.304693) < 1e-6
state = joint.start()
assert state.try_(3e-7)[0] == joint.force([3e-7])[0]
state.commit()

field = ms.JointField(surface, 0.55, areas=[1e-4, 1e-4], loads=[1000.0, 1000.0])
assert np.isclose(field.rigid().force([3e-7])[0], joint.force([3e-7])[0], rtol=1e-12)
load = joint.coupled_response([1e-7, 3e-7], normal_load=[2000.0, 2000.0]).force
assert np.allclose(load, joint.force([1e-7, 3e-7]), rtol=1e-12)
assert joint.periodic([0.0, 3e-7, 0.0, -3e-7]).force.shape == (4,)
assert joint.harmonics([0.0, 3e-7, 0.0]).force[1] > 0.0
assert field.harmonics([0.0, 3e-7, 0.0]).force.shape == (2, 3)
laws = [
    joint,
    ms.Jenkins(5e7, 100.0),
    ms.Coulomb(100.0),
    *ms.Iwan.examples(),
    *ms.SegalmanIwan.examples(),
    *ms.Asperity.examples(),
]
for law in [*laws, ms.Parallel(laws[:2])]:
    assert np.isfinite(law.harmonics([0.0, 1e-7, 2e-8]).jacobian).all() or law is laws[2]
    assert np.isclose(law.start().try_(1e-7)[0], law.force([1e-7])[0], rtol=1e-13)
os.environ.pop("CC", None)  # `make test CC=false` stops the kernel's compiler, not a user's
sys.modules["ziglang"] = None  # its first library takes minutes
with tempfile.TemporaryDirectory() as folder:
    for kind in export.KINDS:
        export.write(kind, joint, Path(folder) / f"{kind}_joint")


def with_scipy() -> None:
    """Run the library up to arrays of joints."""
    for name in ms.__all__:
        thing = getattr(ms, name)
        if hasattr(thing, "examples"):
            assert all(isinstance(example, thing) for example in thing.examples()), name
    assert ms.Oscillator(1.0, 1e6, joint).ring_down(3e-7, cycles=3) is not None
    wave = np.sin(2.0 * np.pi * np.arange(128) / 16.0) * 1e-7
    scan = ms.Scan(wave[:, None] + wave, 1e-6).condition(level="plane")
    assert scan.summits(8e-6).statistics().density > 0.0
    study = ms.Study(
        schema=1,
        surface={"law": "sphere", "materials": ["steel", "al2017"], "radius": "5 mm"},
        joint={"friction_coefficient": 0.2, "normal_load": ["1 N", "2 N"]},
    )
    assert study.joint.normal_load == (1.0, 2.0)
    table = ms.evaluate(
        surface=joint.surface, friction_coefficient=0.5, normal_load=[1e3, 2e3], amplitude=3e-7
    )
    assert table["loss_factor"].shape == (2,)
    missing("a plot", "matplotlib", joint.loop(3e-7).plot)
    missing("a rare unit", "pint", lambda: ms.units("3 furlong"))
    assert ms.units("3 um") == 3e-6


if WITH_SCIPY:
    with_scipy()
else:
    missing("an identification", "scipy", lambda: ms.identify)
    heavy = ms.GreenwoodWilliamson(surface.pair, ms.Exponential(8e-7), 1e-3, 1e8, 2e-4)
    missing("a heavy load", "scipy", lambda: heavy.load(-1e-7))

loaded = {name.partition(".")[0] for name in sys.modules.keys() - BEFORE} & Hidden.names
assert not loaded, f"other packages were loaded: {sorted(loaded)}"
print(
    f"The core runs with NumPy{' and SciPy' * WITH_SCIPY} alone, with the kernel",
    importlib.import_module("microslip._core.kernels").NAME,
)
