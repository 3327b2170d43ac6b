"""Pages from templates, as long as products have some of their own."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from jinja2 import Environment

LARGEST_SVG = 200_000
"""Bytes up to which a figure is lines in any case; beyond, where these are less than a picture."""


class Picture(NamedTuple):
    """A figure as the page shows it."""

    name: str
    source: str
    """A data URI."""
    alternative: str
    """What it is, for those who cannot see it."""
    caption: str
    """What to see in it."""


def environment() -> Environment:
    """Where the templates of all pages are, and how they are filled in."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def data_uri(svg: bytes, png: Callable[[], bytes]) -> str:
    """A figure as a data URI: apart from the page, so that its names and styles stay its own.

    Parameters
    ----------
    svg : bytes
        The figure as SVG.
    png : callable
        Gives it as PNG; called where the SVG is large.

    Returns
    -------
    str
        The smaller one, or the SVG if it is small enough in any case.
    """
    small = packed(svg)
    if len(small) > LARGEST_SVG:
        pixels = png()
        if len(pixels) < len(small):
            return _uri("image/png", pixels)
    return _uri("image/svg+xml", small)


def svg_uri(svg: bytes) -> str:
    """An SVG figure, however large, as a data URI."""
    return _uri("image/svg+xml", packed(svg))


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def packed(svg: bytes) -> bytes:
    """An SVG file without what only its editors use: indentation, comments, names of groups."""
    svg = re.sub(rb"<!--.*?-->|<metadata>.*?</metadata>", b"", svg, flags=re.DOTALL)
    svg = re.sub(rb'<g id="(?:line2d|text|patch|[xy]tick)_\d+">', b"<g>", svg)
    return re.sub(rb">\s+<", b"><", svg)
