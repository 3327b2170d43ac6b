"""Rules for the validity of the model of an interface, and the resulting verdicts."""

from __future__ import annotations

from microslip._core.verdicts import Rule
from microslip._core.verdicts import Verdict as Verdict
from microslip.contact.base import (
    BETWEEN,
    CONTACT_POINTS,
    FEWEST_POINTS,
    LARGEST_PRESSURE,
    MEAN_PRESSURE,
    OVER_HARDNESS,
    RESOLUTION,
    SCATTER,
    YIELD,
    NormalLaw,
)

RULES: tuple[Rule, ...] = (
    Rule(
        name="density * radius * std",
        watch=0.1,
        outside=0.5,
        meaning="summits are apart and few of them overlap",
        reason="Greenwood and Williamson (1966) measured 0.03 to 0.05",
        remedy="check the radius and density of the summits; a scan gives both",
    ),
    Rule(
        name="real over apparent area",
        watch=0.01,
        outside=0.1,
        meaning="contacts are sparse and do not interact",
        reason="a boundary-element solution is up to 20 % stiffer at 0.01 (7 % in the mean), 5 to "
        "20 % at 0.02, 20 to 50 % at 0.06 and 30 to 80 % at 0.1 (Gaussian surfaces, "
        "benchmarks/real_area.py)",
        remedy='a smaller load, or a law with interacting contacts, law = "face"',
    ),
    Rule(
        name="contact radius over summit spacing",
        watch=0.25,
        outside=0.5,
        meaning="a contact is small compared with the distance to the next summit",
        reason="independent summits need contacts that are small compared with their spacing",
        remedy="a smaller load, or a model with interacting contacts",
    ),
    Rule(
        name="contacts",
        watch=30.0,
        outside=10.0,
        meaning="there are enough contacts for a statistical mean",
        reason="a mean over fewer contacts scatters by 20 % or more from joint to joint",
        remedy="give the summits one by one, as a population",
    ),
    Rule(
        name="plasticity index",
        watch=0.6,
        outside=1.0,
        meaning="summits deform elastically",
        reason="Greenwood and Williamson (1966): elastic below 0.6, plastic above 1",
        remedy='use a face that yields: law = "face" with a drawing or a scan, ms.DrawnFace or '
        "ms.MeasuredContact in Python",
        missing="give the hardness of the softer material [Pa]",
    ),
    Rule(
        name=MEAN_PRESSURE,
        watch=0.4,
        outside=1.0,
        meaning="contacts deform elastically at the shortest waves",
        reason="yield begins where a contact's mean pressure is 1.1 times the yield stress, 0.39 "
        "of the hardness, and no contact bears more than the hardness (Johnson 1985, section 6.3)",
        remedy="a longer short-wave cut-off: shorter waves are pressed flat",
        missing="give the hardness of the softer material [Pa]",
    ),
    Rule(
        name="hardness over modulus and slope",
        watch=0.03,
        outside=0.003,
        meaning="the face is no steeper than the faces used for validation",
        reason="compared with boundary elements from 0.03 to 1; below, contacts are pressed flat, "
        "and the short waves have no effect",
        remedy="a longer shortest wave: shorter ones are pressed flat",
    ),
    Rule(
        name=OVER_HARDNESS,
        watch=0.4,
        outside=LARGEST_PRESSURE,
        meaning="only part of the face has yielded",
        reason="near the hardness all of the face is in contact, and the material no longer limits "
        "the pressure at a point",
        remedy="a lower tightening pressure, or the hardness of the worked surface, which is "
        "often higher",
        missing="give the hardness of the softer material [Pa]",
    ),
    Rule(
        name=CONTACT_POINTS,
        watch=500.0,
        outside=float(FEWEST_POINTS),
        meaning="enough points are in contact to resolve the contacts",
        reason="from 1000 down to 100 points the stiffness of a piece scatters by tens of percent; "
        "the energy of a cycle at mu N/k_t deviates by up to 8 % from friction solved point by "
        "point",
        remedy="a larger scan, or a smaller pixel",
    ),
    Rule(
        name=SCATTER,
        watch=0.2,
        outside=0.6,
        meaning="pieces of the scan carry the load alike, so the scan represents the joint",
        reason="standard deviation of the logarithm of the stiffness, from piece to piece; the "
        "mean of n pieces scatters by it over the root of n",
        remedy="a larger scan, several scans, or long waves removed as form",
        missing="the scan was solved as one piece; smaller pieces show their scatter (`piece`, the "
        "points along a side, in a study or in Python)",
    ),
    Rule(
        name=BETWEEN,
        watch=0.1,
        outside=0.5,
        meaning="pieces are larger than the longest waves of the face",
        reason="the elastic coupling between pieces is neglected: "
        "loads deviated by 0 to 16 % where pieces reached half of the longest wave",
        remedy="larger pieces, `piece=None`, or a long-wave cut-off: form then belongs "
        "to the structure",
    ),
    Rule(
        name=RESOLUTION,
        watch=0.15,
        outside=0.5,
        meaning="pixel and cut-off do not determine the stiffness",
        reason="the larger of two changes: by every second point, and without the short waves of "
        "half of the squared slope",
        remedy="smaller pixels or less noise, and a justified short-wave cut-off",
    ),
    Rule(
        name=YIELD,
        watch=1.0,
        outside=2.6,
        meaning="the sphere deforms elastically under the normal load; with friction above 0.3 it "
        "yields earlier, at its face",
        reason="Jackson and Green (2005): yield begins at p0 = 1.295 exp(0.736 nu) times the yield "
        "stress, and is full where the mean pressure is 2.84 times that stress",
        remedy="a smaller load, a larger sphere or a harder material",
        missing="give the hardness of the softer material [Pa]",
    ),
    Rule(
        name="Dundurs' constant of the pair",
        watch=0.1,
        outside=0.3,
        meaning="the two bodies are elastically similar: normal and tangential contact are not "
        "coupled",
        reason="with full stick the load grows by beta^2/3 (Spence 1968), but summits slip under "
        "normal load alone near their edges where friction is below about beta",
        remedy="compare the result with a test: Cattaneo and Mindlin neglect this coupling",
    ),
)
"""Conventions of contact mechanics (Greenwood and Williamson, DOI 10.1098/rspa.1966.0242)."""


def surface_verdicts(
    surface: NormalLaw, separation: float | None, **known: float | None
) -> tuple[Verdict, ...]:
    """Return the verdicts on a surface at a separation [m], None if nothing touches.

    ``known`` are values by rule name that replace those of the surface.
    """
    values = surface._assumptions(separation)
    values |= {name: value for name, value in known.items() if name in values}
    beta = abs(surface.pair.dundurs_beta)
    if beta > 0.0:  # of equal bodies there is nothing to judge
        values["Dundurs' constant of the pair"] = beta
    return tuple(rule.judge(values[rule.name]) for rule in RULES if rule.name in values)
