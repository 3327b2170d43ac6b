"""Named figures of a report, with their HTML elements and scripts."""

from __future__ import annotations

import base64
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path

from microslip.figures.plot import Plot


@dataclass(frozen=True)
class Picture:
    """Named figure with its caption, computed only if a renderer needs it."""

    name: str  # stem of the file names
    caption: str  # one or two sentences
    plot: Callable[[], Plot]  # returns the figure as data
    alternative: str  # alternative text for screen readers

    @cached_property
    def _drawn(self) -> Plot:
        return self.plot()

    @cached_property
    def svg(self) -> bytes:
        """The figure as an SVG file, for the folder and for the page."""
        from microslip.figures.svg import svg  # SVG needs no Matplotlib

        return svg(self._drawn)

    def as_bytes(self, kind: str) -> bytes:
        """Render the figure as "svg", "png" or "pdf"."""
        if kind == "svg":
            return self.svg
        from microslip.figures.matplotlib_figure import rendered

        return rendered(self._drawn, kind)


def script(name: str) -> str:
    """Return the source of a script for pages, ``ticks.js`` or ``figure.js``."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def figure_element(picture: Picture, number: int) -> str:
    """Return a numbered HTML ``<figure>`` with its caption.

    The SVG is embedded as an image, so that its ids and styles have no effect on the page.
    """
    source = "data:image/svg+xml;base64," + base64.b64encode(picture.svg).decode("ascii")
    return (
        f'<figure>\n<img src="{source}" alt="{escape(picture.alternative)}">\n'
        f"<figcaption><strong>Figure {number}.</strong> {escape(picture.caption)}</figcaption>\n"
        "</figure>\n"
    )
