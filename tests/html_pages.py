"""A page of HTML as it is read: whole, safe, with its tags and its text."""

from __future__ import annotations

import base64
import hashlib
from html.parser import HTMLParser

from microslip.figures.picture import script

VOID = {"meta", "img", "br", "hr", "input"}
"""Tags without an end."""
FORBIDDEN = {"script", "link", "iframe", "object", "embed", "form", "base"}
ALLOWED = ("#", "https://doi.org/10.", "data:image/svg+xml;")
"""Beginnings of addresses: a page fetches nothing."""


class Page(HTMLParser):
    """What is on a page.

    It fails where a tag is not closed where it was opened, and where anything but the one script
    of the package could run or be fetched.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        code = f"<script>{script('ticks.js')}{script('figure.js')}</script>"
        assert text.count(code) == 1
        hashed = base64.b64encode(hashlib.sha256(code[8:-9].encode()).digest()).decode()
        assert f"script-src 'sha256-{hashed}'" in text
        text = text.replace(code, "")
        assert "url(" not in text
        assert "@import" not in text
        self.feed(text)
        self.close()
        assert not self.open, f"left open: {self.open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag not in FORBIDDEN
        names = [name for name, _ in attrs]
        assert len(set(names)) == len(names), f"an attribute twice in {tag}"
        for name, value in attrs:
            assert not name.startswith("on"), tag
            if name in ("src", "href", "srcset", "action", "data"):
                assert (value or "").startswith(ALLOWED), value
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open[-1] == tag, f"</{tag}> in {self.open}"  # noqa: PT018
        self.open.pop()

    def handle_data(self, data: str) -> None:
        self.text += data
