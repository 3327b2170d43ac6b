"""Joints as elements of other harmonic-balance codes."""
