"""Tracks that a user has corrected: keyframes, both ways, smoothing, and where to look."""
