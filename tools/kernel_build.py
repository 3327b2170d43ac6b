"""The build backend: setuptools, and a C compiler from PyPI where this machine has none.

One source, one kernel. Measured for a machine without a compiler:

- ziglang, a wheel with a whole C compiler (100 MB to download, 5 s to compile the kernel once): the
  same kernel, as fast as that of the machine's own compiler (0.81 to 1.04 of the time of gcc 12).
  It serves Linux (glibc and musl), macOS and Windows, and knows no Python.h: `_python.h` stands in.
- Wheels are quicker still where there is an index that has them; from source they do not help.
- One source that also runs uncompiled (Cython's pure mode) runs at Python's pace: 50 to 100 times
  slower for one joint under a load that varies, and it would be a second road to test.

Run as a script it prints what is to be installed before a build without isolation, or nothing.
"""

from __future__ import annotations

import os
import sys
import sysconfig
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import setuptools  # noqa: F401 - it is what makes distutils importable
from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403 - all other hooks are its own

COMPILER = "ziglang>=0.13"
NO_COMPILER = (
    "microslip's kernel is C, and neither a C compiler nor ziglang was found. Install one of them "
    "(gcc, clang or MSVC; or: pip install ziglang, on any platform), then install microslip again"
)


@lru_cache
def finds_compiler() -> bool:
    """Whether the compiler that setuptools would use compiles anything."""
    from distutils.ccompiler import new_compiler
    from distutils.sysconfig import customize_compiler

    with tempfile.TemporaryDirectory() as folder, Path(os.devnull).open("w") as nowhere:
        source = Path(folder, "probe.c")
        source.write_text("#include <math.h>\nint probe(void) { return 0; }\n", encoding="utf-8")
        try:
            with redirect_stdout(nowhere), redirect_stderr(nowhere):
                compiler = new_compiler()
                customize_compiler(compiler)
                objects = compiler.compile([str(source)], output_dir=folder)
                return all(Path(name).exists() for name in objects)
        except Exception:  # whatever it is, there is no compiler then
            return False


def zig_command(sources: list[str], target: str, macros: list[tuple[str, str]]) -> list[str]:
    """The command that makes the extension with ziglang."""
    if find_spec("ziglang") is None:
        raise SystemExit(f"error: {NO_COMPILER}")
    flags = ["-shared", "-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off", "-s"]
    if sys.platform == "win32":
        flags += [f"-L{Path(sys.base_prefix, 'libs')}", "-lpython3"]
    else:
        flags += ["-fPIC", "-lm"]
    if sys.platform == "darwin":
        flags += ["-undefined", "dynamic_lookup"]
    include = sysconfig.get_path("include")
    defines = [f"-D{name}={value}" for name, value in macros]
    zig = [sys.executable, "-m", "ziglang", "cc"]
    return [*zig, *flags, *defines, f"-I{include}", *sources, "-o", target]


def get_requires_for_build_wheel(config_settings=None):
    return build_meta.get_requires_for_build_wheel(config_settings) + _compiler()


def get_requires_for_build_editable(config_settings=None):
    return build_meta.get_requires_for_build_editable(config_settings) + _compiler()


def _compiler() -> list[str]:
    return [] if finds_compiler() else [COMPILER]


if __name__ == "__main__":
    if not finds_compiler() and find_spec("ziglang") is None:
        print(COMPILER)
