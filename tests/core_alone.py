"""The library up to its sweeps where only NumPy and SciPy are installed; a program of its own.

.ci/run runs it in such an environment, tests/unit/test_imports.py with all other packages hidden
(``--hide``). What needs more must say in one line what that is.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
from importlib.abc import MetaPathFinder
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

BEFORE = set(sys.modules)
ALONE = {"numpy", "scipy", "microslip"}


class Hidden(MetaPathFinder):
    """Nothing that is installed is found but the few."""

    names = frozenset(packages_distributions()) - ALONE

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> None:
        if name.partition(".")[0] in self.names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


if "--hide" in sys.argv:
    sys.meta_path.insert(0, Hidden())

import numpy as np  # noqa: E402

import microslip as ms  # noqa: E402

for name in ms.__all__:
    thing = getattr(ms, name)
    if hasattr(thing, "examples"):
        assert all(isinstance(example, thing) for example in thing.examples()), name

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
assert ms.Oscillator(1.0, 1e6, joint).ring_down(3e-7, cycles=3) is not None
wave = np.sin(2.0 * np.pi * np.arange(128) / 16.0) * 1e-7
scan = ms.Scan(wave[:, None] + wave, 1e-6).condition(level="plane")
assert scan.summits(8e-6, level=None).statistics().density > 0.0
study = ms.Study(
    schema=1,
    surface={"law": "sphere", "materials": ["steel", "al2017"], "radius": "5 mm"},
    joint={"friction_coefficient": 0.2, "normal_load": ["1 N", "2 N"]},
)
assert study.joint.normal_load == (1.0, 2.0)
with tempfile.TemporaryDirectory() as folder:
    table = ms.sweep(joint, normal_load=[1e3, 2e3], amplitude=[3e-7])
    path = table.to_csv(Path(folder) / "sweep.csv")
    assert len(path.read_text(encoding="utf-8").splitlines()) == 3

    def missing(what: str, package: str, use: Any) -> None:
        try:
            use()
        except ms.InputError as error:
            said = str(error)
        else:
            said = "nothing"
        assert f"{package}, which is not installed: pip install" in said, (what, said)
        assert "\n" not in said, what

    missing("a netCDF file", "h5netcdf", lambda: table.to_netcdf(Path(folder) / "sweep.nc"))
    missing("labelled arrays", "xarray", table.to_xarray)
    missing("a plot", "matplotlib", joint.loop(3e-7).plot)
    missing("a rare unit", "pint", lambda: ms.units("3 furlong"))
    assert ms.units("3 um") == 3e-6

loaded = {name.partition(".")[0] for name in sys.modules.keys() - BEFORE} & Hidden.names
assert not loaded, f"loaded beside NumPy and SciPy: {sorted(loaded)}"
print(
    "The core stands alone, with the kernel",
    importlib.import_module("microslip._core.kernels").NAME,
)
