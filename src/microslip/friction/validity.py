"""How far the assumptions of the model hold: a verdict for each."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, NamedTuple

from microslip.normal import AsperityPopulation, GreenwoodWilliamson

if TYPE_CHECKING:
    from microslip.friction.interface import Interface

Word = Literal["ok", "watch", "outside"]


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
    surface, verdicts = joint.surface, []
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
        area = float(surface.contact_area(joint.separation))
        count = float(surface.contact_count(joint.separation))
        verdicts.append(
            _above(
                "real over apparent area",
                area / surface.area,
                0.1,
                0.2,
                "contacts are sparse and do not feel each other",
            )
        )
        mean_square = area / (math.pi * count)
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
