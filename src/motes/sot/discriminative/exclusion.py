"""No two targets are at one place: who of them is there, and who has to be elsewhere.

What is seen at a place speaks for one target only (MacCormick and Blake, A probabilistic exclusion
principle for tracking multiple objects, ICCV 1999). So when targets that were apart are found at
one place, it belongs to the one that is most like itself there, and the others look again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from motes.core.geometry import Ellipse, iou
from motes.sot.discriminative.identity import BESIDE, GAIN, Identity
from motes.sot.discriminative.standing import DECIDED

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
    """Whether it was missed before this frame. If it looks like another one, it has to come out
    from behind it; a rider may be seen again before his horse."""
    who: Identity
    """What it looks like there, and how it is known to look."""

    @property
    def against(self) -> float:
        """How much speaks against its being there, in log odds."""
        return GAIN * float(self.who.distance(self.who.look)) + DECIDED * self.missed

    def like(self, other: Claim) -> bool:
        """Return whether it looks like another one as well."""
        difference = other.who.distance(self.who.look) - self.who.distance(self.who.look)
        return GAIN * float(difference) < DECIDED


def excluded(claims: Mapping[int, Claim]) -> dict[int, Taken]:
    """Return who has to look again, by index, and the places that others have taken.

    Targets that the user has placed upon each other stay there until one of them is missed.
    """
    indices = sorted(claims, key=lambda index: claims[index].against)
    seen = [claims[index] for index in indices]
    before, now = (np.array(boxes).reshape(-1, 4) for boxes in (
        [each.before.box for each in seen], [each.now.box for each in seen]
    ))  # fmt: skip
    missed = np.array([each.missed for each in seen], bool)
    overlap, met = iou(now[:, None], now), iou(before[:, None], before) <= SHARED
    shared = (overlap > SHARED) & (met | missed[:, None] | missed)
    beside = (overlap > BESIDE) & (missed[:, None] | missed)
    owners: list[int] = []
    again = {}
    for n, index in enumerate(indices):
        places = tuple(
            seen[k].now for k in owners
            if shared[n, k] or (beside[n, k] and seen[n].like(seen[k]))
        )  # fmt: skip
        if places:
            again[index] = Taken(places, BESIDE if missed[n] else SHARED)
        else:
            owners.append(n)
    return again
