"""Command-line options common to the commands that read and measure records."""

from microslip._core import units
from microslip._core.options import option

RECORD_OPTIONS = (
    option("displacement", "Column of the displacement.", metavar="COLUMN"),
    option("force", "Column of the tangential force.", metavar="COLUMN"),
    option(
        "normal_load",
        'Column of the normal load, or "500 N", or none; one for all records, or one for each.',
        metavar="COLUMN",
    ),
    option("time", "Column of the time, or none.", metavar="COLUMN"),
    option(
        "sample_rate", "Sample rate, where there is no time.", float, example="200", above=0.0,
        metavar="HZ",
    ),
    option("flip_sign", "Reverse the sign of the force.", bool, default=False),
    option(
        "rows", "Rows of numbers to take, the first being 1, such as 1..5000.",
        metavar="FIRST..LAST",
    ),
    option(
        "units", "Unit of displacement, force, normal_load or time; may be repeated.", flag="unit",
        metavar="WHAT=UNIT",
    ),
    option(
        "calibration",
        'Factor of a sensor, such as force="12.5 N/V", or with its deviation, force=1±0.01, which '
        "the intervals then include; may be repeated.",
        metavar="WHAT=FACTOR",
    ),
    option(
        "zero",
        'Zero of a channel, such as force="0.3 N" or force=middle; may be repeated.',
        metavar="WHAT=ZERO",
    ),
)  # fmt: skip
REPEATED = ("normal_load", "units", "calibration", "zero")
"""Options that may be given several times."""
DELAY = option(
    "delay",
    "Time by which the force lags behind the displacement, to be removed; a plain number is in s.",
    units.TIME, example="50 us", bare=True, sign="any",
)  # fmt: skip
RIG_STIFFNESS = option(
    "rig_stiffness",
    'Rig in series, to be removed, such as "200 N/um"; a plain number is in N/m.',
    units.STIFFNESS, example="200 N/um", bare=True,
)  # fmt: skip
