"""From what one camera knows of an object to what another camera expects: sample distributions."""

from __future__ import annotations

import numpy as np

from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.color import ColorModel
from motes.mot.cameras.camera_report import Arrival
from motes.mot.cameras.common_ground import CommonGround
from motes.mot.cameras.known_object import KnownObject
from motes.mot.expected import Expected, normal_samples, samples_at

VISIBLE = 0.25
"""An object is expected when this share of it should be in the picture."""


def in_overlap(
    ground: CommonGround, known: KnownObject, size: tuple[int, int], now: float, until: float
) -> Arrival | None:
    """Return where an object that one camera sees should be in the other's picture.

    None if less than `VISIBLE` of it is in the picture there. Its foot and its velocity are mapped
    by the ground. The covariance is mapped likewise, and grows by that of the ground, whose error
    is within `reach` widths in 95 % of cases: 2 standard deviations.

    Parameters
    ----------
    ground
        The ground that both cameras see.
    known
        The object.
    size
        Width and height of the other picture.
    now, until
        The time of the frame, and the last time at which the object is expected there.
    """
    box = known.tracked.box
    foot = ground.there(known.foot(now), box.width, known.camera)
    slope = ground.slope(known.foot(now), box.width, known.camera)
    if foot is None or slope is None:
        return None
    wider, higher = ground.sizes(known.foot(now), slope, known.camera)
    a, b = wider * box.width / 2, higher * box.height / 2
    center = foot[0], foot[1] + 0.5 - b
    if _visible((*center, a, b), size) < VISIBLE or not 1 <= a <= size[0] or not 1 <= b <= size[1]:
        return None
    change = np.zeros((5, 5))
    change[:2, :2], change[2, 2], change[3, 3] = slope, wider, higher
    if known.tracked.covariance:
        mapped = change @ np.reshape(known.tracked.covariance, (5, 5)) @ change.T
    else:
        mapped = np.zeros((5, 5))
    mapped[[0, 1], [0, 1]] += (ground.overlap.reach * a) ** 2
    dx, dy = (slope @ np.array(known.tracked.velocity)).tolist()
    ellipse = Ellipse(*center, a, b)
    covariance = tuple(mapped.ravel().tolist())
    return Arrival(known.identity, _bytes(known), ellipse, (dx, dy), covariance, now, until)


def at_place(known: KnownObject, place: str, scale: float, now: float, until: float) -> Arrival:
    """Return that an object that has left one camera may come to a place of another one.

    Parameters
    ----------
    known
        The object.
    place
        The name of the place.
    scale
        How many times larger objects are in the other camera's picture.
    now, until
        From when on it may come, and the last time.
    """
    box = known.tracked.box
    ellipse = Ellipse(0.0, 0.0, scale * box.width / 2, scale * box.height / 2)
    return Arrival(known.identity, _bytes(known), ellipse, (0.0, 0.0), (), now, until, place)


def expected_of(
    arrival: Arrival, rng: np.random.Generator, now: float, places: Floats, count: int
) -> Expected:
    """Return an arrival with samples for a camera's frame.

    Parameters
    ----------
    arrival
        The arrival.
    rng
        Source of randomness.
    now
        The time of the frame.
    places
        (R, 4), the boxes of the arrival's place, if it has one.
    count
        Number of samples.
    """
    histogram = np.frombuffer(arrival.histogram, np.float32).astype(np.float64)
    (x, y, *_), (dx, dy), dt = arrival.ellipse, arrival.velocity, now - arrival.time
    if arrival.place is None:
        mean = arrival.ellipse._replace(x=x + dx * dt, y=y + dy * dt)
        covariance = np.reshape(arrival.covariance, (5, 5))
        samples = normal_samples(rng, mean, covariance, count)
    else:
        samples = samples_at(rng, places, arrival.ellipse, count)
    return Expected(
        arrival.identity,
        samples,
        np.array(arrival.velocity),
        ColorModel(histogram, histogram),
        certain=arrival.place is None,
    )


def _bytes(known: KnownObject) -> bytes:
    return known.look.astype(np.float32).tobytes()


def _visible(ellipse: tuple[float, float, float, float], size: tuple[int, int]) -> float:
    """Return the share of the box around an upright ellipse x, y, a, b that is in a picture."""
    (x, y, a, b), (width, height) = ellipse, size
    wide = min(x + a, width - 0.5) - max(x - a, -0.5)
    high = min(y + b, height - 0.5) - max(y - b, -0.5)
    return max(wide, 0.0) * max(high, 0.0) / (4 * a * b)
