"""Tangential over normal stiffness of two faces of steel: Mindlin's, for any roughness."""

import microslip as ms

POISSON = (0.27, 0.30, 0.30)  # steel and cast iron: the ratio falls as it rises


def predict() -> dict[str, tuple[float, float, float]]:
    """Return the ratio of stiffnesses."""
    ratios = []
    for poisson in POISSON:
        steel = ms.Material(young_modulus=206e9, poisson_ratio=poisson)
        ratios.append(1.0 / ms.MaterialPair(steel, steel).stiffness_ratio)
    low, middle, high = sorted(ratios)
    return {"tangential over normal stiffness": (low, middle, high)}
