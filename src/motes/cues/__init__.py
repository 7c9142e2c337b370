"""Cues: how far the pixels of an ellipse are from a target model.

motes' own cues are keys of a configuration, as `motes config PRESET` lists them:

>>> color = {"space": "hsv", "sampling": {"points": 128}}
>>> config = motes.configure("nummiaro", {"color": color, "edges": {}})
"""

from __future__ import annotations

from motes.cues.base import AdaptableCue, Cue, HistogramCue, bhattacharyya, visible
from motes.cues.color import Color, ColorModel
from motes.cues.sampling import sunflower
from motes.cues.structure_tensor import Orientation

__all__ = [
    "AdaptableCue",
    "Color",
    "ColorModel",
    "Cue",
    "HistogramCue",
    "Orientation",
    "bhattacharyya",
    "sunflower",
    "visible",
]
