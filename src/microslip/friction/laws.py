"""List of all friction laws that are defined by their backbone."""

from microslip.friction.asperity import Asperity
from microslip.friction.base import BackboneLaw
from microslip.friction.coulomb import Coulomb
from microslip.friction.interface import Interface
from microslip.friction.iwan import Iwan
from microslip.friction.jenkins import Jenkins
from microslip.friction.parallel import Parallel
from microslip.friction.pressed_joint import PressedJoint
from microslip.friction.segalman import SegalmanIwan
from microslip.friction.slider_law import SliderLaw

LAWS: tuple[type[BackboneLaw], ...] = (
    Interface,
    Asperity,
    Coulomb,
    Jenkins,
    Iwan,
    SegalmanIwan,
    SliderLaw,
    Parallel,
    PressedJoint,
)
"""All backbone laws; the shared tests are parametrised by this list."""
