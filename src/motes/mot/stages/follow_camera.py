"""A camera that moves takes the places of all objects along."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from motes.core.geometry import Box
from motes.core.types import Floats
from motes.mot.track_initiation import TrackInitiation
from motes.mot.tracked_object import TrackedObject


def follow_camera(
    objects: Sequence[TrackedObject], initiation: TrackInitiation, motion: Floats
) -> tuple[list[TrackedObject], TrackInitiation]:
    """Return objects and tentative tracks where they would be at rest in the next frame.

    `motion` is the homography (3, 3) of the background from the last frame to the next. So
    velocities are relative to the background. Sizes stay: detections correct them.
    """

    def moved(box: Box) -> Box:
        x, y = shifted(motion, box.x + box.width / 2, box.y + box.height / 2)
        return box._replace(x=x - box.width / 2, y=y - box.height / 2)

    candidates = tuple(
        each._replace(hits=tuple((time, moved(box)) for time, box in each.hits))
        for each in initiation.candidates
    )
    carried = [
        each.carried(
            shifted(motion, each.track.ellipse.x, each.track.ellipse.y),
            shifted(motion, *each.origin),
        )
        for each in objects
    ]
    return carried, replace(initiation, candidates=candidates)


def shifted(motion: Floats, x: float, y: float) -> tuple[float, float]:
    """Return the place to which a homography maps a point."""
    u, v, w = (motion @ np.array([x, y, 1.0])).tolist()
    return (u / w, v / w) if w > 0 else (x, y)
