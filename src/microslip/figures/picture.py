"""Named figures of a report: their cache, their element in HTML and the scripts that zoom."""

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
    """A figure that is made only when a renderer wants it."""

    name: str  # stem of its files
    caption: str  # what to see in it, in a sentence or two
    plot: Callable[[], Plot]  # says the figure as data
    alternative: str = ""  # what it is, for those who cannot see it


class PictureCache:
    """Makes each picture once: the file and the page share it."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str], Any] = {}

    def as_bytes(self, picture: Picture, kind: str = "svg") -> bytes:
        """The picture in a format: "svg", "png" or "pdf"."""
        if (picture.name, "plot") not in self._made:
            self._made[picture.name, "plot"] = picture.plot()
        if (picture.name, kind) not in self._made:
            # Lines and text need no Matplotlib.
            where = "svg" if kind == "svg" else "matplotlib_figure"
            render = getattr(import_module(f"microslip.figures.{where}"), kind)
            self._made[picture.name, kind] = render(self._made[picture.name, "plot"])
        image: bytes = self._made[picture.name, kind]
        return image


def script(name: str) -> str:
    """Return the source of one of the package's scripts: ``ticks.js`` or ``figure.js``."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def figure_element(picture: Picture, number: int, svg: bytes) -> str:
    """Return a numbered ``<figure>`` with its caption.

    The SVG is embedded as an image, so that its ids and styles do not mix with those of the page.
    """
    source = "data:image/svg+xml;base64," + base64.b64encode(svg).decode("ascii")
    return (
        f'<figure>\n<img src="{source}" alt="{escape(picture.alternative or picture.caption)}">\n'
        f"<figcaption><strong>Figure {number}.</strong> {escape(picture.caption)}</figcaption>\n"
        "</figure>\n"
    )
