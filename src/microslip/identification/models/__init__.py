"""Physical laws for the second step of an identification, in parameters that loops determine."""
