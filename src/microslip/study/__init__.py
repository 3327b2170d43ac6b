"""A validated description of what is to be computed."""
