"""Compliance of the two bodies behind an apparent contact, modelled as half-spaces."""

from __future__ import annotations

import math

from microslip.contact.materials import MaterialPair


def solid_stiffness(
    pair: MaterialPair, area: float, hole: float = 0.0, aspect: float | None = None
) -> tuple[float, float]:
    """Return the normal and tangential stiffness of two half-spaces behind a contact [N/m].

    Parameters
    ----------
    pair : MaterialPair
        Materials of the two bodies, each a half-space.
    area : float
        Apparent area [m^2].
    hole : float, optional
        Inner over outer radius of an annulus [-]; a full round contact by default.
    aspect : float, optional
        Longer over shorter side of a rectangle [-], up to 20; a round contact by default.

    Notes
    -----
    A round contact of radius a whose face stays plane has the normal stiffness 2 E* a and the
    tangential stiffness 8 G* a (Johnson, *Contact Mechanics*, 1985, sections 3.4 and 7.2). For an
    annulus of outer radius a and radius ratio e, both are multiplied by the series 1 - 4 e^3/(3
    pi^2) - 8 e^5/(15 pi^2) of Collins (1963, DOI 10.1017/S0013091500010749), and above e = 0.8 by
    pi^2 (1 + e)/(4 ln(16 (1 + e)/(1 - e))), that of a thin ring; between e = 0.7 and 0.8 by means
    of both, weighted by e. They are within 1 % of rings of pressure solved numerically.

    A rectangle of sides a >= b and diagonal d under uniform pressure has a mean normal displacement
    per force of J/(pi E* a^2 b^2), with J = 2 a^2 b ln((b + d)/a) + 2 a b^2 ln((a + d)/b) + 2/3
    (a^3 + b^3 - d^3) (Love's solution, Johnson 1985, section 3.3, integrated once more). A face
    that stays plane is stiffer by the factor 1.09 (a/b)^-0.014; boundary elements up to 20:1 agree
    within 0.7 %. The tangential stiffness is the mean of both directions; at 4:1 the stiffness
    along the longer side is 5 % smaller.
    """
    if aspect is not None:
        a, b = math.sqrt(area * aspect), math.sqrt(area / aspect)
        d = math.hypot(a, b)
        mean = 2.0 * (a * a * b * math.log((b + d) / a) + a * b * b * math.log((a + d) / b))
        mean += 2.0 / 3.0 * (a**3 + b**3 - d**3)
        size = 1.09 * aspect**-0.014 * math.pi * area**2 / mean
    else:
        size = 2.0 * math.sqrt(area / (math.pi * (1.0 - hole**2)))
        series = 1.0 - (4.0 * hole**3 / 3.0 + 8.0 * hole**5 / 15.0) / math.pi**2
        ring = math.pi**2 * (1.0 + hole) / (4.0 * math.log(16.0 * (1.0 + hole) / (1.0 - hole)))
        share = min(max((hole - 0.7) / 0.1, 0.0), 1.0)
        size *= (1.0 - share) * series + share * ring
    return size * pair.composite_modulus, 4.0 * size * pair.composite_shear_modulus


def in_series(first: float, second: float) -> float:
    """Return the stiffness of two springs in series [N/m]."""
    return 1.0 / (1.0 / first + 1.0 / second) if first > 0.0 and second > 0.0 else 0.0
