"""Common base of all packages: checks, units, wording, frozen arrays, whole files, verdicts."""
