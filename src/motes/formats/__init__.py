"""Tracks, annotations and truth in the files of other tools; `registry` lists all formats."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
