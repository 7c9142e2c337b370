"""Scores of tracks against truth."""
