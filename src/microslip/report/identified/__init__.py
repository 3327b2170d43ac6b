"""Identified joints: a fit as a document, figures, files and a study."""
