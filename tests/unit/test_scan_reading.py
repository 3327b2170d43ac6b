"""Files of scans: what is in them comes in to the last bit, and what cannot come in says why."""

from __future__ import annotations

import io
import struct
import tracemalloc
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
from cases import parsed_here
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat

import microslip as ms
from microslip.readers import instruments
from microslip.readers.files import limited
from microslip.readers.instruments import on_grid

REAL = Path(__file__).parents[3] / "shared/data/scans"
Z = np.array([[1.0, 2.5, -3.0], [0.5, 0.0, 4.0], [7.0, -8.0, 9.0], [1.0, 1.0, 2.0]])
UM = {"unit": "um", "pixel": "2 um"}


pytestmark = pytest.mark.usefixtures("here")


def real(name: str) -> Path:
    path = REAL / name
    if not path.exists():
        pytest.skip(f"{name} is not at hand: ../shared/data/scans is absent")
    return path


def put(name: str, content: str | bytes) -> str:
    Path(name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return name


def refused(says: str, name: str, *args: Any, **more: Any) -> str:
    with pytest.raises(ms.InputError, match=says) as info:
        ms.Scan.read(name, *args, **more)
    message = str(info.value)
    assert "\n" not in message
    assert str(name)[:60] in message
    return message


# -- arrays ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["npy", "npz", "mat", "mat73", "csv", "xyz", "gwyddion"])
def test_every_file_gives_the_same_scan(kind: str) -> None:
    z = Z.copy()
    z[1, 2] = np.nan
    how: dict[str, Any] = dict(UM)
    if kind == "npy":
        np.save("a.npy", z)
    elif kind == "npz":
        np.savez("a.npz", heights=z, dx=2.0)
    elif kind == "mat":
        savemat("a.mat", {"Z": z, "comment": "by hand", "dx": 2.0})
    elif kind == "mat73":
        with h5py.File("a.mat73", "w", userblock_size=512) as file:
            file["Z"] = z.T
        head = b"MATLAB 7.3 MAT-file".ljust(512)
        Path("a.mat73").write_bytes(head + Path("a.mat73").read_bytes()[512:])
        how["format"] = "mat"
    elif kind == "csv":
        put("a.csv", "\n".join(",".join(f"{v:g}" for v in row) for row in z))
        how["format"] = "matrix"  # three columns would be taken for x, y and z
    elif kind == "xyz":
        del how["pixel"]
        rows = [f"{2 * j} {2 * i} {z[i, j]:g}" for i in range(4) for j in range(3)]
        np.random.default_rng(0).shuffle(rows)
        put("a.xyz", "\n".join(rows))
    else:
        lines = ["# Channel: Height", "# Width: 6 µm", "# Height: 8 µm", "# Value units: µm"]
        rows = ["\t".join(f"{v:g}" for v in row) for row in z]
        put("a.gwyddion", "\n".join([*lines, *rows]))
        how = {"format": "matrix"}
    scan = ms.Scan.read(f"a.{kind}", **how)
    assert np.array_equal(scan.heights, z / 1e6, equal_nan=True)
    assert scan.pixel == pytest.approx((2e-6, 2e-6), rel=1e-15)
    assert scan.name == f"a.{kind}"
    assert any(note.startswith("heights: in") for note in scan.notes)
    assert "missing: 0.0833 of the points." in scan.notes


@pytest.mark.parametrize("digits", [1, 2])
def test_profiles_with_rounded_places_have_their_mean_step(digits: int) -> None:
    """As a Dektak writes x: steps of 0.0667 um as 0.07 and 0.06, or as 0.1 and 0."""
    x, z = np.arange(300) * 0.0667, np.sin(np.arange(300.0))
    put("d.csv", "x [um],z [nm]\n" + "".join(
        f"{a:.{digits}f},{b:.9f}\n" for a, b in zip(x, z, strict=True)))  # fmt: skip
    scan = ms.Scan.read("d.csv")
    assert scan.heights == pytest.approx(1e-9 * z)
    assert scan.pixel == pytest.approx((0.0667e-6,), rel=2e-3)
    assert any(note.startswith("x: rounded to 0") for note in scan.notes)


def test_profiles() -> None:
    np.save("p.npy", Z[:, 0])
    assert ms.Scan.read("p.npy", **UM).is_profile
    savemat("p.mat", {"z": Z[:, 0]})
    assert ms.Scan.read("p.mat", **UM).heights.shape == (4,)
    put("p.txt", "1\n2\n\n3\n5\n")
    assert ms.Scan.read("p.txt", **UM).heights.tolist() == [1e-6, 2e-6, 3e-6, 5e-6]
    put("q.csv", "x;z\n0,5;1,5\n1,0;2,5\n2,0;3,5\n2,5;0,5\n")
    scan = ms.Scan.read("q.csv", unit=("mm", "um"))
    assert np.array_equal(scan.heights, [1.5e-6, 2.5e-6, np.nan, 3.5e-6, 0.5e-6], equal_nan=True)
    assert scan.pixel == pytest.approx((5e-4,), rel=1e-14)
    assert 'skipped header: "x;z".' in scan.notes


def test_arrays_may_lie_in_structs_and_groups() -> None:
    savemat("a.mat", {"scan": {"z": Z, "unit": "um"}})
    assert np.array_equal(ms.Scan.read("a.mat", **UM).heights, Z / 1e6)
    with h5py.File("a.h5", "w") as file:
        file["run/z"], file["run/mask"] = Z, np.ones((4, 3))
        file["run/z"].attrs["units"] = "nm"
    scan = ms.Scan.read("a.h5", "hdf5", channel="run/z", pixel="1 um")
    assert np.array_equal(scan.heights, Z / 1e9)
    assert 'HDF5 file, array "run/z"' in scan.notes[0]
    refused("this HDF5 file holds more than one array", "a.h5", "hdf5", **UM)


def test_units_must_be_given_where_the_file_has_none() -> None:
    np.save("a.npy", Z)
    refused(
        'does not state the unit of its heights; write for example unit="um"', "a.npy", pixel=1e-6
    )
    refused('does not state the pixel; write for example pixel="1.66 um"', "a.npy", unit="um")
    refused('unit: .*unknown unit "umm"', "a.npy", unit="umm", pixel=1e-6)
    refused("unit: .*a time", "a.npy", unit="s", pixel=1e-6)
    refused("unit: wanted a unit of length", "a.npy", unit=1e-6, pixel=1e-6)
    refused("unit: wanted a unit such as", "a.npy", unit=("um", "um", "um"), pixel=1e-6)
    refused("pixel: .*no unit", "a.npy", unit="um", pixel="1.66")
    refused("pixel must be above zero", "a.npy", unit="um", pixel=0.0)


def test_what_no_height_can_be_is_missing_where_that_is_said() -> None:
    z = Z.copy()
    z[0, 0] = -9999.0
    np.save("a.npy", z)
    scan = ms.Scan.read("a.npy", valid=("-1 mm", 1e-3), **UM)
    assert np.isnan(scan.heights[0, 0])
    assert scan.missing == pytest.approx(1 / 12)
    assert "valid: 1 point below -1 mm or above 1 mm is missing." in scan.notes
    refused("valid must be two heights", "a.npy", valid="1 mm", **UM)
    refused("valid: the first height must be the lower", "a.npy", valid=(1.0, -1.0), **UM)
    refused("valid: ", "a.npy", valid=("1 s", 1.0), **UM)
    refused("all 12 heights are missing", "a.npy", valid=("1 m", "2 m"), **UM)


@pytest.mark.parametrize(
    ("sentinel", "told", "limits"),
    [
        (-9999.0, "-9.999 mm", '("-4 µm", "4 µm")'),
        (32767.0, "32.77 mm", '("-4 µm", "4 µm")'),
        (-30.0, "-30 µm", '("-4 µm", "4 µm")'),
    ],
)
def test_a_number_for_nothing_measured_is_reported(sentinel: float, told: str, limits: str) -> None:
    z = np.linspace(-2.5, 2.5, 400).reshape(20, 20)
    np.save("whole.npy", z)
    z[3:5, 4:6] = sentinel
    np.save("a.npy", z)
    scan = ms.Scan.read("a.npy", **UM)
    note = f"suspect: 4 points are all {told}, far from all others; if that denotes missing "
    note += f"points, remove them with `repaired()`, or with `valid={limits}` when reading."
    assert note in scan.notes
    mended = ms.Scan.read("a.npy", valid=("-4 um", "4 um"), **UM)
    assert mended.missing == 0.01
    assert not any("suspect" in note for note in (*mended.notes, *_notes_of("whole.npy")))


def _notes_of(name: str) -> tuple[str, ...]:
    return ms.Scan.read(name, **UM).notes


@pytest.mark.parametrize(
    ("z", "says"),
    [
        (np.full((5, 5), np.nan), "all 25 heights are missing"),
        (np.full((5, 5), 3.0), "all heights are 3 µm: nothing to measure"),
        (np.arange(3.0)[None], "at least two rows and two columns, got 1 x 3"),
        (np.where(np.eye(5), np.inf, 1.0), "5 of 25 are infinite"),
        (np.where(np.eye(5), 1e300, 1.0), "must be heights in metres"),
        (np.arange(25).reshape(5, 5) * 1j, "wanted real numbers, got an array of complex128"),
        (np.array([["a", "b"], ["c", "d"]]), "wanted real numbers, got an array of <U1"),
    ],
)
def test_heights_that_are_none(z: np.ndarray, says: str) -> None:
    np.save("a.npy", z)
    refused(says, "a.npy", **UM)


# -- files that are not what they should be --------------------------------------------------------


def test_objects_are_not_unpickled() -> None:
    np.save("a.npy", np.array([[print, print]] * 2, dtype=object), allow_pickle=True)
    refused("not a usable npy file of real numbers: .*Python objects", "a.npy", **UM)


def _npy(shape: tuple[int, ...], numbers: int) -> bytes:
    """An npy file whose header promises more than follows."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        file, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    return file.getvalue() + bytes(8 * numbers)


def test_more_points_than_allowed_are_refused_before_they_are_read() -> None:
    put("a.npy", _npy((10**6, 10**6), 9))
    put("b.npy", _npy((3000, 3000), 9))
    for name, content in (("a", _npy((40_000, 40_000), 9)), ("b", _npy((3000, 3000), 9))):
        with zipfile.ZipFile(f"{name}.npz", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("z.npy", content)
    big = np.zeros((3000, 3000))
    np.savez_compressed("c.npz", z=big)
    savemat("c.mat", {"z": big}, do_compression=True)
    put("c.txt", "0 0 0 0 0\n" * 30_000)
    put("d.txt", "0 0 0\n" * 30_000)
    ms.Scan.read(put("e.txt", "1 2 3 4\n2 3 4 5"), **UM)  # imports are none of it
    tracemalloc.start()
    for name in ("a.npy", "b.npy"):
        refused("not a usable npy file of real numbers: mmap length is greater", name, **UM)
    refused("9000000 points, more than limit=1000000", "c.npz", limit=10**6, **UM)
    refused("30000 x 5|30001 x 5", "c.txt", limit=100_000, **UM)
    refused("limit=", "d.txt", limit=20_000, unit="um")
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 24e6  # the arrays would take 72 MB
    refused("not a usable npz file: EOF|too large for the memory", "a.npz", **UM)
    refused("not a usable npz file: EOF", "b.npz", **UM)
    # SciPy unpacks the first 128 kB of a variable to see its size, which can be 135 MB, not more.
    refused("9000000 points", "c.mat", limit=10**6, **UM)


# -- text ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "content",
    [
        "1 2.5 -3 4\n0.5 0 4e0 1\n",
        "# a comment\n% another\n1 2.5 -3 4\n\n0.5 0 4 1",
        "1,2.5,-3,4\n0.5,0,4,1\n",
        "1, 2.5, -3, 4\n0.5, 0, 4, 1\n",
        "1;2,5;-3;4\n0,5;0;4;1\n",
        "1\t2,5\t-3\t4\n0,5\t0\t4\t1\n",
        "1,0 2,5 -3,0 4,0\n0,5 0,0 4,0 1,0\n",
        "1;2.5;-3;4;\r\n0.5;0;4;1;\r\n",
        "heights of the plate\nin um\n1 2.5 -3 4\n0.5 0 4 1",
        "\ufeff1 2.5 -3 4\n0.5 0 4 1",
        "  1  2.5  -3 4\n  0.5 0 4 1 \n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_ways_to_write_a_matrix(content: str, encoding: str) -> None:
    put("a.txt", content.lstrip("\ufeff").encode(encoding) if encoding != "utf-8" else content)
    scan = ms.Scan.read("a.txt", **UM)
    assert scan.heights.tolist() == [[1e-6, 2.5e-6, -3e-6, 4e-6], [5e-7, 0.0, 4e-6, 1e-6]]


@pytest.mark.parametrize(
    ("gap", "separator"),
    [
        (gap, separator)
        for gap in ("nan", "NaN", "BAD", "***", "--", "n/a", "1.#QNAN", "-1.#IND", "")
        for separator in (",", ";", "\t", " ")
        if gap or separator != " "  # blanks cannot stand for a number between blanks
    ],
)
def test_ways_to_write_that_a_point_is_missing(gap: str, separator: str) -> None:
    rows = [["1", gap, "-3", "2"], ["4", "5", gap, "6"], [gap, "1", "2", "3"]]
    put("a.txt", "\n".join(separator.join(row) for row in rows))
    scan = ms.Scan.read("a.txt", **UM)
    expected = np.array([[1, np.nan, -3, 2], [4, 5, np.nan, 6], [np.nan, 1, 2, 3]]) / 1e6
    assert np.array_equal(scan.heights, expected, equal_nan=True)


@pytest.mark.parametrize(
    ("head", "stated"),
    [
        ("x [um],y [um],z [nm]", None),
        ("# x [um],y [um],z [nm]", ("um", "nm")),
        ('"X (µm)","Y (µm)","Z (nm)"', None),
        ("x/um,y/um,z/nm", None),
        ("x_um,y_um,z_nm", ("um", "nm")),
        ("[um],[um],[nm]", None),
        ("Position X [um] Position Y [um] Mean height [nm]", None),
        ("x [um] y [um] z [nm]", None),
        ("by hand\nx [um],y [um],z [nm]\nas measured", None),
        ("Line 1 X [um],Line 1 Y [um],Mean of 3 [nm]", None),
        ("x, y, z [nm]", ("um", "nm")),
        ("x [um], y [um], z", ("um", "nm")),
    ],
)
def test_the_names_of_columns_say_their_units(head: str, stated: tuple[str, str] | None) -> None:
    put("a.csv", f"{head}\n0,0,1\n2,0,2\n0,3,3\n2,3,5\n")
    scan = ms.Scan.read("a.csv", unit=stated)
    assert scan.heights.tolist() == [[1e-9, 2e-9], [3e-9, 5e-9]]
    assert scan.pixel == pytest.approx((2e-6, 3e-6), rel=1e-14)
    told = "as stated in the file" if stated is None else "as given"
    said = [note.replace("µm", "um") for note in scan.notes]
    assert f"heights: in nm, {told}." in said
    assert f"coordinates: in um, {told}." in said
    # A thousandfold is no matter of taste.
    if stated is None:
        refused('coordinates in ".m", not "mm"; omit unit', "a.csv", unit="mm")
        refused('states heights in "nm", not "um"; omit unit', "a.csv", unit="um")
        assert ms.Scan.read("a.csv", unit=("um", "nm")).heights[0, 0] == 1e-9


def test_units_above_some_columns_only() -> None:
    put("a.csv", "x, y, z [nm]\n0,0,1\n2,0,2\n0,3,3\n2,3,5\n")
    refused('heights in "nm", but not .* write for example unit=."mm", "nm".', "a.csv")
    refused('states heights in "nm", not "um"; write unit=."um", "nm".', "a.csv", unit="um")
    put("e.csv", "x [mm], y [mm], z\n0,0,1\n2,0,2\n0,3,3\n2,3,5\n")
    refused('unit of its heights; write for example unit=."mm", "um".', "e.csv")
    refused('coordinates in "mm", not "um"; write unit=."mm", "um".', "e.csv", unit="um")
    assert ms.Scan.read("e.csv", unit=("mm", "um")).pixel == pytest.approx((2e-3, 3e-3), rel=1e-14)
    put("b.csv", "x [mm],y [um],z [nm]\n0,0,1\n2,0,2\n0,3,3\n2,3,5\n")
    refused('x is in "mm", y in "um": wanted one unit for both', "b.csv")
    put("c.txt", "z [nm]\n1\n2\n3\n5\n")
    assert ms.Scan.read("c.txt", pixel="1 um").heights[3] == 5e-9
    refused('not "um"', "c.txt", unit="um", pixel="1 um")
    # In another encoding than ours.
    put("d.csv", "x [µm];z [µm]\n0;1\n1;2\n2;4\n3;3\n".encode("latin-1"))
    assert ms.Scan.read("d.csv").heights[0] == 1e-6


def test_points_may_have_more_than_three_columns() -> None:
    rows = "0 0 1 9\n1 0 2 9\n0 1 3 9\n1 1 5 9\n"
    for name, content in (
        ("a.xyz", rows),
        ("a.txt", "x y z intensity\n" + rows),
        ("b.csv", "X [um],Y [um],Z [um],I\n" + rows.replace(" ", ",")),
    ):
        scan = ms.Scan.read(put(name, content), unit="um")
        assert scan.heights.tolist() == [[1e-6, 2e-6], [3e-6, 5e-6]]
        assert "not read: 1 column beyond x, y and z." in scan.notes
        refused('the coordinates determine the pixel.* write format="matrix"', name, **UM)
        assert ms.Scan.read(name, "matrix", **UM).heights.shape == (4, 4)
    assert ms.Scan.read(put("c.txt", rows), "xyz", unit="um").heights.shape == (2, 2)
    assert ms.Scan.read("c.txt", **UM).heights.shape == (4, 4)
    put("d.xyz", "1 2 3 4\n1 2 4 5\n")
    refused('the first three of 4 columns .* write format="matrix"', "d.xyz", unit="um")


@pytest.mark.parametrize("kind", ["row", "column", "text"])
def test_one_row_is_a_profile(kind: str) -> None:
    line = np.array([1.0, 2.0, 4.0, 3.0, 5.0])
    name = f"a.{'txt' if kind == 'text' else 'npy'}"
    if kind == "text":
        put(name, "1 2 4 3 5\n")
    else:
        np.save(name, line[None] if kind == "row" else line[:, None])
    scan = ms.Scan.read(name, **UM)
    assert scan.is_profile
    assert scan.heights.tolist() == [1e-6, 2e-6, 4e-6, 3e-6, 5e-6]
    what = "column" if kind == "column" else "row"
    assert f"profile: one {what} of 5 points, read as a profile." in scan.notes


# -- scattered order -------------------------------------------------------------------------------


@given(
    shape=st.tuples(st.integers(2, 12), st.integers(2, 12)),
    steps=st.tuples(st.floats(1e-7, 1e3), st.floats(1e-7, 1e3)),
    start=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    seed=st.integers(0, 10_000),
)
def test_points_in_any_order_find_their_place(
    shape: tuple[int, int], steps: tuple[float, float], start: tuple[float, float], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    z = rng.normal(size=shape)
    y, x = np.mgrid[: shape[0], : shape[1]]
    # Beside a start a thousand million steps away nothing is left of a step.
    x = x * steps[0] + start[0] * min(1.0, 1e3 * steps[0])
    y = y * steps[1] + start[1] * min(1.0, 1e3 * steps[1])
    order = rng.permutation(z.size)
    found, distance = on_grid([x.ravel()[order], y.ravel()[order]], z.ravel()[order])
    assert np.array_equal(found, z)
    assert distance == pytest.approx(steps, rel=1e-9)


def test_coordinates_may_be_rounded_and_points_missing() -> None:
    rng = np.random.default_rng(2)
    y, x = np.mgrid[:80, :100]
    kept = rng.permutation(x.size)[:5000]
    z = rng.normal(size=x.size)
    place = [np.round(v.ravel() * 0.3333, 2)[kept] for v in (x, y)]
    found, steps = on_grid(place, z[kept])
    assert steps == pytest.approx((0.3333, 0.3333), rel=1e-4)
    expected = np.full(x.size, np.nan)
    expected[kept] = z[kept]
    assert np.array_equal(found, expected.reshape(x.shape), equal_nan=True)


def test_points_that_are_on_no_grid() -> None:
    rng = np.random.default_rng(3)
    x, y, z = rng.random((3, 200))
    with pytest.raises(ValueError, match=r"regular grid|scattered|limit"):
        on_grid([x, y], z)
    grid = [np.array([0.0, 1.0, 0.0, 1.0, 1.0]), np.array([0.0, 0.0, 1.0, 1.0, 1.0])]
    with pytest.raises(ValueError, match="1 points coincide with another point"):
        on_grid(grid, np.arange(5.0))
    with pytest.raises(ValueError, match="all points have the same y"):
        on_grid([np.arange(5.0), np.zeros(5)], np.arange(5.0))
    with pytest.raises(ValueError, match="x must be a finite number"):
        on_grid([np.array([0.0, np.nan])], np.arange(2.0))
    line = np.arange(300.0)
    y, x = (axis.ravel() for axis in np.mgrid[:6, :7])
    turned = [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y]
    with pytest.raises(ValueError, match="the grid is rotated or the points are scattered"):
        on_grid(turned, np.arange(42.0))
    with pytest.raises(ValueError, match="the points are scattered"):
        on_grid([line, line], line)
    with limited(100), pytest.raises(ValueError, match="more than limit=100"):
        on_grid([line, line], line)


# -- instruments -----------------------------------------------------------------------------------


def nms(dx: float, dy: float) -> bytes:
    """A NanoFocus file of the matrix Z / 10, heights in micrometres."""
    head = bytearray(3468)
    struct.pack_into("<dd", head, 16, -1.0, 1.0)
    struct.pack_into("<IIdd", head, 1368, 3, 4, dx, dy)
    raw = np.rint((Z / 10 + 1.0) / 2.0 * (2**16 - 2)).astype("<u2")
    return bytes(head) + raw.tobytes()


def test_an_instruments_file_by_its_ending_and_by_its_name() -> None:
    put("a.nms", nms(1600.0, 1700.0))
    put("b.bin", nms(1600.0, 1700.0))
    for scan in (ms.Scan.read("a.nms"), ms.Scan.read("b.bin", "nms")):
        np.testing.assert_allclose(scan.heights, Z / 10 * 1e-6, atol=1e-6 / 2**15)
        # The library takes these nanometres for millimetres.
        assert scan.pixel == pytest.approx((1.6e-6, 1.7e-6), rel=1e-12)
        assert any("divided by a million" in note for note in scan.notes)
    scan = ms.Scan.read(put("c.nms", nms(1.6e-3, 1.6e-3)))
    assert scan.pixel == pytest.approx((1.6e-6, 1.6e-6), rel=1e-12)
    assert not any("divided" in note for note in scan.notes)
    scan = ms.Scan.read("a.nms", pixel="1 um")
    assert scan.pixel == (1e-6, 1e-6)
    assert "as given (the file states 1.600 µm x 1.700 µm)" in scan.notes[0]
    refused('the file states heights in "µm"; omit unit', "a.nms", unit="nm")
    refused("3 x 4 = 12 points, more than limit=11", "a.nms", limit=11)
    refused('no channel "B"; the channels are 0: "Default"', "a.nms", channel="B")
    assert ms.Scan.read("a.nms", channel=0).notes == ms.Scan.read("a.nms", channel="Default").notes


def test_files_of_a_nanoscope_have_any_number_or_suffix() -> None:
    """Bruker numbers its files .000 to .999; SurfaceTopography knows .001 to .005."""
    for name, head in (("a.013", b"\0"), ("a.dat", b"\\*File list\r\n"), ("a.005", b"")):
        assert instruments.suffix_of(Path(name), head) == "001"
    assert instruments.suffix_of(Path("a.PLU"), b"\0") == "plu"
    put("a.hfm", "0 0 1\n1 0 2\n0 1 3\n1 1 4\n")
    assert ms.Scan.read("a.hfm", unit="um").heights.shape == (2, 2)


def test_a_broken_instruments_file() -> None:
    put("a.nms", nms(1600.0, 1700.0)[:3470])
    refused("not a usable nms file", "a.nms")
    refused("not a usable plu file", "a.nms", "plu")
    refused("format not recognised .*; write format=", put("a.bin", bytes(range(256)) * 8))


def test_archives_may_not_unpack_to_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(instruments, "_BESIDE", 1000)
    with zipfile.ZipFile("a.x3p", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", bytes(1_000_000))
    refused("unpacks to 1 MB, more than limit=1000 points can need", "a.x3p", limit=1000)


class Channel(SimpleNamespace):
    """What the library tells of a channel."""

    def __init__(self, name: str = "topo", z: Any = Z, **more: Any) -> None:
        usual: dict[str, Any] = {
            "name": name,
            "z": np.ma.masked_invalid(z),
            "nb_grid_pts": np.shape(z)[::-1],
            "physical_sizes": tuple(2.0 * n for n in np.shape(z)[::-1]),
            "unit": "µm",
            "is_height_channel": True,
            "is_uniform": True,
        }
        super().__init__(**(usual | more))


@pytest.fixture(name="holds")
def _holds(monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """A file of an instrument with these channels, as the library would give them."""

    def holds(*channels: Channel) -> str:
        class Fake:
            def __init__(self, path: str) -> None:
                self.channels = channels

            @classmethod
            def format(cls) -> str:
                return "fake"

            @classmethod
            def can_read(cls, head: bytes) -> str:
                return "maybe"

            @classmethod
            def file_extensions(cls) -> list[str]:
                return ["FAKE"]

            def topography(self, channel_index: int, **given: Any) -> Any:
                channel = channels[channel_index]
                assert ("physical_sizes" in given) == (channel.physical_sizes is None)
                warnings.warn("the scan was made on a Monday", UserWarning, stacklevel=1)
                warnings.warn("soon gone", DeprecationWarning, stacklevel=1)
                return SimpleNamespace(
                    heights=lambda: channel.z.T,
                    is_uniform=channel.is_uniform,
                    positions=lambda: channel.positions,
                )

            def close(self) -> None:
                raise OSError

        library = SimpleNamespace(
            lookup_reader_by_format={"fake": Fake},
            readers=[Fake],
            MAGIC_BUFFER_SIZE=512,
            MagicMatch=SimpleNamespace(NO="no", YES="yes"),
        )
        monkeypatch.setattr(instruments, "_library", lambda: library)
        monkeypatch.setattr(instruments, "parsed", parsed_here)
        return put("a.fake", b"\0\1\2")

    return holds


def test_a_channel_has_to_be_chosen_where_several_could_be_meant(
    holds: Callable[..., str],
) -> None:
    name = holds(Channel("trace"), Channel("retrace", 2 * Z), Channel("phase", is_height_channel=0))
    refused('2 height channels, 0: "trace", 1: "retrace"; write channel=', name)
    for wanted in ("retrace", 1, "1"):
        assert ms.Scan.read(name, channel=wanted).heights[0, 0] == 2e-6
    refused('no channel "retrac"; did you mean "retrace"', name, channel="retrac")
    refused("no channel 3", name, channel=3)
    refused("no channel true", name, channel=True)
    scan = ms.Scan.read(holds(Channel("photo", is_height_channel=False), Channel("topo")))
    assert "not read: photo." in scan.notes
    assert scan.pixel == (2e-6, 2e-6)
    refused("no height channel; the channels are 0", holds(Channel(is_height_channel=None)))
    refused("2 channels have this name", holds(Channel("z"), Channel("z")), channel="z")


def test_missing_metadata_of_an_instrument_are_required(holds: Callable[..., str]) -> None:
    name = holds(Channel(unit=None))
    refused("does not state the unit", name)
    refused("does not state the pixel", name, unit="nm")
    assert ms.Scan.read(name, **UM).heights.tolist() == (Z / 1e6).tolist()
    name = holds(Channel(physical_sizes=None))
    refused("does not state the pixel", name)
    assert ms.Scan.read(name, pixel="1 um").pixel == (1e-6, 1e-6)
    refused("does not state the pixel", holds(Channel(physical_sizes=(0.0, np.inf))))
    refused("length unit of the file: .*a time", holds(Channel(unit="s")))


def test_lines_of_instruments(holds: Callable[..., str]) -> None:
    line = np.array([1.0, np.nan, 3.0, 2.0, 5.0])
    scan = ms.Scan.read(holds(Channel(z=line)))
    assert np.array_equal(scan.heights, line / 1e6, equal_nan=True)
    assert scan.pixel == (2e-6,)
    places = np.array([0.0, 3.0, 6.0, 12.0, 15.0])
    scan = ms.Scan.read(holds(Channel(z=np.arange(5.0), is_uniform=False, positions=places)))
    assert np.array_equal(scan.heights * 1e6, [0.0, 1.0, 2.0, np.nan, 3.0, 4.0], equal_nan=True)
    assert scan.pixel == pytest.approx((3e-6,), rel=1e-14)
    uneven = np.array([0.0, 1.0, 4.0, 9.1, 16.0])
    scan = ms.Scan.read(holds(Channel(z=uneven, is_uniform=False, positions=uneven)))
    assert scan.heights == pytest.approx(4e-6 * np.arange(5.0))
    assert "x: uneven steps, interpolated linearly at their mean 4." in scan.notes
    name = holds(Channel(z=np.arange(5.0), is_uniform=False, positions=uneven[[0, 2, 1, 4, 3]]))
    refused("not on a regular grid", name)
    refused("points are not on a regular grid", holds(Channel(is_uniform=False)))


@pytest.mark.parametrize(
    ("name", "shape", "pixel", "rms"),
    [
        ("plu-1.plu", (576, 768), 1.66e-6, 18.2e-9),
        ("al3d-1.al3d", (296, 200), 0.438e-6, 259e-9),
        ("mnt-1.mnt", (600, 960), 1.854e-6, None),
    ],
)
@pytest.mark.parametrize("stated", [False, True])
def test_real_scans(
    name: str, shape: tuple[int, int], pixel: float, rms: float | None, stated: bool
) -> None:
    scan = ms.Scan.read(real(name), name.rpartition(".")[2] if stated else None)
    assert scan.heights.shape == shape
    assert scan.pixel == pytest.approx((pixel, pixel), rel=1e-3)
    assert scan.missing == 0.0
    if rms is not None:  # an independent reckoning, of three digits
        level = scan.condition(level="quadratic").heights
        assert level.std() == pytest.approx(rms, rel=3e-3)
