"""What makes the release: one version everywhere, and a recipe that asks for what is needed."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

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
