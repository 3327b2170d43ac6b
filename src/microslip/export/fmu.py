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
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path

from microslip._version import __version__
from microslip.errors import InputError
from microslip.export.c_source import comment, declarations, definitions, filled
from microslip.export.request import Accuracy, Order

_EPOCH = (1980, 1, 1, 0, 0, 0)  # of a zip: equal joints give equal files
_PLATFORMS = {  # folders of FMI 2.0, endings, and what zig calls them
    "linux": ("linux64", ".so", "x86_64-linux-gnu.2.17"),
    "darwin": ("darwin64", ".dylib", "x86_64-macos"),
    "win32": ("win64", ".dll", "x86_64-windows-gnu"),
}


def write(order: Order) -> tuple[dict[str, str | bytes], Accuracy]:
    """The archive, with a binary for this machine if it has a C compiler, and by zig for all."""
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
    parts |= _binaries(order.name, source)
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in parts.items():
            file.writestr(zipfile.ZipInfo(name, _EPOCH), content, zipfile.ZIP_DEFLATED)
    return {f"{order.stem}.fmu": archive.getvalue()}, order.accuracy


def _binaries(name: str, source: str) -> dict[str, bytes]:
    """Libraries for this machine and, where ziglang is installed, for every other one.

    Nothing where there is no compiler: the sources then serve.
    """
    compiler = shutil.which(os.environ.get("CC", "cc"))
    native = sys.platform if sys.maxsize > 2**32 else ""
    if platform.machine() not in ("x86_64", "AMD64", "arm64"):
        native = ""
    zig = [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") else None
    libraries = {}
    for system, (folder, ending, target) in _PLATFORMS.items():
        if system == native and compiler is not None:
            command = [compiler, "-fPIC", "-fvisibility=hidden"]
        elif zig is not None:
            command = [*zig, "-target", target, "-fvisibility=hidden"]
            command += ["-Wl,-s"] if system != "darwin" else []
        else:
            continue
        path = f"binaries/{folder}/{name}{ending}"
        libraries[path] = _library(command, name, ending, source)
    return libraries


def _library(command: list[str], name: str, ending: str, source: str) -> bytes:
    """What a compiler makes of the source."""
    with tempfile.TemporaryDirectory() as scratch:
        file, library = Path(scratch) / f"{name}.c", Path(scratch) / f"{name}{ending}"
        file.write_text(source, encoding="utf-8")
        process = subprocess.run(
            [*command, "-std=c99", "-O2", "-shared", "-o", str(library), str(file), "-lm"],
            capture_output=True,
            text=True,
            check=False,
        )
        if process.returncode:
            complaint = (process.stderr.strip().splitlines() or ["it says nothing"])[0]
            raise InputError(f"the C compiler {command[0]} does not make a library: {complaint}")
        return library.read_bytes()
