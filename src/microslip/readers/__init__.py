"""Readers of tables, arrays and instrument files: columns, units and limits."""
