"""Adapters through which an evaluation runs trackers of motes, OpenCV and others."""
