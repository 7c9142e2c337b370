"""What an overlay shows of a scene: objects with their past, and totals."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Mapping, Sequence
from functools import partial

from motes.core.frame import Frame
from motes.core.track import ROUNDING, Track
from motes.mot.analytics.event import Event
from motes.mot.analytics.regions import Regions
from motes.mot.boxes import foot_of
from motes.output.overlay import Draw
from motes.output.scene_overlay import Point, draw_scene

TRAIL = 50
"""Frames of a trail."""


class ScenePainter:
    """Paints all objects with their trails, the lines and zones, the time and the totals.

    A trail is of the point that is counted: the foot.

    Parameters
    ----------
    places
        The lines and zones.
    """

    def __init__(self, places: Regions) -> None:
        self._places = places
        self._trails: dict[int, deque[Point]] = {}
        self._totals: Counter[str] = Counter()

    def painted(
        self,
        frame: Frame,
        tracks: Sequence[Track],
        events: Sequence[Event],
        speeds: Mapping[int, float] = {},
    ) -> Draw:
        """Return a function that draws the next frame, with speeds in metres a second."""
        # A detection without an identity has no past.
        here = {each.identity for each in tracks if each.identity > 0}
        self._trails = {
            identity: trail for identity, trail in self._trails.items() if identity in here
        }
        for each in (each for each in tracks if each.identity in here):
            trail = self._trails.setdefault(each.identity, deque(maxlen=TRAIL))
            trail.append(foot_of(each.box))
        for event in events:
            if event.event in ("crosses", "enters", "leaves"):
                self._totals[event.total] += 1
        minutes, seconds = divmod(int(frame.time), 60)
        totals = [f"{what} {count}" for what, count in sorted(self._totals.items())]
        caption = [f"{minutes}:{seconds:02}", *totals]
        trails = {identity: list(trail) for identity, trail in self._trails.items()}
        notes = {identity: speed_label(speed) for identity, speed in speeds.items()}
        return partial(draw_scene, frame.pixels, tracks, trails, self._places, caption, notes)


def speed_label(speed: float) -> str:
    """Return a speed in metres a second as text; a microscope's are small."""
    return f"{speed:{'.2g' if ROUNDING < speed < 0.1 else '.2f'}} m/s"
