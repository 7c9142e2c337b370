"""How long an experiment on scenes will take: a few frames are measured before it starts."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import NamedTuple

from motes.core.frame import Frame
from motes.mot.scene import Scene

MEASURED_FRAMES = 20
"""Number of frames that are measured."""

SceneFactory = Callable[[int], Scene]
"""Makes a new scene from a seed."""


class Expected(NamedTuple):
    """The size of an experiment and its expected duration.

    Attributes
    ----------
    work
        The size, as text: 18 clips, 8994 frames.
    seconds
        Expected duration in seconds.
    """

    work: str
    seconds: float

    def __str__(self) -> str:
        return f"{self.work}: about {duration(self.seconds)}"


def seconds_per_frame(scene: Scene, frames: Iterable[Frame]) -> float:
    """Return the mean time in seconds to get a frame and to track its objects in a new scene.

    The first frame is not measured, since it is slower: a clip draws its scenery for it.

    Parameters
    ----------
    scene
        The scene; it is not of use afterwards.
    frames
        Two frames or more; at most `MEASURED_FRAMES` are taken.
    """
    taken, start = 0, 0.0
    for frame in frames:
        scene.update(frame)
        if taken == 0:
            start = time.perf_counter()
        taken += 1
        if taken == MEASURED_FRAMES:
            break
    return (time.perf_counter() - start) / max(taken - 1, 1)


def duration(seconds: float) -> str:
    """Return a duration in words, in the largest unit that fits: 40 s, 3 min or 2.5 h."""
    if seconds < 100:
        return f"{max(seconds, 1):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
