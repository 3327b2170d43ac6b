"""The worked example, from its study file to the numbers and pictures of its result."""

from __future__ import annotations

import csv
import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import microslip as ms
from microslip.cli import main

EXAMPLE = Path(__file__).parents[2] / "examples" / "al2017.toml"
LOADS = (500.0, 2000.0, 5000.0)
AMPLITUDES = (1e-7, 3e-7, 1e-6, 1e-5)
FIGURES = (
    *("loops", "backbone", "energy_damping", "force_damping"),
    *("contact_state", "slider_density"),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("example") / "result"
    outcome = CliRunner().invoke(main, ["predict", str(EXAMPLE), "-o", str(folder)])
    assert outcome.exit_code == 0, outcome.output
    return folder


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text("utf-8"))


@pytest.fixture(scope="module")
def joint() -> ms.Interface:
    al = ms.Material(young_modulus=69e9, poisson_ratio=0.33, hardness=1.2e9)
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(al, al), heights=ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
    )
    return ms.Interface(surface, friction_coefficient=0.55, normal_load=LOADS[0])


def read(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))


def test_everything_listed_is_there_and_nothing_else(folder: Path, summary: dict[str, Any]) -> None:
    assert summary["files"] == [
        "summary.json",
        "study.toml",
        "report.html",
        "result.nc",
        "loops.csv",
        "curves.csv",
        *(f"{name}.svg" for name in FIGURES),
    ]
    assert sorted(p.name for p in folder.iterdir()) == sorted(summary["files"])
    assert (folder / "study.toml").read_bytes() == EXAMPLE.read_bytes()


def test_the_numbers_of_the_joint(summary: dict[str, Any]) -> None:
    """The worked numbers of this joint, computed independently with 30 digits."""
    light, middle, heavy = summary["joints"]
    assert middle["standardised_separation"] == pytest.approx(0.568, abs=5e-4)
    assert middle["contact_count"] == pytest.approx(5700, abs=0.5)
    assert middle["contact_area_fraction"] == pytest.approx(0.028, abs=5e-4)
    assert middle["tangential_stiffness"] == pytest.approx(5.70e9, rel=1e-3, abs=0)
    assert middle["force_limit"] == pytest.approx(1100.0)
    assert middle["slip_scale"] == pytest.approx(0.343e-6, rel=2e-3, abs=0)
    assert heavy["standardised_separation"] == pytest.approx(-0.005, abs=5e-4)
    assert heavy["contact_count"] == pytest.approx(10041, abs=0.5)
    assert heavy["contact_area_fraction"] == pytest.approx(0.063, abs=5e-4)
    assert light["normal_load"] == 500.0


def test_the_summary_is_what_the_interface_says(
    summary: dict[str, Any], joint: ms.Interface
) -> None:
    assert summary["kind"] == "microslip-result"
    assert summary["schema"] == 1
    assert summary["generator"]["name"] == "microslip"
    assert summary["generator"]["version"] == ms.__version__
    assert summary["study"]["surface"]["heights"] == {"kind": "gaussian", "std": 5e-7, "mean": 0.0}
    assert summary["study"]["excitation"]["curve"] == {"from": 1e-9, "to": 1e-4, "points": 200}
    for load, entry in zip(LOADS, summary["joints"], strict=True):
        here = joint.at(normal_load=load)
        for name in (
            *("normal_load", "separation", "contact_count", "contact_area", "normal_stiffness"),
            *("tangential_stiffness", "force_limit", "slip_per_indentation"),
        ):
            assert entry[name] == pytest.approx(getattr(here, name), rel=1e-14, abs=0), name
            assert name in summary["units"]
        for amplitude, row in zip(AMPLITUDES, entry["amplitudes"], strict=True):
            assert row["amplitude"] == amplitude
            assert row["force_amplitude"] == pytest.approx(
                here.backbone(amplitude), rel=1e-14, abs=0
            )
            for name in ("dissipated_energy", "loss_factor", "damping_ratio", "stick_area"):
                assert row[name] == pytest.approx(getattr(here, name)(amplitude), rel=1e-12, abs=0)
        verdicts = [(v["name"], v["value"], v["limit"], v["word"]) for v in entry["validity"]]
        assert verdicts == [(v.name, v.value, v.limit, v.word) for v in here.validity]
        assert {v["name"] for v in entry["validity"]} >= {"plasticity index"}


def test_the_limits_of_the_energy(summary: dict[str, Any], joint: ms.Interface) -> None:
    for load, entry in zip(LOADS, summary["joints"], strict=True):
        here = joint.at(normal_load=load)
        limits = entry["limits"]
        small, large = 1e-11, 1e-4
        assert here.dissipated_energy(small) == pytest.approx(
            limits["cubic_coefficient"] * small**3, rel=1e-3, abs=0
        )
        assert here.dissipated_energy(large) == pytest.approx(
            4.0 * here.force_limit * (large - limits["linear_offset"]), rel=1e-9, abs=0
        )


def test_the_tables_hold_the_numbers_of_the_interface_bit_for_bit(
    folder: Path, joint: ms.Interface
) -> None:
    loops, curves = read(folder / "loops.csv"), read(folder / "curves.csv")
    assert list(loops) == ["normal_load [N]", "amplitude [m]", "displacement [m]", "force [N]"]
    for load in LOADS:
        here = joint.at(normal_load=load)
        for amplitude in AMPLITUDES:
            mine = (loops["normal_load [N]"] == load) & (loops["amplitude [m]"] == amplitude)
            loop = here.loop(amplitude)
            np.testing.assert_array_equal(loops["displacement [m]"][mine], loop.displacement)
            np.testing.assert_array_equal(loops["force [N]"][mine], loop.force)
        mine = curves["normal_load [N]"] == load
        amplitude = curves["amplitude [m]"][mine]
        np.testing.assert_array_equal(amplitude, np.geomspace(1e-9, 1e-4, 200))
        np.testing.assert_array_equal(curves["force_amplitude [N]"][mine], here.backbone(amplitude))
        for column, name in (
            ("dissipated_energy [J]", "dissipated_energy"),
            ("energy_ratio [-]", "energy_ratio"),
            ("loss_factor [-]", "loss_factor"),
            ("damping_ratio [-]", "damping_ratio"),
            ("secant_stiffness [N/m]", "secant_stiffness"),
            ("dissipation_exponent [-]", "dissipation_exponent"),
            ("stick_area [m^2]", "stick_area"),
        ):
            np.testing.assert_array_equal(curves[column][mine], getattr(here, name)(amplitude))


def test_the_netcdf_file_holds_the_numbers_of_the_summary(
    folder: Path, summary: dict[str, Any]
) -> None:
    import xarray as xr

    with xr.open_dataset(folder / "result.nc") as found:
        np.testing.assert_array_equal(found["load"], LOADS)
        np.testing.assert_array_equal(found["amplitude"], AMPLITUDES)
        for load, entry in zip(LOADS, summary["joints"], strict=True):
            here = found.sel(load=load)
            for name in ("contact_count", "tangential_stiffness", "force_limit", "slip_scale"):
                assert float(here[name]) == entry[name]
                assert here[name].attrs["units"]
            for amplitude, row in zip(AMPLITUDES, entry["amplitudes"], strict=True):
                for name in ("dissipated_energy", "loss_factor", "damping_ratio"):
                    assert float(here[name].sel(amplitude=amplitude)) == row[name]
        assert found.attrs["study"] == EXAMPLE.read_text("utf-8")


def test_the_report_is_one_page_that_needs_nothing_else(folder: Path) -> None:
    text = (folder / "report.html").read_text("utf-8")
    assert "Al 2017, milled, tribometer" in text
    for word in ("5700", "1.10 kN", "plasticity index"):
        assert word in text
    assert len(text) < 3_000_000, "it mails well"
    for name in FIGURES:
        assert f'"{name}.' not in text, "figures are in the page, not beside it"


@pytest.mark.parametrize("name", FIGURES)
def test_the_figures_are_pictures(folder: Path, name: str) -> None:
    root = ET.parse(folder / f"{name}.svg").getroot()
    assert root.tag.endswith("svg")
    assert len(list(root.iter("{http://www.w3.org/2000/svg}path"))) > 10


def test_drawing_leaves_pyplot_and_the_settings_alone(tmp_path: Path) -> None:
    import matplotlib

    matplotlib.rcParams["lines.linewidth"] = 7.25
    try:
        ms.Study.load(EXAMPLE).run().save(tmp_path / "result")
        assert matplotlib.rcParams["lines.linewidth"] == 7.25
        first = {p.name: p.read_bytes() for p in (tmp_path / "result").iterdir()}
    finally:
        matplotlib.rcParams["lines.linewidth"] = matplotlib.rcParamsDefault["lines.linewidth"]
    ms.Study.load(EXAMPLE).run().save(tmp_path / "again")
    again = {p.name: p.read_bytes() for p in (tmp_path / "again").iterdir()}
    assert again == first
