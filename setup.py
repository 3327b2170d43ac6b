"""The optional C extension; everything else about the package is in pyproject.toml.

One abi3 wheel serves CPython 3.11 and every later version. Where nothing can compile, the build
goes on without the extension and the package uses its NumPy twin.
"""

import platform
import sysconfig
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

# Free-threaded builds (as of 3.14) and PyPy have no limited API: there the wheel is of one version.
LIMITED_API = platform.python_implementation() == "CPython" and not sysconfig.get_config_var(
    "Py_GIL_DISABLED"
)

# Fast, but the numbers stay those of the source: no -ffast-math, no -march=native, and no
# contraction into fused multiply-adds, which the NumPy twin could not follow.
UNIX_FLAGS = ["-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off"]
MSVC_FLAGS = ["/O2", "/fp:precise"]


class BuildKernel(build_ext):
    """Choose the flags once the compiler is known."""

    def build_extension(self, ext: Extension) -> None:
        msvc = self.compiler.compiler_type == "msvc"
        ext.extra_compile_args = MSVC_FLAGS if msvc else UNIX_FLAGS
        ext.libraries = [] if msvc else ["m"]
        super().build_extension(ext)


setup(
    cmdclass={"build_ext": BuildKernel},
    ext_modules=[
        Extension(
            "microslip.kernels._compiled",
            sources=["src/microslip/kernels/_compiled.c"],
            depends=[str(header) for header in Path("src/microslip/kernels").glob("*.h")],
            define_macros=[("Py_LIMITED_API", "0x030B0000")] if LIMITED_API else [],
            py_limited_api=LIMITED_API,
            optional=True,
        )
    ],
    options={"bdist_wheel": {"py_limited_api": "cp311"}} if LIMITED_API else {},
)
