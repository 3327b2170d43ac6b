"""The list of all normal load laws."""

from microslip.normal.base import NormalLaw
from microslip.normal.given_summits import AsperityPopulation, SphereOnFlat
from microslip.normal.greenwood_williamson import GreenwoodWilliamson
from microslip.normal.measured import MeasuredContact
from microslip.normal.rough import RoughSurface
from microslip.normal.table import TabulatedNormalLaw
from microslip.normal.tightened import TightenedSurface

NORMAL_LAWS: tuple[type[NormalLaw], ...] = (
    GreenwoodWilliamson,
    AsperityPopulation,
    SphereOnFlat,
    TabulatedNormalLaw,
    TightenedSurface,
    MeasuredContact,
    RoughSurface,
)
"""Every normal load law; the shared tests run over it."""
