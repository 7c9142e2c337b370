"""Metrics that compare tracks with ground truth."""
