"""Objects that are expected in the next frame, as another camera has seen them.

Nummiaro et al., section VII: the other tracker "can then initialize a sample distribution using
this knowledge".
"""

from __future__ import annotations

from typing import ClassVar

import msgspec

from motes.core.types import Floats
from motes.cues.color import Color, ColorModel


class Expected(msgspec.Struct, frozen=True, eq=False):
    """An object that may appear in the next frame."""

    CUE: ClassVar = Color()
    """The cue whose histograms cameras exchange."""
    key: int
    """Its number where it comes from."""
    samples: Floats
    """(N, 5), ellipses where it may be: the initial distribution of its filter."""
    velocity: Floats
    """(2,), in pixels a second."""
    model: ColorModel
    """Its histogram, as `CUE` learns it."""
    certain: bool
    """Whether it must be there, as when another camera sees it now. Then it may begin without a
    detection, and it is the object with this key."""
