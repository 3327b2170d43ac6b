"""Floor 3: the law-agnostic engine of hysteresis at constant normal load."""

from microslip.memory.record import Memory, Tree
from microslip.memory.state import State
from microslip.memory.table import Table

__all__ = ["Memory", "State", "Table", "Tree"]
