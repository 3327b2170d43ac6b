"""The report: a page that is whole, safe, small, and says what the result says."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from html_pages import Page
from studies import LOADS, SURFACE, SURFACES, edited

import microslip as ms
from microslip.figures.picture import PictureCache
from microslip.report.html import html_page as html_page
from microslip.report.predicted.document import prediction_document
from microslip.report.predicted.figures import prediction_pictures

EXAMPLE = Path(__file__).parents[2] / "examples" / "al2017.toml"


def study(*edits: tuple[str, str], folder: Path = Path()) -> ms.Study:
    return ms.Study.from_toml(edited(*edits), folder=folder)


def page(*edits: tuple[str, str], folder: Path = Path()) -> Page:
    return Page(told(study(*edits, folder=folder).run()))


def told(result: ms.Result) -> str:
    return html_page(prediction_document(result), PictureCache())


# -- the page -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def demo() -> ms.Result:
    return ms.Study.load(EXAMPLE).run()


@pytest.fixture(scope="module")
def text(demo: ms.Result) -> str:
    shares: list[float] = []
    page = html_page(prediction_document(demo), PictureCache(), shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    return page


def test_the_page_is_whole_and_mails_well(text: str) -> None:
    found = Page(text)
    assert text.startswith("<!DOCTYPE html>")
    assert text.count("<!DOCTYPE") == 1
    assert len(text) < 700_000
    tags = [tag for tag, _ in found.tags]
    assert tags.count("html") == tags.count("head") == tags.count("body") == tags.count("main") == 1
    assert tags.count("title") == tags.count("h1") == 1
    assert ("meta", {"charset": "utf-8"}) in found.tags
    assert any(attrs.get("name") == "viewport" for tag, attrs in found.tags if tag == "meta")
    assert "@media print" in text


def test_names_on_the_page_are_unique_and_links_lead_somewhere(text: str) -> None:
    found = Page(text)
    names = [attrs["id"] for _, attrs in found.tags if "id" in attrs]
    assert len(set(names)) == len(names)
    links = [(attrs.get("href") or "")[1:] for tag, attrs in found.tags if tag == "a"]
    assert {link for link in links if "/" not in link} <= set(names)


def test_every_figure_is_on_the_page(text: str, demo: ms.Result) -> None:
    images = [attrs for tag, attrs in Page(text).tags if tag == "img"]
    assert len(images) == len(prediction_pictures(demo)) == text.count("<figcaption>")
    for attrs in images:
        kind, data = (attrs["src"] or "").split(",")
        assert kind == "data:image/svg+xml;base64"
        root = ET.fromstring(base64.b64decode(data, validate=True))
        paths = list(root.iter("{http://www.w3.org/2000/svg}path"))
        assert len(paths) > 10
        assert len(attrs["alt"] or "") > 20


# -- study --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SURFACES)
def test_every_surface_has_a_page_with_its_law(name: str) -> None:
    found = page((SURFACE, SURFACES[name]), (LOADS, '"50 N"'))
    law = re.search(r'law = "([\w-]+)"', SURFACES[name])
    assert law
    equations = found.words["span"]
    numbers = {
        "greenwood-williamson": "(19.8)",
        "population": "(19.3), (19.27)",
        "sphere": "(19.3)",
        "table": "",
    }
    assert f"(19.12){numbers[law[1]]}(19.15)" in equations
    assert ("is the table of the study" in found.words["p"]) == (law[1] == "table")
    assert ("(19.7), (19.9)" in equations) == (law[1] != "table")


# -- equations, provenance ----------------------------------------------------------------------


def test_equations_are_well_formed_mathml(text: str) -> None:
    formulas = re.findall(r"<math.*?</math>", text, flags=re.DOTALL)
    assert len(formulas) > 20
    arity = {"mfrac": 2, "msub": 2, "msup": 2, "msubsup": 3, "munder": 2}
    core = {"math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "msqrt", *arity}
    for formula in formulas:
        for node in ET.fromstring(formula).iter():
            assert node.tag in core
            assert len(node) == arity.get(node.tag, len(node)), formula
            if node.tag in ("mi", "mn", "mo", "mtext"):
                assert not len(node)
                assert (node.text or "").strip()
