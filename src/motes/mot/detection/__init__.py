"""Detectors: what there is in a frame."""
