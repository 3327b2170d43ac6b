"""Joints as elements of other harmonic-balance codes, and as differentiable functions."""
