"""Height maps from files of profilometers and microscopes, and from points with coordinates.

Instrument files are read by SurfaceTopography, DOI 10.1088/2051-672X/ac860a.
"""

from __future__ import annotations

import contextlib
import math
import re
import warnings
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip._core.units import LENGTH, QuantityError, engineering, to_si
from microslip._core.wording import did_you_mean, quote, shorten
from microslip.readers import hdf5
from microslip.readers.child import parsed
from microslip.readers.files import (
    allowed_points,
    decoded,
    file_kind,
    first_line,
    head_of,
    refuse_beyond,
)

_OFF = 0.05  # largest deviation of a coordinate from the grid, over the step
_SMALLEST_SHARE = 0.01  # smallest fraction of grid points with a height
_NEIGHBOURS = 0.02  # neighbours per point along the axes: a rotated grid has none


def on_grid(coordinates: list[Floats], heights: Floats) -> tuple[Floats, tuple[float, ...]]:
    """Arrange the heights of points on a regular grid; return the array and the steps in x, y.

    Grid points without a height become NaN.
    """
    places, counts, steps = [], [], []
    for name, values in zip("xy", coordinates, strict=False):
        place, count, step = _axis(name, values)
        places.append(place)
        counts.append(count)
        steps.append(step)
    refuse_beyond(*counts[::-1])
    total = int(np.prod(counts, dtype=float))
    if heights.size < _SMALLEST_SHARE * total:
        raise ValueError(
            f"{heights.size} points on a grid of {' x '.join(map(str, counts))}: the points "
            "are scattered; interpolate them onto a regular grid first"
        )
    index = places[0] if len(places) == 1 else places[1] * counts[0] + places[0]
    occupied = np.zeros(total, dtype=bool)
    occupied[index] = True
    if (twice := index.size - int(np.count_nonzero(occupied))) > 0:
        raise ValueError(f"{twice} points coincide with another point")
    grid = occupied.reshape(counts[::-1])
    if grid.ndim == 2:
        beside = np.count_nonzero(grid[:, 1:] & grid[:, :-1])
        beside += np.count_nonzero(grid[1:] & grid[:-1])
        if beside < _NEIGHBOURS * heights.size:
            raise ValueError(
                f"{heights.size} points on a grid of {' x '.join(map(str, counts))}, few of them "
                "neighbours: the grid is rotated or the points are scattered; interpolate them "
                "onto a regular grid along x and y first"
            )
    result = np.full(total, np.nan)
    result[index] = heights
    return result.reshape(counts[::-1]), tuple(steps)


def evenly_spaced(x: Floats, heights: Floats) -> tuple[Floats, tuple[float, ...], tuple[str, ...]]:
    """Return the heights of a profile at equidistant x, the step in x, and notes.

    If x is rounded to few digits, as in Dektak files, the mean step is used. Heights at uneven x
    are interpolated linearly to equidistant x.
    """
    steps = np.diff(x)
    if x.size < 4 or not np.all(np.isfinite(x)) or not (np.all(steps >= 0.0) or np.all(steps <= 0)):
        return *on_grid([x], heights), ()  # reports what is wrong
    with contextlib.suppress(ValueError):
        return *on_grid([x], heights), ()
    numbers = np.arange(x.size)
    mean, first = np.polyfit(numbers, x, 1).tolist()
    off = float(np.abs(x - first - mean * numbers).max())
    # Steps of rounded places differ by whole digits.
    sizes = np.diff(np.unique(np.append(0.0, np.abs(steps))))
    digit = float(sizes[sizes > 1e-6 * abs(mean)].min(initial=np.inf))
    if off <= digit < np.inf:
        note = f"x: rounded to {digit:.3g} in the file; the mean step {abs(mean):.6g} is used."
    elif np.all(steps != 0.0):
        mean = float(x[-1] - x[0]) / (x.size - 1)
        even = x[0] + mean * numbers
        order = np.sign(mean)
        heights = np.interp(order * even, order * x, heights)
        note = f"x: uneven steps, interpolated linearly at their mean {abs(mean):.6g}."
    else:
        return *on_grid([x], heights), ()
    return heights, (abs(mean),), (note,)


def _axis(name: str, values: Floats) -> tuple[np.ndarray, int, float]:
    """Return the grid index of each point along an axis, the number of grid lines, and the step."""
    if not np.all(np.isfinite(values)):
        raise ValueError(f"{name} must be a finite number for each point")
    distinct = np.unique(values)
    gaps = np.diff(distinct)
    if not gaps.size:
        raise ValueError(f"all points have the same {name}: wanted a grid, or columns x and z")
    # Encoder coordinates repeat only approximately: small gaps are noise.
    step = float(np.median(gaps[gaps > 1e-4 * gaps.max()]))
    if gaps.sum() / step < 2.0**53:
        # Count gap by gap first, since the error of a rounded step accumulates; then fit the step.
        places = np.concatenate([[0.0], np.cumsum(np.rint(gaps / step))])
        place = places[np.searchsorted(distinct, values)]
        for _ in range(2):
            mean = place.mean()
            spread = place - mean
            step = float(spread @ values / (spread @ spread))
            start = float(values.mean() - step * mean)
            place = np.rint((values - start) / step)
        off = float(np.abs(values - start - step * place).max())
        if off <= _OFF * step:
            place -= place.min()
            return place.astype(np.int64), int(place.max()) + 1, step
    raise ValueError(
        f"{name} is not on a regular grid (neighbours are mostly {step:g} apart); interpolate the "
        "points onto one first"
    )


# Formats that microslip reads itself, and a reader that accepts any file of a certain size.
_EXCLUDED_FORMATS = ("npy", "npz", "mat", "asc", "xyz", "hgt")
_IGNORED_WARNINGS = (DeprecationWarning, FutureWarning, ImportWarning, ResourceWarning)
_BYTES_A_POINT = 64
_BESIDE = 1 << 28  # bytes of images and logs stored with the heights
_BYTES_A_SECOND = 2e6  # of SurfaceTopography, which reads text in Python
_XML = 1 << 23  # largest XML file in an archive [bytes]; parsed XML takes many times that

_INSTEAD = 'text with any suffix is read with format="text"'

# An NMS file states nanometres where SurfaceTopography expects millimetres.
_WIDEST_NMS = 1e-3

_NANOSCOPE = b"\\*File list"
"""First bytes of files of Bruker's Nanoscope, whose suffix is a running number of three digits."""


class RawHeights(NamedTuple):
    """Heights as stored in a file, before conversion of units."""

    kind: str
    """Kind of the file and its reader or layout, for the notes."""
    values: np.ndarray
    """Heights in the unit of the file; missing points are NaN or masked."""
    unit: str | None = None
    """Unit of the heights stated by the file; None if it is not."""
    pixel: tuple[float, ...] | None = None
    """Distance between neighbouring points [m], if the file states it."""
    notes: tuple[str, ...] = ()
    steps: tuple[float, ...] | None = None
    """Distance between neighbouring points in the unit of the coordinates."""
    columns: tuple[str | None, str | None] = (None, None)
    """Units of the coordinates and of the heights, from column names."""


def read_channel(path: Path, format_name: str | None, channel: str | int | None) -> RawHeights:
    """Return the requested height channel, read in the given or the first suitable format."""
    _check_size(path)
    content = parsed(
        "instrument file",
        path,
        read_height_channel,
        libraries=["SurfaceTopography.IO", "scipy.sparse", "scipy.io"],
        bytes_a_second=_BYTES_A_SECOND,
        format_name=format_name,
        channel_name=channel,
    )
    pixel = None if content["pixel"] is None else tuple(content["pixel"])
    return RawHeights(
        content["kind"], content["values"], content["unit"], pixel, tuple(content["notes"])
    )


def read_height_channel(path: Path, format_name: str | None, channel_name: str | int | None) -> Any:
    """Return a height channel, read by SurfaceTopography, as a mapping of the fields of RawHeights.

    Runs in the child process.
    """
    with warnings.catch_warnings(record=True) as messages:
        warnings.simplefilter("always")
        try:
            heights = _read(path, format_name, channel_name)
        except InputError:
            raise
        except ValueError as error:
            raise InputError(str(error)) from None
    warnings_given = dict.fromkeys(
        shorten(first_line(w.message), 160)
        for w in messages
        if isinstance(w.message, Warning) and not issubclass(w.category, _IGNORED_WARNINGS)
    )
    remarks = tuple(f"SurfaceTopography: {text}" for text in list(warnings_given)[:5])
    values = heights.values
    if np.ma.isMaskedArray(values) and np.ma.getmaskarray(values).any():
        values = np.ma.filled(values.astype(float), np.nan)
    return heights._replace(
        values=np.ma.getdata(values), notes=(*heights.notes, *remarks)
    )._asdict()


def _library() -> Any:
    with warnings.catch_warnings(), needed_for("instrument files are read by", "scan", _INSTEAD):
        warnings.simplefilter("ignore")
        from SurfaceTopography import IO
    return IO


def _read(path: Path, format_name: str | None, channel_name: str | int | None) -> RawHeights:
    from importlib.metadata import version

    reader, name = _open(path, format_name)
    try:
        with decoded(f"{name} file", quiet=False):
            channels = list(reader.channels)
        index = _channel_index(channels, channel_name)
        channel = channels[index]
        with decoded(f"{name} file", quiet=False):
            shape = tuple(int(n) for n in np.atleast_1d(channel.nb_grid_pts))
            refuse_beyond(*shape)
            values, pixel, unit, remarks = _heights(reader, channel, index, shape)
    finally:
        with contextlib.suppress(Exception):  # the data have been read
            reader.close()
    notes = list(remarks)
    unread = [str(c.name) for i, c in enumerate(channels) if i != index]
    if unread:
        notes.append(f"not read: {', '.join(shorten(text, 40) for text in unread[:20])}.")
    if name == "nms" and pixel is not None and min(pixel) > _WIDEST_NMS:
        notes.append(
            f"pixel: {engineering(pixel[0], 'm')} according to SurfaceTopography, which reads the "
            "nanometres of an nms file as millimetres; divided by a million."
        )
        pixel = tuple(step * 1e-6 for step in pixel)
    library = f"SurfaceTopography {version('SurfaceTopography')}"
    kind = f'{name} file by {library}, channel "{shorten(channel.name, 60)}"'
    return RawHeights(kind, values, unit, pixel, tuple(notes))


def _check_size(path: Path) -> None:
    if file_kind(head_of(path), path.suffix.lower()) == "hdf5":
        hdf5.read_hdf5(path)  # rejects links to other files, which SurfaceTopography would follow
    largest = allowed_points() * _BYTES_A_POINT + _BESIDE
    size = path.stat().st_size
    if zipfile.is_zipfile(path):
        with decoded("archive"), zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
        size = max(size, sum(entry.file_size for entry in entries))
        for entry in entries:
            if entry.filename.lower().endswith(".xml") and entry.file_size > _XML:
                raise ValueError(
                    f"{shorten(entry.filename, 40)} in the archive unpacks to "
                    f"{entry.file_size / 1e6:.0f} MB, wanted at most {_XML / 1e6:.0f} MB"
                )
    if size > largest:
        raise InputError(
            f"unpacks to {size / 1000000.0:.0f} MB, more than `limit={allowed_points()}` "
            "points can need; raise the limit if memory suffices"
        )


def _open(path: Path, format_name: str | None) -> tuple[Any, str]:
    library = _library()
    readers = library.lookup_reader_by_format
    if format_name is not None:
        if format_name not in readers:
            house_formats = ("npy", "npz", "text", "matrix", "xyz", "profile", "mat")
            names = [*house_formats, *sorted({*readers} - {*house_formats})]
            raise InputError(
                f"`format`: no format {quote(format_name)}{did_you_mean(format_name, names)}; "
                f"there are {', '.join(names)}"
            )
        with decoded(f"{format_name} file", quiet=False):
            return readers[format_name](str(path)), format_name
    with path.open("rb") as file:
        head = file.read(library.MAGIC_BUFFER_SIZE)
    suffix = suffix_of(path, head)
    failed: InputError | None = None
    for reader in _candidates(library, head, suffix):
        name = reader.format()
        try:
            with decoded(f"{name} file", quiet=False):
                return reader(str(path)), name
        except InputError as error:
            failed = failed or error
    if failed:
        raise failed
    raise InputError(
        "format not recognised from the first bytes or the suffix; write "
        "`format=...`, one of text, npy, npz, "
        f"{', '.join(sorted({*readers} - {'text', 'npy', 'npz'}))}"
    )


def suffix_of(path: Path, head: bytes) -> str:
    """Return the suffix of a file by which its reader is chosen; 001 for all Nanoscope files."""
    suffix = path.suffix.lower().lstrip(".")
    return "001" if head.startswith(_NANOSCOPE) or re.fullmatch(r"\d{3}", suffix) else suffix


def _candidates(library: Any, head: bytes, suffix: str) -> list[Any]:
    """Return readers that recognise the first bytes, then those that match the suffix.

    Other readers are not tried: they are slow, and some accept files of other formats.
    """
    certain: list[Any] = []
    called: list[Any] = []
    for reader in library.readers:
        match = reader.can_read(head)
        ending = suffix in [reader.format(), *(str(e).lower() for e in reader.file_extensions())]
        if reader.format() in _EXCLUDED_FORMATS or match == library.MagicMatch.NO:
            continue
        if match == library.MagicMatch.YES:
            # Two formats may share the first bytes: the suffix decides.
            certain.insert(0, reader) if ending else certain.append(reader)
        elif ending:
            called.append(reader)
    return certain + called


def _channel_index(channels: list[Any], channel_name: Any) -> int:
    names = [str(channel.name) for channel in channels]
    listed = ", ".join(f'{i}: "{shorten(name, 40)}"' for i, name in enumerate(names[:20]))
    if channel_name is None:
        able = [i for i, channel in enumerate(channels) if channel.is_height_channel]
        if len(able) == 1:
            return able[0]
        if not able:
            raise ValueError(f"no height channel; the channels are {listed or 'none'}")
        listed = ", ".join(f'{i}: "{shorten(names[i], 40)}"' for i in able[:20])
        raise InputError(f"{len(able)} height channels, {listed}; write `channel=...`")
    text = str(channel_name)
    if text in names and not isinstance(channel_name, int):
        if names.count(text) > 1:
            raise ValueError(
                f"{names.count(text)} channels have this name, {listed}; write a number"
            )
        return names.index(text)
    if text.isdecimal() and int(text) < len(names):
        return int(text)
    hint = did_you_mean(text, names)
    raise ValueError(f"no channel {quote(channel_name)}{hint}; the channels are {listed}")


def _heights(
    reader: Any, channel: Any, index: int, shape: tuple[int, ...]
) -> tuple[np.ndarray, tuple[float, ...] | None, str | None, tuple[str, ...]]:
    sizes = channel.physical_sizes
    options = {} if sizes is not None else {"physical_sizes": tuple(float(n) for n in shape)}
    topography = reader.topography(channel_index=index, **options)
    heights = topography.heights()
    if heights.size and heights.ndim == 2:
        heights = heights.T
    unit = channel.unit
    if unit is None:
        return heights, None, None, ()
    factor = _factor(unit)
    if not topography.is_uniform:
        if heights.ndim != 1:
            raise ValueError("points are not on a regular grid; interpolate them onto one first")
        grid, steps, notes = evenly_spaced(
            np.asarray(topography.positions(), dtype=float), np.asarray(heights, dtype=float)
        )
        return grid, (steps[0] * factor,), unit, notes
    if sizes is None:
        return heights, None, unit, ()
    lengths = np.atleast_1d(np.asarray(sizes, dtype=float)) * factor
    pixel = tuple(float(a / n) for a, n in zip(lengths, shape, strict=True))
    if not all(math.isfinite(step) and step > 0.0 for step in pixel):
        return heights, None, unit, ()
    return heights, pixel, unit, ()


def _factor(unit: str) -> float:
    try:
        return to_si(f"1 {unit}", LENGTH, "1 um")
    except QuantityError as error:
        raise ValueError(f"length unit of the file: {error}") from None
