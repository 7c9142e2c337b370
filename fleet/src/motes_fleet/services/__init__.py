"""Annotation tools call these as trackers: CVAT and Label Studio."""
