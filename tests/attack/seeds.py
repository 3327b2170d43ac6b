"""Small sound files of every format, written by the libraries of their kinds or by the format."""

from __future__ import annotations

import io
import struct
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterator
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from foreign_files import NAMED, mesh_file
from laps import STRIP, small_joint
from scipy import io as scipy_io

import microslip as ms
from microslip.study.runs.batch import items_of


class Seed(NamedTuple):
    """A sound file and what reads it."""

    name: str
    content: bytes
    read: Callable[[Path], Any]
    parsed_apart: bool = False
    """Whether a child process parses it."""
    refused: bool = False
    """Whether the file is of a kind that nobody reads here."""


TIME = np.linspace(0.0, 2.0, 200)
MOTION = 1e-5 * np.sin(2.0 * np.pi * 3.0 * TIME)
FORCE = 50.0 * np.sign(np.gradient(MOTION)) + 1e5 * MOTION
HEIGHTS = np.random.default_rng(1).standard_normal((24, 20)) * 1e-7
UNITS = {"time": "s", "displacement": "m", "force": "N"}


@lru_cache
def seeds() -> tuple[Seed, ...]:
    """A file of each format whose library is installed."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        groups = (_records, _scans, _meshes, _tables, _studies)
        return tuple(seed for group in groups for seed in group(here))


def _arrays(path: Path) -> ms.Record:
    return ms.Record.read(path, units=UNITS)


def _of(path: Path, read: Callable[[Path], Any], **more: bool) -> Seed:
    return Seed(path.name, path.read_bytes(), read, **more)


def _records(here: Path) -> Iterator[Seed]:
    columns = {"time": TIME, "displacement": MOTION, "force": FORCE}
    table = np.column_stack([TIME, MOTION * 1e6, FORCE, np.full_like(TIME, 100.0)])
    np.savetxt(here / "record.csv", table, delimiter=",", comments="", fmt="%.6g",
               header="time [s],displacement [um],force [N],normal load [N]")  # fmt: skip
    yield _of(here / "record.csv", ms.Record.read)
    np.savez(here / "record.npz", **columns)
    yield _of(here / "record.npz", _arrays)
    fields = np.rec.fromarrays([*columns.values()], names=[*columns])
    np.save(here / "fields.npy", np.asarray(fields))
    yield _of(here / "fields.npy", _arrays)
    in_micrometres = {
        "displacement": {"unit": "um", "data": MOTION * 1e6},
        "force": {"unit": "N", "data": FORCE},
        "fs": 100.0,
    }
    scipy_io.savemat(here / "record.mat", in_micrometres, do_compression=True)
    yield _of(here / "record.mat", ms.Record.read, parsed_apart=True)
    scipy_io.savemat(here / "record4.mat", columns, format="4")
    yield _of(here / "record4.mat", _arrays, parsed_apart=True)
    with h5py.File(here / "record.h5", "w") as file:
        for name, unit in UNITS.items():
            file.create_dataset(f"run/{name}", data=columns[name], compression="gzip")
            file[f"run/{name}"].attrs["units"] = unit
        file["run/linked"] = h5py.SoftLink("/run/force")
    yield _of(here / "record.h5", ms.Record.read, parsed_apart=True)
    with h5py.File(here / "record73.mat", "w", userblock_size=512) as file:
        for name in columns:
            file[name] = columns[name][None, :]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        reference = np.array([[file["force"].ref]], dtype=h5py.ref_dtype)
        file.create_dataset("cell", data=reference, dtype=h5py.ref_dtype)
    content = (here / "record73.mat").read_bytes()
    head = b"MATLAB 7.3 MAT-file".ljust(512)
    yield Seed("record73.mat", head + content[512:], _arrays, parsed_apart=True)
    if find_spec("nptdms"):
        from nptdms import ChannelObject, TdmsWriter

        rate = {"wf_increment": 0.01}
        with TdmsWriter(here / "record.tdms") as writer:
            writer.write_segment([
                ChannelObject("run", "displacement", MOTION * 1e6, rate | {"unit_string": "um"}),
                ChannelObject("run", "force", FORCE, rate | {"unit_string": "N"}),
            ])  # fmt: skip
        yield _of(here / "record.tdms", ms.Record.read)
    if find_spec("openpyxl"):
        import openpyxl

        book = openpyxl.Workbook()
        for row in (["time [s]", "displacement [um]", "force [N]"], *table[:40, :3].tolist()):
            book.active.append(row)
        book.save(here / "record.xlsx")
        yield _of(here / "record.xlsx", ms.Record.read, parsed_apart=True)


def _scan(path: Path) -> ms.Scan:
    return ms.Scan.read(path, "hdf5", pixel=1e-6, unit="m")


def _scans(here: Path) -> Iterator[Seed]:
    np.save(here / "scan.npy", HEIGHTS)
    yield _of(here / "scan.npy", lambda path: ms.Scan.read(path, pixel=1e-6, unit="m"))
    y, x = np.mgrid[:12, :10] * 1e-6
    np.savetxt(
        here / "scan.xyz", np.column_stack([x.ravel(), y.ravel(), HEIGHTS[:12, :10].ravel()])
    )
    yield _of(here / "scan.xyz", lambda path: ms.Scan.read(path, unit="m"))
    with h5py.File(here / "scan.h5", "w") as file:
        file["z"] = HEIGHTS
    yield _of(here / "scan.h5", _scan, parsed_apart=True)
    if not find_spec("SurfaceTopography"):
        return
    yield Seed("scan.opd", wyko(HEIGHTS), ms.Scan.read, parsed_apart=True)
    yield Seed("scan.x3p", x3p(HEIGHTS), ms.Scan.read, parsed_apart=True)
    yield Seed("scan.nms", _nms(HEIGHTS), ms.Scan.read, parsed_apart=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what it imports
        from SurfaceTopography import Topography

        surface = Topography(HEIGHTS * 1e6, (24.0, 20.0), unit="um", info={"unit": "um"})
        surface.to_netcdf(str(here / "scan.nc"))
    yield _of(here / "scan.nc", ms.Scan.read, parsed_apart=True)
    for real in sorted((Path(__file__).parents[2] / "../shared/data/scans").glob("*.[ap]l*")):
        yield _of(real, ms.Scan.read, parsed_apart=True)


def wyko(heights: Any, pixel: float = 1e-3, wavelength: float = 600.0) -> bytes:
    """A Wyko OPD file: a directory of blocks of 24 bytes each, then their contents in its order.

    Heights in metres, stored as waves of the wavelength [nm]; pixel in millimetres.
    """
    rows = np.asarray(heights / (wavelength * 1e-9), dtype="<f4")[::-1].T
    raster = struct.pack("<3H", *rows.shape, 4) + rows.tobytes()
    blocks = [
        (b"RAW DATA", 3, raster),
        (b"Wavelength", 7, struct.pack("<f", wavelength)),
        (b"Mult", 6, struct.pack("<h", 1)),
        (b"Aspect", 7, struct.pack("<f", 1.0)),
        (b"Pixel_size", 7, struct.pack("<f", pixel)),
        (b"Title", 5, b"a milled face".ljust(20, b"\0")),
        (b"Date", 5, b"03/17/2021".ljust(12, b"\0")),
        (b"Time", 5, b"10:11:12".ljust(10, b"\0")),
    ]
    entries = [(b"Directory", 1, 24 * (len(blocks) + 1))]
    entries += [(name, kind, len(content)) for name, kind, content in blocks]
    directory = b"".join(struct.pack("<16shlH", *entry, 0) for entry in entries)
    return b"\x01\x00" + directory + b"".join(content for _, _, content in blocks)


def x3p(heights: Any) -> bytes:
    """An archive by ISO 25178-72 of heights in metres."""
    rows, columns = heights.shape
    axis = (
        "<AxisType>I</AxisType><DataType>D</DataType><Increment>1e-6</Increment><Offset>0</Offset>"
    )
    main = f"""<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
<Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType>
<Axes><CX>{axis}</CX><CY>{axis}</CY><CZ><AxisType>A</AxisType><DataType>D</DataType></CZ></Axes>
</Record1>
<Record2><Date>2021-03-17T10:11:12</Date></Record2>
<Record3><MatrixDimension><SizeX>{columns}</SizeX><SizeY>{rows}</SizeY><SizeZ>1</SizeZ>
</MatrixDimension><DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink></Record3>
<Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>"""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", main)
        archive.writestr("bindata/data.bin", np.asarray(heights, dtype="<f8").tobytes())
    return packed.getvalue()


def _nms(heights: Any) -> bytes:
    """A NanoFocus file: micrometres of heights between two ends as 16 bits."""
    head = bytearray(3468)
    struct.pack_into("<dd", head, 16, -1.0, 1.0)
    struct.pack_into("<IIdd", head, 1368, *heights.shape[::-1], 1.6e-3, 1.6e-3)
    return bytes(head) + np.rint((heights * 1e6 + 1.0) / 2.0 * (2**16 - 2)).astype("<u2").tobytes()


def _meshes(here: Path) -> Iterator[Seed]:
    def read(path: Path) -> ms.MeshedJoint:
        return ms.MeshedJoint.read(path, **NAMED)

    if find_spec("meshio"):
        for suffix in (".msh", ".inp", ".vtu", ".vtk"):
            nameless = suffix.startswith(".vt")
            path = mesh_file(here / f"mesh{suffix}", nameless=nameless, elements=(2, 2))
            yield _of(path, read, parsed_apart=True, refused=nameless)


def _tables(here: Path) -> Iterator[Seed]:
    small_joint().save(here / "reduced.npz")
    yield _of(here / "reduced.npz", ms.ReducedJoint.load)
    decay = np.exp(-3.0 * np.arange(2000) * 2e-4) * np.cos(1e3 * np.arange(2000) * 2e-4)
    np.savetxt(here / "decay.csv", np.column_stack([np.arange(2000) * 2e-4, decay * 1e-6]),
               delimiter=",", comments="", fmt="%.5g",
               header="time [s],displacement [m]")  # fmt: skip
    yield _of(here / "decay.csv", ms.ModalTest.read)
    listed = b"name,joint.normal_load\n1,100 N\n2,200 N\n3,1 kN\n"
    yield Seed("list.csv", listed, lambda path: items_of(path, path.parent / "study.toml"))


def _studies(here: Path) -> Iterator[Seed]:
    yield Seed("study.toml", STUDY.encode(), ms.Study.load)
    yield Seed("structure.toml", BEAM.encode(), ms.Study.load)


STUDY = """schema = 1
title = "A milled joint"

[material.al]
young_modulus = "69 GPa"
poisson_ratio = 0.33
hardness = "1.2 GPa"

[surface]
law = "greenwood-williamson"
materials = ["al", "al"]
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"
heights = { kind = "gaussian", std = "0.5 um" }

[joint]
friction_coefficient = 0.55
normal_load = ["100 N", "2 kN"]

[excitation]
amplitudes = ["0.1 um", "1 um"]
"""


_MORE = """modes = [1, 3]
amplitude = { from = "0.1 um", to = "10 um", points = 3 }
sensor = { at = ["0.1 m", "0 m", "0 m"], direction = "z" }
samples"""
_BOLT = """torque = { mean = "10 N m", cv = 0.15 }
thread = "6 mm"
nut_factor = 0.2"""
BEAM = STRIP.replace("samples", _MORE).replace('tension = "5 kN"', _BOLT)
BEAM = BEAM.replace("= 0.35", "= { low = 0.1, high = 0.6 }")
