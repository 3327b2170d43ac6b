"""Functional mock-up unit (FMI 2.0 or 3.0) built around the exported C source."""

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
from typing import Any

from microslip._core.errors import InputError
from microslip._version import __version__
from microslip.export.c_source import (
    comment,
    components_of,
    declarations,
    definitions,
    order_of,
    render,
)
from microslip.export.request import Files, Order

_EPOCH = (1980, 1, 1, 0, 0, 0)  # fixed time stamp in the zip, so that equal joints give equal files
_PLATFORMS = {  # folders of FMI 2.0 and 3.0, file suffix, and target name of zig
    "linux": ("linux64", "x86_64-linux", ".so", "x86_64-linux-gnu.2.17"),
    "darwin": ("darwin64", "x86_64-darwin", ".dylib", "x86_64-macos"),
    "win32": ("win64", "x86_64-windows", ".dll", "x86_64-windows-gnu"),
}
_BUILD = (
    '<?xml version="1.0" encoding="UTF-8"?>\n<fmiBuildDescription fmiVersion="3.0">\n'
    '  <BuildConfiguration modelIdentifier="{0}"><SourceFileSet language="C99">'
    '<SourceFile name="{0}.c"/></SourceFileSet></BuildConfiguration>\n</fmiBuildDescription>\n'
)


def write_fmu(order: Order) -> Files:
    """Return a functional mock-up unit (FMU) as {file name: bytes of the archive}.

    It contains a binary for each platform for which a compiler is found.
    """
    header = comment(order.header())
    body = f"{header}\n/* {order.size} node(s). */\n{declarations(order)}\n{definitions(order)}"
    guid = f"{{{uuid.uuid5(uuid.NAMESPACE_URL, body)}}}"
    third = order.kind == "fmu3"
    words: dict[str, Any] = {
        "NAME": order.name,
        "GUID": guid,
        "VERSION": __version__,
        "NODES": order.size,
    }
    if third:
        words |= _arrays(order)
    source = body + render("unit.c", **words) + render(f"{order.kind}.c", **words)
    description = render("modelDescription3.xml" if third else "modelDescription.xml", **words)
    page = f"<!DOCTYPE html><title>{order.name}</title><pre>{escape(header)}</pre>"
    parts: dict[str, bytes] = {
        "modelDescription.xml": description.encode(),
        f"sources/{order.name}.c": source.encode(),
        "documentation/index.html": page.encode(),
    }
    if third:
        parts["sources/buildDescription.xml"] = _BUILD.format(order.name).encode()
    parts |= _binaries(order.name, source, third)
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in parts.items():
            file.writestr(zipfile.ZipInfo(name, _EPOCH), content, zipfile.ZIP_DEFLATED)
    return {f"{order.stem}.fmu": archive.getvalue()}


def _arrays(order: Order) -> dict[str, object]:
    components = components_of(order.element)
    node = f'<Dimension start="{order.size}"/>'
    component = f'<Dimension start="{components}"/>' if components > 1 else ""
    return {
        "ZEROS": " ".join(["0.0"] * (order.size * components)), "SCALAR": node,
        "VECTOR": node + component, "MATRIX": node + component + component,
        "ORDER": order_of(order.element),
    }  # fmt: skip


def _binaries(name: str, source: str, third: bool) -> dict[str, bytes]:
    compiler = shutil.which(os.environ.get("CC", "cc"))
    native = sys.platform if sys.maxsize > 2**32 else ""
    if platform.machine() not in ("x86_64", "AMD64", "arm64"):
        native = ""
    zig = [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") else None
    libraries = {}
    for system, (second, folder, ending, target) in _PLATFORMS.items():
        if system == native and compiler is not None:
            command = [compiler, "-fPIC", "-fvisibility=hidden"]
        elif zig is not None:
            command = [*zig, "-target", target, "-fvisibility=hidden"]
            command += ["-Wl,-s"] if system != "darwin" else []
        else:
            continue
        path = f"binaries/{folder if third else second}/{name}{ending}"
        libraries[path] = _library(command, name, ending, source)
    return libraries


def _library(command: list[str], name: str, ending: str, source: str) -> bytes:
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
            complaint = (process.stderr.strip().splitlines() or ["no message"])[0]
            raise InputError(f"the C compiler {command[0]} cannot build the library: {complaint}")
        return library.read_bytes()
