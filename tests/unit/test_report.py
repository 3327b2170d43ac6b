"""The report: a page that is whole, safe and small."""

from __future__ import annotations

from pathlib import Path

import pytest
from html_pages import Page

import microslip as ms
from microslip.figures.picture import PictureCache
from microslip.report.html import html_page as html_page
from microslip.report.predicted.document import prediction_document

EXAMPLE = Path(__file__).parents[2] / "examples" / "al2017.toml"


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
