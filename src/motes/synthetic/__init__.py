"""Rendered clips with exact truth, to try trackers on.

The argument `size` is width and height in pixels, and `frames` is the number of frames. The ground,
the textures and the grain of the pictures follow from `seed`.

>>> tracker = motes.Tracker("nummiaro")
>>> for frame, (truth,) in motes.synthetic.turning((160, 120), frames=5):
...     track = tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
