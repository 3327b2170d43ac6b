"""Declarations of the options of scans, shared by the command, the studies and Python."""

from microslip._core.options import option
from microslip._core.parameters import REQUIRED
from microslip._core.units import ANGLE, AREA, FORCE, LENGTH
from microslip.readers.files import LIMIT as LIMIT

LEVELS = ("plane", "quadratic", "mean")
PROCESS_NAMES = ("milled", "turned", "ground", "honed", "lapped", "polished", "eroded", "blasted")

CUTOFF = option(
    "cutoff",
    "Short-wave cut-off; none keeps all waves down to the pixel.",
    LENGTH,
    "Short-wave cut-off",
    default=REQUIRED,
    example="10 um",
    none="none",
    metavar="LENGTH",
)
LONG_CUTOFF = option(
    "long_cutoff",
    "Long-wave cut-off.",
    LENGTH,
    "Long-wave cut-off",
    example="0.8 mm",
    metavar="LENGTH",
)
LEVEL = option(
    "level",
    "Form to remove first.",
    default="plane",
    choices=LEVELS,
    none="none",
    metavar="[plane|quadratic|mean|none]",
)
CROP = option(
    "crop",
    "Length to cut off each end; twice for x and y.",
    LENGTH,
    "Cropping",
    example="0.4 mm",
    items=(1, 2),
    metavar="LENGTH",
)
DIRECTION = option(
    "direction",
    "Direction of motion on the measured face, from the x axis of the scan towards y; the mean "
    "over all directions if absent.",
    ANGLE,
    example="90 deg",
    sign="any",
    metavar="ANGLE",
)
SCAN_AREA = option(
    "area",
    "Apparent area of the joint; that of the scan if absent.",
    AREA,
    example="2 cm^2",
    metavar="AREA",
)
BODIES = option(
    "materials",
    "Two metals of the table; together with a load, the face is solved and the joint reported.",
    example="steel",
    items=(2, 2),
    metavar="METAL METAL",
)
_LOAD = option(
    "normal_load",
    "Normal load of that joint on its apparent area.",
    FORCE,
    example="500 N",
    flag="load",
    metavar="FORCE",
)
_FRICTION = option(
    "friction_coefficient",
    "Friction coefficient of that joint, for its loss factor.",
    float,
    default=0.5,
    above=0.0,
    flag="friction",
    metavar="X",
)
_AMPLITUDE = option(
    "amplitude",
    "Amplitude of the loss factor of that joint; 0.3 mu N / k_t if absent.",
    LENGTH,
    example="1 um",
    metavar="LENGTH",
)

FORMAT = option(
    "format", "Format of the file; detected if absent.", example="plu", metavar="FORMAT"
)
UNIT = option(
    "unit",
    "Unit of the heights, or of coordinates and heights, if the file has none.",
    example="um",
    items=(1, 2),
    metavar="UNIT",
)
PIXEL = option(
    "pixel",
    "Pixel size, or sizes along x and y, if the file has none.",
    LENGTH,
    example="1.66 um",
    items=(1, 2),
    metavar="LENGTH",
)
VALID = option(
    "valid",
    "Lowest and highest possible height; points outside are missing.",
    LENGTH,
    example="1 mm",
    sign="any",
    items=(2, 2),
    metavar="LOW HIGH",
)
CHANNEL = option(
    "channel",
    "Channel of an instrument file, by name or number, or array of a file with several arrays.",
    example="0",
    metavar="NAME",
)

READING = (FORMAT, UNIT, PIXEL, VALID, CHANNEL)
"""Options for reading in `microslip surface`."""
AUTOMATIC_LEVEL = LEVEL.but(
    help="Form to remove first; auto is quadratic if the scan is bowed, else plane.",
    default="auto",
    choices=("auto", *LEVELS),
    metavar="[auto|plane|quadratic|mean|none]",
)
CONDITIONING = (CUTOFF, LONG_CUTOFF, AUTOMATIC_LEVEL, CROP)
"""Options for conditioning in `microslip surface`."""
RA = option("ra", "Roughness average Ra of a drawing.", LENGTH, example="0.8 um", metavar="LENGTH")
RQ = option("rq", "Root mean square height Rq, instead.", LENGTH, example="1 um", metavar="LENGTH")
RZ = option(
    "rz", "Mean peak-to-valley height Rz, instead.", LENGTH, example="5 um", metavar="LENGTH"
)
JOINT = (BODIES, _LOAD, _FRICTION, _AMPLITUDE, DIRECTION)
"""Options for a joint in `microslip surface`."""
