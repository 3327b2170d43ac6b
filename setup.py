"""The C extension and the schema of studies; everything else is in pyproject.toml.

One abi3 wheel serves CPython 3.11 and every later version. `tools/kernel_build.py` is the build
backend, and says what compiles where the machine has no compiler.
"""

import os
import platform
import subprocess
import sys
import sysconfig
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

sys.path.insert(0, str(Path(__file__).parent / "tools"))
from kernel_build import finds_compiler, zig_command

# Free-threaded builds (as of 3.14) and PyPy have no limited API: there the wheel is of one version.
LIMITED_API = platform.python_implementation() == "CPython" and not sysconfig.get_config_var(
    "Py_GIL_DISABLED"
)

# Fast, but the numbers stay those of the source: no -ffast-math, no -march=native, and no
# contraction into fused multiply-adds, with which the numbers would hang on the processor.
UNIX_FLAGS = ["-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off"]
MSVC_FLAGS = ["/O2", "/fp:precise"]


class BuildKernel(build_ext):
    """Choose the compiler, and its flags; then write what the package says of its studies."""

    def run(self) -> None:
        super().run()
        # In place the package lies in its sources, otherwise where the wheel is put together.
        folder = Path("src" if self.inplace else self.build_lib).resolve()
        schema = folder / "microslip" / "study" / "study.schema.json"
        schema.write_bytes(
            subprocess.run(
                [sys.executable, "-m", "microslip.study.json_schema"],
                # What this process finds: an isolated build has NumPy in a place of its own.
                env={
                    **os.environ,
                    "PYTHONPATH": os.pathsep.join([str(folder), *filter(None, sys.path)]),
                    "PYTHONIOENCODING": "utf-8",
                },
                stdout=subprocess.PIPE,
                check=True,
            ).stdout
        )

    def build_extension(self, ext: Extension) -> None:
        if finds_compiler():
            msvc = self.compiler.compiler_type == "msvc"
            ext.extra_compile_args = MSVC_FLAGS if msvc else UNIX_FLAGS
            ext.libraries = [] if msvc else ["m"]
            super().build_extension(ext)
            return
        target = Path(self.get_ext_fullpath(ext.name))
        command = zig_command(ext.sources, str(target), ext.define_macros)
        target.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(command, check=True)


setup(
    cmdclass={"build_ext": BuildKernel},
    ext_modules=[
        Extension(
            "microslip._core.kernels._compiled",
            sources=["src/microslip/_core/kernels/_compiled.c"],
            depends=[str(header) for header in Path("src/microslip/_core/kernels").glob("*.h")],
            define_macros=[("Py_LIMITED_API", "0x030B0000")] if LIMITED_API else [],
            py_limited_api=LIMITED_API,
        )
    ],
    options={"bdist_wheel": {"py_limited_api": "cp311"}} if LIMITED_API else {},
)
