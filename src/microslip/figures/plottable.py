"""Interface of every result that can be drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from microslip.figures.plot import Plot


def notebook_view(instance: Any, plot: Plot) -> str:
    """Return what a notebook shows of an object: its text and its figure, as HTML."""
    import base64
    from html import escape

    from microslip.figures.svg import svg

    image = base64.b64encode(svg(plot)).decode("ascii")
    return (
        f"<pre>{escape(repr(instance))}</pre>"
        f'<img src="data:image/svg+xml;base64,{image}" alt="Figure of the object above">'
    )


class Plottable:
    """Gives ``plot`` to a class that says its figure as data."""

    def _figure(self) -> Plot:
        """The figure as data."""
        raise NotImplementedError

    def plot(self, ax: Any = None, *, color: str | None = None, label: str = "") -> Any:
        """Draw it with Matplotlib, as command and report do; axes name their units, such as [N].

        Parameters
        ----------
        ax : matplotlib.axes.Axes or array of them, optional
            Axes to draw on, one for each panel; without, a new figure. Figures laid over each other
            share the units of the first.
        color : str, optional
            Color of black parts; by default the next of the package's colors.
        label : str, optional
            Name for ``ax.legend()``.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of Axes
            What was drawn on; an array where there are several panels.
        """
        from microslip.figures import draw

        return draw(self._figure(), ax, color=color, label=label)

    def _repr_html_(self) -> str:
        return notebook_view(self, self._figure())


class PlottableAtSensor:
    """Gives ``plot`` to a motion of many degrees of freedom, drawn where a sensor is."""

    def _figure(self, at: Any) -> Plot:
        """The figure as data, of a sensor or of what moves most."""
        raise NotImplementedError

    def plot(
        self, ax: Any = None, at: Any = None, *, color: str | None = None, label: str = ""
    ) -> Any:
        """Draw it: amplitude [m] over frequency [Hz], or motion [m] and lost energy [J] over time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or array of them, optional
            Axes to draw on; without, a new figure.
        at : int or array_like, optional
            Of a motion the degree of freedom, of a forced response the direction of the sensor,
            shape (n,); without, the degree of freedom that moves most.
        color : str, optional
            Color of the line; by default the next of the package's colors.
        label : str, optional
            Name for ``ax.legend()``.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of Axes
            What was drawn on.
        """
        from microslip.figures import draw

        return draw(self._figure(at), ax, color=color, label=label)
