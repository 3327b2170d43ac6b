"""Floor 8: the figures of a result, through matplotlib's object interface alone."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from weakref import WeakKeyDictionary

from matplotlib import rcParams, style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from microslip.study.backbone_figure import backbone
from microslip.study.contact_figure import contact_state
from microslip.study.drawing import STYLE, settle
from microslip.study.energy_figure import energy_damping, force_damping
from microslip.study.history_figure import history
from microslip.study.loops_figure import loops
from microslip.study.oscillator_figure import oscillator
from microslip.study.slider_figure import slider_density

if TYPE_CHECKING:
    from microslip.study.result import Result

Format = Literal["svg", "png"]

DRAW: dict[str, Callable[[Result], Figure]] = {
    draw.__name__: draw
    for draw in (
        loops,
        backbone,
        energy_damping,
        force_damping,
        contact_state,
        slider_density,
        history,
        oscillator,
    )
}
"""What draws each figure, by its name."""

# Drawing costs more than all computing: each figure is drawn once, for its files and the report.
_PICTURES: WeakKeyDictionary[Result, dict[tuple[str, Format], bytes]] = WeakKeyDictionary()


def names(result: Result) -> tuple[str, ...]:
    """Names of the figures that a result has something to show in.

    Parameters
    ----------
    result : Result
        Any result.

    Returns
    -------
    tuple of str
        Keys of :data:`DRAW`, in the order of reading.
    """
    shows = {
        "contact_state": result.joints[0].contact_area is not None,
        "history": bool(result.histories),
        "oscillator": bool(result.oscillators),
    }
    return tuple(name for name in DRAW if shows.get(name, True))


def write(result: Result, path: Path) -> None:
    """Draw one figure and write it; name and suffix of the file say which and how.

    Parameters
    ----------
    result : Result
        What to draw.
    path : pathlib.Path
        One of :func:`names`, with the suffix `.svg` or `.png`.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    path.write_bytes(picture(result, path.stem, "svg" if path.suffix == ".svg" else "png"))


def picture(result: Result, name: str, kind: Format) -> bytes:
    """Content of one figure's file.

    Parameters
    ----------
    result : Result
        What to draw.
    name : str
        One of :func:`names`.
    kind : {"svg", "png"}
        Format of the file.

    Returns
    -------
    bytes
        The same for the same result; it is kept as long as the last result that was drawn.
    """
    if result not in _PICTURES:
        _PICTURES.clear()
    kept = _PICTURES.setdefault(result, {})
    if (name, kind) not in kept:
        output = result.study.output
        wanted: set[Format] = {kind, "svg"} if output.report else {kind}
        wanted |= {other for other in ("svg", "png") if other in output.formats}
        kept.update({(name, other): data for other, data in _render(result, name, wanted).items()})
    return kept[name, kind]


def _render(result: Result, name: str, kinds: set[Format]) -> dict[Format, bytes]:
    # From matplotlib's own defaults, whatever the user's matplotlibrc says, and back afterwards.
    with style.context(["default", STYLE]), warnings.catch_warnings():
        # The summary says it, once.
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        figure = DRAW[name](result)
        settle(figure)
        return {kind: (_svg if kind == "svg" else _png)(figure) for kind in sorted(kinds)}


# Through the canvases, since figure.savefig() draws everything twice.


def _svg(figure: Figure) -> bytes:
    file = io.BytesIO()
    figure.set_dpi(150)  # of pictures inside
    # No dates: the same result gives the same file.
    canvas: Any = FigureCanvasSVG(figure)
    canvas.print_svg(file, metadata={"Creator": None, "Date": None})
    return _slim(file.getvalue())


def _png(figure: Figure) -> bytes:
    file = io.BytesIO()
    figure.set_dpi(rcParams["savefig.dpi"])
    canvas: Any = FigureCanvasAgg(figure)
    canvas.print_png(file)
    return file.getvalue()


_PATH = re.compile(rb' d="[^"]*"')
_DIGITS = re.compile(rb"(\.\d\d)\d+")


def _slim(svg: bytes) -> bytes:
    """An SVG file whose curves are given to a hundredth of a point: finer than any print."""
    return _PATH.sub(lambda found: _DIGITS.sub(rb"\1", found[0]), svg)
