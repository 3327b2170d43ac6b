"""Floor 5: tangential laws, each fully given by its backbone."""

from microslip.friction.base import BackboneLaw
from microslip.friction.interface import Interface
from microslip.friction.validity import Verdict
from microslip.friction.views import PeriodicResponse, Sliders

__all__ = ["LAWS", "BackboneLaw", "Interface", "PeriodicResponse", "Sliders", "Verdict"]

LAWS: tuple[type[BackboneLaw], ...] = (Interface,)
"""Every backbone law; the shared tests run over it."""
