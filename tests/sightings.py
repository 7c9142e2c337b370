"""Tracks for tests of events and outputs."""

import numpy as np
from msgspec.structs import replace

from motes import Ellipse, Event, EventCounter, Status, Track


def seen(
    frame: int, foot: tuple[float, float], status: Status = Status.TRACKING, identity: int = 1
) -> Track:
    """Return a track, four frames a second, of an object 11 pixels wide and high."""
    ellipse = Ellipse(foot[0], foot[1] - 5, 5.5, 5.5)
    track = Track(frame, frame / 4, ellipse, np.eye(5), 1.0, status, 0.0, 1.0)
    return replace(track, identity=identity, detected=True)


def told(counting: EventCounter, *tracks: Track) -> list[Event]:
    return [event for track in tracks for event in counting.update([track])]
