"""Tables, arrays and instruments' files, with columns, units and limits."""
