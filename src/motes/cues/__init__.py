"""Cues: how far the pixels of an ellipse are from a target model.

>>> from motes.cues import Color, Edges, Lattice
>>> tracker = motes.ParticleFilter(
...     color=Color(space="hsv", sampling=Lattice(points=128)), edges=Edges()
... )
"""

from __future__ import annotations

from motes.cues.base import AdaptableCue, Cue, HistogramCue, bhattacharyya, visible
from motes.cues.color import Color, ColorModel, Posterior
from motes.cues.correlation_filter import Correlation, ScaleFilter
from motes.cues.gradients import Edges, Hog
from motes.cues.sampling import Checkerboard, EveryPixel, Lattice, Sampling, sunflower
from motes.cues.structure_tensor import Orientation

__all__ = [
    "AdaptableCue",
    "Checkerboard",
    "Color",
    "ColorModel",
    "Correlation",
    "Cue",
    "Edges",
    "EveryPixel",
    "HistogramCue",
    "Hog",
    "Lattice",
    "Orientation",
    "Posterior",
    "Sampling",
    "ScaleFilter",
    "bhattacharyya",
    "sunflower",
    "visible",
]
