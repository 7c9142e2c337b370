"""What an overlay shows: one target with its past, or objects with theirs, and totals."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from math import isfinite, nan

from motes.core.frame import Frame
from motes.core.track import ROUNDING, Status, Track
from motes.core.types import Bytes, Floats
from motes.mot.analytics.regions import Regions
from motes.output.overlay import describe, draw
from motes.output.scene_overlay import Point, draw_scene

TRAIL = 50
"""Frames of a trail."""
RESTS = 3.0
"""Standard deviations below which a speed may be 0."""
NOTHING: Mapping[str, int] = {}
NOWHERE = (nan, nan)
"""In a trail, the place of a target that is not seen."""


class TargetPainter:
    """Paints one target, its particles and its trail, and its speed if that is in `metres`."""

    def __init__(self, *, metres: bool = False) -> None:
        self._metres = metres
        self._trail: deque[Point] = deque(maxlen=TRAIL)

    def painted(
        self,
        frame: Frame,
        target: Track,
        particles: Floats | None = None,
        weights: Floats | None = None,
    ) -> Bytes:
        """Return the next frame with all of this on it."""
        seen = target.status is Status.TRACKING
        self._trail.append(target.ellipse[:2] if seen else NOWHERE)
        speed = speed_label(target) if self._metres else ""
        label = describe(target, speed) if speed else None
        return draw(
            frame.pixels, target, particles=particles, weights=weights, trail=self._trail,
            label=label,
        )  # fmt: skip


class ScenePainter:
    """Paints all objects with their trails and speeds, the lines and zones, the time and totals.

    A trail is of the point that is counted: the foot. It is interrupted where that is not seen.
    """

    def __init__(self, places: Regions) -> None:
        self._places, self._counted = places, sorted({*places.totals})
        self._trails: dict[int, deque[Point]] = {}

    def painted(
        self, frame: Frame, tracks: Sequence[Track], totals: Mapping[str, int] = NOTHING
    ) -> Bytes:
        """Return the next frame with all of this on it, and the totals of lines and zones."""
        # A detection without an identity has no past.
        here = {each.identity for each in tracks if each.identity > 0}
        self._trails = {
            identity: trail for identity, trail in self._trails.items() if identity in here
        }
        for each in (each for each in tracks if each.identity in here):
            trail = self._trails.setdefault(each.identity, deque(maxlen=TRAIL))
            trail.append(each.box.foot if each.status is Status.TRACKING else NOWHERE)
        minutes, seconds = divmod(int(frame.time), 60)
        passed = [f"{name} {totals[name]}" for name in self._counted if name in totals]
        caption = [f"{frame.index}  {minutes}:{seconds:02}", *passed]
        every = {each.identity: speed_label(each) for each in tracks}
        notes = {name: label for name, label in every.items() if label}
        return draw_scene(frame.pixels, tracks, self._trails, self._places, caption, notes)


def speed_label(track: Track) -> str:
    """Return a speed in metres a second as text; "" if it is not known.

    A microscope's are small; one that may be that of an object at rest is 0.00.
    """
    speed, deviation = track.number("speed"), track.number("speed_std")
    if not isfinite(speed):
        return ""
    small = max(ROUNDING, RESTS * deviation if isfinite(deviation) else 0.0) < speed < 0.1
    return f"{speed:.2g} m/s" if small else f"{speed:.2f} m/s"
