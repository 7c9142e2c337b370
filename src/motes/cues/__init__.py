"""Cues: what the pixels of an ellipse show of a target.

>>> from motes.cues import Color, Edges, Lattice
>>> tracker = motes.ParticleFilter(
...     color=Color(space="hsv", sampling=Lattice(points=128)), edges=Edges()
... )
"""

from __future__ import annotations

from motes.cues.base import AdaptableCue, Cue
from motes.cues.color import Color
from motes.cues.color_posterior import Posterior
from motes.cues.correlation_filter import Correlation
from motes.cues.edge_histogram import Edges
from motes.cues.hog import Hog
from motes.cues.sampling import Checkerboard, EveryPixel, Lattice
from motes.cues.scale_filter import ScaleFilter
from motes.cues.structure_tensor import Orientation

__all__ = [
    "AdaptableCue",
    "Checkerboard",
    "Color",
    "Correlation",
    "Cue",
    "Edges",
    "EveryPixel",
    "Hog",
    "Lattice",
    "Orientation",
    "Posterior",
    "ScaleFilter",
]
