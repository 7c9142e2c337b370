"""Whether the target is tracked, lost or searched for, and at which of several places it is.

The rules for the status read log odds only, no pixels. At log odds of 0 the target is as likely
there as not, and the confidence is one half. Where two experts part, a single frame must not
decide: a neighbor who looks alike is the surer one now and then. So the difference of their
evidence is added up, as in Wald's sequential test (Annals of Mathematical Statistics 1945).

No two targets are at one place: what is seen there speaks for one of them only (MacCormick and
Blake, A probabilistic exclusion principle for tracking multiple objects, ICCV 1999). So when
targets that were apart are found at one place, it belongs to the one that is most like itself there
and moves on as before, and the others look again. Twins are told apart by their motion alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Set
from typing import NamedTuple, Self

import numpy as np

from motes.core.geometry import Ellipse, iou
from motes.core.track import Status

FRAMES = 3
"""A target is lost after this many frames in a row that speak against it, and found after as many
that speak for it: single frames are blurred, or wrong by chance."""


class Standing(NamedTuple):
    """The status of a target, and the counts that it follows from."""

    status: Status = Status.TRACKING
    """The status that the track reports."""
    missed: int = 0
    """Number of frames since the target was last believed to be there."""
    confirmed: int = 0
    """Number of frames in a row that speak for the target."""
    contradicted: int = 0
    """Number of frames in a row that contradict the status."""

    @property
    def trusted(self) -> bool:
        """Whether the target was believed to be there in one of the last frames."""
        return self.missed < FRAMES

    def after(self, evidence: float, *, jumped: bool) -> Self:
        """Return the status after a frame.

        A lost target is believed in only after some frames in a row. So the tracker learns nothing
        from an object that is only similar. `evidence` is the log odds that the target is at the
        estimate, or another number of their sign; it has `jumped` if the search has found this
        place in this frame.
        """
        there, tracking = evidence > 0, self.status is Status.TRACKING
        confirmed, contradicted = (0, 0) if jumped else (self.confirmed, self.contradicted)
        confirmed = confirmed + 1 if there else 0
        contradicted = contradicted + 1 if there is not tracking else 0
        believed = there and (self.trusted or confirmed >= FRAMES)
        status = self.status if tracking else Status.SEARCHING
        if contradicted == FRAMES:
            contradicted, status = 0, Status.LOST if tracking else Status.TRACKING
        missed = 0 if believed else self.missed + 1
        return type(self)(status, missed, confirmed, contradicted)


APART = 0.3
"""Two places are different targets from this distance on, in mean sides of the target."""
DECIDED = 1.0
"""Log odds that decide for a place, or between two places: nearly three to one."""


def apart(place: Ellipse, other: Ellipse) -> bool:
    """Return whether two places are too far from each other to be the same target."""
    return math.hypot(place.x - other.x, place.y - other.y) > APART * other.side


class Rival(NamedTuple):
    """A second place, and the evidence for it."""

    place: Ellipse
    """Where it is, if it is alive."""
    lead: float = 0.0
    """Log odds that it is the target and not what is followed, added up over frames."""
    alive: bool = False
    """Whether there is one."""

    @property
    def wins(self) -> bool:
        """Whether the rival is the likelier target."""
        return self.lead > DECIDED

    @property
    def loses(self) -> bool:
        """Whether the rival is not the target."""
        return self.lead < -DECIDED

    def after(self, place: Ellipse, difference: float) -> Self:
        """Return the rival after a frame: its place, and the log odds that it adds there."""
        return type(self)(place, self.lead + difference, alive=True)


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
    claims: Mapping[int, Claim], upon: Set[tuple[int, int]] = frozenset()
) -> dict[int, Taken]:
    """Return who has to look again, by index, and the places that others have taken.

    Pairs of indices `upon` each other, the lower one first, take no place from each other.
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
            and (min(index, indices[k]), max(index, indices[k])) not in upon
        )
        if places:
            again[index] = Taken(places, BESIDE if missed[n] else SHARED)
        else:
            owners.append(n)
    return again
