"""Quadrature and inversion that do not cancel; no physics."""
