"""From measured loops to the parameters of a law, with what they cannot tell."""

from microslip.identification.comparison import Comparison, compare
from microslip.identification.fit_quality import RecordFit
from microslip.identification.folding import Folded, fold
from microslip.identification.result import Identification
from microslip.identification.run import identify
from microslip.identification.verdicts import Direction, Fitted

__all__ = [
    "Comparison",
    "Direction",
    "Fitted",
    "Folded",
    "Identification",
    "RecordFit",
    "compare",
    "fold",
    "identify",
]
