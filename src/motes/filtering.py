"""The interfaces of the parts of a tracker, for parts of another package.

motes' own parts are chosen by their type, as `motes config PRESET` lists them:

>>> config = motes.configure("nummiaro", {"motion": {"type": "ellipse_walk", "position": 4.0}})
>>> tracker = motes.Tracker(config)
"""

from __future__ import annotations

from motes.sot.discriminative.expert import Expert
from motes.sot.filtering.fusion import Fusion
from motes.sot.filtering.likelihood import Likelihood
from motes.sot.filtering.model_update import Strategy
from motes.sot.filtering.motion import Motion
from motes.sot.filtering.resampling import Resampling, Weights

__all__ = ["Expert", "Fusion", "Likelihood", "Motion", "Resampling", "Strategy", "Weights"]
