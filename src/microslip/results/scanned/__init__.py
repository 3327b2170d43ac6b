"""A measured scan: what was asked and found, its document, pictures and files."""
