"""Fixtures and Hypothesis profiles of all tests."""

from __future__ import annotations

import os
from pathlib import Path

# Before NumPy loads: the workers share the cores, and BLAS's threads only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


import pytest
from hypothesis import HealthCheck, settings

# Fixtures that last a test are what Hypothesis warns of and what is wanted here.
_COMMON = {"deadline": None, "suppress_health_check": [HealthCheck.function_scoped_fixture]}
# Derandomised, so that every machine, the CI's included, tries the same examples. Most properties
# run on thirty examples of laws, so that eight make hundreds; HYPOTHESIS_PROFILE=slow makes more.
settings.register_profile("quick", max_examples=8, derandomize=True, **_COMMON)
# Where the same code runs again, on another Python or from another compiler.
settings.register_profile("few", max_examples=4, derandomize=True, **_COMMON)
settings.register_profile("slow", max_examples=20, derandomize=True, **_COMMON)
# For a search by hand: other examples each time.
settings.register_profile("explore", max_examples=500, print_blob=True, **_COMMON)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, which is the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def pytest_configure(config: pytest.Config) -> None:
    """HYPOTHESIS_PROFILE chooses the profile; ``-m slow`` means the slow one."""
    default = "slow" if config.option.markexpr == "slow" else "quick"
    settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", default))
