"""Computations of a study: predictions with uncertainty, structures, and batches."""
