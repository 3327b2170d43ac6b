"""What may be chosen of an identification: for commands, which do not wait for what works on it."""

LAWS = ("interface", "jenkins", "iwan", "segalman", "bouc-wen")
"""The usual laws; any other that is exported may be fitted, too."""
NUISANCES = ("parallel", "viscous", "inertia", "tilt", "play")
"""What may be beside the law, its size free."""
LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")
"""How outliers may count."""
