"""A hunt: a search over weather, faults and errors of the model for the run that comes nearest to a violated safety
property, and the smallest case of what it finds."""
