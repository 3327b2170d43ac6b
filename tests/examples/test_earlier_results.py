"""Studies of an earlier microslip run and give the same numbers; its results still open."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from command import run

import microslip as ms

EARLIER = Path(__file__).parents[1] / "earlier"
STUDIES = EARLIER / "studies"
RESULTS = EARLIER / "results"
WORDS = {"slip_scale_meaning", "meaning", "message", "notes", "reason", "remedy", "files"}
WORDS |= {"generator", "version", "limit", "word", "caption", "warnings"}
"""Prose, lists of files, versions, and limits of rules, which judge a number and are none."""
CHANGED = {"chord_stiffness", "evaluations", "oscillator", "frequency", "frequency_at_rest"}
CHANGED |= {"frequency_in_slip", "interface_damping_ratio", "varying_normal_load", "energy_share"}
CHANGED |= {"smallest_normal_load", "largest_normal_load", "flatness"}
CHANGED |= {"limits", "cubic_coefficient", "linear_offset"}
"""Meant: noise has no part in the stiffness at reversals any more, fits go another way to the
same minimum, and studies have no oscillator and no varying normal load any more;
the flatness of a scan is its maximum height; asymptotes of the energy are gone."""


def differences(old: Any, new: Any, tolerance: float, where: str = "") -> Iterator[str]:
    """What was told and is told no more, or otherwise; there may be more than there was."""
    if isinstance(old, dict):
        for key in old.keys() - WORDS - CHANGED:
            if key in new:
                yield from differences(old[key], new[key], tolerance, f"{where}.{key}")
            else:
                yield f"{where}.{key} is gone"
    elif isinstance(old, list) and all(isinstance(item, dict) and "name" in item for item in old):
        # Rules by their names, as others may come between them.
        later = {item["name"]: item for item in new}
        for item in old:
            if item["name"] not in CHANGED:
                yield from differences(item, later.get(item["name"], {}), tolerance, where)
    elif isinstance(old, list):
        if len(old) != len(new):
            yield f"{where}: {len(old)} and {len(new)} items"
        for index, pair in enumerate(zip(old, new, strict=False)):
            yield from differences(*pair, tolerance, f"{where}[{index}]")
    elif isinstance(old, float) and isinstance(new, (int, float)):
        if not np.isclose(new, old, rtol=tolerance, atol=0.0, equal_nan=True):
            yield f"{where}: {old} and {new}"
    elif isinstance(old, str) and " " in old and old.endswith("."):
        if not isinstance(new, str):  # a sentence may be said in other words
            yield f"{where}: {old!r} and {new!r}"
    elif old != new:
        yield f"{where}: {old!r} and {new!r}"


@pytest.fixture
def studies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the studies, and the current folder."""
    shutil.copytree(STUDIES, tmp_path / "studies")
    monkeypatch.chdir(tmp_path / "studies")
    return tmp_path / "studies"


def summary(folder: Path) -> Any:
    return json.loads((folder / "summary.json").read_text("utf-8"))


def done(*words: str) -> None:
    outcome = run(*words)
    assert outcome.exit_code == 0, outcome.output


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.json")), ids=lambda path: path.stem)
def test_an_earlier_study_runs_and_gives_the_same_numbers(path: Path) -> None:
    old = json.loads(path.read_text("utf-8"))
    new = json.loads(json.dumps(ms.Study.load(path.with_suffix(".toml")).run().summary))
    # Sums in another order of another BLAS: some roundings of numbers that hardly cancel.
    assert not list(differences(old, new, 1e-12))


# Each command over its own earlier result.
COMMANDS = {
    "predicted": "predict joint.toml",
    "measured": "measure record.csv",
    "scanned": "surface scan.npy --pixel 1um --unit um --cutoff 4um",
    "figures": "figures --only 19.13",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_an_earlier_result_is_known_and_gives_way(name: str, studies: Path) -> None:
    target = studies / name
    shutil.copytree(RESULTS / name, target)
    words = (*COMMANDS[name].split(), "-o", name)
    refused = run(*words)
    assert refused.exit_code == 2
    assert "--overwrite" in refused.stderr
    old = summary(target)
    done(*words, "--overwrite")
    new = summary(target)
    if name == "predicted":
        assert not list(differences(old, new, 1e-12))
    if name == "measured":
        # That of the joint which made the record; the polygon was 0.19 % below.
        energy = ms.Interface.examples()[0].dissipated_energy(1e-6)
        found = new["records"][0]["mean"]["dissipated_energy"]["value"]
        assert found == pytest.approx(energy, rel=3e-4)


def test_the_study_in_an_earlier_result_runs_where_it_stands(studies: Path) -> None:
    shutil.copytree(RESULTS / "predicted", studies / "predicted")
    old, path = summary(RESULTS / "predicted"), studies / "predicted" / "study.toml"
    with pytest.raises(ms.StudyError, match=r"oscillator: removed in 0\.3"):
        ms.Study.load(path)
    text = path.read_text("utf-8")
    before, after = text.index("[oscillator]"), text.index("[output]")
    path.write_text(text[:before] + text[after:], "utf-8")
    new = ms.Study.load(studies / "predicted" / "study.toml").run().summary
    assert not list(differences(old["joints"], new["joints"], 1e-12))


def test_earlier_arrays_open_with_the_names_that_they_have_today(studies: Path) -> None:
    with xarray.open_dataset(RESULTS / "predicted" / "result.nc", engine="h5netcdf") as old:
        new = ms.Study.load(studies / "joint.toml").run().to_xarray()
        kept = {name for name in old.variables if not str(name).startswith("oscillator_")} - CHANGED
        assert kept <= set(new.variables)
        for name, values in old[sorted(kept & set(old.data_vars))].data_vars.items():
            assert values.attrs.get("units") == new[name].attrs.get("units")
            if values.dtype.kind == "f":
                scale = float(np.nanmax(np.abs(values.values)))
                np.testing.assert_allclose(new[name], values, rtol=1e-12, atol=1e-12 * scale)


def test_what_earlier_commands_handed_on_is_taken(studies: Path) -> None:
    """The record of a rig and an identified joint."""
    assert len(ms.Record.read("record.csv")) > 0
    shutil.copytree(RESULTS / "identified", studies / "identified")
    done("predict", "identified/joint.toml", "-o", "joint")
    fit = summary(RESULTS / "identified")["identification"]
    found = fit["parameters"]["friction_coefficient"]["value"]
    joint = summary(studies / "joint")["joints"][0]
    assert joint["force_limit"] == pytest.approx(found * joint["normal_load"], rel=1e-12)
