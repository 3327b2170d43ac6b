"""A unit of FMI 2.0 (functional mock-up) around the exported C, its sources inside."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from html import escape
from io import BytesIO
from pathlib import Path

from microslip._version import __version__
from microslip.errors import InputError
from microslip.export.c_source import comment, declarations, definitions, filled
from microslip.export.request import Accuracy, Order

_EPOCH = (1980, 1, 1, 0, 0, 0)  # of a zip: equal joints give equal files
_PLATFORMS = {
    ("linux", 64): ("linux64", ".so"),
    ("darwin", 64): ("darwin64", ".dylib"),
    ("win32", 64): ("win64", ".dll"),
}


def write(order: Order) -> tuple[dict[str, str | bytes], Accuracy]:
    """The archive, with a binary for this machine if it has a C compiler."""
    header = comment(order.header())
    body = f"{header}\n{declarations(order)}\n{definitions(order)}"
    guid = f"{{{uuid.uuid5(uuid.NAMESPACE_URL, body)}}}"
    source = body + filled("fmu.c", NAME=order.name, GUID=guid)
    description = filled("modelDescription.xml", NAME=order.name, GUID=guid, VERSION=__version__)
    page = f"<!DOCTYPE html><title>{order.name}</title><pre>{escape(header)}</pre>"
    parts: dict[str, bytes] = {
        "modelDescription.xml": description.encode(),
        f"sources/{order.name}.c": source.encode(),
        "documentation/index.html": page.encode(),
    }
    parts |= _binary(order.name, source)
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in parts.items():
            file.writestr(zipfile.ZipInfo(name, _EPOCH), content, zipfile.ZIP_DEFLATED)
    return {f"{order.stem}.fmu": archive.getvalue()}, order.accuracy


def _binary(name: str, source: str) -> dict[str, bytes]:
    """The library for this machine; nothing where there is no compiler: the sources then serve."""
    compiler = shutil.which(os.environ.get("CC", "cc"))
    bits = 64 if sys.maxsize > 2**32 else 32
    place = _PLATFORMS.get((sys.platform, bits))
    if compiler is None or place is None or platform.machine() not in ("x86_64", "AMD64", "arm64"):
        return {}
    folder, ending = place
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / f"{name}.c"
        file.write_text(source, encoding="utf-8")
        library = Path(scratch) / f"{name}{ending}"
        command = [compiler, "-std=c99", "-O2", "-shared", "-fPIC", "-fvisibility=hidden"]
        process = subprocess.run(
            [*command, "-o", str(library), str(file), "-lm"],
            capture_output=True,
            text=True,
            check=False,
        )
        if process.returncode:
            complaint = (process.stderr.strip().splitlines() or ["it says nothing"])[0]
            raise InputError(f"the C compiler {compiler} does not make a library: {complaint}")
        return {f"binaries/{folder}/{name}{ending}": library.read_bytes()}
