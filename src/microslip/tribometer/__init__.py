"""Floor 6: records of rigs and the loops in them."""

from microslip.tribometer.condition import (
    condition,
    delay_of,
    rate_dependence,
    rig_stiffness_of,
)
from microslip.tribometer.estimates import Estimate
from microslip.tribometer.measure import Measurement, measure
from microslip.tribometer.record import Record
from microslip.tribometer.regimes import Thresholds
from microslip.tribometer.virtual import VirtualTribometer

__all__ = [
    "Estimate",
    "Measurement",
    "Record",
    "Thresholds",
    "VirtualTribometer",
    "condition",
    "delay_of",
    "measure",
    "rate_dependence",
    "rig_stiffness_of",
]
