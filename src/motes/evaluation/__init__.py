"""Measuring trackers on sequences with ground truth."""
