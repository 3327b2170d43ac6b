"""One version everywhere, and how the kernel is built with and without a compiler."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import kernel_build
import pytest

import microslip as ms

ROOT = Path(__file__).parents[2]
VERSION = ms.__version__


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_one_version_and_one_date() -> None:
    section = re.search(r"(?m)^## \[(\S+)\] – (\d{4}-\d\d-\d\d)$", text("CHANGELOG.md"))
    assert section is not None
    assert section[1] == VERSION
    assert f"\nversion: {VERSION}\ndate-released: {section[2]}\n" in text("CITATION.cff")
    assert f'\n  version: "{VERSION}"\n' in text("conda/recipe.yaml")
    assert f'"version": "{VERSION}"' in text("codemeta.json")


def test_the_readme_names_what_the_core_needs_alone() -> None:
    """The line for authors of solvers lists the packages with which core_alone.py is run."""
    line = re.search(r"pip install --no-deps ([a-z ]+)`", text("README.md"))
    named = re.search(r"ALONE = {(.*)}", text("tests/core_alone.py"))
    assert line is not None
    assert named is not None
    assert set(line[1].split()) == set(re.findall(r'"(\w+)"', named[1]))


def test_the_recipe_asks_for_what_the_package_needs() -> None:
    project = tomllib.loads(text("pyproject.toml"))
    run = text("conda/recipe.yaml").partition("  run:\n")[2].partition("\n\n")[0]
    found = {line.removeprefix("    - ").replace(" ", "") for line in run.splitlines()}
    wanted = {line.lower() for line in project["project"]["dependencies"]}
    # conda-forge's matplotlib brings Qt; what draws without it has another name.
    found = {line.replace("matplotlib-base", "matplotlib") for line in found}
    assert found == wanted | {f"python{project['project']['requires-python']}"}
    variants = text("conda/variants.yaml")
    for name in re.findall(r"\$\{\{ (compiler|stdlib)\(\"c\"\)", text("conda/recipe.yaml")):
        assert f"c_{name}:" in variants


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


def test_the_build_has_the_flags_of_the_numbers_or_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(kernel_build, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match=r"Install one of them .*pip install ziglang"):
        kernel_build.zig_command(["a.c"], "a.so", [])
    monkeypatch.setattr(kernel_build, "find_spec", lambda name: object())
    command = kernel_build.zig_command(["a.c"], "a.so", [("Py_LIMITED_API", "0x030B0000")])
    assert {"-ffp-contract=off", "-shared", "a.c", "-DPy_LIMITED_API=0x030B0000"} <= set(command)
    assert not {"-ffast-math", "-march=native"} & set(command)
