"""Which detection is which object, by overlap and by appearance, one to one; what became of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from motes.config import Config, NonNegative, Share
from motes.detection import Detection
from motes.geometry import Box

Floats = NDArray[np.float64]


class Outcome(StrEnum):
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


@dataclass(frozen=True, slots=True)
class Account:
    """A detection, what became of it, and which object it went to."""

    detection: Detection
    outcome: Outcome
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
    reach
        How far from where it should be a hidden object may come up, in its own mean half-sizes.
    spread
        How much farther for every second that it was hidden.
    """

    overlap: Share = 0.2
    distance: Share = 0.45
    appearance: NonNegative = 0.5
    reach: NonNegative = 1.5
    spread: NonNegative = 2.0

    def costs(self, overlaps: Floats, distances: Floats) -> Floats:
        """Return the costs (n, m) of objects that were just seen; infinite where ruled out.

        Parameters
        ----------
        overlaps, distances
            (n, m), of each object with each detection: intersection over union, and distance of
            the object's model from what is seen there.
        """
        costs = 1 - overlaps + self.appearance * distances
        return np.where(overlaps >= self.overlap, costs, np.inf)

    def off(self, away: Floats, hidden: Floats) -> Floats:
        """Return how far off detections are from hidden objects, as a share of their reach.

        Parameters
        ----------
        away
            (n, m), how far each detection is from where each object should be, in its mean
            half-sizes.
        hidden
            (n,), seconds since it was seen.
        """
        reach = self.reach + self.spread * hidden[:, None]
        out: Floats = away / np.maximum(reach, np.finfo(float).tiny)
        return out

    def recoveries(self, off: Floats, distances: Floats) -> Floats:
        """Return the costs (n, m) of hidden objects; infinite where ruled out.

        Parameters
        ----------
        off, distances
            (n, m), how far off each detection is, and how far from each object's model.
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


def inside(first: Floats, second: Floats) -> Floats:
    """Return which share of each box (n, 4) lies inside each other one (m, 4): (n, m)."""
    low = np.maximum(first[:, None, :2], second[None, :, :2])
    high = np.minimum(
        first[:, None, :2] + first[:, None, 2:], second[None, :, :2] + second[None, :, 2:]
    )
    areas = first[:, 2:].prod(axis=1)
    shares: Floats = np.clip(high - low, 0, None).prod(axis=2) / areas[:, None]
    return shares


def divided(places: Floats, blob: Box) -> Floats:
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


def may_hide(boxes: Floats) -> NDArray[np.bool_]:
    """Return which objects, in boxes (n, 4), are so near that one may hide the other: (n, n).

    Zhao and Pei, equations 18 and 19: the squared distance of their centers is less than
    A² + B², where A and B are half the sum of their widths and of their heights. The paper compares
    it with the root of that. Nobody meets itself.
    """
    centers, sizes = boxes[:, :2] + boxes[:, 2:] / 2, boxes[:, 2:]
    away = centers[:, None] - centers
    reach = (sizes[:, None] + sizes) / 2
    met: NDArray[np.bool_] = (away**2).sum(axis=2) < (reach**2).sum(axis=2)
    return met & ~np.eye(len(boxes), dtype=bool)
