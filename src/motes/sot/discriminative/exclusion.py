"""Which of several targets is at a place, where more than one is found.

No two targets are at one place: what is seen there speaks for one of them only (MacCormick and
Blake, A probabilistic exclusion principle for tracking multiple objects, ICCV 1999). So when
targets that were apart are found at one place, it belongs to the one that is most like itself there
and moves on as before, and the others look again. Twins are told apart by their motion alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import NamedTuple

import numpy as np

from motes.core.geometry import Ellipse, iou

BESIDE = 0.2
"""Overlap below which two boxes are beside each other, and show two objects."""
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
    """Whether it was missed before this frame. Then an overlap by more than `BESIDE` makes one
    place of two: who comes out from behind another one has to be seen beside it."""
    against: float
    """How much speaks against its being there, in log odds."""


def excluded(
    claims: Mapping[int, Claim], stacked: Set[tuple[int, int]] = frozenset()
) -> dict[int, Taken]:
    """Return who has to look again, by index, and the places that others have taken.

    Pairs of `stacked` indices, the lower one first, take no place from each other.
    """
    indices = sorted(claims, key=lambda index: claims[index].against)
    seen = [claims[index] for index in indices]
    before = np.array([each.before.box for each in seen]).reshape(-1, 4)
    now = np.array([each.now.box for each in seen]).reshape(-1, 4)
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
            and (min(index, indices[k]), max(index, indices[k])) not in stacked
        )
        if places:
            again[index] = Taken(places, BESIDE if missed[n] else SHARED)
        else:
            owners.append(n)
    return again
