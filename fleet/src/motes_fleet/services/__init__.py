"""Annotation tools call these as trackers."""
