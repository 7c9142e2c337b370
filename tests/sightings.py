"""Tracks for tests of events and outputs."""

from __future__ import annotations

import numpy as np

from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.mot.analytics.events import Event, EventCounter
from motes.mot.tracked_object import SceneTrack


def seen(
    frame: int, foot: tuple[float, float], status: Status = Status.TRACKING, identity: int = 1
) -> SceneTrack:
    """Return a track, four frames a second, of an object 11 pixels wide and high."""
    ellipse = Ellipse(foot[0], foot[1] - 5, 5.5, 5.5)
    track = Track(frame, frame / 4, ellipse, np.eye(5), 1.0, status, 0.0, 1.0)
    return SceneTrack(identity, track, None, True)


def told(counting: EventCounter, *tracks: SceneTrack) -> list[Event]:
    return [event for track in tracks for event in counting.update([track])]
