"""Command-line options common to the commands that read and measure records."""

from __future__ import annotations

from microslip._core import units
from microslip._core.options import option
from microslip._core.units import STIFFNESS

DISPLACEMENT = option("displacement", "Column of the displacement.", metavar="COLUMN")
FORCE = option("force", "Column of the tangential force.", metavar="COLUMN")
NORMAL_LOAD = option(
    "normal_load",
    'Column of the normal load, or "500 N", or none.',
    metavar="COLUMN",
)
TIME = option("time", "Column of the time, or none.", metavar="COLUMN")
SAMPLE_RATE = option(
    "sample_rate", "Sample rate, where there is no time.", float, example="200", above=0.0,
    metavar="HZ",
)  # fmt: skip
FLIP_SIGN = option("flip_sign", "Reverse the sign of the force.", bool, default=False)
UNITS = option(
    "units", "Unit of displacement, force, normal_load or time; may be repeated.", flag="unit",
    metavar="WHAT=UNIT",
)  # fmt: skip
CALIBRATION = option(
    "calibration",
    'Factor of a sensor, such as force="12.5 N/V", or with its deviation, force=1±0.01, which the '
    "intervals then include; may be repeated.",
    metavar="WHAT=FACTOR",
)
ZERO = option(
    "zero",
    'Zero of a channel, such as force="0.3 N" or force=middle; may be repeated.',
    metavar="WHAT=ZERO",
)
ROWS = option(
    "rows", "Rows of numbers to take, the first being 1, such as 1..5000.", metavar="FIRST..LAST"
)
DELAY = option(
    "delay",
    "Time by which the force lags behind the displacement, to be removed; a plain number is in s.",
    units.TIME, example="50 us", bare=True, sign="any",
)  # fmt: skip
SCALING = (UNITS, CALIBRATION, ZERO)

RIG_STIFFNESS = option(
    "rig_stiffness",
    'Rig in series, to be removed, such as "200 N/um"; a plain number is in N/m.',
    STIFFNESS, example="200 N/um", bare=True,
)  # fmt: skip
