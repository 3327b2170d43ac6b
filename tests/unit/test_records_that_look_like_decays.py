"""Records of a tribometer that have a time and a displacement, as a ring-down has."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command import run

TIME = np.arange(2000) / 1000.0
X = 10.0 * np.cos(2.0 * np.pi * 10.0 * TIME)
FALLING = np.mod(20.0 * np.pi * TIME, 2.0 * np.pi) < np.pi
FORCE = np.where(FALLING, np.maximum(30.0 - 10.0 * (10.0 - X), -30.0),
                 np.minimum(-30.0 + 10.0 * (10.0 + X), 30.0))  # fmt: skip
ENERGY = 4.0 * 30.0 * (10e-6 - 3e-6)
NOISE = 0.02 * np.random.default_rng(1).normal(size=TIME.size)


def written(folder: Path, **columns: np.ndarray) -> str:
    heads = {"time [s]": TIME, "displacement [um]": X, **columns}
    rows = zip(*(values.tolist() for values in heads.values()), strict=True)
    lines = [",".join(heads), *(",".join(map(repr, row)) for row in rows)]
    (folder / "r.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return "r.csv"


@pytest.mark.parametrize(
    ("columns", "options"),
    [
        ({"Reibkraft [N]": FORCE}, ()),
        ({"Friction force [g]": FORCE / 9.80665e-3}, ()),
        ({"force [g]": FORCE / 9.80665e-3}, ()),
        ({"COF": FORCE / 100.0, "normal load [N]": 100.0 + 0.0 * X}, ()),
        ({"friction coefficient [%]": FORCE}, ("--normal-load", "100 N")),
        ({"µ": FORCE / 100.0}, ("--normal-load", "100 N")),
    ],
)
def test_forces_by_other_names_are_read(
    columns: dict[str, np.ndarray],
    options: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = run("measure", written(tmp_path, **columns), *options, "--json")
    assert outcome.exit_code == 0, outcome.stderr

    (record,) = json.loads(outcome.stdout)["records"]
    assert record["mean"]["dissipated_energy"]["value"] == pytest.approx(ENERGY, rel=3e-3)
    assert record["mean"]["force_amplitude"]["value"] == pytest.approx(30.0, rel=1e-3)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"Force A [N]": FORCE, "Force B [N]": FORCE}, "2 columns could be it"),
        ({}, "must decay"),
        ({"displacement [um]": X + NOISE}, "name its column of the force, --force"),
        ({"COF": FORCE / 100.0}, "--normal-load"),
    ],
)
def test_what_is_no_loop_is_no_decay_either(
    columns: dict[str, np.ndarray],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = run("measure", written(tmp_path, **columns))
    assert outcome.exit_code != 0
    assert message in outcome.stderr
    assert "damping" not in outcome.stdout
