"""Evaluation of joints at many loads, amplitudes and coefficients of friction."""

from microslip.friction.sweeps.arrays import Sweep
from microslip.friction.sweeps.evaluation import evaluate
from microslip.friction.sweeps.run import sweep

__all__ = ["Sweep", "evaluate", "sweep"]
