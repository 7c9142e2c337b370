"""Rendered clips with exact truth, to try trackers on.

The argument `size` is width and height in pixels, and `frames` is the number of frames. The ground,
the textures and the grain of the pictures follow from `seed`.

>>> tracker = motes.Tracker("nummiaro")
>>> for frame, (truth,) in motes.synthetic.turning((160, 120), frames=5):
...     track = tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)
"""

from __future__ import annotations

from motes.synthetic.beetle import Target
from motes.synthetic.clips import (
    Clip,
    Truth,
    crossing,
    crowd,
    demo,
    growing,
    jumping,
    occluded,
    rolling,
    still,
    turning,
)
from motes.synthetic.pitch import Pitch
from motes.synthetic.street import Street

__all__ = [
    "Clip",
    "Pitch",
    "Street",
    "Target",
    "Truth",
    "crossing",
    "crowd",
    "demo",
    "growing",
    "jumping",
    "occluded",
    "rolling",
    "still",
    "turning",
]
