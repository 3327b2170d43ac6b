"""The list of all normal load laws."""

from microslip.contact.base import NormalLaw
from microslip.contact.drawn import DrawnFace
from microslip.contact.given_summits import AsperityPopulation, SphereOnFlat
from microslip.contact.greenwood_williamson import GreenwoodWilliamson
from microslip.contact.measured import MeasuredContact
from microslip.contact.table import TabulatedNormalLaw

NORMAL_LAWS: tuple[type[NormalLaw], ...] = (
    GreenwoodWilliamson,
    AsperityPopulation,
    SphereOnFlat,
    TabulatedNormalLaw,
    MeasuredContact,
    DrawnFace,
)
"""Every normal load law; the shared tests run over it."""
