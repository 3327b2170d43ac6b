"""Friction laws as JSON files: name of the law and parameters in SI units."""

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.parameters import is_fully_declared, key_of, parameters_of
from microslip._core.wording import shorten
from microslip.friction import laws
from microslip.friction.base import BackboneLaw
from microslip.friction.law_bands import LawBand
from microslip.readers.files import usable

_KIND = "microslip-law"
_VERSION = 1
_LARGEST = 10_000_000  # bytes: a million cells of an Iwan model


def _by_name() -> dict[str, type[BackboneLaw]]:
    return {key_of(kind): kind for kind in laws.LAWS if is_fully_declared(kind)}


def law_content(law: BackboneLaw, band: LawBand | None = None) -> dict[str, Any]:
    """Return the content of a law file; raise InputError unless all parameters are numbers."""
    kinds = _by_name()
    if kinds.get(key_of(type(law))) is not type(law):
        raise InputError(f"`law` must be one of {', '.join(kinds)}, got {show(law)}")
    units = {item.name: item.unit or "-" for item in parameters_of(type(law))}
    return {
        "kind": _KIND,
        "version": _VERSION,
        "law": key_of(type(law)),
        "parameters": {name: np.asarray(getattr(law, name)).tolist() for name in units},
        "units": units,
        **({} if band is None else {"band": band.content}),
    }


def law_text(content: dict[str, Any]) -> str:
    """Format the content of a law file as JSON."""
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def save_law(
    law: BackboneLaw,
    path: str | PathLike[str],
    *,
    overwrite: bool = False,
    band: LawBand | None = None,
) -> None:
    """Write a friction law to a JSON file: name of the law and parameters in SI units.

    Parameters
    ----------
    law : BackboneLaw
        A law that is fully defined by numbers, such as Jenkins or SegalmanIwan.
    path : str or path
        File name ending in ``.json``. The write is atomic.
    overwrite : bool, optional
        Replace an existing file.
    band : LawBand, optional
        Confidence intervals of the law, which a study that uses this file adds to its predictions.

    Raises
    ------
    InputError
        If the law has a surface or other laws as parameters, or the name does not end in ``.json``.
    """
    file, content = Path(path), law_content(law, band)
    if file.suffix.lower() != ".json":
        raise InputError(f"`path` must end in .json, got {show(file.name)}")
    with atomic_file(file, overwrite) as stage:
        stage.write_text(law_text(content), encoding="utf-8")


def load_law(path: str | PathLike[str]) -> BackboneLaw:
    """Read a friction law, of the class named in the file, that :func:`save_law` wrote.

    Parameters
    ----------
    path : str or path
        JSON file.

    Raises
    ------
    InputError
        If the file does not hold a law, has another version, names an unknown law, or has invalid
        parameters.
    """
    return _law_of(*_read(path))


def load_law_and_band(path: str | PathLike[str]) -> tuple[BackboneLaw, LawBand | None]:
    """Read a friction law and its confidence intervals, None if the file has no intervals."""
    file, content = _read(path)
    law = _law_of(file, content)
    if "band" not in content:
        return law, None
    try:
        return law, LawBand.of_content(content["band"])
    except InputError as error:
        raise InputError(f"{file.name}: {error}") from None


def _read(path: str | PathLike[str]) -> tuple[Path, dict[str, Any]]:
    if not isinstance(path, (str, PathLike)):
        raise InputError(f"`path` must be the name of a file, got {show(path)}")
    file = Path(path)
    try:
        with usable(file, "the file of a law"):
            text = file.read_bytes()[: _LARGEST + 1]
    except ValueError as error:
        raise InputError(f"{shorten(file.name, 200)}: {error}") from None
    if len(text) > _LARGEST:
        raise InputError(f"{file.name}: a law must have at most {_LARGEST} bytes")
    try:
        content: Any = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file.name}: is not a JSON law file ({error})") from None
    if not isinstance(content, dict) or content.get("kind") != _KIND:
        raise InputError(f'{file.name}: is not a law file: "kind" must be "{_KIND}"')
    if content.get("version") != _VERSION:
        raise InputError(
            f"{file.name}: version must be {_VERSION}, got {show(content.get('version'))}"
        )
    return file, content


def _law_of(file: Path, content: dict[str, Any]) -> BackboneLaw:
    kinds, name = _by_name(), content.get("law")
    if not isinstance(name, str) or name not in kinds:
        raise InputError(f"{file.name}: law must be one of {', '.join(kinds)}, got {show(name)}")
    wanted = [item.name for item in parameters_of(kinds[name])]
    numbers = content.get("parameters")
    if not isinstance(numbers, dict) or set(numbers) != set(wanted):
        given = sorted(numbers) if isinstance(numbers, dict) else numbers
        raise InputError(
            f"{file.name}: parameters of {name} must be {', '.join(wanted)}, got {show(given)}"
        )
    units = {item.name: item.unit or "-" for item in parameters_of(kinds[name])}
    if content.get("units") != units:
        raise InputError(f"{file.name}: units must be {units}, got {show(content.get('units'))}")
    try:
        return kinds[name](**numbers)
    except InputError as error:
        raise InputError(f"{file.name}: {error}") from None
