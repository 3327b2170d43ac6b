"""Floor 7: a joint in a structure."""

from microslip.structures.oscillator import Decay, Oscillator
from microslip.structures.ring_down import RingDown

__all__ = ["Decay", "Oscillator", "RingDown"]
