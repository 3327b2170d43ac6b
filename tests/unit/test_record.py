"""Records: what a rig wrote comes in as it is, and what cannot come in says why."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

import microslip as ms
from microslip.readers import tables

X = np.array([1e-6, 2.5e-6, -1e-6, 0.0])
T = np.array([10.0, 12.5, -10.0, 0.5])


@pytest.fixture(name="put")
def _put(here: Path) -> Callable[[str, str | bytes], Path]:
    """Write a file into the empty folder where the test is."""

    def put(name: str, content: str | bytes) -> Path:
        data = content if isinstance(content, bytes) else content.encode()
        Path(name).write_bytes(data)
        return Path(name)

    return put


def equal(a: Any, b: Any) -> None:
    np.testing.assert_array_equal(np.asarray(a), np.asarray(b), strict=True)


# -- text ------------------------------------------------------------------------------------------

PLAIN = "Time [s],Position [um],Friction [N]\n0,1,10\n1,2.5,12.5\n2,-1,-10\n3,0,0.5\n"
COMMAS = PLAIN.replace(",", ";").replace(".", ",")
SHAPES: dict[str, str | bytes] = {
    "commas before units": COMMAS.replace(" [", ", ").replace("]", ""),
    "units row with an unknown one": PLAIN.replace(
        "Time [s],Position [um],Friction [N]\n", "Time,Position,Friction,Glow\n[s],[um],[N],[lx?]\n"
    )
    .replace("10\n", "10,1\n")
    .replace(".5\n", ".5,1\n"),
    "strokes": PLAIN.replace("[N]\n", "[N]\n----,----,----\n").replace(",", "\t"),
    "blank lines": PLAIN.replace("[N]\n", "[N]\n\n").replace("\n1,", "\n\n1,") + "\n\n",
    "comments between": PLAIN.replace("\n2,", "\n# pause\n2,"),
    "stamps": "\n".join(
        ("Stamp;" if i == 0 else f"31.01.2024 12:00:0{i};") + line
        for i, line in enumerate(COMMAS.splitlines())
    ),
    "LabVIEW": "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\n"
    "***End_of_Header***\t\n\t\t\nChannels\t2\t\t\nSamples\t4\t4\t\nX_Dimension\tTime\tTime\t\n"
    "***End_of_Header***\t\t\t\n" + PLAIN.replace(",", "\t").replace("[N]\n", "[N]\tComment\n"),
    "other columns": "\n".join(
        line + (",Friction coefficient,Cycle" if i == 0 else f",0.{i},{i}")
        for i, line in enumerate(PLAIN.splitlines())
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_shapes_that_laboratories_write(shape: str, put: Any) -> None:
    path = put("record.csv", SHAPES[shape])
    before = path.read_bytes()
    record = ms.Record.read(path)
    equal(record.time, np.array([0.0, 1.0, 2.0, 3.0]))
    np.testing.assert_allclose(record.displacement, X, rtol=4e-16)
    equal(record.force, T)
    assert record.normal_load is None
    assert record.name == "record"
    assert path.read_bytes() == before
    # What was found is told.
    assert record.notes[0].startswith("record.csv: text (")
    found = [note.partition(":")[0] for note in record.notes if '" by its' in note]
    assert [role for role in found if role != "cycle_number"] == [
        "displacement",
        "force",
        "time",
    ]


def test_shift_jis(tmp_path: Path) -> None:
    """Japanese instruments write it; French and German accents are not mistaken for it."""
    rows = "\n0,1,2\n1,2,-2\n2,1,2\n"
    for head, encoding, called in (
        ("時間(s),変位(μm),摩擦力(N)", "cp932", "Shift-JIS"),
        ("Zeit (s),Weg geglättet (um),Reibkraft größte (N)", "cp1252", "Latin-1"),
        ("temps (s),déplacement (um),effort étéré d’été (N)", "cp1252", "Latin-1"),
    ):
        path = tmp_path / "record.csv"
        path.write_bytes((head + rows).encode(encoding))
        record = ms.Record.read(path)
        assert called in record.notes[0]
        equal(record.force, np.array([2.0, -2.0, 2.0]))


@pytest.mark.parametrize("step", ["", "Step No. 2\n", "\nStep No. 12\n"])
def test_a_heading_that_is_repeated_between_rows(step: str, put: Any) -> None:
    head = "Time,X,Fx\ns,mm,N\n"
    text = f"Step No. 1\n{head}0,1,2\n1,2,-2\n{step}{head}2,1,2\n"
    equal(ms.Record.read(put("record.csv", text)).force, np.array([2.0, -2.0, 2.0]))
    other = text.removesuffix(f"{head}2,1,2\n") + head.replace("mm", "um") + "2,1,2\n"
    with pytest.raises(ms.InputError, match='wanted a number, got "s"'):
        ms.Record.read(put("other.csv", other))


def test_calibration(put: Any) -> None:
    path = put("volts.csv", "LVDT (mV),Force (V),Load (V)\n100,1,2\n200,-2,2\n")
    record = ms.Record.read(
        path,
        calibration={"displacement": "10 um/V", "force": "12.5 N/V", "normal_load": 100},
        zero={"force": "-25 N", "displacement": 1e-6},
        sign={"displacement": -1},
    )
    np.testing.assert_allclose(record.displacement, [-0.0, -1e-6], rtol=1e-14, atol=1e-21)
    equal(record.force, np.array([37.5, 0.0]))
    equal(record.normal_load, np.array([200.0, 200.0]))
    assert (
        'column "Force (V)" by its name, by the calibration 12.5 N/V, column in V, zero at'
        in (record.notes[2])
    )
    # Counts, and a factor that says itself what it is per.
    path = put("counts.csv", "pos,force\n100,1\n200,-2\n")
    record = ms.Record.read(path, calibration={"displacement": "2 nm", "force": "3 N/V"})
    np.testing.assert_allclose(record.displacement, [2e-7, 4e-7], rtol=1e-15)
    equal(record.force, np.array([3.0, -6.0]))
    # A correction of what is calibrated already.
    path = put("new.csv", "pos [um],force [mN]\n100,1\n200,-2\n")
    record = ms.Record.read(path, calibration={"force": "1.5 mN/mN"})
    np.testing.assert_allclose(record.force, [1.5e-3, -3e-3], rtol=1e-15)


@pytest.mark.parametrize(
    ("zero", "wanted"),
    [("mean", 2.0), ("middle", 3.0), ("first", 1.0), (0.5, 0.5), ("500 mN", 0.5), (None, 0.0)],
)
def test_zeros(zero: Any, wanted: float, put: Any) -> None:
    path = put("z.csv", "x [m],F [N]\n0,1\n1,1\n2,1\n3,5\n")
    record = ms.Record.read(path, zero={"force": zero}, sign={"force": -1})
    equal(record.force, -(np.array([1.0, 1.0, 1.0, 5.0]) - wanted))


def test_stated_units_go_before_those_of_the_file(put: Any) -> None:
    path = put("lies.csv", "x [mm],F [N]\n1,2\n3,4\n")
    record = ms.Record.read(path, units={"displacement": "um"})
    equal(record.displacement, np.array([1.0, 3.0]) / 1e6)
    assert 'um as stated (against "mm" by its header)' in record.notes[1]


def test_time_may_be_left_out(put: Any) -> None:
    path = put("t.csv", PLAIN)
    record = ms.Record.read(path, sample_rate=50.0)
    assert (record.time, record.sample_rate) == (None, 50.0)
    assert 'not read: "Time [s]".' in record.notes
    record = ms.Record.read(path, time=False)
    assert (record.time, record.sample_rate) == (None, None)
    assert "time: none; frequencies are not known." in record.notes


def test_an_export_of_a_tribometer_lacks_the_unit_of_its_last_force(put: Any) -> None:
    path = put("umt.csv", "T,X,Fx,Fz\ns,mm,N,\nStep No. 1\n0,0.1,2,-9\n1,0.3,4,-11\n")
    record = ms.Record.read(path)
    equal(record.normal_load, np.array([9.0, 11.0]))
    (note,) = [note for note in record.notes if note.startswith("normal_load")]
    assert 'N as "Fx", sign reversed' in note
    turned = ms.Record.read(path, calibration={"normal_load": "-1 N/N"})
    equal(turned.normal_load, np.array([9.0, 11.0]))
    path = put("own.csv", "x [mm],Ft [N],normal load\n1,2,3\n3,4,5\n")
    with pytest.raises(ms.InputError, match=r'"normal load": no unit; write units='):
        ms.Record.read(path)


def test_rows(put: Any) -> None:
    path = put("r.csv", "x [m],F [N]\nNaN,1\n1,2\n2,3\n3,4\nNaN,1\n4,5\n5,6\n")
    record = ms.Record.read(path, rows=slice(1, 4))
    equal(record.displacement, np.array([1.0, 2.0, 3.0]))
    assert "rows 1 to 4 (without) of 7." in record.notes


# -- wrong files -----------------------------------------------------------------------------------


def test_wrong_paths(put: Any) -> None:
    put("record.csv", PLAIN)
    Path("folder").mkdir()
    for path, message in (
        ("recrod.csv", 'recrod.csv: no such file; did you mean "record.csv"?'),
        ("folder", "folder: wanted a record, got a folder"),
        ("a\nb.csv", "a\\nb.csv: no such file"),
        ("nowhere/b.csv", "nowhere/b.csv: no such file"),
        (3, "path must be the name of a file, got 3"),
    ):
        with pytest.raises(ms.InputError) as caught:
            ms.Record.read(path)  # type: ignore[arg-type]
        assert str(caught.value) == message


def test_a_wrong_row_among_the_first_is_not_skipped(put: Any) -> None:
    """Stated by number, columns would be found even if rows began below it."""
    rows = ["1,2", "2,3", "3,4", "4,5"]
    keywords: dict[str, Any] = {"displacement": "#1", "force": "#2", "units": UNITS}
    for wrong, message in (
        ("2,ERR", 'column "{}": wanted a number, got "ERR"'),
        ("2", 'wanted 2 cells as in line {}, got 1, "2"'),
    ):
        for i in range(4):
            for head in ([], ["x,y"], ["Rig A", "Rate,200"]):
                lines = [*head, *rows[:i], wrong, *rows[i:]]
                path = put("wrong.csv", "\n".join(lines))
                if wrong == "2" and i == 0:
                    continue  # that may be a line of anything
                with pytest.raises(ms.InputError) as caught:
                    ms.Record.read(path, **keywords)
                column = "y" if head == ["x,y"] else "#2"
                assert str(caught.value) == (
                    f"wrong.csv: line {len(head) + i + 1}"
                    + (", " if "column" in message else ": ")
                    + message.format(column if "column" in message else len(head) + 1)
                )


# -- NumPy, MATLAB, HDF5, TDMS ---------------------------------------------------------------------

UNITS = {"displacement": "m", "force": "N"}
COLUMNS: dict[str, Any] = {"displacement": "#1", "force": "#2", "units": UNITS}


def fields_of_numpy(name: str) -> None:
    fields = np.zeros(4, dtype=[("displacement", "f8"), ("force", "f4"), ("state", "S2")])
    fields["displacement"], fields["force"] = X, T
    np.save(name, fields)


def mat_struct(name: str) -> None:
    run = {
        "pos": {"values": X * 1e6, "unit": "um"},
        "friction": {"values": T, "unit": "N"},
        "dt": 0.01,
    }
    savemat(name, {"run": run, "others": np.column_stack([X, T])})


def mat_units_in_names(name: str) -> None:
    savemat(name, {"run": {"disp_um": {"data": X * 1e6}, "force_N": {"data": T}, "fs": 100.0}})


def mat_channels(name: str) -> None:
    channels = np.empty(2, dtype=object)
    channels[0] = {"name": "Position", "unit": "m", "data": X}
    channels[1] = {"name": "Friction", "unit": "N", "data": T}
    savemat(name, {"channels": channels})


def mat73(name: str) -> None:
    def text73(group: h5py.Group, name: str, text: str) -> None:
        data = group.create_dataset(name, data=np.array([[ord(c)] for c in text], dtype="u2"))
        data.attrs["MATLAB_class"] = np.bytes_("char")

    with h5py.File(name, "w", userblock_size=512) as file:
        run = file.create_group("run")
        run["force"] = T[None]
        text73(run, "comment", "in N")
        file["table"] = np.vstack([X, T])  # n x 2 in MATLAB
        file["rate"] = np.array([[7.0]])
        file["none"] = np.array([0, 0], dtype="u8")
        file["none"].attrs["MATLAB_empty"] = 1
        refs = file.create_group("#refs#")
        for i, (title, values) in enumerate((("Position", X), ("Friction", T))):
            refs[f"v{i}"] = values[None]
            text73(refs, f"n{i}", title)
        channels = file.create_group("channels")
        for field, letter in (("data", "v"), ("name", "n")):
            places = [[refs[f"{letter}{i}"].ref] for i in range(2)]
            channels.create_dataset(field, data=places, dtype=h5py.ref_dtype)
    with Path(name).open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def hdf5(name: str) -> None:
    with h5py.File(name, "w") as file:
        file["run1/displacement"], file["run1/force"] = X * 1e3, T.astype("f4")
        file["run1/displacement"].attrs["units"] = "mm"
        file["run1/force"].attrs["unit"] = np.bytes_("N")
        file["run1/normal load"] = np.full((4, 1), 5)
        file["run1/normal load"].attrs["units"] = "kN"
        file["run1"].attrs["sample_rate"] = 100
        file["run1/itself"] = file["run1"]
        file["run1/nowhere"] = h5py.SoftLink("/gone")
        file["picture"] = np.zeros((100, 100))


def hdf5_table(name: str) -> None:
    table = np.zeros(4, dtype=[("position [mm]", "f8"), ("force [N]", "f8"), ("state", "S2")])
    table["position [mm]"], table["force [N]"] = X * 1e3, T
    with h5py.File(name, "w") as file:
        file["log"] = table


def hdf5_two_rates(name: str) -> None:
    with h5py.File(name, "w") as file:
        file["a/x"], file["b/F"] = X, T
        file["a/dt"], file["b/fs"] = 0.5, 3.0


def tdms(name: str) -> None:
    with TdmsWriter(name) as writer:
        for channel, unit, values in (("Position", "mm", X * 1e3), ("Friction", "N", T)):
            properties = {"unit_string": unit, "wf_increment": 0.01}
            writer.write_segment([ChannelObject("Log", channel, values, properties)])
        writer.write_segment([ChannelObject("Log", "Remarks", ["a", "b"])])


PLAIN_MAT = {"x": X, "force": T[:, None], "fs": 200.0, "note": "none"}
IN_STRUCT = {"displacement": "run.pos.values", "force": "run.friction.values"}
BY_COLUMN = {"displacement": "others#1", "force": "others#2", "units": UNITS}
TWO_RATES = 'HDF5 file; two sample rates, 2 Hz by "a/dt" and 3 Hz by "b/fs", so neither is used.'
# A file, what writes it, how it is read, its sample rate, and what the first note says of it.
FILES: list[tuple[str, Callable[[str], object], dict[str, Any], float | None, str]] = [
    ("fields.npy", fields_of_numpy, {"units": UNITS}, None, ""),
    ("matrix.npy", lambda name: np.save(name, np.stack([X, T])), COLUMNS, None, ""),
    ("a.npz", lambda name: np.savez(name, position=X, friction=T, note=np.array("by hand")),
     {"units": UNITS}, None, ""),
    ("5.mat", lambda name: savemat(name, PLAIN_MAT), {"units": UNITS}, 200.0, "MAT-file."),
    ("4.mat", lambda name: savemat(name, PLAIN_MAT, format="4"), {"units": UNITS}, 200.0, ""),
    ("struct.mat", mat_struct, IN_STRUCT, 100.0, ""),
    ("beside.mat", mat_struct, BY_COLUMN, 100.0, ""),
    ("names.mat", mat_units_in_names, {}, 100.0, ""),
    ("channels.mat", mat_channels, {}, None, ""),
    ("73.mat", mat73, {"displacement": "table#1", "force": "run.force", "units": UNITS}, None,
     "MAT-file of version 7.3."),
    ("cells.mat", mat73, {"force": "channels(2).Friction", "units": UNITS}, None, ""),
    ("a.h5", hdf5, {}, 100.0, "HDF5 file."),
    ("table.h5", hdf5_table, {}, None, ""),
    ("rates.h5", hdf5_two_rates, {"units": UNITS}, None, TWO_RATES),
    ("a.tdms", tdms, {}, 100.0, "TDMS file."),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "write", "given", "rate", "note"), FILES, ids=lambda v: str(v)[:9]
)
def test_every_file_gives_the_same_record(
    name: str, write: Any, given: dict[str, Any], rate: float | None, note: str, put: Any
) -> None:
    write(name)
    record = ms.Record.read(name, **given)
    np.testing.assert_allclose(record.displacement, X, rtol=4e-16)
    equal(record.force, T)
    assert record.sample_rate == rate
    assert record.notes[0].startswith(name)
    assert record.notes[0].endswith(note)
    if write is hdf5:
        equal(record.normal_load, np.full(4, 5000.0))


# -- out and in again ------------------------------------------------------------------------------

finite = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e30, max_value=1e30)


@st.composite
def records(draw: st.DrawFn) -> ms.Record:
    size = draw(st.integers(2, 6))
    series = st.lists(finite, min_size=size, max_size=size)
    keywords: dict[str, Any] = {}
    kind = draw(st.sampled_from(["time", "rate", "none"]))
    if kind == "time":
        times = st.lists(finite, min_size=size, max_size=size, unique=True)
        keywords["time"] = sorted(draw(times))
    elif kind == "rate":
        keywords["sample_rate"] = draw(st.floats(1e-3, 1e9))
    load = draw(st.sampled_from(["column", "number", "none"]))
    if load == "column":
        keywords["normal_load"] = np.abs(draw(series))
    elif load == "number":
        keywords["normal_load"] = draw(st.floats(1e-3, 1e6))
    notes = tuple(draw(st.lists(st.text(max_size=30), max_size=2)))
    return ms.Record(draw(series), draw(series), notes=notes, **keywords)


def same(a: ms.Record, b: ms.Record) -> None:
    for key in ("displacement", "force", "normal_load", "time"):
        first, second = getattr(a, key), getattr(b, key)
        assert (first is None) == (second is None), key
        if first is not None:
            assert np.asarray(first).tobytes() == np.asarray(second).tobytes(), key
    assert a.sample_rate == b.sample_rate


unhurried = settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@unhurried
@given(record=records())
def test_csv_reads_back_bit_for_bit(record: ms.Record, put: Any) -> None:
    record.to_csv("out.csv", overwrite=True)
    same(ms.Record.read("out.csv"), record)


@st.composite
def dialects(draw: st.DrawFn) -> dict[str, Any]:
    separator = draw(st.sampled_from([",", ";", "\t", "|", " ", "  ", "; ", ", "]))
    marks = [","] if separator.strip() != "," else []
    return {
        "separator": separator,
        "decimal": draw(st.sampled_from([".", *marks])),
        "units": draw(st.sampled_from([" [%s]", " (%s)", "row", "[row]", "none"])),
        "trailing": draw(st.booleans()) and bool(separator.strip()),
        "newline": draw(st.sampled_from(["\n", "\r\n", "\r"])),
        "encoding": draw(st.sampled_from(["utf-8", "utf-8-sig", "latin-1", "utf-16"])),
        "settings": draw(st.integers(0, 4)),
        "empty": draw(st.integers(0, 3)),
        "missing": draw(st.sampled_from(["", "NaN", "n/a"])),
        "text": draw(st.booleans()) and bool(separator.strip()),
        "quoted": draw(st.booleans()) and separator in (",", ";", "\t"),
        "plus": draw(st.booleans()),
        "names": draw(st.booleans()),
    }


def written(columns: dict[str, tuple[str, list[str]]], way: dict[str, Any]) -> str:
    """Numbers in a dialect, below settings, above rows that hold nothing."""
    separator, end = way["separator"], way["newline"]
    quote = '"{}"' if way["quoted"] else "{}"
    tail = separator if way["trailing"] else ""
    lines = [f"Opérateur{i}: Müller, Rig {i}" for i in range(way["settings"])]
    names, units = list(columns), [unit for unit, _ in columns.values()]
    if way["names"]:
        if "%s" in way["units"]:
            names = [name + way["units"] % unit for name, unit in zip(names, units, strict=True)]
        extra = ["State"] if way["text"] else []
        lines.append(separator.join(quote.format(cell) for cell in [*names, *extra]) + tail)
        if "row" in way["units"]:
            shape = "[{}]" if "[" in way["units"] else "{}"
            cells = [shape.format(unit) for unit in units] + (["-"] if way["text"] else [])
            lines.append(separator.join(quote.format(cell) for cell in cells) + tail)
    for row in zip(*(numbers for _, numbers in columns.values()), strict=True):
        cells = [
            ("+" if way["plus"] and number[0] != "-" else "") + number.replace(".", way["decimal"])
            for number in row
        ]
        cells += ["running"] if way["text"] else []
        lines.append(separator.join(quote.format(cell) for cell in cells) + tail)
    missing = way["missing"] if separator.strip() else way["missing"] or "NaN"
    width = len(columns) + way["text"]
    lines += [separator.join([missing] * width) + tail] * way["empty"]
    return end.join(lines) + end


@settings(unhurried, max_examples=6 * settings().max_examples)
@given(
    way=dialects(),
    numbers=st.lists(st.tuples(finite, finite, finite), min_size=3, max_size=8),
    unit=st.sampled_from(["m", "mm", "um", "µm", "nm"]),
)
def test_any_dialect_is_read_exactly(
    way: dict[str, Any], numbers: list[Any], unit: str, put: Any
) -> None:
    x, f, p = (list(column) for column in zip(*numbers, strict=True))
    # In units of a power of ten the decimal point moves, and nothing is rounded before it is read.
    power = {"m": 0, "mm": 3, "um": 6, "µm": 6, "nm": 9}[unit]
    moved = [str(Decimal(repr(value)).scaleb(power)) for value in x]
    columns = {
        "Position": (unit, moved),
        "Friction": ("N", [repr(value) for value in f]),
        "Normal": ("N", [repr(abs(value)) for value in p]),
    }
    Path("any.txt").write_bytes(written(columns, way).encode(way["encoding"], "replace"))
    keywords: dict[str, Any] = {}
    named = way["names"]
    if not named:
        keywords = {"displacement": "#1", "force": "#2", "normal_load": "#3"}
    if not named or way["units"] == "none":
        keywords["units"] = {"displacement": unit, "force": "N", "normal_load": "N"}
    record = ms.Record.read("any.txt", **keywords)
    assert record.force.tobytes() == np.array(f).tobytes()
    assert np.asarray(record.normal_load).tobytes() == np.abs(p).tobytes()
    if power == 0:
        assert record.displacement.tobytes() == np.array(x).tobytes()
    else:  # the number in the file is rounded, and once more in metres
        np.testing.assert_array_equal(
            record.displacement, np.array([float(cell) for cell in moved]) / 10.0**power
        )
        np.testing.assert_allclose(record.displacement, x, rtol=4e-16, atol=1e-320)


def test_csv_is_not_overwritten(put: Any) -> None:
    record = ms.Record(X, T, 500.0, sample_rate=10.0, notes=("from a\nrig\0",))
    record.to_csv("a.csv")
    assert Path("a.csv").read_text(encoding="utf-8") == (
        "# sample_rate = 10.0 Hz\n# normal_load = 500.0 N\n# note: from a\\nrig\\x00\n"
        "displacement [m],force [N]\n1e-06,10.0\n2.5e-06,12.5\n-1e-06,-10.0\n0.0,0.5\n"
    )
    with pytest.raises(ms.InputError) as caught:
        ms.Record(T, X).to_csv("a.csv")
    assert str(caught.value) == "a.csv: exists; replace it with overwrite=True"
    same(ms.Record.read("a.csv"), record)
    ms.Record(T, X).to_csv("a.csv", overwrite=True)
    equal(ms.Record.read("a.csv").force, X)


def test_stated_values_go_before_those_of_the_file(put: Any) -> None:
    ms.Record(X, T, 500.0, sample_rate=10.0).to_csv("a.csv")
    record = ms.Record.read("a.csv", sample_rate=20.0, normal_load=600.0)
    assert (record.sample_rate, record.normal_load) == (20.0, 600.0)
    assert ms.Record.read("a.csv", normal_load="2 kN").normal_load == 2000.0
    assert ms.Record.read("a.csv", normal_load=False).normal_load is None
    assert 'normal_load: 500 N by "line 2" of the file.' in ms.Record.read("a.csv").notes


# -- scale, speed, the real one --------------------------------------------------------------------


@pytest.mark.parametrize("factor", ["1e-3", "1e-6", "1e-9", "1e3", "2.5", "1e-30"])
def test_powers_of_ten_are_rounded_once(factor: str) -> None:
    values = np.random.default_rng(0).uniform(-1e6, 1e6, 2000).round(3)
    scaled = values.copy()
    tables.scale(scaled, Decimal(factor))
    # The nearest double to the double in the file times the factor, found without doubles.
    exact = np.array([float(Decimal(value) * Decimal(factor)) for value in values.tolist()])
    if factor in ("2.5", "1e-30"):
        np.testing.assert_allclose(scaled, exact, rtol=3e-16)
    else:
        np.testing.assert_array_equal(scaled, exact)


@pytest.mark.parametrize("decimal", [".", ","])
def test_a_decimal_sign_that_comes_late(decimal: str, put: Any) -> None:
    rows = ["0;1"] * 300 + [f"2{decimal}5;3{decimal}5"]
    record = ms.Record.read(put("late.csv", "\n".join(["x [m];F [N]", *rows])))
    assert (record.displacement[-1], record.force[-1]) == (2.5, 3.5)
    assert ("decimal commas" in record.notes[0]) == (decimal == ",")


def test_binary_files_hold_real_numbers(put: Any) -> None:
    np.save("o.npy", np.array([print, 1], dtype=object), allow_pickle=True)
    with pytest.raises(ms.InputError, match="not a usable npy file of real numbers"):
        ms.Record.read("o.npy")
    with h5py.File("n.h5", "w") as file:
        file["x"], file["F"] = X, np.array([1.0, np.nan, 2.0, 3.0])
    with pytest.raises(
        ms.InputError, match=r'^n\.h5: sample 1, column "F": wanted a number, got nan'
    ):
        ms.Record.read("n.h5", units=UNITS)
