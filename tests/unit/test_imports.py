"""What importing costs, and that every public name is there."""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import pkgutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from studies import STUDY

import microslip as ms
from microslip._core.parameters import parameters_of
from microslip.contact import NORMAL_LAWS
from microslip.contact.heights import HEIGHTS
from microslip.friction import LAWS
from microslip.friction.field_backbone import FieldBackbone
from microslip.laboratory.virtual import InSeries

PACKAGE = Path(ms.__file__).parent
LISTS = (
    (ms.BackboneLaw, LAWS),
    (ms.NormalLaw, NORMAL_LAWS),
    (ms.HeightDistribution, HEIGHTS),
)


def run(code: str, **environment: str) -> str:
    """Run a program in a fresh interpreter that finds the same microslip."""
    path = os.pathsep.join(filter(None, (str(PACKAGE.parent), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=os.environ | {"PYTHONPATH": path} | environment,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


LOADED = "import sys; print(*sorted(sys.modules))"


def test_import_is_light() -> None:
    loaded = run(f"import microslip; microslip.__version__; dir(microslip); {LOADED}").split()
    assert "microslip" in loaded
    for heavy in ("numpy", "scipy", "pydantic", "pint", "matplotlib", "click", "rich"):
        assert heavy not in loaded


GAUSSIAN = """
import microslip as ms
al = ms.Material(69e9, 0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, 0.55, normal_load=2000.0)
joint.loop(1e-6).loss_factor, joint.dissipated_energy([1e-11, 1e-6]), joint.at(normal_load=100.0)
joint.force([1e-6, -1e-6, 0.0]), joint.displacement([500.0, -500.0]), joint.validity
joint.periodic([0.0, 1e-7, -1e-7]), joint.sliders().density(1e-7), joint.stick_area(1e-7)
joint.dissipation_exponent(1e-6), joint.contact_count, surface.separation([1.0, 10.0])
state = joint.start(); state.try_(1e-7); state.commit()
"""


def test_gaussian_interfaces_need_no_scipy() -> None:
    loaded = run(GAUSSIAN + LOADED).split()
    for heavy in ("scipy", "pydantic", "pint", "matplotlib", "click", "rich"):
        assert heavy not in loaded
    laws = ("population", "sphere", "table")
    assert not {f"microslip.contact.{law}" for law in laws} & set(loaded)
    assert "microslip.contact.measured_face" not in loaded


@pytest.mark.parametrize(
    "steps",
    [
        {
            ("measure", "record.csv"): "pint scipy.fft microslip.study.description",
            ("identify", "record.csv"): "pint microslip.study.description",
        },
        {("check", "joint.toml"): "pint scipy.fft microslip.surfaces.filters microslip.app"},
    ],
    ids=("records", "study"),
)
def test_a_command_loads_what_it_needs(steps: dict[tuple[str, ...], str], tmp_path: Path) -> None:
    rig = ms.VirtualTribometer(ms.Jenkins(1e9, 500.0), noise=0.01, sample_rate=500.0)
    rig.record(amplitude=1e-6, frequency=10.0, cycles=4).to_csv(tmp_path / "record.csv")
    (tmp_path / "joint.toml").write_text(STUDY)
    code = f"import os, sys; os.chdir({str(tmp_path)!r}); from microslip.cli import main\n"
    for arguments, unneeded in steps.items():
        code += f"main({arguments!r}, standalone_mode=False)\n"
        code += f"assert not {set(unneeded.split())!r} & set(sys.modules), {arguments!r}\n"
    run(code)


def test_the_core_needs_only_numpy() -> None:
    """A program of its own, which .ci/run runs where nothing else is installed, and with SciPy."""
    program = Path(__file__).parents[1] / "core_alone.py"
    code = f"import runpy, sys; sys.argv = ['', '--hide']; runpy.run_path({str(program)!r})"
    assert run(code).startswith("The core runs with NumPy")


# -- names -----------------------------------------------------------------------------------------


def stub_names() -> dict[str, str]:
    """Public names and their modules, as the stub gives them."""
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    names: dict[str, str] = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            assert node.level == 1
            for alias in node.names:
                assert alias.asname == alias.name, (
                    "a stub exports only names imported as themselves"
                )
                names[alias.name] = f"microslip.{node.module}"
                # The module would stand where its name should.
                assert alias.name != str(node.module).partition(".")[0]
    return names


def test_names_of_the_stub() -> None:
    assert sorted(ms.__all__) == sorted([*stub_names(), "__version__"])
    assert len(set(ms.__all__)) == len(ms.__all__)


def test_names_resolve() -> None:
    for name, module in stub_names().items():
        value = getattr(ms, name)
        assert value is getattr(importlib.import_module(module), name)
        assert value.__name__ == name


# -- lists that the shared tests run over ----------------------------------------------------------


def modules() -> list[ModuleType]:
    imported = []
    for info in pkgutil.walk_packages([str(PACKAGE)], "microslip."):
        if not info.name.endswith((".__main__", "._compiled")):
            try:
                imported.append(importlib.import_module(info.name))
            except ModuleNotFoundError as missing:  # of an optional extra
                if str(missing.name).startswith("microslip"):
                    raise
    return imported


def concrete(base: type) -> set[type]:
    below: set[type] = set()
    for child in base.__subclasses__():
        below |= {child} | concrete(child)
    return {
        child
        for child in below
        if child.__module__.startswith("microslip.") and not inspect.isabstract(child)
    }


@pytest.mark.parametrize(("base", "listed"), LISTS, ids=lambda v: getattr(v, "__name__", "list"))
def test_every_class_is_in_its_list(base: type, listed: tuple[type, ...]) -> None:
    modules()
    assert len(set(listed)) == len(listed)
    # A rig in series wraps a law, and fields make their own: no choice.
    made = {InSeries, FieldBackbone}
    assert concrete(base) - made == set(listed)
    for law in listed:
        assert getattr(ms, law.__name__) is law
        for declared in parameters_of(law):
            assert declared.symbol and declared.meaning  # noqa: PT018
