"""Sweeps: labels, shapes, files, and each error."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import Any

import h5py
import netCDF4
import numpy as np
import pytest
import xarray
from own_laws import LAWS

import microslip as ms

JOINT = ms.Interface.examples()[0]
LOADS = [500.0, 2000.0, 5000.0]
AMPLITUDES = np.array([0.0, 1e-8, 1e-7, 1e-6])
SWEPT = ms.sweep(
    JOINT,
    normal_load=LOADS,
    amplitude=AMPLITUDES,
    quantities=["dissipated_energy", "loss_factor", "force_limit", "contact_count"],
)


def refusal(call: Any, *args: Any, **kwargs: Any) -> str:
    with pytest.raises(ms.InputError) as caught:
        call(*args, **kwargs)
    return str(caught.value)


# -- labels and shapes -----------------------------------------------------------------------------


def test_labels() -> None:
    assert SWEPT.dims == ("normal_load", "amplitude")
    assert SWEPT.sizes == {"normal_load": 3, "amplitude": 4}
    assert SWEPT.shape == (3, 4)
    assert list(SWEPT) == ["dissipated_energy", "loss_factor", "force_limit", "contact_count"]
    assert len(SWEPT) == 4
    assert "loss_factor" in SWEPT
    assert "normal_load" in SWEPT
    assert "stick_area" not in SWEPT
    assert SWEPT["loss_factor"].shape == (3, 4)
    assert SWEPT.variables["force_limit"].dims == ("normal_load",)
    np.testing.assert_array_equal(SWEPT["force_limit"], 0.55 * np.array(LOADS))
    np.testing.assert_array_equal(SWEPT["amplitude"], AMPLITUDES)
    # What was not given is there, without a dimension.
    assert SWEPT["friction_coefficient"] == 0.55
    assert type(SWEPT["friction_coefficient"]) is float
    assert SWEPT.variables["dissipated_energy"].attributes == {
        "units": "J", "long_name": "energy dissipated in a cycle",
    }  # fmt: skip
    assert SWEPT.attributes["source"] == f"microslip {ms.__version__}"


def test_a_joint_given_by_its_separation_keeps_it() -> None:
    joint = JOINT.at(separation=4.1e-7)
    swept = ms.sweep(joint, amplitude=1e-7, quantities=["separation"])
    assert swept["separation"] == 4.1e-7


@pytest.mark.parametrize(
    "law", [e for cls in LAWS if not issubclass(cls, ms.Interface) for e in cls.examples()], ids=str
)
def test_laws_without_a_load(law: ms.BackboneLaw) -> None:
    a = np.geomspace(1e-8, 1e-4, 5)
    names = [
        "dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio", "secant_stiffness",
        "dissipation_exponent",
    ]  # fmt: skip
    shares: list[float] = []
    quantities = [*names, "force_amplitude", "tangent_stiffness", "force_limit"]
    swept = ms.sweep(law, amplitude=a, quantities=quantities, progress=shares.append)
    assert swept.dims == ("amplitude",)
    assert shares == [1.0]
    for name in names:
        np.testing.assert_array_equal(swept[name], getattr(law, name)(a))
    np.testing.assert_array_equal(swept["force_amplitude"], law.backbone(a))
    np.testing.assert_array_equal(swept["tangent_stiffness"], law.backbone_stiffness(a))
    assert swept["force_limit"] == law.force_limit
    assert np.shape(ms.sweep(law, amplitude=1e-6)["loss_factor"]) == ()


# -- files -----------------------------------------------------------------------------------------


def test_netcdf_is_read_by_all(tmp_path: Path) -> None:
    path = SWEPT.to_netcdf(tmp_path / "sweep.nc")
    for engine in ("h5netcdf", "netcdf4"):
        with xarray.open_dataset(path, engine=engine) as data:
            assert dict(data.sizes) == SWEPT.sizes
            for name in (*SWEPT.variables, *SWEPT.coords):
                np.testing.assert_array_equal(data[name], SWEPT[name])
            assert data["amplitude"].attrs["units"] == "m"
            assert data.attrs["Conventions"] == "CF-1.11"
            assert set(data.coords) == {"friction_coefficient", "normal_load", "amplitude"}
    with netCDF4.Dataset(path) as file:
        np.testing.assert_array_equal(file["loss_factor"][:], SWEPT["loss_factor"])
        assert file["loss_factor"].dimensions == SWEPT.dims
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["loss_factor"][:], SWEPT["loss_factor"])
    assert [entry.name for entry in tmp_path.iterdir()] == ["sweep.nc"]


def test_csv(tmp_path: Path) -> None:
    path = SWEPT.to_csv(tmp_path / "sweep.csv")
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = list(csv.reader(file))
    assert head == [
        "friction_coefficient [-]", "normal_load [N]", "amplitude [m]", "dissipated_energy [J]",
        "loss_factor [-]", "force_limit [N]", "contact_count [-]",
    ]  # fmt: skip
    assert len(rows) == 12
    numbers = np.array(rows, dtype=float)
    np.testing.assert_array_equal(numbers[:, 1], np.repeat(LOADS, 4))
    np.testing.assert_array_equal(numbers[:, 2], np.tile(AMPLITUDES, 3))
    np.testing.assert_array_equal(numbers[:, 4].reshape(3, 4), SWEPT["loss_factor"])
    np.testing.assert_array_equal(numbers[:, 6], np.repeat(SWEPT["contact_count"], 4))
    single = ms.sweep(JOINT, amplitude=1e-7).to_csv(tmp_path / "single.csv")
    assert len(single.read_text(encoding="utf-8").splitlines()) == 2


@pytest.mark.parametrize("kind", ["to_netcdf", "to_csv"])
def test_nothing_is_overwritten_unasked(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "mine"
    path.write_text("mine", encoding="utf-8")
    write = getattr(SWEPT, kind)
    assert refusal(write, path) == f"{path}: exists; replace it with overwrite=True"
    assert path.read_text(encoding="utf-8") == "mine"
    assert write(path, overwrite=True) == path
    assert path.read_bytes()[:4] in (b"\x89HDF", b"fric")
    folder = tmp_path / "folder"
    folder.mkdir()
    assert refusal(write, folder, overwrite=True) == f"{folder}: is a folder"
    nowhere = tmp_path / "no" / "file"
    assert refusal(write, nowhere) == (f"{nowhere}: cannot be written: no such file or directory")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["folder", "mine"]
    mask = os.umask(0)
    os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~mask


@pytest.mark.parametrize("kind", ["to_netcdf", "to_csv"])
def test_a_file_that_appears_meanwhile_is_kept(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "mine"
    link = os.link

    def late(source: Any, target: Any) -> None:
        path.write_text("mine", encoding="utf-8")
        link(source, target)

    def without_links(source: Any, target: Any) -> None:
        raise PermissionError("no links here")

    monkeypatch.setattr(os, "link", late)
    message = f"{path}: exists; replace it with overwrite=True"
    assert refusal(getattr(SWEPT, kind), path) == message
    assert path.read_text(encoding="utf-8") == "mine"
    path.unlink()
    monkeypatch.setattr(os, "link", without_links)
    getattr(SWEPT, kind)(path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["mine"]
