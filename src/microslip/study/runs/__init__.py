"""The runs of a study: a prediction with its scatter, a structure, a batch of many."""
