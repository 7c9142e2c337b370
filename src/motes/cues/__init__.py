"""Cues: how far the pixels of an ellipse are from a target model.

motes' own cues are keys of a configuration, as `motes config PRESET` lists them:

>>> color = {"space": "hsv", "sampling": {"points": 128}}
>>> config = motes.configure("nummiaro", {"color": color, "edges": {}})
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
