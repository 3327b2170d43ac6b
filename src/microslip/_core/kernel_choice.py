"""Which kernel runs, found out without importing NumPy (``microslip --version`` asks)."""

from __future__ import annotations

import os
import sys
from functools import lru_cache
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path


def kernel_name() -> str:
    """Name of the kernel that this process uses, "compiled" or "numpy".

    The environment variable ``MICROSLIP_KERNEL=numpy`` chooses the NumPy twin; otherwise the
    compiled kernel runs wherever it was built and loads.
    """
    if os.environ.get("MICROSLIP_KERNEL", "").strip().lower() == "numpy":
        return "numpy"
    return "compiled" if _extension_loads() else "numpy"


@lru_cache(maxsize=1)
def _extension_loads() -> bool:
    # The file is looked for beside the package, not through it: importing the package would
    # import NumPy. It is loaded rather than only found, since an extension left by another
    # platform or Python is there and of no use.
    spec = PathFinder.find_spec(
        "microslip.kernels._compiled", [str(Path(__file__).parents[1] / "kernels")]
    )
    if spec is None or spec.loader is None or spec.origin is None:
        return False
    try:
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError:
        return False
    # The one that is loaded is the one that works: an extension is not loaded twice.
    sys.modules.setdefault(spec.name, module)
    return True
