"""Fixtures and Hypothesis profiles of all tests."""

from __future__ import annotations

import os

# Before NumPy loads: the workers share the cores, and BLAS's threads only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from importlib.util import find_spec
from types import ModuleType
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from microslip import kernels
from microslip.kernels import twin

# The fixture `kernel` lasts a test, which is what Hypothesis warns of and what is wanted here.
_COMMON = {"deadline": None, "suppress_health_check": [HealthCheck.function_scoped_fixture]}
# Derandomised, so that every machine, the CI's included, tries the same examples.
settings.register_profile("quick", max_examples=12, derandomize=True, **_COMMON)
# Where the same code runs again, on another Python or another kernel.
settings.register_profile("few", max_examples=4, derandomize=True, **_COMMON)
settings.register_profile("slow", max_examples=50, derandomize=True, **_COMMON)
# For a search by hand: other examples each time.
settings.register_profile("explore", max_examples=500, print_blob=True, **_COMMON)


def _wants_slow(config: pytest.Config) -> bool:
    return config.option.markexpr == "slow"


def pytest_configure(config: pytest.Config) -> None:
    """HYPOTHESIS_PROFILE chooses the profile; ``-m slow`` means the slow one."""
    default = "slow" if _wants_slow(config) else "quick"
    settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", default))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """With ``-m slow`` every property test joins in, on the many examples of that profile."""
    if _wants_slow(config):
        for item in items:
            if getattr(getattr(item, "obj", None), "is_hypothesis_test", False):
                item.add_marker("slow")


def _compiled() -> ModuleType:
    return pytest.importorskip(
        "microslip.kernels._compiled",
        reason="the compiled kernel is not built: install microslip with a C compiler at hand",
        exc_type=ImportError,
    )


@pytest.fixture
def compiled() -> ModuleType:
    """The compiled kernel, for tests that call it themselves."""
    return _compiled()


def _kernels() -> list[Any]:
    """The kernel of this installation; with `make slow` the twin as well, where it is the other.

    What both make of generated input is compared bit for bit in any case, by
    ``tests/physics/test_kernels.py``.
    """
    built = find_spec("microslip.kernels._compiled") is not None
    return ["compiled", pytest.param("numpy", marks=pytest.mark.slow)] if built else ["numpy"]


@pytest.fixture(params=_kernels())
def kernel(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Runs the test with each kernel."""
    module = twin if request.param == "numpy" else _compiled()
    monkeypatch.setattr(kernels, "active", module)
    return module
