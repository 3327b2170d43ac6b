"""A validated description of a calculation."""
