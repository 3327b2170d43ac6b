"""What every floor stands on: checks, units, wording, frozen arrays, whole files, verdicts."""
