"""Rules of how far a fit can be trusted, in one place."""

from __future__ import annotations

from collections.abc import Iterable

from microslip._core.verdicts import Rule, Verdict

CAUSES_FROM, WRONG_FROM = 2.0, 25.0
"""Reduced chi-squared from which on causes are looked for, and from which on what was given may be
wrong."""

MISFIT = Rule(
    name="what the misfit may hide",
    watch=0.01,
    # A force that was clipped moves the limit of sliding by up to four times what shows: 5 %.
    outside=0.0125,
    meaning="the law leaves no more than noise, or what it leaves can move no number by much",
    reason="largest shift of a number, of its value, that what the law leaves does not show, if "
    "what it lacks is as large along that number as beside it",
    remedy="compare other laws, or see what the rig did: it is the best fit of this law, not its "
    "proof",
    missing="numbers that the records tell",
)
TOLD_SHARE = Rule(
    name="share of parameters identified",
    watch=1.0,
    outside=1e-9,
    meaning="the records tell every parameter that was free",
    reason="profiles of the likelihood that close on both sides",
    remedy="each open parameter says what would settle it",
)
RULES: tuple[Rule, ...] = (MISFIT, TOLD_SHARE)


def verdicts(stake: float | None, is_known: Iterable[bool], converged: bool) -> tuple[Verdict, ...]:
    """Verdicts on a fit, by which free parameters are known: none of one that did not converge."""
    identified = list(is_known)
    share = sum(identified) / len(identified) if identified else 1.0
    return MISFIT.judge(stake), TOLD_SHARE.judge(share if converged else 0.0)
