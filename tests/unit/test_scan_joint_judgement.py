"""What a joint on a scan hangs on: summits that nobody measured, both cut-offs, the scan's size."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import fails, run
from scipy.integrate import simpson
from scipy.stats import norm

import microslip as ms
from microslip.scans import random_surface
from microslip.scans.height_laws import TAIL, MeasuredSurface

STEEL = ms.Material(210e9, 0.3, 2e9)
PAIR = ms.MaterialPair(STEEL, STEEL)
PRESSURE = 3e7  # [Pa] a hundredth of real area


@pytest.fixture(name="scan", scope="module")
def _scan() -> ms.Scan:
    return random_surface((256, 256), 1e-6, m0=4e-14, m2=8e-4, m4=1.6e8, seed=5)


@pytest.fixture(name="worn", scope="module")
def _worn(scan: ms.Scan) -> ms.Scan:
    """The same with its highest parts worn flatter, as by running in."""
    z, start = scan.heights, 0.7 * scan.statistics().rms
    return ms.Scan(np.where(z > start, start + 0.3 * (z - start), z), pixel=scan.pixel)


@pytest.mark.parametrize("highest", [-5e-7, 2e-7, 6e-7, 1.2e-6])
def test_share_of_load_above_against_quadrature(highest: float) -> None:
    """An independent integral of the load over the heights above."""
    surface = MeasuredSurface(PAIR, ms.Gaussian(2e-7, 3e-7), 1e-5, 1e10, 1e-4, highest)
    for separation in (0.0, 5e-7):
        law = norm(3e-7, 2e-7)

        def load(start: float, law: Any = law, d: float = separation) -> float:
            # Of u = y - d = v^2: without the root's end.
            low = math.sqrt(max(start - d, 0.0))
            root = np.linspace(low, 2e-3, 20001)
            value = simpson(2.0 * root**4 * law.pdf(d + root**2), x=root)
            return float(value)

        wanted = load(max(highest, separation)) / load(separation)
        got = surface.load_share_above(highest, separation)
        assert got == pytest.approx(wanted, rel=2e-9, abs=1e-14)
        joint = ms.Interface(surface, 0.3, normal_load=float(surface.load(separation)))
        verdict = next(v for v in joint.validity if v.name == TAIL)
        assert verdict.value == pytest.approx(wanted, rel=1e-6, abs=1e-12)


def test_share_of_given_heights_is_a_sum() -> None:
    heights = np.linspace(0.0, 1e-6, 11)
    surface = MeasuredSurface(PAIR, heights, 1e-5, 1e10, 1e-4, 1e-6)
    part = np.maximum(heights - 2.5e-7, 0.0) ** 1.5
    # The share is of the summits that are higher than a height between two of them.
    got = surface.load_share_above(7.5e-7, 2.5e-7)
    assert got == pytest.approx(part[8:].sum() / part.sum(), rel=5e-3)  # steps, by quadrature
    assert surface.load_share_above(1e-6, 2.5e-7) == 0.0


def test_gaussian_heights_are_recommended_where_they_hold(scan: ms.Scan, worn: ms.Scan) -> None:
    load = PRESSURE * scan.area
    true = scan.summits(None, prominence=0.0).height_laws(PAIR, load, amplitude=1e-7)
    assert true.recommended == "gaussian", true.reason
    assert true.laws["gaussian"].above < 0.05
    own = worn.summits(None, prominence=0.0).height_laws(PAIR, load, amplitude=1e-7)
    assert own.recommended == "population"
    assert own.laws["gaussian"].above > 0.2
    assert own.laws["gaussian"].tangential_stiffness < 0.8 * (
        own.laws["population"].tangential_stiffness
    )
    words = {v.name: v.word for v in own.verdicts()}
    assert words[TAIL] == "outside"
    for law in own.laws.values():
        assert 0.0 < law.loss_factor < 4.0 / math.pi  # type: ignore[operator]


def test_scatter_of_the_stiffness_against_drawing_again(scan: ms.Scan) -> None:
    """The formula against a bootstrap of the summits, within its own scatter of 200 draws."""
    summits = scan.summits(None, prominence=0.0)
    load = 3.0 * PRESSURE * scan.area
    found = summits.height_laws(PAIR, load)
    rng = np.random.default_rng(1)
    drawn = []
    for _ in range(200):
        weights = rng.poisson(1.0, summits.count)
        z, r = np.repeat(summits.heights, weights), np.repeat(summits.radii, weights)
        law = ms.AsperityPopulation(PAIR, z, r, summits.density * scan.area / summits.count)
        drawn.append(math.log(float(law.stiffness(law.separation(load)))))
    assert found.scatter == pytest.approx(float(np.std(drawn)), rel=0.2)


def test_joint_over_cutoffs(scan: ms.Scan) -> None:
    load = PRESSURE * scan.area
    table = scan.joint_over_cutoffs(PAIR, load, cutoff="8 um", amplitude=1e-7)
    assert table.cutoff[table.chosen[1]] == 8e-6
    assert math.isinf(table.long_cutoff[table.chosen[0]])
    # The joint that was asked for is the one that the summits make.
    summits = scan.condition(level="plane").summits("8 um")
    surface = summits.to_surface(PAIR, heights="population")
    joint = ms.Interface(surface, 0.5, normal_load=load)
    got = {name: float(values[table.chosen]) for name, values in table.values.items()}
    assert got["tangential_stiffness"] == joint.tangential_stiffness
    assert got["loss_factor"] == joint.loss_factor(1e-7)
    assert got["real_area"] == pytest.approx(joint.contact_area / scan.area, rel=1e-12)
    # Shorter waves make smaller contacts; waves that are cut off at the long end stiffen it.
    assert table.slope("real_area", "cutoff") > 0.0
    assert table.slope("tangential_stiffness", "long_cutoff") < 0.0
    # Patches of a surface without long waves are as good as the whole.
    assert 0.7 < table.bias("tangential_stiffness") < 1.4
    row = table.chosen[0]
    line, x = table.values["real_area"][row], np.log(table.cutoff)
    at = table.chosen[1]
    slope = math.log(line[at + 1] / line[at - 1]) / (x[at + 1] - x[at - 1])
    assert table.slope("real_area", "cutoff") == pytest.approx(slope, rel=1e-12)
    with pytest.raises(ms.InputError, match='"cutoff" or "long_cutoff"'):
        table.slope("real_area", "pixel")


@pytest.fixture(name="folder")
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, worn: ms.Scan) -> Path:
    monkeypatch.chdir(tmp_path)
    np.save("worn.npy", worn.heights[:128, :128] * 1e6)
    return tmp_path


ARGUMENTS = ("surface", "worn.npy", "--unit", "um", "--pixel", "1 um", "--cutoff", "6 um")


def test_the_command_tells_the_joint(folder: Path) -> None:
    joint = ("--materials", "steel", "AL2017", "--load", "0.5 N", "--amplitude", "0.1 um")
    outcome = run(*ARGUMENTS, *joint, "--heights", "gaussian", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    summary = json.loads((folder / "out/summary.json").read_text("utf-8"))
    told = summary["joint"]
    assert told["recommended"] == "population"
    assert "Take --heights population" in outcome.stdout
    words = {v["name"]: v["word"] for v in summary["validity"]}
    assert words[TAIL] == "outside"
    rows = list(csv.DictReader((folder / "out/joint_cutoffs.csv").read_text("utf-8").splitlines()))
    assert len(rows) == len(told["over_both_cutoffs"])
    assert float(rows[0]["tangential_stiffness [N/m]"]) > 0.0
    assert 'heights = "gaussian"' in (folder / "out/surface.toml").read_text("utf-8")
    assert {"summit_heights.svg", "joint_cutoffs.svg"} <= set(summary["files"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--load", "5 N"), "--load goes with --materials steel steel"),
        (("--materials", "steel", "steel"), '--materials goes with --load "500 N"'),
        (("--amplitude", "1 um"), "--amplitude goes with --materials steel steel and --load"),
        (("--materials", "steel", "cheese", "--load", "5 N"), "no metal is named 'cheese'"),
        (("--load", "5 kg"), "--load: wanted a force"),
    ],
)
def test_a_joint_with_half_of_its_keys(
    folder: Path, options: tuple[str, ...], message: str
) -> None:
    assert message in fails(*ARGUMENTS, *options)


def test_heights_in_a_study(folder: Path) -> None:
    text = """schema = 1
[surface]
law = "scan"
materials = ["steel", "steel"]
scan = "worn.npy"
unit = "um"
pixel = "1 um"
cutoff = "6 um"
heights = "table"
[joint]
friction_coefficient = 0.3
normal_load = "0.5 N"
"""
    study = ms.Study.from_toml(text, folder=folder)
    surface: Any = study.run().joints[0].surface
    assert isinstance(surface.heights, ms.TabulatedHeights)
    whole = ms.Study.from_toml(text.replace("table", "population"), folder=folder)
    assert isinstance(whole.run().joints[0].surface, ms.AsperityPopulation)
    with pytest.raises(ms.StudyError, match=r"surface\.heights"):
        ms.Study.from_toml(text.replace('"table"', '"table"\nestimate = "population"'), folder)
