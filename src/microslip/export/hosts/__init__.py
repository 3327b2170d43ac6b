"""The joint as an element of other harmonic-balance codes."""
