"""Why two estimates of the summits of a scan differ, in sentences."""

from __future__ import annotations

from collections.abc import Callable

from microslip._core.units import engineering, significant
from microslip.scans.findings import Findings
from microslip.scans.scan_rules import LOST_TO_PIXEL


def disagreements(findings: Findings) -> list[str]:
    """Nothing where counting and moments agree within a half; each cause has its own line."""
    mccool, counted = findings.estimates.get("mccool"), findings.estimates.get("counted")
    if mccool is None or counted is None or findings.summits is None:
        return []
    factors = {
        name: getattr(counted, name) / getattr(mccool, name)
        for name in ("density", "radius", "std")
        if getattr(counted, name) > 0.0
    }
    factors_apart = {
        name: factor for name, factor in factors.items() if not 1.0 / 1.5 < factor < 1.5
    }
    if not factors_apart:
        return []
    texts = [
        f"{significant(factor, 2)} times the {_NOUNS[name]}"
        for name, factor in factors_apart.items()
    ]
    if findings.summits.method == "watershed" and "radius" in factors_apart:
        # The verdict on radii compares what McCool's is, one over a mean curvature.
        alike = findings.summits.mean_radius / mccool.radius
        texts[list(factors_apart).index("radius")] += (
            " (the counted one by load; by mean curvature, as McCool's is, "
            f"{significant(alike, 2)} times)"
        )
    judged = sorted(
        (
            v
            for v in findings.verdicts
            # What the pixel takes in part it takes from counting and from moments alike.
            if v.word != "ok"
            and v.name in _CAUSES
            and (v.name != LOST_TO_PIXEL or v.word == "outside")
        ),
        key=lambda verdict: (verdict.word != "outside", [*_CAUSES].index(verdict.name)),
    )
    causes = [_CAUSES[verdict.name](verdict.value or 0.0, findings) for verdict in judged]
    every = findings.summits.neighbours.density
    if counted.density < every / 1.5:
        causes.insert(
            1 if judged and judged[0].word == "outside" else 0,
            f"of all points above their eight neighbours only {100.0 * counted.density / every:.2g}"
            f" % rise {engineering(findings.summits.threshold, 'm')} above the saddle to a higher "
            "one and are round; the rest may be noise, which moments take for summits",
        )
    causes = causes[:_MOST_CAUSES] or ["heights are not Gaussian, which moments take for granted"]
    gappy = any(verdict.name == "missing" for verdict in judged)
    noisy = any(v.name == LOST_TO_PIXEL for v in judged)
    advice = (
        'Fill the gaps first (`fill="interpolate"`).'
        if gappy
        else "Choose a short-wave cut-off first, then build on the counted ones."
        if noisy and findings.request.cutoff is None
        else "Build on the counted ones, and look at the map."
    )
    why = "".join(f"\n({number}) {cause}." for number, cause in enumerate(causes, start=1))
    return [
        (
            f"Two estimates differ: the summits counted have {_listed(texts)} of McCool's "
            f"moments. Why:{why}\n{advice}"
        )
    ]


def _listed(parts: list[str]) -> str:
    return " and ".join([", ".join(parts[:-1])] * (len(parts) > 1) + parts[-1:])


_NOUNS = {"density": "density", "radius": "radius", "std": "spread in height"}


_MOST_CAUSES = 3


def _tail_share(moment: str) -> Callable[[float, Findings], str]:
    return lambda value, findings: (
        f"one point in a thousand carries {100.0 * value:.2g} % of the {moment}"
    )


_CAUSES: dict[str, Callable[[float, Findings], str]] = {
    "kurtosis": lambda value, findings: (
        f"the kurtosis is {value:.3g} (3 if Gaussian): few points, a scratch, pits or spikes, make "
        "the variance of the heights, on which moments are built, while counting takes each summit "
        "once"
    ),
    "missing": lambda value, findings: (
        f"{100.0 * value:.2g} % of the points are missing, and a summit counts only where it and "
        "its eight neighbours are there"
    ),
    LOST_TO_PIXEL: lambda value, findings: (
        "curvatures are of waves of a few pixels, so that noise and the pixel make them"
    ),
    "anisotropy": lambda value, findings: (
        f"slopes across the lay are {value:.2g} times those along it, but moments are averaged "
        "over directions"
    ),
    "share of m0 in 0.1 % of points": _tail_share("variance of the heights"),
    "share of m2 in 0.1 % of points": _tail_share("mean square slope"),
    "share of m4 in 0.1 % of points": _tail_share("mean square curvature"),
}
"""Verdicts that tell why counting and moments differ, in words; the most telling first."""
