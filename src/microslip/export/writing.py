"""Writing of exported files: either all files of an export are written or none."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from microslip._core.checks import show, whole_number
from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.wording import one_line
from microslip.export import c_source, fmu
from microslip.export import element_files as elements
from microslip.export.request import (
    Accuracy,
    Files,
    Order,
    check_name,
    check_word,
    checked_patches,
    described,
    element_of,
)
from microslip.friction import IsotropicField, IsotropicJoint, Parallel
from microslip.friction.conversions import amplitude_range

_RUN = "run by the tests of microslip"
_OPENSEES = f"{_RUN} with OpenSeesPy 3.5.1, against the cells"
_CALCULIX = f"{_RUN} with CalculiX 2.20, against the cells"


class _Format(NamedTuple):
    kind: str
    run: str  # how this kind of file was verified
    suffix: str  # of the files
    write: Callable[[Order], Files]  # returns the files by name


_FORMATS = (
    _Format("c", f"{_RUN}, compiled, against joint.force", ".c", c_source.write_c),
    _Format(
        "abaqus-user",
        f"{_RUN}, called as Abaqus calls it, by Fortran; not run in Abaqus",
        ".c",
        c_source.write_user,
    ),
    _Format("fmu", f"{_RUN} with FMPy, against joint.force", ".fmu", fmu.write_fmu),
    _Format("fmu3", f"{_RUN} with FMPy, against joint.force", ".fmu", fmu.write_fmu),
    _Format("opensees", _OPENSEES, ".py", elements.opensees),
    _Format("calculix", _CALCULIX, ".inp", elements.calculix),
)

KINDS = tuple(item.kind for item in _FORMATS)
"""Kinds of files that :func:`microslip.export.write` can write."""


_MOST_DEPTH = 1_000_000
_MOST_CELLS = 10_000
_MOST_ENERGY_ERROR = 0.05  # over the range of amplitudes
_MOST_NODES = 10_000


@dataclass(frozen=True)
class Exported:
    """Files written by an export, and their accuracy with respect to the law."""

    files: tuple[Path, ...]
    """Paths of the files."""
    accuracy: Accuracy
    """Errors over the range of amplitudes."""
    run: str
    """Verification of this kind of file."""


def write(
    kind: str,
    law: Any,
    file: str | Path,
    *,
    smallest_amplitude: float | None = None,
    largest_amplitude: float | None = None,
    cells: int = 50,
    depth: int = 256,
    element: str = "joint",
    size: int = 1,
    name: str = "joint",
    nodes: ArrayLike | None = None,
    direction: int = 1,
    first_number: int | None = None,
    overwrite: bool = False,
) -> Exported:
    """Write a law as input of another program; the file header states the errors.

    Parameters
    ----------
    kind : str
        One of :data:`microslip.export.KINDS`.
    law : BackboneLaw, IsotropicJoint, IsotropicField or JointField
        The law. Laws in two directions can be exported only as code, a field only as elements.
    file : str or pathlib.Path
        File to write; some kinds write further files with the same stem.
    smallest_amplitude, largest_amplitude : float, optional
        Range of amplitudes [m] for cells and errors, by default 0.01 and 10 times the
        displacement force_limit / tangential_stiffness.
    cells : int, optional
        Number of cells [-], at least 2, for kinds that use cells.
    depth : int, optional
        Rows of memory [-] of exported code, at least 4. A row is used for each reversal whose loop
        is not closed yet and, under varying load, for each increase of the load. If rows run out,
        the oldest loops are merged: decaying motion stays exact, and for motion that grows back to
        the size of merged loops the function ``<name>_error`` of the code returns a bound of the
        error [N].
    element : str, optional
        For code: ``joint``, one displacement at a constant load; ``contact``, with the separation;
        ``planar``, two displacements; ``planar-contact``, two displacements and the separation. The
        last two use ``cells`` sliders.
    size : int, optional
        Number of nodes [-] of an FMI 3 unit, each with this joint, up to 10 000.
    name : str, optional
        Beginning of all names in the file.
    nodes : array_like of int, optional
        Two mesh node numbers for each patch, shape (patches, 2); without them the elements must be
        connected by hand.
    direction : int, optional
        Direction of the joint in the mesh: 1, 2 or 3 for x, y or z.
    first_number : int, optional
        First number of the added elements, materials and nodes; by default the number after the
        largest of ``nodes``. Added nodes must not coincide with nodes of a patch.
    overwrite : bool, optional
        Replace existing files.

    Returns
    -------
    Exported
        The files and their accuracy.

    Notes
    -----
    Cells are those of :meth:`microslip.BackboneLaw.to_iwan` (Iwan 1966, DOI 10.1115/1.3625199).
    Exported code stores the backbone as piecewise polynomials, exact to rounding, and follows
    Masing's rules.
    """
    check_word("kind", kind, KINDS)
    file_format = _FORMATS[KINDS.index(kind)]
    try:
        path = Path(file)
    except TypeError:
        raise InputError(f"`file` must be a path, got {show(file)}") from None
    suffix = file_format.suffix
    stem = path.stem if path.suffix == suffix else path.name
    if not stem or stem.startswith("."):
        raise InputError(f"`file` must be the name of a file, got {show(str(file))}")
    check_name(name)
    depth = whole_number("depth", depth, 4, _MOST_DEPTH)
    cells = whole_number("cells", cells, 2, _MOST_CELLS)
    direction = whole_number("direction", direction, 1, 3)
    size = whole_number("size", size, 1, _MOST_NODES)
    if size > 1 and kind != "fmu3":
        raise InputError(f"`size` must be 1 for {kind}, got {size}; several nodes need fmu3")
    limits = {"smallest_amplitude": smallest_amplitude, "largest_amplitude": largest_amplitude}
    element, model, law_along = element_of(kind, law, element, cells, limits)
    patches = checked_patches(kind, law_along, nodes)
    if first_number is None:
        first_number = 1 + max((node for patch in patches for node in patch.nodes), default=0)
    first_number = whole_number("first_number", first_number, 1, 90_000_000)
    whole = patches[0].law if len(patches) == 1 else Parallel([patch.law for patch in patches])
    order = Order(
        kind, file_format.run, patches, element, model,
        amplitude_range(whole, smallest_amplitude, largest_amplitude),
        cells, depth, size, name, direction, first_number, stem, suffix,
        one_line(described(law_along)),
    )  # fmt: skip
    _check_energy(order, law, limits)
    texts = file_format.write(order)
    paths = [path.parent / text for text in texts]
    with ExitStack() as stack:
        stages = [stack.enter_context(atomic_file(item, overwrite)) for item in paths]
        for stage, content in zip(stages, texts.values(), strict=True):
            stage.write_bytes(content.encode() if isinstance(content, str) else content)
    return Exported(tuple(paths), order.accuracy, file_format.run)


def _check_energy(order: Order, law: Any, limits: dict[str, Any]) -> None:
    """Raise InputError if the dissipated energy of the file is in error by more than 5 %.

    The largest error over the amplitudes counts. Only models of cells or sliders exceed the limit;
    for cells the message states a sufficient number.
    """
    error = order.accuracy.energy_error
    if not error > _MOST_ENERGY_ERROR:
        return
    low = order.span[0]
    if isinstance(law, (IsotropicJoint, IsotropicField)):
        raise InputError(
            f"`law` must have enough sliders for cycles of {low:.3g} m, got a relative error of "
            f"{error:.3g} in the energy; give the joint itself with `cells`, more sliders, "
            "or a larger `smallest_amplitude`"
        )
    cells = order.cells
    while cells < _MOST_CELLS:
        cells = min(2 * cells, _MOST_CELLS)
        _, model, _ = element_of(order.kind, law, order.element, cells, limits)
        if replace(order, model=model, cells=cells).accuracy.energy_error <= _MOST_ENERGY_ERROR:
            break
    else:
        cells = 0
    remedy = (
        f"give cells={cells} for an error below {100.0 * _MOST_ENERGY_ERROR:g} %, or a larger "
        "smallest_amplitude"
        if cells
        else "give a larger smallest_amplitude"
    )
    raise InputError(
        f"`cells` must be enough for cycles of {low:.3g} m, where {order.cells} cells have a "
        f"relative error of {error:.3g} in the dissipated energy; {remedy}"
    )
