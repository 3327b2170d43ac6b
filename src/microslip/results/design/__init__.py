"""Inverse design: which values give what is wanted of a joint."""
