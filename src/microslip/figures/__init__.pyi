from .matplotlib_figure import draw as draw
from .matplotlib_figure import pdf as pdf
from .matplotlib_figure import png as png
