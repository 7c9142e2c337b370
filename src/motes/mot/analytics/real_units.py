"""Places in metres and speeds of one target, with their standard deviations.

The tracker's covariance is carried over to the ground by the derivatives of the map, to first
order. The speed is that of a straight line through the last half second, fitted by generalized
least squares; where the places scatter more than their covariances allow, its deviation is larger
by as much.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track, finite
from motes.core.types import Floats
from motes.mot.analytics.events import SPEED_OVER
from motes.mot.analytics.ground_plane import Ground, Point
from motes.mot.analytics.lens import Lens
from motes.mot.boxes import foot_of

STEP = 1e-3
"""Half the difference of the derivatives, in pixels and radians."""
LEAST_POINTS = 3
"""Places that a speed needs, even if they take longer: two leave nothing to see scatter by."""


class GroundPlace(NamedTuple):
    """Where a target is on the ground, and how fast, with standard deviations.

    Metres and metres per second, or the units of the ground. The speed is NaN at first.
    """

    x_m: float
    y_m: float
    x_m_std: float
    y_m_std: float
    speed: float = math.nan
    speed_std: float = math.nan

    @property
    def columns(self) -> dict[str, float | None]:
        """The columns of a row; None where there is no speed."""
        return {name: finite(value) for name, value in self._asdict().items()}


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
        point = foot_of(ellipse.box) if self.ground.scale is None else (ellipse.x, ellipse.y)
        place = self.lens.undistorted(point) if self.lens else point
        return None if place is None else self.ground.metres(place)


PIXELS = RealUnits(Ground(scale=1.0))
"""Pixels as they are."""


class GroundMotion:
    """The places and speeds of a target, frame by frame.

    Parameters
    ----------
    units
        How pixels become metres.
    """

    def __init__(self, units: RealUnits) -> None:
        self._units = units.corrected()
        self._past: deque[tuple[float, Floats, Floats]] = deque()

    def update(self, track: Track | None) -> GroundPlace | None:
        """Return the place in a frame; None where the target is not seen, or above the horizon."""
        if track is None or track.status not in (Status.TRACKING, Status.INTERPOLATED):
            self._past.clear()
            return None
        found = place_of(self._units, track)
        if found is None:
            self._past.clear()
            return None
        self._past.append((track.time, *found))
        while len(self._past) > LEAST_POINTS and track.time - self._past[0][0] > SPEED_OVER:
            self._past.popleft()
        (x, y), (x_std, y_std) = found[0].tolist(), np.sqrt(found[1].diagonal()).tolist()
        speed = speed_of(self._past) if len(self._past) >= LEAST_POINTS else (math.nan, math.nan)
        return GroundPlace(x, y, x_std, y_std, *speed)


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


def speed_of(past: Sequence[tuple[float, Floats, Floats]]) -> tuple[float, float]:
    """Return the speed of the line through places at times, and its standard deviation.

    Raises
    ------
    ConfigError
        If all times are the same.
    """
    times = np.array([time for time, _, _ in past])
    if np.ptp(times) <= 0:
        raise ConfigError("A speed needs different times; give the frames their own.")
    times = times - times.mean()
    information, right = np.zeros((4, 4)), np.zeros(4)
    weights = []
    for time, (_, place, covariance) in zip(times, past, strict=True):
        # A tracker may be sure to the last bit; a place is never known better than to its digits.
        weight = np.linalg.inv(covariance + np.eye(2) * (1e-9 + 1e-6 * np.trace(covariance)))
        design = np.hstack([np.eye(2), time * np.eye(2)])
        information += design.T @ weight @ design
        right += design.T @ weight @ place
        weights.append((design, weight))
    inverse = np.linalg.inv(information)
    line = inverse @ right
    scatter = sum(
        float((place - design @ line) @ weight @ (place - design @ line))
        for (design, weight), (_, place, _) in zip(weights, past, strict=True)
    )
    spread = np.asarray(inverse[2:, 2:] * max(1.0, scatter / (2 * len(past) - 4)), np.float64)
    velocity = line[2:]
    speed = float(np.hypot(*velocity))
    if speed * speed <= np.trace(spread):  # the direction is not known
        return speed, math.sqrt(float(np.trace(spread)) / 2)
    along = velocity / speed
    return speed, math.sqrt(float(along @ spread @ along))
