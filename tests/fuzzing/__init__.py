"""Inputs damaged at random, the same for the same seed."""
