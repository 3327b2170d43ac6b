"""Floor 10: a validated description of what is to be computed."""
