"""Rendered clips with exact truth."""

from __future__ import annotations

from motes.evaluation.synthetic.beetle import Target
from motes.evaluation.synthetic.clips import (
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
from motes.evaluation.synthetic.dial_clips import DialClip, dial_clips

__all__ = [
    "Clip",
    "DialClip",
    "Target",
    "Truth",
    "crossing",
    "crowd",
    "demo",
    "dial_clips",
    "growing",
    "jumping",
    "occluded",
    "rolling",
    "still",
    "turning",
]
