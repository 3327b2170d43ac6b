"""Floor 8: a validated description of one prediction, and its result."""

from microslip.study.result import AmplitudeCurve, Limits, Result
from microslip.study.schema import Study

__all__ = ["AmplitudeCurve", "Limits", "Result", "Study"]
