"""Rules of how far a fit can be trusted, in one place."""

from __future__ import annotations

from collections.abc import Iterable

from microslip._core.verdicts import Rule, Verdict

CAUSES_FROM, WRONG_FROM = 2.0, 25.0
"""Reduced chi-squared from which on causes are looked for, and from which on what was given may be
wrong."""

MISFIT = Rule(
    name="error hidden by the misfit",
    watch=0.01,
    # A force that was clipped moves the limit of sliding by up to four times what shows: 5 %.
    outside=0.0125,
    meaning="the misfit is noise, or cannot move any number by much",
    reason="largest relative shift of a number that the residuals do not show, if the error of the "
    "law is as large along that number as across it",
    remedy="compare other laws, or look for effects of the rig: the best fit of a law does not "
    "prove the law",
    missing="numbers that the records determine",
)
TOLD_SHARE = Rule(
    name="share of parameters identified",
    watch=1.0,
    outside=1e-9,
    meaning="the records determine every free parameter",
    reason="profiles of the likelihood that close on both sides",
    remedy="each open parameter names the measurement that would determine it",
)
RULES: tuple[Rule, ...] = (MISFIT, TOLD_SHARE)


def verdicts(stake: float | None, is_known: Iterable[bool], converged: bool) -> tuple[Verdict, ...]:
    """Verdicts on a fit, by which free parameters are known: none of one that did not converge."""
    identified = list(is_known)
    share = sum(identified) / len(identified) if identified else 1.0
    return MISFIT.judge(stake), TOLD_SHARE.judge(share if converged else 0.0)
