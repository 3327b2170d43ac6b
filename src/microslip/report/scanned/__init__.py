"""Report of a measured scan: document, figures and files."""
