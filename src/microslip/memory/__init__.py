"""Floor 3: the law-agnostic engine of hysteresis at constant normal load."""

from microslip.memory.record import Memory, Tree
from microslip.memory.state import State

__all__ = ["Memory", "State", "Tree"]
