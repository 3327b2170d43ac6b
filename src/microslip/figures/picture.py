"""Named figures of a report, with their cache, HTML elements and scripts."""

from __future__ import annotations

import base64
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any

from microslip.figures.plot import Plot


@dataclass(frozen=True)
class Picture:
    """Named figure with its caption, computed only if a renderer needs it."""

    name: str  # stem of the file names
    caption: str  # one or two sentences
    plot: Callable[[], Plot]  # returns the figure as data
    alternative: str = ""  # alternative text for screen readers


class PictureCache:
    """Cache of rendered pictures, used for both files and pages."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str], Any] = {}

    def as_bytes(self, picture: Picture, kind: str = "svg") -> bytes:
        """Render a picture as "svg", "png" or "pdf"."""
        if (picture.name, "plot") not in self._made:
            self._made[picture.name, "plot"] = picture.plot()
        if (picture.name, kind) not in self._made:
            # SVG needs no Matplotlib.
            where = "svg" if kind == "svg" else "matplotlib_figure"
            render = getattr(import_module(f"microslip.figures.{where}"), kind)
            self._made[picture.name, kind] = render(self._made[picture.name, "plot"])
        image: bytes = self._made[picture.name, kind]
        return image


def script(name: str) -> str:
    """Return the source of a script for pages, ``ticks.js`` or ``figure.js``."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def figure_element(picture: Picture, number: int, svg: bytes) -> str:
    """Return a numbered HTML ``<figure>`` with its caption.

    The SVG is embedded as an image, so that its ids and styles have no effect on the page.
    """
    source = "data:image/svg+xml;base64," + base64.b64encode(svg).decode("ascii")
    return (
        f'<figure>\n<img src="{source}" alt="{escape(picture.alternative or picture.caption)}">\n'
        f"<figcaption><strong>Figure {number}.</strong> {escape(picture.caption)}</figcaption>\n"
        "</figure>\n"
    )
