"""Evaluation of joints at many loads, amplitudes and coefficients of friction."""

from microslip.friction.sweeps.evaluation import evaluate

__all__ = ["evaluate"]
