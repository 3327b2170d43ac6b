"""Files of a result: their names and writers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from microslip._core import kernels
from microslip._core.checks import Progress
from microslip._core.dataset import DataSet
from microslip._core.wording import ESCAPED
from microslip._version import __version__
from microslip.report.document import Document, File
from microslip.report.folder import staged


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

            return text_file(name, lambda: html_page(document))
        return File(name, lambda path: path.write_bytes(pictures[stem].as_bytes(kind)))

    return tuple(map(file, document.data["files"]))


def text_file(name: str, text: Callable[[], str]) -> File:
    """Return a text file whose content is computed when it is written."""
    return File(name, lambda path: path.write_bytes(text().encode("utf-8", ESCAPED)))


def csv_file(
    name: str,
    make: Callable[[], DataSet],
    columns: Mapping[str, str] | None = None,
    dims: tuple[str, ...] = ("row",),
) -> File:
    """Return a CSV table of a data set, which is made when the file is written.

    ``columns`` maps headings to names, all of the data set by default; see
    :meth:`~microslip._core.dataset.DataSet.csv_lines`.
    """

    def write(path: Path) -> None:
        data = make()
        with path.open("w", encoding="utf-8", errors=ESCAPED, newline="") as file:
            file.writelines(data.csv_lines(columns or {key: key for key in data}, dims))

    return File(name, write)


def write_all(files: Sequence[File], folder: Path, progress: Progress | None = None) -> None:
    """Write files into an existing folder."""
    for number, file in enumerate(files, 1):
        file.write(folder / file.name)
        if progress is not None:
            progress(number / len(files))


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
