"""Named figures of a report, and the cache that renders each figure once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
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
