"""A measured scan: request and findings, its document, pictures and files."""
