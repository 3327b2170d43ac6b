"""Floor 6: tables, arrays and instruments' files, with columns, units and limits."""
