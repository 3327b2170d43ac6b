"""The report: a page that is whole, safe, small, and says what the result says."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from html_pages import Page

import microslip as ms
from microslip.figures.picture import PictureCache
from microslip.report.html import html_page as html_page
from microslip.report.predicted.document import prediction_document
from microslip.report.predicted.figures import prediction_pictures

EXAMPLE = Path(__file__).parents[2] / "examples" / "al2017.toml"


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
