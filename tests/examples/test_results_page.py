"""docs/results.md names every file, key, dimension and attribute of a result, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studies import AMPLITUDES, CURVE, LOADS, SURFACE, SURFACES, edited

import microslip as ms
from microslip._core.quantities import QUANTITIES

PAGE = (Path(__file__).parents[2] / "docs" / "results.md").read_text(encoding="utf-8")
FORMATS = ('formats = ["csv"]', 'formats = ["netcdf", "csv", "svg", "png"]')
HISTORY = 'history = { file = "record.csv", column = "x" }'
FULL = edited(
    ("poisson_ratio = 0.33", 'poisson_ratio = 0.33\nhardness = "1.2 GPa"'),
    (CURVE, f"{CURVE}\n{HISTORY}"),
    FORMATS,
)
MEASURED = 'law = "face"\nscan = "z.npy"\nunit = "um"\npixel = "1 um"\n'
STUDIES = {
    "full": FULL,
    "by force": edited((f"amplitudes = {AMPLITUDES}", 'force_amplitudes = ["50 N"]'), FORMATS),
    "table": edited((SURFACE, SURFACES["table"]), (LOADS, '"1 kN"'), FORMATS),
    "measured": edited((SURFACE, MEASURED), (LOADS, '"0.02 N"'), FORMATS),
}


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> list[ms.Result]:
    home = tmp_path_factory.mktemp("page")
    (home / "record.csv").write_text("x [um],N [kN]\n0,1\n1,2\n-1,1\n")
    x = np.arange(64) / 8.0
    np.save(home / "z.npy", 0.1 * np.outer(np.sin(x), np.cos(x)))
    return [ms.Study.from_toml(text, folder=home).run() for text in STUDIES.values()]


def section(title: str) -> str:
    found = re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


def rows(text: str) -> list[list[str]]:
    """Cells of the tables, without their heads."""
    cells = [
        [c.strip() for c in line.split("|")[1:-1]] for line in text.splitlines() if "|" in line
    ]
    rules = [i for i, row in enumerate(cells) if set("".join(row)) <= {"-", " "}]
    return [row for i, row in enumerate(cells) if i not in rules and i + 1 not in rules]


def names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def test_every_file_is_named(results: list[ms.Result]) -> None:
    told: set[str] = set()
    for name, when, _ in rows(section("Files")):
        suffixes = [""] if "." in name else [f".{kind}" for kind in ("svg", "png")]
        told |= {n + suffix for n in names(name) for suffix in suffixes}
        assert when
    written = {name for result in results for name in result.summary["files"]}
    assert told == written


def test_every_attribute_of_the_file_is_named(results: list[ms.Result]) -> None:
    table = section("result.nc").rpartition("| attribute of the file |")[2]
    told = {n for row in rows("| attribute of the file |" + table) for n in names(row[0])}
    assert told == {name for result in results for name in result.data.attributes}


def keys_of(value: Any, path: str = "") -> Iterator[str]:
    """Paths of all keys; lists do not show."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield f"{path}{key}"
            # Keys of a study, names of quantities; a scan has a test of its own.
            if f"{path}{key}" not in (*("study", "units", "scan", "joints.sensitivities"),):
                yield from keys_of(inner, f"{path}{key}.")
    elif isinstance(value, list):
        for inner in value:
            yield from keys_of(inner, path)


def test_every_key_of_the_summary_is_named(results: list[ms.Result]) -> None:
    found = {key for result in results for key in keys_of(result.summary)}
    first, entries = section("summary.json").split("An entry of `joints`")
    told = {names(row[0])[0] for row in rows(first)}
    for top in rows(first):
        if names(top[0]) == ["generator"]:
            told |= {f"generator.{name}" for name in names(top[1])}
    inside = {names(row[0])[0]: row[1] for row in rows(entries)}
    told |= {f"joints.{key}" for key in inside}
    told |= {f"joints.validity.{name}" for name in names(inside["validity"])}
    for key in sorted(found - told):
        holder, _, name = key.rpartition(".")
        assert holder.startswith("joints"), key
        assert name in QUANTITIES, key
    assert not told - found


def test_every_key_of_a_scan_is_named(results: list[ms.Result]) -> None:
    told = next(row[1] for row in rows(section("summary.json")) if names(row[0]) == ["scan"])
    found = next(result.summary["scan"] for result in results if "scan" in result.summary)
    assert set(names(told)) == set(found)
