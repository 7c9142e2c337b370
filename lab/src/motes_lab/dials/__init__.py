"""Trackers on films that are hard in one respect at a time."""
