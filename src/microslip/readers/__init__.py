"""Readers of files with tables, arrays and instrument data: columns, units and size limits."""
