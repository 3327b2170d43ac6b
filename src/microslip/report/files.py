"""Files of a result: their names, estimated cost and writers."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Any

from microslip._core import kernels, netcdf
from microslip._core.checks import Progress
from microslip._core.dataset import DataSet
from microslip._core.wording import ESCAPED
from microslip._version import __version__
from microslip.figures.picture import PictureCache
from microslip.report.document import Document, File
from microslip.report.folder import staged

# Approximate times [s] for the progress bar: a number as text, a binary number, a figure.
TEXT, NUMBER, FIGURE = 6e-7, 9e-8, 0.02


def header(kind: str, schema: int, title: str) -> dict[str, Any]:
    """Return the first entries of a summary.json, common to all kinds of results."""
    return {
        "kind": kind,
        "schema": schema,
        "generator": {"name": "microslip", "version": __version__, "kernel": kernels.NAME},
        "title": title,
    }


def with_file_names(
    document: Document, kinds: Sequence[str] = ("svg",), *, page: bool = True
) -> Document:
    """Return the document with the names of all files in its summary.

    ``kinds`` are the formats of the figures; ``page`` includes the page of the report.
    """
    figures = (f"{picture.name}.{kind}" for picture in document.pictures for kind in kinds)
    names = [*["report.html"] * page, *(file.name for file in document.files), *figures]
    names.append("summary.json")
    return replace(document, data={**document.data, "files": names})


def standard_files(document: Document) -> tuple[File, ...]:
    """Return the files that the summary of a document names."""
    cache = PictureCache()
    by_name = {file.name: file for file in document.files}
    pictures = {picture.name: picture for picture in document.pictures}

    def file(name: str) -> File:
        stem, _, kind = name.rpartition(".")
        if name in by_name:
            return by_name[name]
        if name == "summary.json":
            return text_file(name, lambda: json_text(document.data))
        if name == "report.html":
            from microslip.report.html import html_page

            def write_page(path: Path, progress: Progress) -> None:
                path.write_bytes(html_page(document, cache, progress).encode("utf-8", ESCAPED))

            return File(name, write_page, FIGURE * (len(pictures) + 1))
        picture = pictures[stem]
        cost = FIGURE if kind == "svg" else 20.0 * FIGURE
        return File(name, lambda path, _: path.write_bytes(cache.as_bytes(picture, kind)), cost)

    return tuple(map(file, document.data["files"]))


def text_file(name: str, text: Callable[[], str]) -> File:
    """Return a text file whose content is computed when it is written."""
    return File(name, lambda path, _: path.write_bytes(text().encode("utf-8", ESCAPED)))


def csv_file(
    name: str,
    make: Callable[[], DataSet],
    columns: Mapping[str, str] | None = None,
    dims: tuple[str, ...] = ("row",),
    cost: float = 1e-3,
) -> File:
    """Return a CSV table of a data set, which is made when the file is written.

    ``columns`` maps headings to names, all of the data set by default; see
    :meth:`~microslip._core.dataset.DataSet.csv_lines`.
    """

    def write(path: Path, progress: Progress) -> None:
        data = make()
        lines = data.csv_lines(columns or {key: key for key in data}, dims)
        write_csv(path, lines, data.count(dims) or 1, progress)

    return File(name, write, cost)


def netcdf_file(name: str, data: DataSet) -> File:
    """Return a netCDF-4 file of labelled arrays."""
    count = sum(variable.values.size for variable in data.values())
    return File(name, lambda path, progress: netcdf.store(path, data, progress), count * NUMBER)


def write_all(files: Sequence[File], folder: Path, progress: Progress | None = None) -> None:
    """Write files into an existing folder."""
    report = progress or (lambda share: None)
    # The same summation for parts and total, so that the last fraction is exactly 1.
    reached = list(accumulate((file.cost for file in files), initial=0.0))

    for file, begun, ended in zip(files, reached, reached[1:], strict=False):

        def part(
            share: float, begin: float = begun / reached[-1], end: float = ended / reached[-1]
        ) -> None:
            report(min(begin + (end - begin) * share, end))

        file.write(folder / file.name, part)
        part(1.0)


def write_document(
    document: Document,
    folder: Path,
    kinds: Sequence[str] = ("svg",),
    progress: Progress | None = None,
) -> Document:
    """Write all files of a document into an existing folder.

    Return the document with the names of the files in its summary.
    """
    document = with_file_names(document, kinds)
    write_all(standard_files(document), folder, progress)
    return document


def save(
    files: Sequence[File],
    folder: str | Path,
    kind: str,
    noun: str = "result",
    overwrite: bool = False,
    progress: Progress | None = None,
) -> tuple[Path, ...]:
    """Write files into a folder, all or none; see :func:`~microslip.report.folder.staged`."""
    with staged(Path(folder), overwrite, kind, noun) as stage:
        write_all(files, stage, progress)
    return tuple(Path(folder) / file.name for file in files)


def json_text(data: Mapping[str, Any]) -> str:
    """Format plain values as JSON, numbers with all digits."""
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def write_csv(
    path: Path, lines: Iterable[tuple[int, str]], rows: int, progress: Progress | None = None
) -> None:
    """Write blocks of rows as one CSV file.

    Each item of ``lines`` is the number of rows in a block, and their text. ``rows`` is the total
    number of rows, to compute the finished fraction that ``progress`` receives.
    """
    written = 0
    with path.open("w", encoding="utf-8", errors=ESCAPED, newline="") as file:
        for count, text in lines:
            file.write(text)
            written += count
            if progress is not None:
                progress(written / rows)
