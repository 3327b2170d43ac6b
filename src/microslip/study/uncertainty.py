"""Sampling of the uncertain inputs of a study: points, seed, quantiles, correlations."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.readers.files import Unusable, decoded
from microslip.readers.text import whole_text
from microslip.study.fields import LINE, YES_NO, number, one_of, text, whole_number
from microslip.study.part import Part, Table, key
from microslip.study.readers import Items, KeyedError, Place, Reading

MOST_SAMPLES = 65_536
GROUPS = 8
"""Scramblings of their own, from whose differences the error of a quantile is told."""

_KEYS = '["surface.radius", "surface.density"]'


class CorrelationPart(Part):
    """Correlation of two uncertain numbers: that of their normal scores."""

    between: tuple[str, ...] = key(Items(LINE, _KEYS, (1, 2)), "Keys of the two.")
    value: float = key(number("-0.5", above=-1.0, below=1.0), "Correlation of their normal scores.")


class _Shares(Items):
    """Shares in their order."""

    def read(self, raw_value: object, place: Place) -> Any:
        """The shares, rising."""
        values = super().read(raw_value, place)
        return tuple(sorted(values)) if isinstance(values, tuple) else values


class UncertaintyPart(Part):
    """Sampling of the uncertain inputs, and the quantiles reported."""

    samples: int = key(
        whole_number(64, MOST_SAMPLES, "512"),
        "Points, rounded up to eight times a power of two.",
        default=512,
    )
    seed: int = key(
        whole_number(0, 2**32 - 1, noun="a whole number of at least 0"),
        "Of the scrambling: the same seed gives the same bytes.",
        default=0,
    )
    quantiles: tuple[float, ...] = key(
        _Shares(number("0.05", above=0.0, below=1.0), "[0.05, 0.5, 0.95]", (1, 9), distinct=True),
        "Shares that lie below the bands.",
        default=(0.05, 0.5, 0.95),
    )
    method: str = key(
        one_of("sobol", "random"), "Scrambled Sobol' points, or independent ones.", default="sobol"
    )
    indices: bool = key(
        YES_NO, "Whether Sobol' indices are computed, too; they cost as much.", default=False
    )
    correlations: tuple[CorrelationPart, ...] = key(
        Items(Table(CorrelationPart), f"[{{ between = {_KEYS}, value = -0.5 }}]", (1, 100)),
        "Correlations of the uncertain numbers.",
        default=(),
    )
    scan_patches: tuple[int, ...] | None = key(
        Items(whole_number(1, 30), "[3, 3]", (1, 2)),
        "Patches of a scanned surface, across and down, that are resampled together: "
        "spread, radius and density of the summits keep their correlation.",
        default=None,
    )
    identification: str | None = key(
        text("the name of a folder", "records-identified"),
        "Folder that microslip identify wrote: friction, spread of the heights and "
        "density scatter as its covariance says.",
        default=None,
    )
    _fit: dict[str, Any]

    def check(self, place: Place) -> None:
        """Read what was identified."""
        if self.identification is None:
            return
        try:
            self._fit = read_fit(place.reading, self.identification)
        except (OSError, ValueError) as error:
            raise KeyedError(".identification", f"{self.identification}: {error}") from None

    @property
    def fit(self) -> tuple[tuple[str, ...], Floats, Floats]:
        """Names, values and covariance of what was identified."""
        return self._fit["names"], self._fit["values"], self._fit["covariance"]

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


def read_fit(reading: Reading, folder: str) -> dict[str, Any]:
    """Names, values and covariance of an identified interface, from the summary of its folder."""
    path = reading.path(folder) / "summary.json"
    if not path.exists():
        raise ValueError("no such folder of an identification (it has no summary.json)")
    with decoded("result of identify"):
        fit = json.loads(whole_text(path))
        while "parameters" not in fit:
            fit = fit["fits"][0] if "fits" in fit else fit["identification"]
        names = tuple(name for name in fit["correlation"]["names"] if name in _FITTED)
        if "friction_coefficient" not in names:
            raise Unusable("wanted the identification of an interface")
        places = [fit["correlation"]["names"].index(name) for name in names]
        correlation = np.array(fit["correlation"]["matrix"])[np.ix_(places, places)]
        errors = np.array([float(fit["parameters"][name]["standard_error"]) for name in names])
        values = np.array([float(fit["parameters"][name]["value"]) for name in names])
        if not (np.abs(correlation) <= 1.0 + 1e-9).all() or not (errors < 1e40).all():
            raise Unusable("wanted correlations within -1 and 1 and finite standard errors")
    return {"names": names, "values": values, "covariance": correlation * np.outer(errors, errors)}
