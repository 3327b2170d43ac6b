"""Errors of commands name options: each rule against a message that the package really has."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import numpy as np
import pytest

import microslip as ms
from microslip.cli.identify import identify as identify_command
from microslip.cli.measure import measure
from microslip.cli.options import spelling
from microslip.cli.surface import surface
from microslip.identification import conclusions as outcomes
from microslip.identification import models
from microslip.identification import run as fits
from microslip.scans import random_surface

ARGUMENT = re.compile(r"(?<!--unit )(?<!--calibration )\b[a-z_]+=(?=[\"'{(\[.]|\d|$|,|;| )")
"""What an argument of Python looks like."""
JOINT = ms.Interface.examples()[0]
PAIR = JOINT.surface.pair
RECORD = ms.VirtualTribometer(JOINT.at(normal_load=2000.0), sample_rate=400.0).record(
    amplitude=5e-6, frequency=10.0, cycles=8
)
BARE = ms.Record(RECORD.displacement, RECORD.force)
TILTED = ms.Record(
    RECORD.displacement, RECORD.force, np.linspace(1000.0, 3000.0, len(RECORD)), sample_rate=400.0
)
HEIGHTS = random_surface((96, 96), 1e-6, m0=1e-13, m2=1e-3, m4=4e7, seed=3).heights


def table(head: str, columns: int, gap: list[int]) -> Path:
    path = Path("table.csv")
    values = np.tile(np.stack([RECORD.displacement, RECORD.force], axis=1), (1, 2))[:, :columns]
    values[gap] = np.nan
    np.savetxt(path, values, header=head, comments="", delimiter=",")
    return path


def read(
    head: str, columns: int = 2, gap: tuple[int, ...] = (), **how: Any
) -> Callable[[], object]:
    return lambda: ms.Record.read(table(head, columns, list(gap)), **how)


def with_role(name: str, role: str, value: str) -> Callable[[], object]:
    how: dict[str, Any] = {name: {role: value}}
    return read(TWO, **how)


def clock() -> ms.Record:
    rows = "\n".join(f"12:00:0{i},{i},{i}" for i in range(9))
    Path("clock.csv").write_text(f"time [s],displacement [m],force [N]\n{rows}\n", "utf-8")
    return ms.Record.read("clock.csv")


def timed() -> ms.Record:
    np.savetxt("timed.csv", np.arange(24.0).reshape(-1, 3), delimiter=",", comments="",
               header="time [s],displacement [m],force [N]")  # fmt: skip
    return ms.Record.read("timed.csv", time="time", sample_rate=1.0)


def measure_notes(record: ms.Record) -> None:
    raise ms.InputError(*ms.measure(record).notes)


TWO = "displacement [m],force [N]"
READING: dict[str, Callable[[], object]] = {
    "a clock": clock,
    "no unit": read("displacement,force [N]"),
    "no unit of time": read("displacement [m],force [N],time", 3),
    "volts": read("displacement [m],force [V]"),
    "no name": read("#,#2"),
    "two displacements": read("displacement [m],force [N],displacement 2 [m]", 3),
    "two loads": read("displacement [m],force [N],normal load [N],normal load B [N]", 4),
    "two commanded": read("displacement [m],force [N],commanded [m],commanded B [m]", 4),
    "no load": read("displacement [m],force [N]", normal_load="load"),
    "a load in metres": read(TWO, normal_load="500 m"),
    "a gap": read(TWO, gap=(5, 6, 7, 8)),
    "time and rate": timed,
    "rate": read(TWO, sample_rate=-1.0),
    "turned time": read("time [s],force [N],displacement [m]", 3),
    "rounded time": lambda: ms.Record([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], time=[0.0, 1.0, 1.0]),
    "confidence": lambda: ms.measure(RECORD, confidence=2.0),
    "sign": lambda: ms.measure(ms.Record(RECORD.displacement, -RECORD.force)),
    **{
        f"{name} of {role}": with_role(name, role, value)
        for name, value in (("units", "m"), ("calibration", "1 m/V"), ("zero", "mean"))
        for role in ("normal_load", "time", "commanded")
    },
}
# A compliant rig makes most of the way: gross slip, though little of the displacement slides.
SOFT = ms.VirtualTribometer(
    JOINT.at(normal_load=2000.0), sample_rate=400.0, rig_stiffness=1e8
).record(amplitude=4e-5, frequency=10.0, cycles=4)


def two_rigs() -> None:
    """What the fit of records of two rigs says, as an error."""
    joint = ms.Interface.examples()[0]
    records = [
        ms.VirtualTribometer(joint, rig_stiffness=rig, sample_rate=640.0, noise=0.001).record(
            amplitude=12e-6, frequency=10.0, cycles=5
        )
        for rig in (1e8, 2e8)
    ]
    found = ms.identify(records, intervals="curvature", held_back=0).message
    raise ms.InputError(found)


def identify(*records: ms.Record, **how: Any) -> Callable[[], object]:
    return lambda: ms.identify(list(records or (RECORD,)), **how)


def without_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fits, "solve", lambda *_, **__: None)
    identify()()


def without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = SimpleNamespace(model=SimpleNamespace(name="iwan"))
    best = SimpleNamespace(finite=False, cause="no number", problem=problem)
    answer: Any = SimpleNamespace(best=best)
    outcomes.Conclusions(answer, "linear")


IDENTIFY: dict[str, Callable[[], object]] = {
    "no load": identify(BARE),
    "a rig in Bouc and Wen": identify(law="bouc-wen", rig_stiffness=1e8),
    "a rig below zero": identify(rig_stiffness=-1.0),
    "a rig fixed": identify(fixed={"rig_stiffness": 1e8}),
    "fixed beyond": identify(fixed={"friction_coefficient": 1e9}),
    "fixed by no name": identify(fixed={"nothing": 1.0}),
    "bounds by no name": identify(bounds={"nothing": (0.0, 1.0)}),
    "an area without a pair": identify(contact_area=(6e-6, 1e-6, 2000.0)),
    "an area without contacts": identify(law="iwan", contact_area=(6e-6, 1e-6, 2000.0)),
    "an area beyond all": identify(contact_area=(1.0, 1e-6, 2000.0), pair=PAIR, area=1e-4),
    "no pair": lambda: models.model_of("interface").build({}, 1.0),
    "held back": identify(held_back=3.0),
    "known without a pair": identify(known={"radius": (1e-3, 1e-4)}),
    "two rigs": two_rigs,
    "a delay without time": identify(ms.Record(BARE.displacement, BARE.force, 2000.0), delay=1e-3),
    "a load that varies": identify(TILTED),
}


def scan(heights: Any, name: str = "a.npy", **how: Any) -> Callable[[], object]:
    steps, then = how.pop("steps", {}), how.pop("then", {})

    def call() -> object:
        np.save(name, heights) if isinstance(heights, np.ndarray) else Path(name).write_text(
            heights, "utf-8"
        )
        found = ms.Scan.read(name, **{"unit": "m", "pixel": 1e-6, **how})
        return found.condition(**steps).condition(**then).moments()

    return call


def two_arrays() -> object:
    np.savez("two.npz", a=HEIGHTS, b=HEIGHTS)
    return ms.Scan.read("two.npz")


def suspect() -> object:
    np.save("suspect.npy", np.where(np.eye(96, dtype=bool), -1e-3, HEIGHTS))
    scan = ms.Scan.read("suspect.npy", unit="m", pixel=1e-6)
    (note,) = (note for note in scan.notes if note.startswith("suspect:"))
    raise ms.InputError(note)


def no_array() -> object:
    Path("no.npy").write_bytes(b"\0\1" * 99)
    return ms.Scan.read("no.npy")


def junk() -> object:
    Path("junk.bin").write_bytes(b"\0\1" * 99)
    return ms.Scan.read("junk.bin")


SPIKY = HEIGHTS.copy()
SPIKY[3, 3] = 1.0
FEW = HEIGHTS[:3, :3].copy()
FEW[1, 1] = 1e-3
SPARSE = HEIGHTS.copy()
SPARSE[:, ::2] = np.nan
SPARSE[::2] = np.nan
SURFACE: dict[str, Callable[[], object]] = {
    "no unit": scan(HEIGHTS, unit=None),
    "an unknown unit": scan(HEIGHTS, unit="furlongz"),
    "three units": scan(HEIGHTS, unit=("m", "m", "m")),
    "a unit twice": scan("# Value units: m\n" + "1 2 3 4\n" * 4, "a.txt"),
    "no pixel": scan(HEIGHTS, pixel=None),
    "a pixel twice": scan("1 2 3\n" * 4, "a.txt"),
    "two columns": scan("1 2\n" * 4, "a.txt", format="xyz"),
    "too many": scan(HEIGHTS, limit=10),
    "arrays": two_arrays,
    "a key": scan(HEIGHTS, key="a"),
    "limits": scan(HEIGHTS, valid=(1.0, -1.0)),
    "spikes": scan(SPIKY),
    "gaps": scan(SPARSE),
    "outliers": scan(HEIGHTS, steps={"outliers": 1.0}),
    "short": scan(HEIGHTS, steps={"cutoff": 1e-6}),
    "long": scan(HEIGHTS, steps={"long_cutoff": 1.0}),
    "turned after": scan(HEIGHTS, steps={"long_cutoff": 8e-6}, then={"cutoff": 9e-6}),
    "few left": scan(FEW, steps={"outliers": 2.0}),
    "suspect": suspect,
    "no array": no_array,
    "half a unit": scan("x,y,z [nm]\n0,0,1\n1,0,2\n0,1,3\n1,1,5\n", "b.txt", unit="m", pixel=None),
    "no format": scan(HEIGHTS, format="nonsense"),
    "no known format": junk,
    "turned": scan(HEIGHTS, steps={"cutoff": 9e-6, "long_cutoff": 8e-6}),
    "a plane": scan(np.add.outer(np.arange(96.0), np.arange(96.0)), steps={"level": "plane"}),
    "a cylinder of few": scan(np.where(np.eye(96, dtype=bool), HEIGHTS, np.nan),
                              steps={"level": "quadratic"}),
}  # fmt: skip

WITH_LIBRARY = ("no format", "no known format")
if find_spec("SurfaceTopography") is None:
    SURFACE = {name: call for name, call in SURFACE.items() if name not in WITH_LIBRARY}
MEASURE: dict[str, Callable[[], object]] = {
    "rig": lambda: ms.measure(RECORD, rig_stiffness=-1.0),
    "law": lambda: ms.measure(RECORD, model=ms.Coulomb(1.0)),
    "gross slip": lambda: measure_notes(SOFT),
}
SPELT = [
    *((surface, call) for call in SURFACE.values()),
    *((command, call) for command in (measure, identify_command) for call in READING.values()),
    *((measure, call) for call in MEASURE.values()),
    *((identify_command, call) for call in IDENTIFY.values()),
]


@pytest.mark.parametrize(("command", "call"), SPELT)
def test_errors_are_spelt_by_their_arguments(
    command: click.Command,
    call: Callable[[], object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ms.InputError) as caught:
        call()
    told = caught.value.said(spelling(click.Context(command)))
    assert told != str(caught.value) or not ARGUMENT.search(told)
    assert not ARGUMENT.search(told.partition("Python")[0]), told


@pytest.mark.parametrize("call", [without_start, without_end])
def test_a_fit_without_an_end_names_options(
    call: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ms.InputError) as caught:
        call(monkeypatch)
    assert "--bound NAME=LOW..HIGH" in caught.value.said(spelling(click.Context(identify_command)))
