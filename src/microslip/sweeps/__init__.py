"""Many loads, amplitudes and coefficients of friction at once, as labelled arrays."""

from microslip.sweeps.arrays import Sweep
from microslip.sweeps.evaluation import evaluate
from microslip.sweeps.run import sweep

__all__ = ["Sweep", "evaluate", "sweep"]
