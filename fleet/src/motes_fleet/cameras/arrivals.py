"""From what one camera knows of an object to what another camera expects: sample distributions."""

from __future__ import annotations

import numpy as np

from motes import Ellipse
from motes.core import Floats
from motes.cues import ColorModel
from motes.mot import Expected, intersection_over_first
from motes.sot import scatter
from motes_fleet.cameras.camera_report import Arrival, unpacked
from motes_fleet.cameras.common_ground import CommonGround
from motes_fleet.cameras.known_objects import KnownObject

VISIBLE = 0.25
"""An object is expected when this share of it should be in the picture."""


def in_overlap(
    ground: CommonGround, known: KnownObject, size: tuple[int, int], now: float, until: float
) -> Arrival | None:
    """Return where an object that one camera sees should be in the other's picture.

    None if less than `VISIBLE` of it is in the picture there. Its foot and its velocity are mapped
    by the ground. The covariance is mapped likewise, and grows by that of the ground, whose error
    is within `reach` widths in 95 % of cases: 2 standard deviations. The other picture has a `size`
    (width, height); the object is expected there up to the time `until`.
    """
    box = known.tracked.box
    foot = ground.there(known.foot(now), box.width, known.camera)
    slope = ground.slope(known.foot(now), box.width, known.camera)
    if foot is None or slope is None:
        return None
    wider, higher = ground.sizes(known.foot(now), slope, known.camera)
    a, b = wider * box.width / 2, higher * box.height / 2
    ellipse = Ellipse(foot[0], foot[1] + 0.5 - b, a, b)
    visible = intersection_over_first(np.array(ellipse.box), np.array((0, 0, *size)))
    if visible < VISIBLE or not 1 <= a <= size[0] or not 1 <= b <= size[1]:
        return None
    change = np.zeros((5, 5))
    change[:2, :2], change[2, 2], change[3, 3] = slope, wider, higher
    if known.tracked.covariance:
        mapped = change @ np.reshape(known.tracked.covariance, (5, 5)) @ change.T
    else:
        mapped = np.zeros((5, 5))
    mapped[[0, 1], [0, 1]] += (ground.overlap.reach * a) ** 2
    dx, dy = (slope @ np.array(known.tracked.velocity)).tolist()
    covariance = tuple(mapped.ravel().tolist())
    return Arrival(known.identity, known.histogram, ellipse, (dx, dy), covariance, now, until)


def at_place(known: KnownObject, place: str, scale: float, now: float, until: float) -> Arrival:
    """Return that an object that has left one camera may come to a place of another one.

    Objects are `scale` times larger there. It may come from `now` to `until`.
    """
    box = known.tracked.box
    ellipse = Ellipse(0.0, 0.0, scale * box.width / 2, scale * box.height / 2)
    return Arrival(known.identity, known.histogram, ellipse, (0.0, 0.0), (), now, until, place)


def expected_of(
    arrival: Arrival, rng: np.random.Generator, now: float, places: Floats, count: int
) -> Expected:
    """Return an arrival with a `count` of samples for a camera's frame at the time `now`.

    `places` (R, 4) are the boxes of the arrival's place, if it has one.
    """
    histogram = unpacked(arrival.histogram)
    (x, y, *_), (dx, dy), dt = arrival.ellipse, arrival.velocity, now - arrival.time
    if arrival.place is None:
        mean = arrival.ellipse._replace(x=x + dx * dt, y=y + dy * dt)
        covariance = np.reshape(arrival.covariance, (5, 5))
        samples = normal_samples(rng, mean, covariance, count)
    else:
        samples = scatter(rng, places, arrival.ellipse, count)
    return Expected(
        arrival.identity,
        samples,
        np.array(arrival.velocity),
        ColorModel(histogram, histogram),
        certain=arrival.place is None,
    )


def normal_samples(
    rng: np.random.Generator, mean: Ellipse, covariance: Floats, count: int
) -> Floats:
    """Return samples (count, 5) of a normal distribution of ellipses; half-axes are 1 or more.

    The covariance (5, 5) is that of x, y, a, b, theta.
    """
    # The eigenvalues of a covariance that was estimated from few particles may be slightly below 0.
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    spread = vectors * np.sqrt(np.maximum(values, 0))
    samples: Floats = np.array(mean) + rng.standard_normal((count, 5)) @ spread.T
    samples[:, 2:4] = np.maximum(samples[:, 2:4], 1.0)
    return samples
