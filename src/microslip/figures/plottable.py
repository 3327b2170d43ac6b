"""Mixins for all results that can be plotted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from microslip.figures.plot import Plot


def notebook_view(instance: Any, plot: Plot, text: str = "") -> str:
    """Return the representation and the figure of an object as HTML, for notebooks.

    ``text``, such as a table of numbers, is written below the representation.
    """
    import base64
    from html import escape

    from microslip.figures.svg import svg

    image = base64.b64encode(svg(plot)).decode("ascii")
    words = f"{instance!r}\n\n{text}" if text else repr(instance)
    return (
        f"<pre>{escape(words)}</pre>"
        f'<img src="data:image/svg+xml;base64,{image}" alt="Figure of the object above">'
    )


class Plottable:
    """Mixin that adds the method ``plot`` to a class with a method ``_figure``."""

    def _figure(self) -> Plot:
        """Return the figure as data, not yet drawn."""
        raise NotImplementedError

    def plot(self, ax: Any = None, *, color: str | None = None, label: str = "") -> Any:
        """Draw the figure of this result with Matplotlib, as in reports.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or array of them, optional
            Axes to draw on, one for each panel; by default a new figure. Axis labels name the
            units, such as [N]; figures drawn over each other share the units of the first.
        color : str, optional
            Color of the parts that are black in reports; by default the next color of the package.
        label : str, optional
            Name for ``ax.legend()``.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of Axes
            The axes; an array if the figure has several panels.
        """
        from microslip.figures import draw

        return draw(self._figure(), ax, color=color, label=label)

    def _repr_html_(self) -> str:
        return notebook_view(self, self._figure())


class PlottableAtSensor:
    """Mixin that adds ``plot`` to a motion of many degrees of freedom, drawn at one sensor."""

    def _figure(self, at: Any) -> Plot:
        """Return the figure of the motion at sensor ``at``, by default where it is largest."""
        raise NotImplementedError

    def plot(
        self, ax: Any = None, at: Any = None, *, color: str | None = None, label: str = ""
    ) -> Any:
        """Draw amplitude [m] over frequency [Hz], or motion [m] and energy [J] over time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or array of them, optional
            Axes to draw on; by default a new figure.
        at : int or array_like, optional
            Degree of freedom to draw, by default that with the largest motion. For a forced
            response also the direction s of a sensor that measures s^T x [-], shape (n,).
        color : str, optional
            Color of the line; by default the next of the package's colors.
        label : str, optional
            Name for ``ax.legend()``.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of Axes
            The axes.
        """
        from microslip.figures import draw

        return draw(self._figure(at), ax, color=color, label=label)

    def _repr_html_(self) -> str:
        return notebook_view(self, self._figure(None))
