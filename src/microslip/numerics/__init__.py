"""Quadrature and inversion that do not cancel, small systems without threads; no physics."""
