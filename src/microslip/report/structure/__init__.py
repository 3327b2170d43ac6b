"""Report on the bolted structure of a study: frequency and damping against amplitude."""
