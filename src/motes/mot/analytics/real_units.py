"""Places in metres and speeds of one target, with their standard deviations.

The tracker's covariance is carried over to the ground by the derivatives of the map, to first
order. The speed is that of a straight line through half a second, fitted by least squares; where
the places scatter more than their covariances allow, its deviation is larger by as much. Live, the
line goes through the last half second, so the speed is that of a quarter of a second ago. In
hindsight, the frame is in the middle.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.core.geometry import Ellipse
from motes.core.track import GROUND, ROUNDING, SURE, Status, Track, finite
from motes.core.types import Floats
from motes.mot.analytics.ground_plane import Ground, Point
from motes.mot.analytics.lens import Lens
from motes.mot.analytics.trajectory import SPEED_OVER

STEP = 1e-3
"""Half the difference of the derivatives, in pixels and radians."""
LEAST_POINTS = 3
"""Places that a speed needs, even if they take longer: two leave nothing to see scatter by."""
NO_SPEED = math.nan, math.nan

Columns = Mapping[str, float | None]
"""Where a target is on the ground, and how fast: the further columns `GROUND` of its row.

Metres and metres per second, or the units of the ground; None where there is no speed. Empty where
the target is not seen, or is above the horizon.
"""


class RealUnits(Config, frozen=True):
    """How pixels become metres."""

    ground: Ground
    """The plane on which the target moves. With a scale the target's center is measured; otherwise
    its foot, the middle of its box's lower edge. Points of the picture that describe it are those
    of the distorted picture; a homography and a scale are for the picture without distortion."""
    lens: Lens | None = None
    """The distortion of the lens; None if there is none."""

    def corrected(self) -> RealUnits:
        """Return these units with the points of the ground where the lens really sees them."""
        points, lens = self.ground.points, self.lens
        if points is None or lens is None:
            return self
        moved: list[tuple[float, float, float, float]] = []
        for x, y, metres_x, metres_y in points:
            place = lens.undistorted((x, y))
            if place is None:
                raise ConfigError(f"The lens has no place for the ground's point {x:g}, {y:g}.")
            moved.append((*place, metres_x, metres_y))
        return replace(self, ground=Ground(points=tuple(moved)))

    def metres(self, ellipse: Ellipse) -> Point | None:
        """Return the place of a target; None on the horizon or above, or where no lens sees it."""
        point = ellipse.box.foot if self.ground.scale is None else (ellipse.x, ellipse.y)
        place = self.lens.undistorted(point) if self.lens else point
        return None if place is None else self.ground.metres(place)


PIXELS = RealUnits(Ground(scale=1.0))
"""Pixels as they are."""


class Seen(NamedTuple):
    """Where the target is seen in a frame, on the ground."""

    time: float
    """Seconds."""
    place: Floats
    """(2,) in metres."""
    covariance: Floats
    """(2, 2) of the place."""

    @property
    def marked(self) -> bool:
        """Whether it is the place of a keyframe."""
        return not self.covariance.any()

    def at_speed(self, speed: tuple[float, float]) -> Columns:
        """Return the place, with a speed and its deviation."""
        values = *self.place.tolist(), *np.sqrt(self.covariance.diagonal()).tolist(), *speed
        return dict(zip(GROUND, map(finite, values), strict=True))


class GroundMotion:
    """The places and speeds of objects live, frame by frame.

    Parameters
    ----------
    units
        How pixels become metres.
    size
        Width and height of the picture. Where its edge cuts the box of a detected object, what is
        left moves otherwise than the object does: then the speed is that of before, if there is
        one. None for a target whose ellipse is followed.

    Attributes
    ----------
    note
        One line about the first object that is seen and has no place; None before.
    """

    def __init__(self, units: RealUnits, size: tuple[int, int] | None = None) -> None:
        self._units, self._size = units.corrected(), size
        self._known: dict[int, tuple[deque[Seen], tuple[float, float]]] = {}
        self.note: str | None = None

    def update(self, tracks: Iterable[Track]) -> list[Track]:
        """Return the tracks of a frame with their places on the ground, where they are seen."""
        before, self._known, placed = self._known, {}, []
        for each in tracks:
            past, speed = before.get(each.identity, (deque(), NO_SPEED))
            seen, cut = seen_in(self._units, each), each.box.is_cut(self._size)
            if seen is None or cut:
                past.clear()
            if seen is None:
                speed = NO_SPEED
                if each.status is Status.TRACKING and self.note is None:
                    self.note = (
                        f"Frame {each.frame}: object {each.identity} is on the horizon of the "
                        f"ground or above it, or where the lens sees nothing; such rows have no "
                        f"metres."
                    )
            elif not cut:
                past.append(seen)
                while len(past) > LEAST_POINTS and seen.time - past[0].time > SPEED_OVER:
                    past.popleft()
                speed = speed_of(past)
            self._known[each.identity] = past, speed
            columns = {} if seen is None else seen.at_speed(speed)
            if seen is not None and np.trace(each.covariance) < ROUNDING:
                columns = {**columns, **dict.fromkeys(GROUND[2:4])}  # no particles are spread yet
            placed.append(replace(each, further={**each.further, **columns}))
        return placed


def motion_in_hindsight(units: RealUnits | None, tracks: Iterable[Track | None]) -> list[Columns]:
    """Return places and speeds in successive frames, each speed from frames before and after it.

    No line goes beyond a frame in which the target is not seen, or a keyframe: what is corrected
    there changes no speed elsewhere. Without units, there are none.
    """
    if units is None:
        return [{} for _ in tracks]
    units = units.corrected()
    return with_speeds([seen_in(units, track) for track in tracks])


def with_speeds(seen: Sequence[Seen | None]) -> list[Columns]:
    """Return the places in successive frames with their speeds, as `motion_in_hindsight`."""
    found: list[Columns] = [{}] * len(seen)
    stretch = list[Seen]()
    for end, each in enumerate([*seen, None]):
        if each is not None:
            stretch.append(each)
        if each is None or (each.marked and len(stretch) > 1):
            first = end - len(stretch) + (each is not None)
            for index, one in enumerate(stretch):
                if not found[first + index]:
                    found[first + index] = one.at_speed(speed_of(around(stretch, index)))
            stretch = [] if each is None else [each]
    return found


def around(seen: Sequence[Seen], index: int) -> Sequence[Seen]:
    """Return those within a quarter of a second of one of them, `LEAST_POINTS` at least."""
    time, half = seen[index].time, SPEED_OVER / 2
    first = bisect_left(seen, time - half, key=lambda each: each.time)
    first = min(first, max(min(index - 1, len(seen) - LEAST_POINTS), 0))
    end = bisect_right(seen, time + half, key=lambda each: each.time)
    return seen[first : max(end, first + LEAST_POINTS)]


def seen_in(units: RealUnits, track: Track | None) -> Seen | None:
    """Return where a target is; None where it is not seen, or above the horizon.

    A bridge over frames in which it was lost counts where the target is rather there than not.
    """
    if track is None or not track.visible:
        return None
    if track.status is Status.INTERPOLATED and track.confidence < SURE:
        return None
    found = place_of(units, track)
    return None if found is None else Seen(track.time, *found)


def seen_live(track: Track | None) -> Seen | None:
    """Return where the row of a live run has a target in metres; None where it has it nowhere.

    A row has no covariance of x and y; it is taken to be 0. A live run has no keyframes: a place
    without a deviation, as that of the first frame, or with 0, is not taken to be exact.
    """
    if track is None or not math.isfinite(track.number("x_m")):
        return None
    x, y, *deviations = (track.number(name) for name in GROUND[:4])
    variances = np.fmax(np.square(deviations), np.finfo(float).tiny)
    return Seen(track.time, np.array([x, y]), np.diag(variances))


def place_of(units: RealUnits, track: Track) -> tuple[Floats, Floats] | None:
    """Return the place (2,) of a track and its covariance (2, 2); None above the horizon."""
    ellipse = np.array(track.ellipse)
    places = [units.metres(track.ellipse)]
    for offset in np.eye(5) * STEP:
        places += [units.metres(Ellipse(*(ellipse + sign * offset))) for sign in (1, -1)]
    known = [place for place in places if place is not None]
    if len(known) < len(places):
        return None
    table = np.array(known)
    slopes = (table[1::2] - table[2::2]).T / (2 * STEP)
    covariance: Floats = slopes @ np.asarray(track.covariance) @ slopes.T
    return table[0], covariance


def speed_of(seen: Sequence[Seen]) -> tuple[float, float]:
    """Return the speed of the line through places at times, and its standard deviation.

    Of fewer than `LEAST_POINTS` places, both are NaN. Raises a ConfigError if all times are the
    same.
    """
    if len(seen) < LEAST_POINTS:
        return NO_SPEED
    times = np.array([each.time for each in seen])
    if np.ptp(times) <= 0:
        raise ConfigError("A speed needs different times; give the frames their own.")
    places = np.array([each.place for each in seen])
    covariances = np.array([each.covariance for each in seen])
    times -= times.mean()
    pull = times / (times @ times)
    velocity = pull @ places
    off = places - places.mean(axis=0) - np.outer(times, velocity)
    scatter = np.square(off).sum() / (2 * len(seen) - 4)
    allowed = np.trace(covariances, axis1=1, axis2=2).mean() / 2
    spread = np.tensordot(pull**2, covariances, 1)
    spread += max(scatter - allowed, 0.0) * (pull @ pull) * np.eye(2)
    speed = float(np.hypot(*velocity))
    if not speed * speed > np.trace(spread):  # no direction is known, or no spread
        return speed, math.sqrt(float(np.trace(spread)) / 2)
    along = velocity / speed
    return speed, math.sqrt(float(along @ spread @ along))
