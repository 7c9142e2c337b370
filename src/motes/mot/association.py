"""What makes a detection the same object as before: overlap, place and appearance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from motes.core.config import Config, NonNegative, Share
from motes.core.frame import Frame
from motes.core.types import Floats
from motes.mot.overlaps import grouped, inscribed, search_areas
from motes.mot.pairs import Integers, meeting
from motes.mot.tracked_object import TrackedObject

PART = 0.5
"""Standard deviation of the center of an object that reappears in part, in mean half-axes."""


class Association(Config, frozen=True):
    """Which detection belongs to which object."""

    overlap: Share = 0.3
    """Least intersection over union of a visible object and its detection, as in SORT (Bewley et
    al., ICIP 2016). A larger value demands more overlap."""
    distance: Share = 0.45
    """Largest distance in appearance between an occluded object's model and its detection, at the
    edge of the gate. With a larger value more detections are accepted."""
    appearance: NonNegative = 0.5
    """Weight of the distance in appearance in the cost of a pair; the overlap has weight 1."""

    def costs(self, overlaps: Floats, distances: Floats) -> Floats:
        """Return the costs (k,) of pairs of a visible object and a detection; infinite for no pair.

        Parameters
        ----------
        overlaps, distances
            (k,) each: intersection over union, and distance of the object's model from the
            detection's region.
        """
        costs = 1 - overlaps + self.appearance * distances
        return np.where(overlaps >= self.overlap, costs, np.inf)

    def recovery_costs(self, gate_distances: Floats, distances: Floats) -> Floats:
        """Return the costs (k,) of pairs of an occluded object and a detection; infinite for none.

        Parameters
        ----------
        gate_distances, distances
            (k,) each: see `near`, and distance of the object's model from the detection's region.
        """
        # An object that reappears is still half covered. So near its place, a worse match will do.
        largest = self.distance + (1 - self.distance) * (1 - gate_distances)
        allowed = (gate_distances <= 1) & (distances <= largest)
        return np.where(allowed, distances + gate_distances, np.inf)


def near(
    places: Floats, variances: Floats, boxes: Floats, area: float
) -> tuple[Integers, Integers, Floats]:
    """Return which detections lie in the gates of occluded objects, and how far off they are.

    A gate ends where the object is as likely as a new one, which may come anywhere in the
    picture: Reid, An algorithm for tracking multiple targets, IEEE Transactions on Automatic
    Control 1979. So an object whose place is not known any more has none.

    Parameters
    ----------
    places
        (n, p, 5), ellipses where each object may be; the nearest counts. The first is its own.
    variances
        (n, 2), of the places in x and y, in squared mean half-axes.
    boxes
        (m, 4), of the detections.
    area
        Of the picture, in pixels.

    Returns
    -------
    i, j, gate_distance
        (k,) each: object and detection, sorted, and the distance as a share of the largest one.
    """
    sizes = np.sqrt(places[:, :1, 2] * places[:, :1, 3])
    sigmas = np.maximum(sizes * np.sqrt(variances + PART**2), 1)  # a pixel at least
    limits = np.maximum(2 * np.log(area / (2 * math.pi * sigmas.prod(axis=1))), 0)
    reach = (sigmas * np.sqrt(limits)[:, None]).max(axis=1)
    pairs = [meeting(search_areas(places[:, p, :2], reach), boxes) for p in range(places.shape[1])]
    i, j = np.unique(np.hstack(pairs), axis=1)
    away = boxes[j, None, :2] + (boxes[j, None, 2:] - 1) / 2 - places[i, :, :2]
    squares = ((away / sigmas[i, None]) ** 2).sum(axis=2).min(axis=1)
    inside = squares < limits[i]
    i, j, squares = i[inside], j[inside], squares[inside]
    return i, j, np.sqrt(squares / limits[i])


def model_distances(
    objects: Sequence[TrackedObject], frame: Frame, boxes: Floats, i: Integers, j: Integers
) -> Floats:
    """Return the distances of models from regions: (k,), for pairs sorted by object.

    Parameters
    ----------
    boxes
        (m, 4), the regions.
    i, j
        (k,) each: indices of objects and of boxes.
    """
    distances, ellipses = np.empty(len(i)), inscribed(boxes)
    for one, which in grouped(i, np.arange(len(i))).items():
        distances[which] = objects[one].distances(frame, ellipses[j[which]])
    return distances
