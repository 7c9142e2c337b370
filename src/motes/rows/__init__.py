"""Rows of tracks: one schema, its writer and its reader, and the journal of a run."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
