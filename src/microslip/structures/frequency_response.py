"""Frequency responses for other programs: CSV, and data sets 58 of the universal file format."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, show
from microslip._core.files import whole_file
from microslip._core.frozen import LockedArrays
from microslip._core.packages import needed_for
from microslip.errors import InputError

_DIRECTIONS = {None: 0, "x": 1, "y": 2, "z": 3}  # 0 is a scalar
_FREQUENCY, _FORCE = 18, 13  # specific data types of the format
_SI = {
    "type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1,
    "length": 1.0, "force": 1.0, "temp": 1.0, "temp_offset": 0.0,
}  # fmt: skip


class _Measured(NamedTuple):
    """Quantity that a sensor measures, as the format names it."""

    kind: int
    unit: str
    over_force: str
    """Unit of a response."""


MEASURED = {
    "displacement": _Measured(8, "m", "m/N"),
    "velocity": _Measured(11, "m/s", "m/(N s)"),
    "acceleration": _Measured(12, "m/s^2", "m/(N s^2)"),
}


class Node(NamedTuple):
    """Place of a response or a force, for the header of a universal file."""

    number: int
    direction: str | None = None
    """One of the axes x, y and z; None for a direction of its own."""
    text: str = ""
    """The place in words."""


_SENSOR, _REFERENCE = Node(1), Node(2)


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(LockedArrays):
    """Motion of a sensor over the harmonic force that makes it, of one amplitude of this force.

    Made by :meth:`microslip.ForcedResponse.frequency_response`; those of a study are in
    ``result.structure.frequency_responses``. Of a joint with friction each force has another; for a
    harmonic balance behind it see Krack and Gross (2019), DOI 10.1007/978-3-030-14023-6.
    """

    frequency: Floats
    """Frequencies [Hz], rising."""
    value: NDArray[np.complex128]
    """Fundamental of the motion over the force, for a force Re(F exp(i w t))."""
    quantity: str
    """``displacement``, ``velocity`` or ``acceleration``: [m/N], [m/(N s)] or [m/(N s^2)]."""
    force: float
    """Amplitude of the force [N]."""
    sensor: Node = _SENSOR
    """Place of the response."""
    reference: Node = _REFERENCE
    """Place of the force."""

    @property
    def unit(self) -> str:
        """Unit of :attr:`value`."""
        return MEASURED[self.quantity].over_force

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write it as a table or as a universal file.

        Frequencies of a universal file have six digits, as the format has it: the values are those
        at the rounded frequencies, of twelve digits.

        Parameters
        ----------
        path : str or path
            A file ending in ``.csv``, or in ``.uff``, ``.unv`` or ``.58``, which pyuff writes:
            ``pip install "microslip[uff]"``.
        overwrite : bool, optional
            Whether a file in its place may be replaced.
        """
        file = Path(path)
        kind = file.suffix.lower()
        if kind not in (".csv", ".uff", ".unv", ".58"):
            raise InputError(f"path must end in .csv or .uff, got {show(file.name)}")
        with whole_file(file, overwrite) as stage:
            if kind == ".csv":
                columns = response_columns([self])
                heads = ",".join(f"{name} [{unit}]" for name, (unit, _) in columns.items())
                rows = zip(*(map(repr, part.tolist()) for _, part in columns.values()), strict=True)
                stage.write_text("\n".join([heads, *map(",".join, rows), ""]), encoding="utf-8")
            else:
                write_universal([self], stage)

    def __repr__(self) -> str:
        f = self.frequency
        return (
            f"FrequencyResponse({f.size} points, {f[0]:.5g} to {f[-1]:.5g} Hz, {self.quantity} "
            f"over {self.force:g} N)"
        )


def response_columns(responses: Sequence[FrequencyResponse]) -> dict[str, tuple[str, Floats]]:
    """Columns of a table with their units, of one quantity."""
    value = np.concatenate([r.value for r in responses])
    unit = responses[0].unit
    return {
        "force_amplitude": (
            "N", np.concatenate([np.full(r.frequency.size, r.force) for r in responses])
        ),
        "frequency": ("Hz", np.concatenate([r.frequency for r in responses])),
        "frf_real": (unit, value.real),
        "frf_imag": (unit, value.imag),
    }  # fmt: skip


def six_digits(frequency: Floats) -> Floats:
    """Frequencies as the format writes them (E13.5), rising."""
    return np.unique([float(f"{f:.5e}") for f in frequency.tolist()])


def universal_files() -> Any:
    """The library that writes them, or how to have it."""
    with needed_for("universal files are written by", "uff", "CSV needs nothing more"):
        import pyuff
    return pyuff


def write_universal(responses: Sequence[FrequencyResponse], path: Path) -> None:
    """Data set 164, the units, and a data set 58 for each force, by pyuff."""
    pyuff = universal_files()
    pyuff.UFF(str(path)).write_sets([dict(_SI), *map(_set, responses)], mode="overwrite")


def _set(response: FrequencyResponse) -> dict[str, Any]:
    measured = MEASURED[response.quantity]
    frequency = six_digits(response.frequency)
    # Inverse responses are nearly parabolas: to a rounded frequency they go on straight.
    inverse = 1.0 / response.value
    values = 1.0 / (
        np.interp(frequency, response.frequency, inverse.real)
        + 1j * np.interp(frequency, response.frequency, inverse.imag)
    )
    sensor, reference = response.sensor, response.reference
    return {
        "type": 58,
        "func_type": 4,  # a frequency response function
        "id1": f"microslip, {response.quantity} over force",
        "id2": f"force of {response.force:.6g} N"[:80],
        "id4": (sensor.text or "NONE")[:80],
        "id5": (reference.text or "NONE")[:80],
        "rsp_node": sensor.number,
        "rsp_dir": _DIRECTIONS[sensor.direction],
        "ref_node": reference.number,
        "ref_dir": _DIRECTIONS[reference.direction],
        "abscissa_spacing": 0,
        "abscissa_spec_data_type": _FREQUENCY,
        "abscissa_axis_lab": "Frequency",
        "abscissa_axis_units_lab": "Hz",
        "ordinate_spec_data_type": measured.kind,
        "ordinate_axis_lab": response.quantity.capitalize(),
        "ordinate_axis_units_lab": measured.unit,
        "orddenom_spec_data_type": _FORCE,
        "orddenom_axis_lab": "Force",
        "orddenom_axis_units_lab": "N",
        "z_axis_spec_data_type": _FORCE,
        "z_axis_axis_lab": "Force amplitude",
        "z_axis_axis_units_lab": "N",
        "z_axis_value": response.force,
        "x": frequency,
        "data": values,
    }
