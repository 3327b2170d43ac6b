"""Inverse design: exact derivatives, closed answers, probabilities, and each error."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import microslip as ms
from microslip.cli import main
from microslip.runs.design import Range, Search, Target
from microslip.runs.modal_design import AnySearch, open_search
from microslip.sweeps.derivatives import QUANTITIES, log_derivatives

STUDY = """
schema = 1
[surface]
law = "greenwood-williamson"
materials = ["al2017", "al2017"]
heights = { kind = "gaussian", std = "0.5 um" }
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"
[joint]
friction_coefficient = MU
normal_load = "2 kN"
"""
SURE = STUDY.replace("MU", "0.55")
UNSURE = STUDY.replace("MU", "{ mean = 0.55, cv = 0.15 }") + "[uncertainty]\nsamples = 256\n"
NAMES = ("normal_load", "friction_coefficient", "std", "radius", "density", "area")


def test_derivatives_against_differences() -> None:
    rng = np.random.default_rng(4)
    given = {
        "young_modulus": 69e9, "poisson_ratio": 0.33, "std": 5e-7 * rng.uniform(0.5, 2.0, 20),
        "radius": 1e-3, "density": 1e8, "area": 2e-4, "friction_coefficient": 0.55,
        "normal_load": 10.0 ** rng.uniform(1.0, 4.5, 20),
        "amplitude": 10.0 ** rng.uniform(-9, -5, 20),
    }  # fmt: skip
    step = 1e-4
    for quantity in QUANTITIES:
        exact = log_derivatives(quantity, given, NAMES)
        for name in NAMES:
            logs = [
                np.log(ms.evaluate(**{**given, name: given[name] * math.exp(k * step)})[quantity])
                for k in (-2, -1, 1, 2)
            ]
            # Fourth order: 1e-16 of the differences, and rounding 1e-15 over the step.
            slope = (logs[0] - 8.0 * logs[1] + 8.0 * logs[2] - logs[3]) / (12.0 * step)
            np.testing.assert_allclose(exact[name], slope, rtol=1e-8, atol=1e-9)


def search(text: str, target: str, *ranges: str, probability: float = 0.9) -> Search:
    study = ms.Study.from_toml(text)
    return Search(study, Target.read(target), [Range.read(r) for r in ranges], probability)


def test_a_load_by_a_root() -> None:
    """One key, nothing uncertain: the design is the root next to the study."""
    from scipy.optimize import brentq

    found = search(SURE, "damping_ratio >= 6 % at 0.1 um", "joint.normal_load=500 N..5 kN").solve()
    joint = ms.Study.from_toml(SURE).run().joints[0]
    root = brentq(lambda n: joint.at(normal_load=n).damping_ratio(1e-7) - 0.06, 500.0, 2000.0)
    assert found.feasible
    assert found.values["joint.normal_load"] == pytest.approx(root, rel=1e-5)


def test_with_a_probability() -> None:
    """The share of fresh samples that meet the target is what was asked for."""
    one = search(UNSURE, "damping_ratio >= 5 % at 0.1 um", "joint.normal_load=200 N..5 kN",
                 "surface.heights.std=0.1 um..1 um")  # fmt: skip
    found = one.solve()
    assert found.feasible
    assert found.probability == pytest.approx(0.9, abs=0.01)
    rng = np.random.default_rng(11)
    width = math.log1p(0.15**2)
    friction = 0.55 * np.exp(math.sqrt(width) * rng.standard_normal(200_000) - 0.5 * width)
    fresh = ms.evaluate(
        young_modulus=one.middle["young_modulus"], poisson_ratio=one.middle["poisson_ratio"],
        std=found.values["surface.heights.std"], radius=1e-3, density=1e8, area=2e-4,
        friction_coefficient=friction, normal_load=found.values["joint.normal_load"],
        amplitude=1e-7, quantities=["damping_ratio"],
    )["damping_ratio"]  # fmt: skip
    assert np.mean(fresh >= 0.05) == pytest.approx(0.9, abs=0.01)
    # The way there is the steepest: the step goes along the slopes (a stationary point).
    x = np.log(list(found.values.values()))
    step, slopes = x - one.start, one.quantile(x)[1]
    along = abs(step @ slopes) / np.linalg.norm(step) / np.linalg.norm(slopes)
    assert along > 0.99


@pytest.mark.slow
def test_the_command(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(UNSURE)
    words = ["design", str(tmp_path / "study.toml"), "--target", "damping_ratio >= 5 % at 0.1 um"]
    vary = ["--vary", "joint.normal_load=200 N..5 kN"]
    found = CliRunner().invoke(main, [*words, *vary, "-o", str(tmp_path / "out")])
    assert found.exit_code == 0, found.output
    data = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert data["feasible"]
    assert data["met_by"] == pytest.approx(0.9, abs=0.01)
    assert {p.name for p in (tmp_path / "out").iterdir()} == set(data["files"])
    loads = [one["design"]["joint.normal_load"] for one in data["trade_off"] if one["feasible"]]
    assert loads == sorted(loads, reverse=True), "more damping, less load"
    far = [*words[:3], "damping_ratio >= 0.6 at 0.1 um", *vary, "--json"]
    found = CliRunner().invoke(main, far)
    assert found.exit_code == 0
    assert not json.loads(found.output)["feasible"]


WRONG = {
    "target": (("damping_ratio", "joint.normal_load=1 N..2 N"), "target must read like"),
    "quantity": (
        ("damping >= 1 at 1 um", "joint.normal_load=1 N..2 N"),
        "target must be among damp",
    ),
    "amplitude": (("loss_factor >= 1 at 1 N", "joint.normal_load=1 N..2 N"), "target"),
    "level": (("loss_factor >= 0 at 1 um", "joint.normal_load=1 N..2 N"), "a value above zero"),
    "key": (("loss_factor >= 1 at 1 um", "joint.load=1 N..2 N"), "vary must be among joint.normal"),
    "ends": (("loss_factor >= 1 at 1 um", "joint.normal_load=2 N..1 N"), "low..high above zero"),
    "dots": (("loss_factor >= 1 at 1 um", "joint.normal_load=2 N"), "must read like"),
    "unit": (("loss_factor >= 1 at 1 um", "joint.normal_load=1 m..2 m"), "vary: joint.normal_load"),
}


@pytest.mark.parametrize("case", WRONG.values(), ids=WRONG)
def test_wrong_input_is_reported(case: tuple[tuple[str, str], str]) -> None:
    (target, vary), message = case
    with pytest.raises(ms.InputError) as caught:
        search(SURE, target, vary)
    assert message in str(caught.value)
    with pytest.raises(ms.InputError, match="probability must be above 0 and below 1, got 1"):
        search(SURE, "loss_factor >= 1 at 1 um", "joint.normal_load=1 N..2 N", probability=1.0)


JENKINS = """
schema = 1
[joint]
law = "jenkins"
stiffness = "50 N/um"
force_limit = { mean = "20 N", cv = 0.1 }
[uncertainty]
samples = 64
"""


def test_a_law_by_its_closed_form() -> None:
    """Jenkins loses 4 F (a - F/k): with nine in ten the quantile of F decides."""
    target = Target.read("secant_stiffness >= 2e7 at 1 um")  # F/a beyond its slip
    found = open_search(
        ms.Study.from_toml(JENKINS), target, ["joint.force_limit=5 N..49 N"], 0.9
    ).solve()
    width = math.log1p(0.01)
    lowest = math.exp(-1.2816 * math.sqrt(width) - 0.5 * width)  # its 10 %
    assert found.feasible
    # A quantile of 64 points.
    assert found.values["joint.force_limit"] == pytest.approx(20.0 / lowest, rel=0.02)


@pytest.mark.slow
def test_any_study_gives_what_the_exact_search_gives() -> None:
    """The same study by both ways, and keys and joints that only the second has."""
    target, vary = "damping_ratio >= 6 % at 0.1 um", "joint.normal_load=500 N..5 kN"
    study = ms.Study.from_toml(SURE)
    exact = open_search(study, Target.read(target), [vary], 0.9)
    assert type(exact) is Search
    other = AnySearch(study, Target.read(target), [vary], 0.9)
    there = np.log([1500.0])
    np.testing.assert_allclose(other.quantile(there)[1], exact.quantile(there)[1], rtol=1e-6)
    key = "joint.normal_load"
    assert other.solve().values[key] == pytest.approx(exact.solve().values[key], rel=1e-5)
    two = SURE.replace('"2 kN"', '["1 kN", "2 kN"]') + 'tightening_load = "4 kN"\n'
    found = open_search(
        ms.Study.from_toml(two), Target.read(target), ["joint.friction_coefficient=0.1..0.9"], 0.9
    ).solve()
    assert found.feasible
    changed = two.replace("0.55", repr(found.values["joint.friction_coefficient"]))
    ratios = [float(j.damping_ratio(1e-7)) for j in ms.Study.from_toml(changed).run().joints]
    assert min(ratios) == pytest.approx(0.06, rel=1e-4), "the heavier load decides"


@pytest.mark.slow
def test_a_surface_is_tightened_once_for_all_samples() -> None:
    """Neither friction nor load changes what was tightened; each sample has its own joint."""
    text = UNSURE.replace('"2 kN"', '"2 kN"\ntightening_load = "6 kN"\nyield_stress = "250 MPa"')
    study = ms.Study.from_toml(text.replace("samples = 256", "samples = 64"))
    for target in ("damping_ratio >= 6 % at 0.1 um", "dissipated_energy >= 4e-6 at 0.1 um"):
        search = AnySearch(study, Target.read(target), ["joint.normal_load=500 N..5 kN"], 0.9)
        found = search.solve()
        assert len(search._surfaces) == 1
        assert found.feasible
        assert found.probability >= 0.9, "what is told is met"
        surface = next(iter(search._surfaces.values()))
        load = found.values["joint.normal_load"]
        row = search._rows[3]
        joint = ms.Interface(surface, row["joint.friction_coefficient"], normal_load=load)
        wanted = float(getattr(joint, search.target.quantity)(1e-7))
        assert math.exp(search.values(np.log([load]))[3]) == pytest.approx(wanted, rel=1e-9)
