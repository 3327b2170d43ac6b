"""The runs of a study: a prediction with its scatter, a structure, a design, a batch of many."""
