"""Every kind of file, what it is, and whether it was ever run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import cast

from microslip.export.order import Accuracy, Order

_RUN = "run by the tests of microslip"
_NOT_RUN = "not run here, written after the public manual"

Files = dict[str, str | bytes]


@dataclass(frozen=True)
class Format:
    """A kind of file that a law can be exported to."""

    kind: str
    """Its name."""
    what: str
    """What it is, in a line."""
    run: str
    """Whether it was ever run, and against what."""
    suffixes: tuple[str, ...]
    """Endings of its file; the first one stands for those that are not in the list."""
    module: str
    """Module that writes it."""

    def write(self, order: Order) -> tuple[Files, Accuracy]:
        """Its files by their names, and how exact they are."""
        writer = cast("Callable[[Order], tuple[Files, Accuracy]]", import_module(self.module).write)
        return writer(order)


def _here(name: str) -> str:
    return f"microslip.export.{name}"


FORMATS = (
    Format(
        "c", "one C99 file, exact, with a header and an interface for Fortran",
        f"{_RUN}, compiled, against joint.force", (".c",), _here("c_source"),
    ),
    Format(
        "fmu", "an FMI 2.0 unit for model exchange and co-simulation, exact, its sources inside",
        f"{_RUN} with FMPy, against joint.force", (".fmu",), _here("fmu"),
    ),
    Format(
        "opensees", "elements for OpenSees, in Python or Tcl",
        f"{_RUN} with OpenSeesPy 3.5.1, against the cells", (".py", ".tcl"), _here("opensees"),
    ),
    Format(
        "calculix", "elements for CalculiX",
        f"{_RUN} with CalculiX 2.20, against the cells", (".inp",), _here("calculix"),
    ),
    Format("abaqus", "connectors for Abaqus", _NOT_RUN, (".inp",), _here("abaqus")),
    Format("ansys", "COMBIN40 elements for Ansys", _NOT_RUN, (".mac", ".inp"), _here("ansys")),
    Format("lsdyna", "discrete elements for LS-DYNA", _NOT_RUN, (".k", ".key"), _here("lsdyna")),
    Format("nastran", "rods for Nastran", _NOT_RUN, (".bdf", ".dat"), _here("nastran")),
    Format(
        "table", "backbone, energies and cells",
        f"{_RUN}, read back", (".json", ".csv"), _here("tables"),
    ),
    Format(
        "segalman", "the four-parameter model of Segalman that is closest, and its misfit",
        f"{_RUN}, as a study", (".toml", ".json"), _here("fitted_laws"),
    ),
    Format(
        "bouc-wen", "the model of Bouc and Wen that is closest, and its misfit",
        f"{_RUN}, read back", (".json",), _here("fitted_laws"),
    ),
    Format(
        "iwan", "Iwan's cells over the range, and their misfit",
        f"{_RUN}, as a study", (".toml", ".json"), _here("fitted_laws"),
    ),
)  # fmt: skip

KINDS = tuple(item.kind for item in FORMATS)
"""Kinds of files that :func:`microslip.export.write` writes."""
