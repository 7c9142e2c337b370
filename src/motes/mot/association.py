"""Which detection is which object, by overlap and by appearance, one to one; what became of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes.core.config import Config, NonNegative, Share
from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot.pairs import Floats, Integers, meeting

MARGIN = 1.0
"""Pixels by which the search for candidates reaches farther, so that rounding loses none."""


class DetectionOutcome(StrEnum):
    """What became of a detection."""

    MATCHED = "matched"
    """It is where an object is that was just seen."""
    FOUND = "found"
    """It is where an object comes up again that was hidden."""
    BORN = "born"
    """It makes an object of a candidate."""
    CANDIDATE = "candidate"
    """It may be an object; the next frames will tell."""
    SEVERAL = "several objects"
    """Two or more objects lie in it, as in a blob where they touch, and share it."""
    PART = "part of an object"
    """It lies on an object that has a better detection, or that is being followed without."""
    DOUBLE = "the same as a surer one"
    """It lies on a detection that scores higher, or is larger."""
    DOUBTFUL = "doubtful"
    """It is among the least sure detections so far, which begin no objects."""
    USELESS = "too small, too large or outside"
    """No tracker can start on it."""
    SURPLUS = "beyond the limit"
    """It is less sure than the largest number of detections that are taken of a frame."""


@dataclass(frozen=True, slots=True)
class LoggedDetection:
    """A detection, what became of it, and which object it went to."""

    detection: Detection
    outcome: DetectionOutcome
    identity: int | None = None


class Association(Config, frozen=True):
    """What makes a detection the same object as before.

    Attributes
    ----------
    overlap
        Least intersection over union of an object that was just seen with its detection.
    distance
        Largest distance between a hidden object's model and the detection that it may be.
    appearance
        What appearance counts beside overlap.
    gate_radius
        How far from where it should be a hidden object may come up, in its own mean half-sizes.
    gate_growth
        How much farther for every second that it was hidden.
    merged_blob_ratio
        A detection with several objects in it is more than this many times larger than each.
    """

    overlap: Share = 0.2
    distance: Share = 0.45
    appearance: NonNegative = 0.5
    gate_radius: NonNegative = 1.5
    gate_growth: NonNegative = 2.0
    merged_blob_ratio: Annotated[float, Meta(ge=1)] = 1.4

    def costs(self, overlaps: Floats, distances: Floats) -> Floats:
        """Return the costs (k,) of objects that were just seen; infinite where ruled out.

        Parameters
        ----------
        overlaps, distances
            (k,), of an object with a detection: intersection over union, and distance of the
            object's model from what is seen there.
        """
        costs = 1 - overlaps + self.appearance * distances
        return np.where(overlaps >= self.overlap, costs, np.inf)

    def reaches(self, hidden: Floats) -> Floats:
        """Return how far objects may come up (k,), in half-sizes, hidden for seconds (k,)."""
        return self.gate_radius + self.gate_growth * hidden

    def gate_distance(self, away: Floats, hidden: Floats) -> Floats:
        """Return how far off detections are from hidden objects, as a share of their reach.

        Parameters
        ----------
        away
            (k,), how far a detection is from where an object should be, in its mean half-sizes.
        hidden
            (k,), seconds since it was seen.
        """
        out: Floats = away / np.maximum(self.reaches(hidden), np.finfo(float).tiny)
        return out

    def near(
        self, places: Floats, hidden: Floats, boxes: Floats
    ) -> tuple[Integers, Integers, Floats]:
        """Return which detections hidden objects can reach, and how far off these are.

        Parameters
        ----------
        places
            (n, p, 5), ellipses: where each object may be; the nearest counts. Its own is the first.
        hidden
            (n,), seconds since it was seen.
        boxes
            (m, 4), of the detections.

        Returns
        -------
        i, j, gate_distance
            (k,) each: object and detection, sorted, and how far off, at most 1.
        """
        sizes = np.sqrt(places[:, 0, 2] * places[:, 0, 3])
        reach = self.reaches(hidden) * sizes + MARGIN
        pairs = [meeting(squares(places[:, p, :2], reach), boxes) for p in range(places.shape[1])]
        i, j = np.unique(np.hstack(pairs), axis=1)
        away = boxes[j, None, :2] + (boxes[j, None, 2:] - 1) / 2 - places[i, :, :2]
        off = self.gate_distance(
            np.hypot(away[..., 0], away[..., 1]).min(axis=1) / sizes[i], hidden[i]
        )
        return i[off <= 1], j[off <= 1], off[off <= 1]

    def recoveries(self, off: Floats, distances: Floats) -> Floats:
        """Return the costs (k,) of hidden objects; infinite where ruled out.

        Parameters
        ----------
        gate_distance, distances
            (k,), how far off a detection is, and how far from the object's model.
        """
        # Half of what comes up is still hidden, so where it should be counts the more for its look.
        near = (off <= 1) & (distances <= self.distance + (1 - self.distance) * (1 - off))
        return np.where(near, distances + off, np.inf)


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


def as_rows(boxes: Iterable[Box]) -> Floats:
    """Return boxes as (n, 4)."""
    return np.array(list(boxes), np.float64).reshape(-1, 4)


def squares(centers: Floats, half: Floats) -> Floats:
    """Return the squares (n, 4) around centers (n, 2), from half their sides (n,)."""
    sides = 2 * half[:, None]
    return np.hstack([centers - half[:, None], sides, sides])


def intersection_over_first(first: Floats, second: Floats) -> Floats:
    """Return which share of boxes lies inside others, shapes (..., 4) that broadcast."""
    low = np.maximum(first[..., :2], second[..., :2])
    high = np.minimum(first[..., :2] + first[..., 2:], second[..., :2] + second[..., 2:])
    shares: Floats = np.clip(high - low, 0, None).prod(axis=-1) / first[..., 2:].prod(axis=-1)
    return shares


def split_merged_blob(places: Floats, blob: Box) -> Floats:
    """Return where objects are in a box that holds them all, each with its own size: (n, 4).

    On each side, the outermost one touches the box's edge; otherwise they are where they should be.

    Parameters
    ----------
    places
        (n, 4), boxes where they should be.
    blob
        The box that holds them.
    """
    out, blob_low = places.copy(), np.array(blob[:2])
    for axis in range(2):
        low, size = places[:, axis], places[:, 2 + axis]
        first, last = int(low.argmin()), int((low + size).argmax())
        if first != last:  # one that is both may be hidden in part, or hide the others
            out[first, axis] = blob_low[axis]
            out[last, axis] = blob_low[axis] + blob[2 + axis] - size[last]
    return out


def occlusion_candidates(boxes: Floats) -> tuple[Integers, Integers]:
    """Return which objects, in boxes (n, 4), are so near that one may hide the other.

    Zhao and Pei, equations 18 and 19: the squared distance of their centers is less than
    A² + B², where A and B are half the sum of their widths and of their heights. The paper compares
    it with the root of that. Nobody meets itself.

    Returns
    -------
    i, j
        (k,) each, indices of both, each pair in both orders, sorted.
    """
    centers, sizes = boxes[:, :2] + boxes[:, 2:] / 2, boxes[:, 2:]
    # The root of A² + B² is at most half the sum of the diagonals.
    around = squares(centers, np.hypot(sizes[:, 0], sizes[:, 1]) / 2 + MARGIN)
    i, j = meeting(around, around)
    away, reach = centers[i] - centers[j], (sizes[i] + sizes[j]) / 2
    met = ((away**2).sum(axis=1) < (reach**2).sum(axis=1)) & (i != j)
    return i[met], j[met]
