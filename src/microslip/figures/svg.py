"""Figures written directly as SVG, which takes milliseconds per page."""

from __future__ import annotations

import base64
import re
import struct
import zlib
from collections.abc import Iterable
from functools import singledispatch
from html import escape

import numpy as np
from numpy.typing import NDArray

from microslip._core.wording import ESCAPED
from microslip.figures import plot as shapes
from microslip.figures.layout import SMALL, TEXT, TITLE, AxisScale, Page, PanelFrame, lay_out
from microslip.figures.plot import Floats, Marker, Plot

_FONT = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif"
_NO_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_HALO = 'paint-order="stroke" stroke="#fff" stroke-width="3" stroke-linejoin="round"'
_ALL_DRAWN = 32  # lines with up to this many points are drawn in full
_STRAIGHT = 0.01  # [pt] deviation from the chord of the neighbours below which a point is dropped
_THINNED_FROM = 3000  # lines with more points are thinned to the resolution of print
_NEAR = 0.25  # [pt] distance between points after thinning


def svg(plot: Plot) -> bytes:
    """Return a figure as a self-contained SVG file; equal plots give equal bytes."""
    page = lay_out(plot)
    parts = [
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{page.width:.4g}pt" '
        f'height="{page.height:.5g}pt" viewBox="0 0 {page.width:.4g} {page.height:.5g}" '
        f'font-family="{_FONT}" font-size="{SMALL}" fill="#1a1a1a" stroke-linejoin="round">'
        '<rect width="100%" height="100%" fill="#fff"/>'
    ]
    for number, line in enumerate(page.title):
        y = 6.0 + TITLE * (0.9 + 1.25 * number)
        parts.append(_text(0.5 * page.width, y, line, TITLE, "middle"))
    for number, frame in enumerate(page.frames):
        parts += _panel(frame, f"p{number}")
    parts += _legend(page)
    parts.append("</svg>\n")
    return "".join(parts).encode("utf-8", ESCAPED)


def _escaped(text: str) -> str:
    text = escape(_NO_XML.sub("\N{REPLACEMENT CHARACTER}", text), quote=False)
    return text.replace('"', "&quot;")


def _text(
    x: float, y: float, text: str, size: float = SMALL, anchor: str = "start", attributes: str = ""
) -> str:
    sized = "" if size == SMALL else f' font-size="{size:g}"'
    placed = "" if anchor == "start" else f' text-anchor="{anchor}"'
    extra = f" {attributes}" if attributes else ""
    return f'<text x="{x:.2f}" y="{y:.2f}"{sized}{placed}{extra}>{_escaped(text)}</text>'


def _box(left: float, top: float, width: float, height: float) -> str:
    return f'x="{left:.2f}" y="{top:.2f}" width="{width:.2f}" height="{height:.2f}"'


def _dash(dash: tuple[float, ...], width: float) -> str:
    lengths = " ".join(f"{length * width:.3g}" for length in dash)
    return f' stroke-dasharray="{lengths}"' if dash else ""


# -- panels --------------------------------------------------------------------------------------


def _panel(frame: PanelFrame, name: str) -> Iterable[str]:
    panel = frame.panel
    left, top, width, height = frame.left, frame.top, frame.width, frame.height
    box = _box(left, top, width, height)
    # figure.js needs these data to convert positions to values.
    data = f'data-box="{left:.2f} {top:.2f} {width:.2f} {height:.2f}"'
    for direction, scale in (("x", frame.x), ("y", frame.y)):
        data += f' data-{direction}="{scale.low!r} {scale.high!r} {int(scale.log)}"'
    names = "&#10;".join(_escaped(axis.label.replace("\n", " ")) for axis in (panel.x, panel.y))
    yield f'<g {data} data-names="{names}"><clipPath id="{name}"><rect {box}/></clipPath>'
    across, up = _ticks(frame.x), _ticks(frame.y)
    if panel.grid:
        lines = [
            f"M{frame.across(share):.2f} {top:.2f}v{height:.2f}" for share, _, b in across if b
        ]
        lines += [f"M{left:.2f} {frame.down(share):.2f}h{width:.2f}" for share, _, b in up if b]
        grid = f'<path data-ticks="grid" d="{"".join(lines)}" stroke="#d9d9d9"'
        yield f'{grid} stroke-width=".5" fill="none"/>'
    yield f'<g clip-path="url(#{name})">'
    for item in panel.items:
        yield _draw(item, frame)
    yield "</g>"
    yield from _frame_and_ticks(frame, across, up)
    yield from _labels(frame, across, up)
    yield "</g>"


def _ticks(scale: AxisScale) -> list[tuple[float, str, bool]]:
    """Return for each tick its position (0 to 1), its label, and whether it is major."""
    places = []
    for ticks, major in ((scale.ticks.major, True), (scale.ticks.minor, False)):
        if ticks:
            shares = scale.share(np.array([value for value, _ in ticks]))
            for share, (_, label) in zip(shares.tolist(), ticks, strict=True):
                if -1e-6 <= share <= 1.0 + 1e-6:
                    places.append((share, label, major))
    return places


def _frame_and_ticks(
    frame: PanelFrame, across: list[tuple[float, str, bool]], up: list[tuple[float, str, bool]]
) -> Iterable[str]:
    strokes = [
        f"M{frame.across(share):.2f} {frame.bottom:.2f}v{-3.5 if major else -2}"
        for share, _, major in across
    ]
    for share, _, major in up:
        strokes.append(f"M{frame.left:.2f} {frame.down(share):.2f}h{3.5 if major else 2}")
    box = f"M{frame.left:.2f} {frame.top:.2f}h{frame.width:.2f}v{frame.height:.2f}"
    box += f"h{-frame.width:.2f}z"
    look = 'stroke="#333" stroke-width=".7" fill="none"'
    yield f'<path d="{box}" {look}/><path data-ticks="" d="{"".join(strokes)}" {look}/>'


def _labels(
    frame: PanelFrame, across: list[tuple[float, str, bool]], up: list[tuple[float, str, bool]]
) -> Iterable[str]:
    panel = frame.panel
    left, top, right = frame.left, frame.top, frame.right
    middle = frame.across(0.5), frame.down(0.5)
    drop = 0.36 * SMALL  # from the middle of a character to its baseline
    if not panel.x.bare:
        yield '<g data-ticks="x" text-anchor="middle">'
        for share, label, _ in across:
            if label:
                yield _text(frame.across(share), frame.bottom + 4.0 + SMALL, label)
        yield "</g>"
        foot = frame.bottom + 5.0 + 1.25 * SMALL
        for number, line in enumerate(panel.x.label.split("\n") if panel.x.label else ()):
            y = foot + TEXT * (0.95 + 1.25 * number)
            yield _text(middle[0], y, line, TEXT, "middle")
        if frame.x.ticks.offset:
            yield _text(right, foot + 0.95 * TEXT, frame.x.ticks.offset, anchor="end")
    if not panel.y.bare:
        yield '<g data-ticks="y" text-anchor="end">'
        for share, label, _ in up:
            if label:
                yield _text(left - 4.0, frame.down(share) + drop, label)
        yield "</g>"
        yield _vertical_text(frame.label_left, middle[1], panel.y.label)
        if frame.y.ticks.offset:
            yield _text(left, top - 4.0, frame.y.ticks.offset)
    if panel.note:
        shift = 40.0 if frame.y.ticks.offset else 0.0
        yield _text(left + shift, top - 4.5, panel.note)


def _vertical_text(x: float, y: float, label: str) -> str:
    lines = label.split("\n")
    texts = []
    for number, line in enumerate(lines):
        shift = 0.36 * TEXT + 1.25 * TEXT * (number - 0.5 * (len(lines) - 1))
        if line:
            texts.append(_text(0.0, shift, line, TEXT, "middle"))
    return f'<g transform="translate({x:.2f} {y:.2f}) rotate(-90)">{"".join(texts)}</g>'


# -- what is drawn -------------------------------------------------------------------------------


@singledispatch
def _draw(item: shapes.Item, frame: PanelFrame) -> str:
    raise TypeError(f"cannot draw a {type(item).__name__}")


@_draw.register
def _(item: shapes.Line, frame: PanelFrame) -> str:
    path = _path(*frame.points(item.x, item.y))
    if not path:
        return ""
    dash = _dash(item.dash, item.width)
    cap = "" if item.dash else ' stroke-linecap="square"'
    return (
        f'<path d="{path}" fill="none" stroke="{item.color}" '
        f'stroke-width="{item.width:g}"{dash}{cap}/>'
    )


@_draw.register
def _(item: shapes.Marks, frame: PanelFrame) -> str:
    x, y = frame.points(item.x, item.y)
    fine = np.isfinite(x) & np.isfinite(y)
    shape = marker_path(item.marker, 0.5 * item.size)
    places = zip(x[fine].tolist(), y[fine].tolist(), strict=True)
    path = "".join(f"M{px:.2f} {py:.2f}{shape}" for px, py in places)
    if not path:
        return ""
    return f'<path d="{path}" fill="#fff" stroke="{item.color}" stroke-width=".8"/>'


@_draw.register
def _(item: shapes.Guide, frame: PanelFrame) -> str:
    scale = frame.y if item.axis == "y" else frame.x
    share = float(scale.share(np.array([item.value]))[0])
    if item.axis == "y":
        path = f"M{frame.left:.2f} {frame.down(share):.2f}h{frame.width:.2f}"
    else:
        path = f"M{frame.across(share):.2f} {frame.top:.2f}v{frame.height:.2f}"
    if not -0.01 <= share <= 1.01:
        return ""
    dash = _dash(item.dash, item.width)
    return (
        f'<path d="{path}" fill="none" stroke="{item.color}" stroke-width="{item.width:g}"{dash}/>'
    )


@_draw.register
def _(item: shapes.Band, frame: PanelFrame) -> str:
    scale = frame.y if item.axis == "y" else frame.x
    shares = np.clip(np.nan_to_num(scale.share(np.array([item.low, item.high]))), -0.01, 1.01)
    low, high = sorted(shares.tolist())
    if item.axis == "y":
        place = (frame.left, frame.down(high), frame.width, (high - low) * frame.height)
    else:
        place = (frame.across(low), frame.top, (high - low) * frame.width, frame.height)
    return f'<rect {_box(*place)} fill="{item.color}"/>'


@_draw.register
def _(item: shapes.Area, frame: PanelFrame) -> str:
    return f'<path d="{_path(*frame.points(item.x, item.y))}z" fill="{item.color}"/>'


@_draw.register
def _(item: shapes.Words, frame: PanelFrame) -> str:
    if item.data:
        xs, ys = frame.points(np.array([item.x]), np.array([item.y]))
        x, y = float(xs[0]), float(ys[0])
    else:
        x, y = frame.across(item.x), frame.down(item.y)
    text = _text(x, y + 1.15 * SMALL, item.text, attributes=_HALO)
    return f'<g fill="{item.color}">{text}</g>'


@_draw.register
def _(item: shapes.Pixels, frame: PanelFrame) -> str:
    x, y = frame.points(np.array([item.left, item.right]), np.array([item.bottom, item.top]))
    left, right = sorted(x.tolist())
    top, bottom = sorted(y.tolist())
    # Browsers blur enlarged pixels, which would merge the few fields of a small map.
    enlargement = (
        max(1, 640 // max(item.values.shape[:2])) if max(item.values.shape[:2]) < 64 else 1
    )
    values = item.values.repeat(enlargement, axis=0).repeat(enlargement, axis=1)
    data = base64.b64encode(png_bytes(values)).decode("ascii")
    return (
        f'<image {_box(left, top, right - left, bottom - top)} preserveAspectRatio="none" '
        f'href="data:image/png;base64,{data}"/>'
    )


def _path(x: Floats, y: Floats) -> str:
    fine = np.isfinite(x) & np.isfinite(y)
    parts = []
    ends = np.flatnonzero(np.diff(np.concatenate(([False], fine, [False])).astype(np.int8)))
    for begin, end in ends.reshape(-1, 2).tolist():
        if end - begin > 1:
            across, down = x[begin:end], y[begin:end]
            if end - begin > _THINNED_FROM:
                across, down = _thinned(across, down)
            across, down = _straightened(across, down)
            points = zip(across.tolist(), down.tolist(), strict=True)
            parts.append("M" + " ".join([f"{a:.2f} {b:.2f}" for a, b in points]))
    return "".join(parts)


def _thinned(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Keep one point of a line per length ``_NEAR`` [pt] along it, and its last point."""
    length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    keep = np.concatenate(([True], np.diff(np.floor(length / _NEAR)) > 0.0))
    keep[-1] = True
    return x[keep], y[keep]


def _straightened(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Drop points within ``_STRAIGHT`` [pt] of the chord between their neighbours."""
    dropped = x.size > _ALL_DRAWN
    while dropped:
        near = slice(0, x.size - 2, 2), slice(1, x.size - 1, 2), slice(2, x.size, 2)
        (ax, bx, cx), (ay, by, cy) = ([v[part] for part in near] for v in (x, y))
        size = (cx - ax) ** 2 + (cy - ay) ** 2
        share = ((bx - ax) * (cx - ax) + (by - ay) * (cy - ay)) / np.where(size > 0.0, size, 1.0)
        share = np.clip(share, 0.0, 1.0)
        off = np.hypot(ax + share * (cx - ax) - bx, ay + share * (cy - ay) - by)
        keep = np.ones(x.size, dtype=bool)
        keep[near[1]] = off > _STRAIGHT
        dropped = bool(np.count_nonzero(keep) < 0.9 * x.size)
        x, y = x[keep], y[keep]
    return x, y


def marker_path(marker: Marker, r: float) -> str:
    """Return the SVG outline of a marker of half-width ``r`` [pt] about the current point."""
    if marker == "o":
        return f"m{-r:g} 0a{r:g} {r:g} 0 1 0 {2 * r:g} 0a{r:g} {r:g} 0 1 0 {-2 * r:g} 0z"
    if marker == "s":
        return f"m{-r:g} {-r:g}h{2 * r:g}v{2 * r:g}h{-2 * r:g}z"
    if marker == "^":
        return f"m0 {-r:g}l{r:g} {2 * r:g}h{-2 * r:g}z"
    if marker == "v":
        return f"m0 {r:g}l{r:g} {-2 * r:g}h{-2 * r:g}z"
    if marker == "D":
        d = 1.3 * r
        return f"m0 {-d:g}l{d:g} {d:g}l{-d:g} {d:g}l{-d:g} {-d:g}z"
    t = 0.67 * r
    return (
        f"m{-t / 2:g} {-r:g}h{t:g}v{r - t / 2:g}h{r - t / 2:g}v{t:g}h{t / 2 - r:g}v{r - t / 2:g}"
        f"h{-t:g}v{t / 2 - r:g}h{t / 2 - r:g}v{-t:g}h{r - t / 2:g}z"
    )


def png_bytes(values: NDArray[np.uint8]) -> bytes:
    """Encode rows of RGB bytes as PNG."""
    height, width = values.shape[:2]
    rows = values.reshape(height, -1)
    raw = np.concatenate([np.zeros((height, 1), np.uint8), rows], axis=1).tobytes()

    def chunk(name: bytes, data: bytes) -> bytes:
        body = name + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(raw, 6))
        + chunk(b"IEND", b"")
    )


# -- legend --------------------------------------------------------------------------------------


def _legend(page: Page) -> Iterable[str]:
    if page.legend and page.legend_title:
        yield _text(
            0.5 * page.width, page.legend_top + 0.95 * SMALL, page.legend_title, anchor="middle"
        )
    for entry, left, middle in page.legend:
        yield f'<g data-entry="{entry.color}">'
        if entry.line:
            yield (
                f'<path d="M{left:.2f} {middle:.2f}h18.7" stroke="{entry.color}" '
                f'stroke-width="1.4"{_dash(entry.dash, 1.4)}/>'
            )
        if entry.marker is not None:
            shape = marker_path(entry.marker, 2.25)
            yield (
                f'<path d="M{left + 9.35:.2f} {middle:.2f}{shape}" fill="#fff" '
                f'stroke="{entry.color}" stroke-width=".8"/>'
            )
        yield _text(left + 25.0, middle + 0.36 * SMALL, entry.label) + "</g>"
