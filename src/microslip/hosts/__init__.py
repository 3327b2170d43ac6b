"""The joint as an element of other people's harmonic-balance codes."""
