"""What an overlay and a live picture show of a run: tracks with their past, and totals."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from motes.core.frame import Frame
from motes.core.track import Status
from motes.mot.analytics.events import Event
from motes.mot.analytics.regions import Regions
from motes.mot.tracked_object import SceneTrack
from motes.output.overlay import Draw, draw
from motes.output.scene_overlay import Point, draw_scene

if TYPE_CHECKING:
    from motes.sot.step_info import StepInfo

TRAIL = 50
"""Frames of a trail."""
NOWHERE = (float("nan"), float("nan"))


class TrackPainter:
    """Paints one object, with its particles and its trail."""

    def __init__(self) -> None:
        self._trail: deque[Point] = deque(maxlen=TRAIL)

    def painted(self, frame: Frame, info: StepInfo | None) -> Draw:
        """Return a function that draws the next frame; without info, it is as it was."""
        if info is None:
            return lambda: frame.pixels
        track = info.track
        seen = track.status is Status.TRACKING
        self._trail.append(track.ellipse[:2] if seen else NOWHERE)
        return partial(
            draw,
            frame.pixels,
            track,
            particles=info.ellipses,
            weights=info.weights,
            trail=list(self._trail),
        )


class ScenePainter:
    """Paints all objects with their trails, the lines and zones, the time and the totals.

    Parameters
    ----------
    places
        The lines and zones.
    """

    def __init__(self, places: Regions) -> None:
        self._places = places
        self._trails: dict[int, deque[Point]] = {}
        self._totals: Counter[str] = Counter()

    def painted(self, frame: Frame, tracks: Sequence[SceneTrack], events: Sequence[Event]) -> Draw:
        """Return a function that draws the next frame."""
        here = {each.identity for each in tracks}
        self._trails = {
            identity: trail for identity, trail in self._trails.items() if identity in here
        }
        for each in tracks:
            trail = self._trails.setdefault(each.identity, deque(maxlen=TRAIL))
            trail.append(each.track.ellipse[:2])
        for event in events:
            if event.event in ("crosses", "enters", "leaves"):
                self._totals[f"{event.place} {event.direction or event.event}"] += 1
        minutes, seconds = divmod(int(frame.time), 60)
        totals = [f"{what} {count}" for what, count in sorted(self._totals.items())]
        caption = [f"{minutes}:{seconds:02}", *totals]
        trails = {identity: list(trail) for identity, trail in self._trails.items()}
        return partial(draw_scene, frame.pixels, tracks, trails, self._places, caption)
