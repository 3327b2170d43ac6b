"""Document of a bolted structure of a study: frequency and damping against amplitude."""
