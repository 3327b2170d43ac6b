"""Floor 3: the law-agnostic engines of hysteresis, at a constant and at a varying normal load."""

from microslip.memory.along import along, loads_along
from microslip.memory.diagram import Diagram, Rows, Slips
from microslip.memory.field_state import FieldResponse, FieldState
from microslip.memory.record import Memory, Tree
from microslip.memory.state import Load, State
from microslip.memory.trial import Trial
from microslip.memory.vector_state import VectorResponse, VectorState

__all__ = [
    "Diagram",
    "FieldResponse",
    "FieldState",
    "Load",
    "Memory",
    "Rows",
    "Slips",
    "State",
    "Tree",
    "Trial",
    "VectorResponse",
    "VectorState",
    "along",
    "loads_along",
]
