"""No two targets are at one place: who of them is there, and who has to be elsewhere.

What is seen at a place speaks for one target only (MacCormick and Blake, A probabilistic exclusion
principle for tracking multiple objects, ICCV 1999). So when targets that were apart are found at
one place, it belongs to the one that is most like itself there and moves on as before, and the
others look again. Twins are told apart by their motion alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import NamedTuple

import numpy as np

from motes.core.geometry import Ellipse, iou
from motes.sot.discriminative.identity import BESIDE

SHARED = 0.5
"""Overlap of the boxes of two targets from which they are at one place."""


class Taken(NamedTuple):
    """Places of other targets, at which a target is not."""

    places: tuple[Ellipse, ...] = ()
    overlap: float = SHARED
    """Overlap with one of them from which a target would be there."""

    def holds(self, place: Ellipse) -> bool:
        """Return whether a place is one of them."""
        boxes = [each.box for each in self.places]
        return bool(boxes) and bool(np.any(iou(place.box, boxes) > self.overlap))


class Claim(NamedTuple):
    """A target that is seen in a frame."""

    before: Ellipse
    """Where it was in the frame before."""
    now: Ellipse
    """Where it is seen."""
    missed: bool
    """Whether it was missed before this frame. It may be seen behind another one no more: it has to
    come out from there."""
    against: float
    """How much speaks against its being there, in log odds."""


def excluded(
    claims: Mapping[int, Claim], upon: Set[tuple[int, int]] = frozenset()
) -> dict[int, Taken]:
    """Return who has to look again, by index, and the places that others have taken.

    Pairs of indices `upon` each other, the lower one first, take no place from each other.
    """
    indices = sorted(claims, key=lambda index: claims[index].against)
    seen = [claims[index] for index in indices]
    before, now = (np.array(boxes).reshape(-1, 4) for boxes in (
        [each.before.box for each in seen], [each.now.box for each in seen]
    ))  # fmt: skip
    missed = np.array([each.missed for each in seen], bool)
    met = (iou(now[:, None], now) > SHARED) & (iou(before[:, None], before) <= SHARED)
    behind = (iou(now[:, None], now) > BESIDE) & (missed[:, None] | missed)
    owners: list[int] = []
    again = {}
    for n, index in enumerate(indices):
        places = tuple(
            seen[k].now
            for k in owners
            if (met[n, k] or behind[n, k])
            and (min(index, indices[k]), max(index, indices[k])) not in upon
        )
        if places:
            again[index] = Taken(places, BESIDE if missed[n] else SHARED)
        else:
            owners.append(n)
    return again
