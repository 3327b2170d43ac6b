"""How far a fit is to be trusted: its rules, in one place."""

from __future__ import annotations

from collections.abc import Iterable

from microslip._core.verdicts import Rule, Verdict

MISFIT = Rule(
    name="reduced χ²",
    watch=2.0,
    outside=25.0,
    meaning="the law leaves no more than noise",
    reason="squared residuals over the noise that the scatter of the cycles shows",
    remedy="compare other laws, or see what the rig did: it is the best fit of this law, not its "
    "proof",
    missing="records with several settled cycles, whose scatter is the noise",
)
KNOWN = Rule(
    name="share of parameters identified",
    watch=1.0,
    outside=1e-9,
    meaning="the records tell every parameter that was free",
    reason="profiles of the likelihood that close on both sides",
    remedy="each open parameter says what would settle it",
)
RULES: tuple[Rule, ...] = (MISFIT, KNOWN)


def verdicts(
    reduced_chi_squared: float | None, is_known: Iterable[bool], converged: bool
) -> tuple[Verdict, ...]:
    """Verdicts on a fit; ``is_known`` says of each free parameter whether the records tell it.

    Of one that did not converge nothing is known.
    """
    known = list(is_known)
    share = sum(known) / len(known) if known else 1.0
    return MISFIT.judge(reduced_chi_squared), KNOWN.judge(share if converged else 0.0)
