"""How far the assumptions of the model hold: a verdict for each."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple, get_args

from microslip.normal import AsperityPopulation, GreenwoodWilliamson, NormalLaw

if TYPE_CHECKING:
    from microslip.friction.interface import Interface

Word = Literal["ok", "watch", "outside"]
_WORDS: tuple[str, ...] = get_args(Word)


class Verdict(NamedTuple):
    """One assumption of Greenwood and Williamson (DOI 10.1098/rspa.1966.0242) held to its limit."""

    name: str
    """What is judged."""
    value: float
    """Its value [-]."""
    limit: float
    """Where ``ok`` ends; ``outside`` begins a stated factor further."""
    word: Word
    """``ok``, ``watch`` (the result leans on the assumption) or ``outside``."""
    meaning: str
    """What the assumption is, in a sentence."""


def _above(name: str, value: float, limit: float, outside: float, meaning: str) -> Verdict:
    word: Word = "ok" if value <= limit else "watch" if value <= outside else "outside"
    return Verdict(name, value, limit, word, meaning)


def validity(joint: Interface) -> tuple[Verdict, ...]:
    """Verdicts on an interface at its load.

    The limits are conventions of contact mechanics: Greenwood and Williamson (1966) measured
    density * radius * std between 0.03 and 0.05 and put the end of elastic contact at a plasticity
    index of 1 and its beginning at 0.6; independent summits need contacts that are small beside
    their spacing and a real area of not much more than a tenth of the apparent one.
    """
    return _judge(joint.surface, joint.separation)


def worst_validity(
    joint: Interface, normal_loads: Iterable[float]
) -> tuple[tuple[Verdict, float | None], ...]:
    """Verdicts on an interface under several normal loads: of each the worst, and at which load.

    Parameters
    ----------
    joint : Interface
        An interface at one of them.
    normal_loads : iterable of float
        Normal loads [N], at least one, zero or more; without a load nothing touches.

    Returns
    -------
    tuple of tuple of Verdict and float or None
        In the order of :func:`validity`, each with its load [N]; None where it is the same at all.
        Of two with the same word the one that is nearer to the end of it is the worse.

    Raises
    ------
    InputError
        A load that the surface cannot carry.
    """
    loads = [float(load) for load in normal_loads]
    found = [_judge(joint.surface, _separation(joint, load)) for load in loads]
    result: list[tuple[Verdict, float | None]] = []
    for same in zip(*found, strict=True):
        if len({verdict.value for verdict in same}) == 1:
            result.append((same[0], None))
        else:
            result.append(max(zip(same, loads, strict=True), key=lambda pair: _doubt(pair[0])))
    return tuple(result)


def _separation(joint: Interface, load: float) -> float | None:
    """Separation at a load [N]; None where there is none."""
    if load == joint.normal_load:
        return joint.separation
    return float(joint.surface.separation(load)) if load > 0.0 else None


def _doubt(verdict: Verdict) -> tuple[int, float]:
    """Larger the worse: the word, then how far past the limit or, where it is ok, how near."""
    value, limit = verdict.value, verdict.limit
    past = abs(math.log(value / limit)) if value > 0.0 else math.inf
    return _WORDS.index(verdict.word), -past if verdict.word == "ok" else past


def _judge(surface: NormalLaw, separation: float | None) -> tuple[Verdict, ...]:
    """Verdicts on a surface at a separation; None is one at which nothing touches."""
    verdicts = []
    if isinstance(surface, GreenwoodWilliamson):
        spread = surface.heights.spread
        verdicts.append(
            _above(
                "density * radius * std",
                surface.density * surface.radius * spread,
                0.1,
                0.5,
                "summits are apart and few of them overlap",
            )
        )
        area = count = 0.0
        if separation is not None:
            area = float(surface.contact_area(separation))
            count = float(surface.contact_count(separation))
        verdicts.append(
            _above(
                "real over apparent area",
                area / surface.area,
                0.1,
                0.2,
                "contacts are sparse and do not feel each other",
            )
        )
        mean_square = area / (math.pi * count) if count > 0.0 else 0.0
        verdicts.append(
            _above(
                "contact radius over summit spacing",
                math.sqrt(mean_square * surface.density),
                0.25,
                0.5,
                "a contact is small beside the distance to the next summit",
            )
        )
        word: Word = "ok" if count >= 30.0 else "watch" if count >= 10.0 else "outside"
        verdicts.append(
            Verdict(
                "contacts", count, 30.0, word, "contacts are many enough for a statistical mean"
            )
        )
        radius = surface.radius
    elif isinstance(surface, AsperityPopulation):
        import numpy as np

        heights = np.asarray(surface.heights)
        spread, radius = float(np.std(heights)), float(np.mean(np.asarray(surface.radii)))
    else:
        return ()
    hardness = surface.pair.hardness
    if hardness is not None and spread > 0.0:
        verdicts.append(
            _above(
                "plasticity index",
                surface.pair.composite_modulus / hardness * math.sqrt(spread / radius),
                0.6,
                1.0,
                "summits deform elastically",
            )
        )
    return tuple(verdicts)
