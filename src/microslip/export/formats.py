"""Every kind of file, what it is, and whether it was ever run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from microslip.export import c_source, fitted_laws, fmu, tables
from microslip.export import element_files as elements
from microslip.export.order import Accuracy, Order

_RUN = "run by the tests of microslip"
_NOT_RUN = "not run here, written after the public manual"


@dataclass(frozen=True)
class Format:
    """A kind of file that a law can be exported to."""

    kind: str
    """Its name."""
    summary: str
    """What it is, in a line."""
    run: str
    """Whether it was ever run, and against what."""
    suffixes: tuple[str, ...]
    """Endings of its file; the first one stands for those that are not in the list."""
    write: Callable[[Order], tuple[dict[str, str | bytes], Accuracy]]
    """Makes its files by their names, and says how exact they are."""


FORMATS = (
    Format(
        "c", "one C99 file, exact, with a header and an interface for Fortran",
        f"{_RUN}, compiled, against joint.force", (".c",), c_source.write,
    ),
    Format(
        "fmu", "an FMI 2.0 unit for model exchange and co-simulation, exact, its sources inside",
        f"{_RUN} with FMPy, against joint.force", (".fmu",), fmu.write,
    ),
    Format(
        "opensees", "elements for OpenSees, in Python or Tcl",
        f"{_RUN} with OpenSeesPy 3.5.1, against the cells", (".py", ".tcl"), elements.opensees,
    ),
    Format(
        "calculix", "elements for CalculiX",
        f"{_RUN} with CalculiX 2.20, against the cells", (".inp",), elements.calculix,
    ),
    Format("abaqus", "connectors for Abaqus", _NOT_RUN, (".inp",), elements.abaqus),
    Format("ansys", "COMBIN40 elements for Ansys", _NOT_RUN, (".mac", ".inp"), elements.ansys),
    Format("lsdyna", "discrete elements for LS-DYNA", _NOT_RUN, (".k", ".key"), elements.lsdyna),
    Format("nastran", "rods for Nastran", _NOT_RUN, (".bdf", ".dat"), elements.nastran),
    Format(
        "table", "backbone, energies and cells",
        f"{_RUN}, read back", (".json", ".csv"), tables.write,
    ),
    Format(
        "segalman", "the four-parameter model of Segalman that is closest, and its misfit",
        f"{_RUN}, as a study", (".toml", ".json"), fitted_laws.write,
    ),
    Format(
        "bouc-wen", "the model of Bouc and Wen that is closest, and its misfit",
        f"{_RUN}, read back", (".json",), fitted_laws.write,
    ),
    Format(
        "iwan", "Iwan's cells over the range, and their misfit",
        f"{_RUN}, as a study", (".toml", ".json"), fitted_laws.write,
    ),
)  # fmt: skip

KINDS = tuple(item.kind for item in FORMATS)
"""Kinds of files that :func:`microslip.export.write` writes."""
