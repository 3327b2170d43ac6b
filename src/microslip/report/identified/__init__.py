"""Report of an identified joint: document, figures, files, and a study that uses the fitted law."""
