"""Files that reviewers and archives read: they are there, they agree, what is to be filled in."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from urllib.parse import unquote

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


def test_badges_are_true() -> None:
    """Compare each badge of the README with the file that it is about."""
    badges = re.findall(r"^\[!\[([^\]]+)\]\(([^)]+)\)\]\(([^)]+)\)$", text("README.md"), re.M)
    words = [words for words, _, _ in badges]
    project = tomllib.loads(text("pyproject.toml"))["project"]
    versions = re.search(r"python: \[(.+)\]", text(".github/workflows/tests.yml"))
    assert versions is not None
    tested = re.findall(r"[\d.]+", versions[1])
    assert words == ["tests", f"licence {project['license']}", f"Python {' | '.join(tested)}"]
    assert all(f"Programming Language :: Python :: {v}" in project["classifiers"] for v in tested)
    assert "actions/workflows/tests.yml" in badges[0][1]
    for (label, message), (_, picture, _) in zip(
        (("licence", project["license"]), ("Python", " | ".join(tested))), badges[1:], strict=True
    ):
        assert unquote(picture).startswith(f"https://img.shields.io/badge/{label}-{message}-")
    assert "zenodo" not in text("README.md"), "a DOI of microslip also belongs into CITATION.cff"
