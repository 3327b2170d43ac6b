"""A validated description of a calculation, and its run."""
