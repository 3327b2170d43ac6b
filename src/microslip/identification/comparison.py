"""Several laws on the same records."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from microslip._core.checks import Progress, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.units import significant
from microslip.identification.caveats import FIXED
from microslip.identification.coordinates import RIG
from microslip.identification.models import MODELS, model_of
from microslip.identification.result import Identification
from microslip.identification.run import fold_all, identify
from microslip.identification.verdicts import Fitted, interval_text
from microslip.laboratory.record import Record

LAWS = tuple(model.name for model in MODELS)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Locked):
    """The same records fitted by several laws, the one that predicts best first.

    Made by :func:`microslip.compare`; criteria after Akaike (1974, DOI 10.1109/TAC.1974.1100705)
    and Schwarz (1978, DOI 10.1214/aos/1176344136).
    """

    fits: Mapping[str, Identification]
    """The fits by the names of their laws, in the order of Akaike's criterion; a law that comes
    more than once has a number: "jenkins", "jenkins 2"."""
    failed: Mapping[str, str]
    """Laws that could not be fitted, and why."""

    @property
    def best(self) -> str:
        """Name of the law with the least criterion of Akaike among those that converged."""
        return next((n for n, fit in self.fits.items() if fit.converged), next(iter(self.fits)))

    def rows(self) -> list[dict[str, Any]]:
        """One row a law: status, number of parameters, fit and criteria, as plain values."""
        fits = self.fits.values()
        sound = [fit.aic for fit in fits if fit.converged] or [fit.aic for fit in fits]
        lowest = min(sound, default=math.nan)
        return [
            {
                "law": name,
                "status": fit.status,
                "parameters": len(fit.names),
                "reduced_chi_squared": fit.reduced_chi_squared,
                "aic": fit.aic,
                "bic": fit.bic,
                "aic_over_best": fit.aic - lowest,
                "held_back": fit.held_back,
            }
            for name, fit in self.fits.items()
        ]

    def rigs(self) -> dict[str, dict[str, Fitted]]:
        """The stiffness of each rig as the laws have it, by its name and theirs; not what is fixed.

        Where no law leaves but noise it takes up what a law lacks: then the spread over the laws
        says more of it than the interval of any of them.
        """
        stiffnesses: dict[str, dict[str, Fitted]] = {}
        for law, fit in self.fits.items():
            for name, fitted in fit.parameters.items():
                if name.startswith(RIG) and fitted.verdict != FIXED and fit.converged:
                    stiffnesses.setdefault(name, {})[law] = fitted
        return {name: laws for name, laws in stiffnesses.items() if len(laws) > 1}

    def table(self) -> str:
        """The rows as text."""
        head = f"{'law':<12}{'parameters':>11}{'chi^2/dof':>12}{'AIC':>12}{'BIC':>12}"
        lines = [f"{head}{'held back':>12}  status"]
        for row in self.rows():
            numbers = "".join(
                f"{significant(row[key], 4):>12}"
                for key in ("reduced_chi_squared", "aic", "bic", "held_back")
            )
            lines.append(f"{row['law']:<12}{row['parameters']:>11}{numbers}  {row['status']}")
        for name, laws in self.rigs().items():
            intervals = (f"{interval_text(fitted)} ({law})" for law, fitted in laws.items())
            lines.append(f"{name}: {', '.join(intervals)}")
        lines += [f"{name}: {why}" for name, why in self.failed.items()]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"Comparison({', '.join(self.fits)})"


def compare(
    records: Record | Iterable[Record],
    laws: Sequence[Any] = LAWS,
    *,
    intervals: str = "curvature",
    progress: Progress | None = None,
    **options: Any,
) -> Comparison:
    """Fit several laws to the same records.

    Parameters
    ----------
    records : Record or iterable of Record
        As for :func:`microslip.identify`.
    laws : sequence, optional
        Names, classes or instances of laws. Those of one name are numbered.
    intervals : str, optional
        As for :func:`microslip.identify`; a comparison does not need the profiles.
    progress : callable, optional
        Called now and then with the share that is done, 0 ... 1.
    options : optional
        Further options of :func:`microslip.identify`, the same for all laws.

    Returns
    -------
    Comparison
        The fits, ordered by Akaike's criterion; laws that the records do not suit are told apart.

    Notes
    -----
    The noise is known from the cycles, so the criteria are those of Akaike (1974,
    DOI 10.1109/TAC.1974.1100705) and Schwarz (1978, DOI 10.1214/aos/1176344136) on chi-squared.
    What noise of the displacement does to the force depends on the law's own stiffness, so each
    law has a covariance of its own, and minus twice the logarithm of the likelihood is chi-squared
    plus the logarithm of the determinant of that. Under a robust ``loss`` the weights of the forces
    are part of the covariance, so that a law pays for what it takes for outliers.
    """
    if isinstance(laws, str) or not isinstance(laws, Sequence) or not laws:
        raise InputError(
            f"`laws` must be a list such as ['interface', 'jenkins'], got {show(laws)}"
        )
    models = [model_of(law) for law in laws]  # a wrong name is no law that does not suit
    folded: Any = fold_all(
        records, options.pop("cycles", None), lambda share: None, options.pop("noise", None)
    )
    fits: dict[str, Identification] = {}
    failed: dict[str, str] = {}
    for at, (law, model) in enumerate(zip(laws, models, strict=True)):
        law_options = dict(options)

        def report(share: float, at: int = at) -> None:
            if progress is not None:
                progress((at + share) / len(laws))

        name = _unused_name(model.name, (*fits, *failed))
        try:
            fits[name] = identify(folded, law, intervals=intervals, progress=report, **law_options)
        except InputError as error:
            failed[name] = str(error)
    if not fits:
        raise InputError(f"no law could be fitted: {'; '.join(failed.values())}")
    ordered = sorted(fits.items(), key=lambda item: (not item[1].converged, item[1].aic))
    return Comparison(MappingProxyType(dict(ordered)), MappingProxyType(failed))


def _unused_name(name: str, used_names: Collection[str]) -> str:
    """The name, with a number if it is taken."""
    names = itertools.chain([name], (f"{name} {k}" for k in itertools.count(2)))
    return next(name for name in names if name not in used_names)
