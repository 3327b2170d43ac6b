"""Floor 10: how what is uncertain in a study is drawn: points, seed, quantiles, correlations."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, PrivateAttr, ValidationInfo, model_validator

from microslip._core.checks import Floats
from microslip.study.columns import FileName
from microslip.study.fields import Line, YesOrNo, array, different, integer, number, one_of
from microslip.study.part import KeyedError, Part, Reading, optional, required

MOST_SAMPLES = 65_536
GROUPS = 8
"""Scramblings of their own, from whose differences the error of a quantile is told."""

_SHARE = number(
    "a number above 0 and below 1 such as 0.05",
    exclusiveMinimum=0,
    exclusiveMaximum=1,
)
_CORRELATION = number(
    "a number above -1 and below 1 such as -0.5",
    exclusiveMinimum=-1,
    exclusiveMaximum=1,
)


class CorrelationPart(Part):
    """How two uncertain numbers go together: the correlation of their normal scores."""

    between: Annotated[tuple[Line, ...], array('["surface.radius", "surface.density"]', 2)] = (
        required("Keys of the two.", '["surface.radius", "surface.density"]')
    )
    value: Annotated[float, _CORRELATION] = required("Correlation of their normal scores.", "-0.5")


class UncertaintyPart(Part):
    """How the numbers that are given as tables are drawn, and what is told of the results."""

    samples: Annotated[int, integer(64, MOST_SAMPLES, 512)] = optional(
        "Points, rounded up to eight times a power of two.", default=512
    )
    seed: Annotated[int, integer(0, 2**32 - 1, words="a whole number of at least 0")] = optional(
        "Of the scrambling: the same seed gives the same bytes.", default=0
    )
    quantiles: Annotated[
        tuple[Annotated[float, _SHARE], ...],
        array("[0.05, 0.5, 0.95]", 9),
        AfterValidator(different),
        AfterValidator(lambda quantiles: tuple(sorted(quantiles))),
    ] = optional("Shares that lie below the bands.", default=(0.05, 0.5, 0.95))
    method: Annotated[Literal["sobol", "random"], one_of("sobol", "random")] = optional(
        "Scrambled Sobol' points, or independent ones.", default="sobol"
    )
    indices: YesOrNo = optional(
        "Whether Sobol' indices are computed, too; they cost as much.", default=False
    )
    correlations: Annotated[
        tuple[CorrelationPart, ...],
        array('[{ between = ["surface.radius", "surface.density"], value = -0.5 }]', 100),
    ] = optional("Which of the uncertain numbers go together.", default=())
    scan_patches: (
        Annotated[
            tuple[Annotated[int, integer(1, 30)], ...],
            array("[3, 3]", 2),
        ]
        | None
    ) = optional(
        "Patches of a scanned surface, across and down, that are drawn anew together: "
        "spread, radius and density of the summits keep their correlation.",
        "[3, 3]",
    )
    identification: FileName | None = optional(
        "Folder that microslip identify wrote: friction, spread of the heights and "
        "density scatter as its covariance says.",
        '"records-identified"',
    )
    _fit: dict[str, object] = PrivateAttr(default_factory=dict)

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        if self.identification is not None:
            try:
                self._fit = read_fit(Reading.of(info), self.identification)
            except (OSError, ValueError, KeyError, TypeError) as error:
                reason = str(error) if isinstance(error, ValueError) else "no result of identify"
                raise KeyedError(
                    "uncertainty.identification", f"{self.identification}: {reason}"
                ) from None
        return self

    @property
    def fit(self) -> tuple[tuple[str, ...], Floats, Floats]:
        """Names, values and covariance of what was identified."""
        fit = self._fit
        return fit["names"], fit["values"], fit["covariance"]  # type: ignore[return-value]

    def matrix(self, names: tuple[str, ...]) -> Floats:
        """Correlations of the normal scores of the uncertain numbers."""
        matrix = np.eye(len(names))
        for index, pair in enumerate(self.correlations, start=1):
            where = f"uncertainty.correlations, item {index}"
            if len(pair.between) != 2 or pair.between[0] == pair.between[1]:
                raise KeyedError(where, "wanted the keys of two different numbers")
            for name in pair.between:
                if name not in names:
                    listed = ", ".join(names) or "none"
                    raise KeyedError(where, f'wanted uncertain keys ({listed}), got "{name}"')
            i, j = map(names.index, pair.between)
            matrix[i, j] = matrix[j, i] = pair.value
        if names and np.linalg.eigvalsh(matrix).min() < 1e-9:
            raise KeyedError(
                "uncertainty.correlations",
                "wanted correlations that numbers can have, and no numbers have all of these at "
                "once (their matrix is not positive)",
            )
        return matrix


_FITTED = ("friction_coefficient", "slip_scale", "standardised_separation")


def read_fit(reading: Reading, folder: str) -> dict[str, object]:
    """Names, values and covariance of an identified interface, from the summary of its folder."""
    import json

    path = reading.path(folder) / "summary.json"
    if not path.exists():
        raise ValueError("no such folder of an identification (it has no summary.json)")
    data = json.loads(path.read_text(encoding="utf-8"))
    fit = data
    while "parameters" not in fit:
        fit = fit["fits"][0] if "fits" in fit else fit["identification"]
    names = tuple(name for name in fit["correlation"]["names"] if name in _FITTED)
    if "friction_coefficient" not in names:
        raise ValueError("wanted the identification of an interface")
    places = [fit["correlation"]["names"].index(name) for name in names]
    correlation = np.array(fit["correlation"]["matrix"])[np.ix_(places, places)]
    errors = np.array([float(fit["parameters"][name]["standard_error"]) for name in names])
    values = np.array([float(fit["parameters"][name]["value"]) for name in names])
    return {"names": names, "values": values, "covariance": correlation * np.outer(errors, errors)}
