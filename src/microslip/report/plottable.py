"""What every result that can be drawn offers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from microslip.report.plot import Plot


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
            Of what would be black; by default the next of the house's colours.
        label : str, optional
            Name for ``ax.legend()``.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of Axes
            What was drawn on; an array where there are several panels.

        Raises
        ------
        InputError
            Something else than axes, or too few or too many of them.
        """
        from microslip.report.axes import draw

        return draw(self._figure(), ax, color=color, label=label)
