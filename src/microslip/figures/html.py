"""Figures in HTML pages: the element of a figure, and the scripts that let readers zoom into it."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path

from microslip.figures.picture import Picture


def script(name: str) -> str:
    """Return the source of one of the package's scripts: ``ticks.js`` or ``figure.js``."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def figure(picture: Picture, number: int, svg: bytes) -> str:
    """Return a numbered ``<figure>`` with its caption.

    The SVG is embedded as an image, so that its ids and styles do not mix with those of the page.
    """
    source = "data:image/svg+xml;base64," + base64.b64encode(svg).decode("ascii")
    return (
        f'<figure>\n<img src="{source}" alt="{escape(picture.alternative or picture.caption)}">\n'
        f"<figcaption><strong>Figure {number}.</strong> {escape(picture.caption)}</figcaption>\n"
        "</figure>\n"
    )
