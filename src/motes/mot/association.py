"""What makes a detection the same object as before: overlap, place and looks; the assignment."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from motes.core.config import Config, NonNegative, Share
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Flags, Floats
from motes.mot.look import UNKNOWN, Look, costs
from motes.mot.overlaps import grouped, inscribed, inside, search_areas
from motes.mot.pairs import Integers, meeting
from motes.mot.tracked_object import TrackedObject

DENSE = 2**16
"""Largest number of cells for which a full matrix of costs takes the least time."""


def assign(costs: Floats) -> list[tuple[int, int]]:
    """Return rows and columns of the one-to-one assignment of least cost.

    As many pairs as possible are formed of those that are not ruled out, (n, m) with infinite cost.
    """
    from scipy.optimize import linear_sum_assignment  # takes half a second to import

    allowed = np.isfinite(costs)
    if not allowed.any():
        return []
    # A pair that is ruled out costs more than any number of others.
    forbidden = 1 + 2 * min(costs.shape) * costs[allowed].max()
    rows, columns = linear_sum_assignment(np.where(allowed, costs, forbidden))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(i, j) for i, j in pairs if allowed[i, j]]


def assign_pairs(
    i: Integers, j: Integers, costs: Floats, shape: tuple[int, int]
) -> list[tuple[int, int]]:
    """Return the pairs of the one-to-one assignment of least cost where few are possible, sorted.

    As many pairs as possible are formed of those with finite costs.

    Parameters
    ----------
    i, j, costs
        (k,) each: rows, columns and costs of the pairs; all others are ruled out.
    shape
        Numbers of rows and of columns.
    """
    possible = np.isfinite(costs)
    i, j, costs = i[possible], j[possible], costs[possible]
    n, m = shape
    if n * m <= DENSE:
        matrix = np.full(shape, np.inf)
        matrix[i, j] = costs
        return assign(matrix)
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import min_weight_full_bipartite_matching

    # Each row also has a column of its own that stands for no pair, and costs more than any number
    # of pairs.
    none = 1 + 2 * min(n, m) * costs.max(initial=0.0)
    own = np.arange(n)
    values = 1 + np.concatenate([costs, np.full(n, none)])  # a cost of 0 would be no pair
    places = np.concatenate([i, own]), np.concatenate([j, m + own])
    rows, columns = min_weight_full_bipartite_matching(csr_array((values, places), (n, m + n)))
    return sorted((a, b) for a, b in zip(rows.tolist(), columns.tolist(), strict=True) if b < m)


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


SAME = 0.7
"""Overlap of an object's place and a detection from which on it is the object, however it looks: it
may have come into another light."""


def impostors(
    objects: Sequence[TrackedObject], frame: Frame, boxes: Floats, i: Integers, j: Integers
) -> Flags:
    """Return of which pairs the detection looks as if it were another object, (k,).

    It is compared with how the object looked when it was last clear of others. Of one that was so
    for a few frames at most, and of what the edge of the picture cuts, nothing is said.

    Parameters
    ----------
    boxes
        (m, 4), of the detections.
    i, j
        (k,) each: indices of objects and of boxes.
    """
    some, models = np.unique(i, return_inverse=True)
    seen, places = np.unique(j, return_inverse=True)
    ellipses = [Ellipse(*row) for row in inscribed(boxes[seen]).tolist()]
    looks = (objects[n].known for n in some.tolist())
    known = [look if look is not None and look.settled else None for look in looks]
    unlikely = costs(Look.at(frame, ellipses), known)[places, models]
    return np.asarray((unlikely > UNKNOWN) & inside(boxes, frame)[j])
