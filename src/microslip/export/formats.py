"""Table of all kinds of files: what writes each, and how it was verified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from microslip.export import c_source, fitted_laws, fmu, tables
from microslip.export import element_files as elements
from microslip.export.request import Accuracy, Order

_RUN = "run by the tests of microslip"
_OPENSEES = f"{_RUN} with OpenSeesPy 3.5.1, against the cells"
_CALCULIX = f"{_RUN} with CalculiX 2.20, against the cells"
_NOT_RUN = "not run here, written after the public manual"


@dataclass(frozen=True)
class Format:
    """A kind of file that a law can be exported to."""

    kind: str
    """Its name."""
    run: str
    """Whether it was ever run, and against what."""
    suffixes: tuple[str, ...]
    """Endings of its file; the first one stands for those that are not in the list."""
    write: Callable[[Order], tuple[dict[str, str | bytes], Accuracy]]
    """Makes its files by their names, and says how exact they are."""


FORMATS = (
    Format("c", f"{_RUN}, compiled, against joint.force", (".c",), c_source.write),
    Format(
        "abaqus-user",
        f"{_RUN}, called as Abaqus calls it, by Fortran; not run in Abaqus",
        (".c",),
        c_source.write_user,
    ),
    Format("fmu", f"{_RUN} with FMPy, against joint.force", (".fmu",), fmu.write),
    Format("fmu3", f"{_RUN} with FMPy, against joint.force", (".fmu",), fmu.write),
    Format("opensees", _OPENSEES, (".py", ".tcl"), elements.opensees),
    Format("calculix", _CALCULIX, (".inp",), elements.calculix),
    Format("abaqus", _NOT_RUN, (".inp",), elements.abaqus),
    Format("ansys", _NOT_RUN, (".mac", ".inp"), elements.ansys),
    Format("lsdyna", _NOT_RUN, (".k", ".key"), elements.lsdyna),
    Format("nastran", _NOT_RUN, (".bdf", ".dat"), elements.nastran),
    Format("table", f"{_RUN}, read back", (".json", ".csv"), tables.write),
    Format("segalman", f"{_RUN}, as a study", (".toml", ".json"), fitted_laws.write),
    Format("bouc-wen", f"{_RUN}, read back", (".json",), fitted_laws.write),
    Format("iwan", f"{_RUN}, as a study", (".toml", ".json"), fitted_laws.write),
)

KINDS = tuple(item.kind for item in FORMATS)
"""Kinds of files that :func:`microslip.export.write` writes."""
