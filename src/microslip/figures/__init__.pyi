from .matplotlib_figure import draw as draw
