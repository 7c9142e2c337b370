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

__all__ = [
    "Clip",
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
