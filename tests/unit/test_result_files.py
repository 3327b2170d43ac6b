"""The files of a result: each number as the API gives it, in every reader, the same bytes again."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from studies import AMPLITUDES, CURVE, LOADS, SURFACE, SURFACES, edited

import microslip as ms
from microslip._core.quantities import QUANTITY_UNITS
from microslip.report.predicted.numbers import FLAGS

FORMATS = ('formats = ["csv"]', 'formats = ["netcdf", "csv"]\nreport = false')
HISTORY = 'history = { file = "record.csv", column = "x" }'
FULL = edited(
    ('title = "A joint"', 'title = "Füge, µ = 0.55"'),
    ("poisson_ratio = 0.33", 'poisson_ratio = 0.33\nhardness = "1.2 GPa"'),
    (LOADS, '["2 kN", "500 N", "1 kN"]'),  # in no order
    (CURVE, f"{CURVE}\n{HISTORY}"),
    FORMATS,
)
BY_FORCE = edited((f"amplitudes = {AMPLITUDES}", 'force_amplitudes = ["200 N", "50 N"]'), FORMATS)
TABLE = edited((SURFACE, SURFACES["table"]), FORMATS)
CASES = {"full": FULL, "by force": BY_FORCE, "table": TABLE}


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    home = tmp_path_factory.mktemp("case")
    record = np.cumsum(np.random.default_rng(7).standard_normal(3000)) * 0.05
    (home / "record.csv").write_text("x [um]\n" + "\n".join(map(repr, record.tolist())))
    result = ms.Study.from_toml(CASES[request.param], folder=home).run()
    result.save(home / "result")
    return result, home / "result"


@pytest.fixture
def result(case: tuple[ms.Result, Path]) -> ms.Result:
    return case[0]


@pytest.fixture
def folder(case: tuple[ms.Result, Path]) -> Path:
    return case[1]


def driven(result: ms.Result) -> str:
    by_force = result.study.excitation.force_amplitudes is not None
    return "force_amplitude" if by_force else "amplitude"


def same(got: Any, wanted: Any) -> None:
    """Bit for bit, and of the same type."""
    got, wanted = np.asarray(got), np.asarray(wanted)
    assert got.dtype == wanted.dtype
    assert got.shape == wanted.shape
    assert got.tobytes() == wanted.tobytes()


def expected(result: ms.Result) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """What the file must hold, from the result itself."""
    by = driven(result)
    wanted: dict[str, tuple[tuple[str, ...], Any]] = {
        "load": (("load",), [joint.normal_load for joint in result.joints]),
        by: ((by,), getattr(result.rows[0], by)),
        "sample": (("sample",), np.arange(512, dtype=np.int32)),
        "point": (("point",), np.arange(20, dtype=np.int32)),
        "curve_amplitude": (("point",), result.curves[0].amplitude),
    }
    for name in ("displacement", "force"):
        arrays = [[getattr(loop, name) for loop in loops] for loops in result.loops]
        wanted[name] = (("load", by, "sample"), arrays)
    entries = result.summary["joints"]
    for name, value in entries[0].items():
        if isinstance(value, float) and name != "normal_load":
            wanted[name] = (("load",), [entry[name] for entry in entries])
    for tables, prefix, dim in (
        (result.rows, "", by),
        (result.curves, "curve_", "point"),
        (result.histories, "history_", "history_sample"),
    ):
        for name in tables[0].columns() if tables else ():
            if prefix + name not in (by, "curve_amplitude"):
                arrays = [table.columns()[name] for table in tables]
                wanted[prefix + name] = (("load", dim), arrays)
    if result.histories:
        count = np.arange(len(result.histories[0].force), dtype=np.int32)
        wanted["history_sample"] = (("history_sample",), count)
    for place, verdict in enumerate(result.joints[0].validity):
        name = "validity_" + verdict.name.replace(" * ", "_").replace(" ", "_")
        found = [joint.validity[place] for joint in result.joints]
        wanted[name] = (("load",), [np.nan if v.value is None else v.value for v in found])
        words = np.array([FLAGS.index(v.word) for v in found], dtype=np.int8)
        wanted[f"{name}_word"] = (("load",), words)
    return {name: (dims, np.asarray(values)) for name, (dims, values) in wanted.items()}


# -- netCDF: what is in it, in every reader ------------------------------------------------------


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_every_reader_sees_the_numbers_of_the_api(
    result: ms.Result, folder: Path, engine: str
) -> None:
    wanted = expected(result)
    with xarray.open_dataset(folder / "result.nc", engine=engine) as file:
        found, provenance = {str(name): v.load() for name, v in file.variables.items()}, file.attrs
    assert set(found) == set(wanted)
    for name, variable in found.items():
        assert variable.dims == wanted[name][0], name
        same(variable.values, wanted[name][1])
        plain = name.removeprefix("curve_").removeprefix("history_")
        unit = QUANTITY_UNITS.get({"load": "normal_load"}.get(plain, plain), "-")
        assert variable.attrs["units"] == ("1" if unit == "-" else unit), name
        assert variable.attrs["long_name"], name
    assert provenance == {
        "title": result.study.title,
        "kind": "microslip-result",
        "source": f"microslip {ms.__version__}",
        "kernel": result.summary["generator"]["kernel"],
        "study": result.study.text,
        "notes": "\n".join(result.summary["notes"]),
        "schema": 1,
    }


# Of the case that has everything in it; the second is made by a process of its own.
@pytest.mark.parametrize("case", ["full"], indirect=True)
def test_two_results_are_the_same_bytes(result: ms.Result, folder: Path, tmp_path: Path) -> None:
    """In another process, folder and second, with another order of sets."""
    program = (
        "import sys; import microslip as ms; from pathlib import Path; "
        "study, home, out = map(Path, sys.argv[1:]); "
        "ms.Study.from_toml(study.read_text('utf-8'), folder=home).run().save(out)"
    )
    out = tmp_path / "elsewhere" / "again"
    given = tmp_path / "study.toml"
    given.write_text(result.study.text, "utf-8")
    subprocess.run(
        [sys.executable, "-c", program, given, folder.parent, out],
        env=os.environ | {"PYTHONHASHSEED": "4711", "TZ": "Asia/Kathmandu"},
        check=True,
        timeout=120,
    )
    first, again = ({p.name: p.read_bytes() for p in f.iterdir()} for f in (folder, out))
    assert set(first) == set(result.summary["files"])
    # Each names the files of the study as they are seen from where it stands.
    for there, study in ((folder, first.pop("study.toml")), (out, again.pop("study.toml"))):
        assert study.decode("utf-8") == result.study.text_for(there)
    assert again == first


def test_a_saved_study_runs_where_it_stands(
    result: ms.Result, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = folder / "study.toml"
    assert ms.Study.load(study).run().summary["joints"] == result.summary["joints"]
    assert ("../record.csv" in study.read_text("utf-8")) == bool(result.histories)
    # From a folder of its own on, whatever the current one is; comments stay.
    monkeypatch.chdir(tmp_path)
    text = "# mine\n" + result.study.text
    (folder.parent / "mine.toml").write_text(text, "utf-8")
    again = ms.Study.load(folder.parent / "mine.toml").run()
    again.save("deep/er")
    saved = Path("deep/er/study.toml")
    assert saved.read_text("utf-8").startswith("# mine\n")
    repeated = ms.Study.load(saved).run()
    assert repeated.summary["joints"] == again.summary["joints"]
    for one, other in zip(repeated.histories, again.histories, strict=True):
        np.testing.assert_array_equal(one.force, other.force)


# -- tables ---------------------------------------------------------------------------------------


def test_the_tables_hold_the_numbers_of_the_result(result: ms.Result, folder: Path) -> None:
    tables = {"curves": result.curves}
    tables |= {"history": result.histories} if result.histories else {}
    for name, wanted in tables.items():
        head, *rows = (folder / f"{name}.csv").read_text("utf-8").splitlines()
        columns = ["normal_load", *wanted[0].columns()]
        assert head.split(",") == [f"{column} [{QUANTITY_UNITS[column]}]" for column in columns]
        found = np.array([row.split(",") for row in rows], dtype=float)
        blocks = np.split(found, len(wanted))  # loads one below the other
        for joint, table, block in zip(result.joints, wanted, blocks, strict=True):
            assert (block[:, 0] == joint.normal_load).all()
            for values, got in zip(table.columns().values(), block.T[1:], strict=True):
                same(got, values)
    assert {p.stem for p in folder.glob("*.csv")} == {*tables, "loops"}
