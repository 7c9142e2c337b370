"""The steps of a particle filter."""
