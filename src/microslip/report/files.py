"""Files of a result: their names and writers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from microslip._core import kernels
from microslip._core.checks import Progress
from microslip._core.dataset import DataSet
from microslip._core.wording import ESCAPED
from microslip._version import __version__
from microslip.figures.picture import Picture
from microslip.report.document import Document, File
from microslip.report.html import html_page


def header(kind: str, schema: int, title: str) -> dict[str, Any]:
    """Return the first entries of a summary.json, common to all kinds of results."""
    return {
        "kind": f"microslip-{kind}",
        "schema": schema,
        "generator": {"name": "microslip", "version": __version__, "kernel": kernels.NAME},
        "title": title,
    }


def complete(document: Document, kinds: Sequence[str] = ("svg",), *, page: bool = True) -> Document:
    """Return the document with all files of its folder, which its summary names.

    ``kinds`` are the formats of the figures; ``page`` includes the page of the report.
    """
    files = [
        *document.files,
        *(
            File(f"{picture.name}.{kind}", partial(_draw, picture, kind))
            for picture in document.pictures
            for kind in kinds
        ),
    ]
    names = ["report.html"] if page else []
    names += [*(file.name for file in files), "summary.json"]
    document = replace(document, data={**document.data, "files": names})
    if page:
        files.insert(0, text_file("report.html", lambda: html_page(document)))
    files.append(text_file("summary.json", lambda: json_text(document.data)))
    return replace(document, files=tuple(files))


def _draw(picture: Picture, kind: str, path: Path) -> None:
    path.write_bytes(picture.as_bytes(kind))


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
    document = complete(document, kinds)
    write_all(document.files, folder, progress)
    return document


def json_text(data: Mapping[str, Any]) -> str:
    """Format plain values as JSON, numbers with all digits."""
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
