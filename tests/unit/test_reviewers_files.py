"""Files that reviewers and archives read: they are there, they agree, what is to be filled in."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest

import microslip as ms

ROOT = Path(__file__).parents[2]


def text(name: str) -> str:
    return (ROOT / name).read_text("utf-8")


def test_versions_agree() -> None:
    assert json.loads(text("codemeta.json"))["version"] == ms.__version__
    assert re.search(r"^version: (.*)$", text("CITATION.cff"), re.M).group(1) == ms.__version__  # type: ignore[union-attr]


def test_every_citation_of_the_paper_is_in_its_bibliography() -> None:
    cited = set(re.findall(r"@([a-z]+\d{4})", text("paper.md")))
    known = set(re.findall(r"^@\w+\{(\w+),", text("paper.bib"), re.M))
    assert cited <= known
    assert known - cited == set()
    for program in ("TMDSimPy", "NLvib", "pyHarm", "tamaas", "SurfaceTopography", "CONTACT"):
        assert program in text("paper.md")


def test_workflows_and_templates_are_there() -> None:
    for name in ("tests.yml", "docs.yml", "wheels.yml"):
        assert "runs-on:" in text(f".github/workflows/{name}")
    assert "make test" in text(".github/workflows/tests.yml")
    assert "make docs" in text(".github/workflows/docs.yml")
    for name in ("ISSUE_TEMPLATE/wrong-result.md", "ISSUE_TEMPLATE/measurement.md"):
        assert text(f".github/{name}").startswith("---\nname: ")


def test_placeholders_are_filled_in() -> None:
    """Skips with the list of what only a maintainer knows."""
    urls = tomllib.loads(text("pyproject.toml"))["project"]["urls"]
    waiting = [f"[project.urls] {name}" for name, url in urls.items() if "example.org" in url]
    waiting += ["contact in CODE_OF_CONDUCT.md"] * ("example.org" in text("CODE_OF_CONDUCT.md"))
    waiting += ["affiliation in paper.md"] * ("To be filled in" in text("paper.md"))
    if waiting:
        pytest.skip(f"to be filled in: {', '.join(waiting)}")
