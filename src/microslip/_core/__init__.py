"""What every package stands on: checks, units, wording, frozen arrays, whole files, verdicts."""
