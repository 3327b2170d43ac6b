"""What a bolted structure of a study does: frequency and damping against amplitude."""
