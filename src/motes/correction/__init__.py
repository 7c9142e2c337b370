"""Tracks that a user has corrected: keyframes, both ways, smoothing, and where to look."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
