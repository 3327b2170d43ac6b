"""Uncertain numbers of a study: closed forms, coverage, agreement of methods, and each error."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.special import ndtr, ndtri

import microslip as ms
from microslip._core.dataset import Variable
from microslip._core.quantities import QUANTITIES
from microslip.cli import main
from microslip.study.build import Design, check_draws
from microslip.study.description import StudyDescription
from microslip.study.runs.scatter import scatter

SPHERE = """
schema = 1
[surface]
law = "sphere"
materials = ["al", "al"]
radius = { mean = "5 mm", cv = 0.2 }
[material.al]
young_modulus = { mean = "69 GPa", cv = 0.1 }
poisson_ratio = 0.33
[joint]
friction_coefficient = 0.5
normal_load = { mean = "20 N", cv = 0.15 }
[excitation]
amplitudes = ["0.1 um"]
curve = { from = "10 nm", to = "1 um", points = 3 }
[uncertainty]
samples = 128
"""
ROUGH = """
schema = 1
[surface]
law = "greenwood-williamson"
materials = ["al", "al"]
heights = { kind = "gaussian", std = { mean = "0.5 um", cv = 0.15 } }
radius = { mean = "1 mm", cv = 0.2 }
density = { mean = "100 1/mm^2", cv = 0.2 }
area = "2 cm^2"
[material.al]
young_modulus = { mean = "69 GPa", cv = 0.03 }
poisson_ratio = 0.33
[joint]
friction_coefficient = { mean = 0.55, cv = 0.15 }
normal_load = { mean = "2 kN", cv = 0.15 }
[excitation]
amplitudes = ["0.1 um", "1 um"]
curve = { from = "10 nm", to = "1 um", points = 3 }
[uncertainty]
samples = 128
"""


def width(cv: float) -> float:
    return math.log1p(cv * cv)


def lognormal(shares: Any, powers: dict[float, float]) -> np.ndarray:
    """Quantiles of a product of lognormals over that of their means: {cv: power}."""
    variance = sum(p * p * width(cv) for cv, p in powers.items())
    shift = sum(-0.5 * p * width(cv) for cv, p in powers.items())
    return np.exp(shift + math.sqrt(variance) * ndtri(shares))


def test_bands_of_products_of_lognormals_are_their_closed_forms() -> None:
    """A sphere's stiffness goes as E^(2/3) R^(1/3) N^(1/3), its limit as N."""
    result = ms.Study.from_toml(SPHERE).run()
    found = result.scatter
    assert found is not None
    assert found.samples == 128
    joint, shares = result.joints[0], found.quantiles
    for name, powers in (
        ("tangential_stiffness", {0.1: 2 / 3, 0.2: 1 / 3, 0.15: 1 / 3}),
        ("force_limit", {0.15: 1.0}),
    ):
        wanted = getattr(joint, name) * lognormal(shares, powers)
        got, (low, high) = found.bands[name].values[:, 0], found.intervals[name][:, :, 0]
        assert np.all(np.abs(got - wanted) <= 0.03 * wanted)
        assert (low[1] <= wanted[1] <= high[1], high[1] - low[1] < 0.08 * wanted[1]) == (True, True)
    assert [one.key for one in found.inputs] == [
        "material.al.young_modulus", "surface.radius", "joint.normal_load",
    ]  # fmt: skip


def test_a_rough_joint_is_what_theory_says() -> None:
    """Shares and widths of the worked example, by regression and samples."""
    result = ms.Study.from_toml(ROUGH).run()
    found = result.scatter
    assert found is not None
    low, middle, high = found.bands["loss_factor"].values[:, 0, 0]
    assert (high - low) / middle == pytest.approx(0.68, abs=0.06)
    decision = found.decision("loss_factor", 0, 0)
    shares = dict(zip([one.key for one in found.inputs], decision.shares, strict=True))
    assert shares["joint.friction_coefficient"] == pytest.approx(0.63, abs=0.03)
    assert shares["surface.heights.std"] == pytest.approx(0.25, abs=0.03)
    assert shares["surface.density"] == pytest.approx(0.07, abs=0.02)
    assert decision.explained > 0.97
    # All that the result says has a band, and stands in the document.
    for name in ("force", "curve_loss_factor", "contact_count", "dissipated_energy"):
        assert found.bands[name].values.shape[0] == 3
    summary = result.summary["uncertainty"]
    assert summary["bands"]["loss_factor"]["quantiles"][0][0][0] == low
    assert "bands.csv" in result.summary["files"]


# -- with a model of its own, which costs nothing --------------------------------------------------


def product(study: StudyDescription) -> dict[str, Variable]:
    """Load times friction, to a power at the second amplitude."""
    load, friction = study.joint.normal_load[0], study.joint.friction_coefficient
    values = np.array([[load * friction, load**2 * friction]])
    dims = ("load", "amplitude")
    names = ("loss_factor", "dissipated_energy", "secant_stiffness")
    return {name: Variable(dims, values, QUANTITIES[name]) for name in names}


def of_product(more: str = "", **changes: str) -> Any:
    text = """
schema = 1
surface = { law = "sphere", materials = ["steel", "steel"], radius = "5 mm" }
joint = { friction_coefficient = MU, normal_load = LOAD }
uncertainty = { samples = 512 MORE }
"""
    given = {"MU": "{ mean = 0.5, cv = 0.2 }", "LOAD": '{ mean = "2 N", cv = 0.3 }', "MORE": more}
    for name, value in {**given, **changes}.items():
        text = text.replace(name, value)
    return ms.Study.from_toml(text)


def test_quantiles_and_intervals_cover_over_seeds() -> None:
    """The 5 to 95 % band holds 90 %, and so do the intervals of the quantiles."""
    wanted = lognormal(np.array([0.05, 0.5, 0.95]), {0.2: 1.0, 0.3: 1.0})
    mean, sigma = -0.5 * (width(0.2) + width(0.3)), math.sqrt(width(0.2) + width(0.3))
    inside, held = [], []
    for seed in range(16):
        study = of_product(f", seed = {seed}")
        found = scatter(study, product(study), product)
        got = found.bands["loss_factor"].values[:, 0, 0]
        low, high = found.intervals["loss_factor"][:, :, 0, 0]
        inside.append((low <= wanted) & (wanted <= high))
        ends = ndtr((np.log(got) - mean) / sigma)
        held.append(ends[2] - ends[0])
    assert np.mean(held) == pytest.approx(0.90, abs=4e-3)
    assert np.std(held) < 0.01
    assert np.mean(inside) > 0.85


def test_methods_agree() -> None:
    """The shares by regression of a product are those of its variances."""
    study = of_product()
    found = scatter(study, product(study), product)
    shares = np.array([width(0.2), 4.0 * width(0.3)])
    decision = found.decision("dissipated_energy", 0, 1)
    assert [one.key for one in found.inputs] == ["joint.friction_coefficient", "joint.normal_load"]
    assert decision.scatter == pytest.approx(math.sqrt(shares.sum()), rel=0.08)
    np.testing.assert_allclose(decision.shares, shares / shares.sum(), atol=1e-9)


def test_kinds_of_scatter() -> None:
    study = of_product(MU="{ low = 0.2, high = 0.6 }", LOAD='{ values = ["1 N", "2 N", "6 N"] }')
    assert float(study.joint.friction_coefficient) == pytest.approx(0.4)
    assert study.joint.normal_load[0] == pytest.approx(3.0)
    found = scatter(study, product(study), product)
    product_values = np.array(
        [[m * n for m in np.linspace(0.2, 0.6, 4001)] for n in (1.0, 2.0, 6.0)]
    )
    wanted = np.quantile(product_values, [0.05, 0.5, 0.95])
    np.testing.assert_allclose(found.bands["loss_factor"].values[:, 0, 0], wanted, rtol=0.04)
    with pytest.raises(ms.StudyError, match=r"distribution with mean and cv was removed in 0\.3"):
        of_product(LOAD='{ mean = "2 N", cv = 0.3, distribution = "normal" }')


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    study = ms.Study.from_toml(SPHERE.replace("samples = 128", "samples = 64\nseed = 5"))
    files = []
    for name in ("first", "second"):
        study.run().save(tmp_path / name)
        files.append({p.name: p.read_bytes() for p in (tmp_path / name).iterdir()})
    assert files[0] == files[1]


def test_check_refuses_what_some_draws_refuse(tmp_path: Path) -> None:
    path = tmp_path / "joint.toml"
    table = """law = "table"
materials = ["al", "al"]
separation = ["0 um", "1 um", "2 um"]
load = ["2.2 kN", "1 kN", "0 N"]
"""
    usual = ROUGH.replace("samples = 128", "samples = 512")
    text = usual.replace(ROUGH[ROUGH.index("law") : ROUGH.index("[material")], table)
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ms.StudyError, match=r"joint.normal_load: \d+ of 512 draws") as caught:
        check_draws(StudyDescription.load(path))
    # Lognormal of mean 2 kN: so many are above 2.2 kN.
    width = math.log1p(0.15**2)
    share = 1.0 - ndtr((math.log(1.1) + 0.5 * width) / math.sqrt(width))
    count = int(str(caught.value).partition("normal_load: ")[2].partition(" of")[0])
    assert count == pytest.approx(512 * share, abs=2)
    assert CliRunner().invoke(main, ["check", str(path)]).exit_code == 2
    # A law without an end answers all of them.
    path.write_text(usual, encoding="utf-8")
    check_draws(StudyDescription.load(path))


def test_any_number_may_scatter() -> None:
    """Hardness, heights, area, load, amplitudes."""
    hardness = 'hardness = { low = "0.8 GPa", high = "1.2 GPa" }'
    text = ROUGH.replace("poisson_ratio", f"{hardness}\npoisson_ratio")
    text = text.replace('"2 cm^2"', '{ mean = "2 cm^2", cv = 0.05 }')
    text = text.replace('["0.1 um"', '[{ mean = "0.1 um", cv = 0.1 }')
    design = Design(ms.Study.from_toml(text))
    assert [one.key for one in design.inputs] == [
        "material.al.young_modulus", "material.al.hardness", "surface.heights.std",
        "surface.radius", "surface.density", "surface.area", "joint.friction_coefficient",
        "joint.normal_load", "excitation.amplitudes, item 1",
    ]  # fmt: skip
    for row in design.scores(design.points()[0]):
        drawn = design.at(row)
        assert 1e7 <= drawn.material["al"].hardness <= 1.2e9  # type: ignore[union-attr]
