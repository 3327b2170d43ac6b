"""Floor 5: tangential laws, each fully given by its backbone, and one that is not."""

from microslip.friction.asperity import Asperity
from microslip.friction.base import BackboneLaw
from microslip.friction.bouc_wen import BoucWen
from microslip.friction.coulomb import Coulomb
from microslip.friction.coupled import CoupledResponse
from microslip.friction.fields import AsperityFields, Zone
from microslip.friction.interface import Interface
from microslip.friction.iwan import Iwan
from microslip.friction.jenkins import Jenkins
from microslip.friction.segalman import SegalmanFit, SegalmanIwan
from microslip.friction.validity import Verdict
from microslip.friction.views import PeriodicResponse, Sliders

__all__ = [
    "LAWS",
    "Asperity",
    "AsperityFields",
    "BackboneLaw",
    "BoucWen",
    "Coulomb",
    "CoupledResponse",
    "Interface",
    "Iwan",
    "Jenkins",
    "PeriodicResponse",
    "SegalmanFit",
    "SegalmanIwan",
    "Sliders",
    "Verdict",
    "Zone",
]

LAWS: tuple[type[BackboneLaw], ...] = (Interface, Asperity, Coulomb, Jenkins, Iwan, SegalmanIwan)
"""Every backbone law; the shared tests run over it."""
