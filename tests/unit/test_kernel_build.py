"""The build where there is no C compiler."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def backend() -> Any:
    spec = spec_from_file_location("kernel_build", ROOT / "tools" / "kernel_build.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_without_a_compiler_the_build_asks_for_one() -> None:
    code = (
        "import sys; sys.path.insert(0, 'tools'); import kernel_build as b\n"
        "print(b.get_requires_for_build_wheel(), b.get_requires_for_build_editable())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT,
        env={**os.environ, "CC": "false"},
    )  # fmt: skip
    assert done.stdout.count("ziglang>=") == 2, done


def test_with_neither_it_says_what_to_do(backend: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backend, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match=r"Install one of them .*pip install ziglang"):
        backend.zig_command(["a.c"], "a.so", [])


def test_the_command_has_the_flags_of_the_numbers(
    backend: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(backend, "find_spec", lambda name: object())
    command = backend.zig_command(["a.c"], "a.so", [("Py_LIMITED_API", "0x030B0000")])
    assert {"-ffp-contract=off", "-shared", "a.c", "-DPy_LIMITED_API=0x030B0000"} <= set(command)
    assert not {"-ffast-math", "-march=native"} & set(command)
