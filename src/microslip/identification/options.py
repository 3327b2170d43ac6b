"""Options of an identification, without the code that works on them, for fast commands."""

LAWS = ("interface", "jenkins", "iwan", "segalman")
"""The usual laws; any other that is exported may be fitted, too."""
NUISANCES = ("parallel", "viscous", "inertia", "tilt", "play")
"""Additional force terms of free size."""
LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")
"""Loss functions of the residuals, by which outliers may count less."""
