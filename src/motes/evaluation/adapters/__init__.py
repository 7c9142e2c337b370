"""Trackers that are compared: ours, OpenCV's, others by protocol."""
