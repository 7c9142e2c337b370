"""What makes a detection the same object as before: overlap, place and appearance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes.core.config import Config, NonNegative, Share
from motes.core.frame import Frame
from motes.core.types import Floats
from motes.mot.boxes import search_areas
from motes.mot.overlaps import grouped
from motes.mot.pairs import Integers, meeting
from motes.mot.tracked_object import TrackedObject


class Association(Config, frozen=True):
    """Which detection belongs to which object.

    Attributes
    ----------
    overlap
        Least intersection over union of a visible object and its detection, as in SORT (Bewley et
        al., ICIP 2016). A larger value demands more overlap.
    distance
        Largest distance in appearance between an occluded object's model and its detection, at the
        edge of the gate. With a larger value more detections are accepted.
    appearance
        Weight of the distance in appearance in the cost of a pair; the overlap has weight 1.
    gate_radius
        Radius of the gate, the area around its predicted place in which an occluded object may
        reappear, in mean half-axes of the object.
    gate_growth
        Growth of the gate's radius for each second without a detection, in mean half-axes of the
        object.
    merged_blob_ratio
        Least ratio of the size of a detection that contains several objects to the size of each of
        them. With a larger value fewer detections count as merged.
    """

    overlap: Share = 0.3
    distance: Share = 0.45
    appearance: NonNegative = 0.5
    gate_radius: NonNegative = 1.5
    gate_growth: NonNegative = 2.0
    merged_blob_ratio: Annotated[float, Meta(ge=1)] = 1.4

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

    def gate_distance(self, away: Floats, unseen: Floats) -> Floats:
        """Return how far detections are from occluded objects, as shares (k,) of the gate's radius.

        Parameters
        ----------
        away
            (k,), distances from the predicted place, in mean half-axes of the object.
        unseen
            (k,), seconds since the last detection.
        """
        out: Floats = away / np.maximum(self._radii(unseen), np.finfo(float).tiny)
        return out

    def near(
        self, places: Floats, unseen: Floats, boxes: Floats
    ) -> tuple[Integers, Integers, Floats]:
        """Return which detections lie in the gates of occluded objects, and how far off they are.

        Parameters
        ----------
        places
            (n, p, 5), ellipses where each object may be; the nearest counts. The first is its own.
        unseen
            (n,), seconds since the last detection.
        boxes
            (m, 4), of the detections.

        Returns
        -------
        i, j, gate_distance
            (k,) each: object and detection, sorted, and the distance as a share of the radius.
        """
        sizes = np.sqrt(places[:, 0, 2] * places[:, 0, 3])
        radii = self._radii(unseen) * sizes
        pairs = [
            meeting(search_areas(places[:, p, :2], radii), boxes) for p in range(places.shape[1])
        ]
        i, j = np.unique(np.hstack(pairs), axis=1)
        away = boxes[j, None, :2] + (boxes[j, None, 2:] - 1) / 2 - places[i, :, :2]
        off = self.gate_distance(
            np.hypot(away[..., 0], away[..., 1]).min(axis=1) / sizes[i], unseen[i]
        )
        return i[off <= 1], j[off <= 1], off[off <= 1]

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

    def _radii(self, unseen: Floats) -> Floats:
        """Return the radii of the gates (k,), in half-axes, of objects unseen for seconds (k,)."""
        return self.gate_radius + self.gate_growth * unseen


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
    distances = np.empty(len(i))
    for one, which in grouped(i, np.arange(len(i))).items():
        distances[which] = objects[one].distances(frame, boxes[j[which]])
    return distances
