"""What figures of Matplotlib share, as long as products draw some with it."""

from __future__ import annotations

import numpy as np

from microslip.report.drawing import DASHES as DASHES
from microslip.report.drawing import STYLE as STYLE
from microslip.report.drawing import log_scale as log_scale
from microslip.report.drawing import new_figure as new_figure
from microslip.report.drawing import note as note
from microslip.report.drawing import settle as settle
from microslip.report.plot import Floats
from microslip.report.scales import length_prefix as length_prefix

_LINES = ("-", (0, (6, 2)), (0, (1, 1)), (0, (6, 2, 1, 2)), (0, (3, 1)), (0, (5, 1, 1, 1, 1, 1)))


def drawable(values: Floats, log: bool = False) -> Floats:
    """Values with gaps where nothing can be drawn: not finite or, on a log axis, not above zero."""
    fine = np.isfinite(values) & (values > 0.0) if log else np.isfinite(values)
    return np.where(fine, values, np.nan)
