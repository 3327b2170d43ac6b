"""Identified joints: what is said of a fit, as a document, figures, files and a study."""
