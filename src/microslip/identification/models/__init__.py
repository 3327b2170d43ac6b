"""Physical laws for the second step of an identification, in the parameters that loops know."""
