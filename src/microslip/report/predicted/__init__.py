"""A predicted joint: its numbers, its document, its figures."""
