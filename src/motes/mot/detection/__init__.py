"""Detectors: they find the objects in a frame."""
