"""Counts, zones, lines, and positions on the ground."""
