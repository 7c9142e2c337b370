"""Rendered clips in which objects meet, and one hides the other whole for a known time."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.evaluation.synthetic.clips import Clip, Colors, Target

Way = Literal["passing", "crossing", "turning back"]
"""Behind a longer one, at an even pace; behind one that stands, and on; the same, and back."""

COATS: tuple[Colors, ...] = (
    ((238, 196, 92), (44, 30, 26), (196, 78, 40)),
    ((90, 140, 220), (30, 40, 80), (200, 200, 240)),
    ((200, 80, 80), (90, 20, 20), (250, 180, 120)),
    ((120, 190, 110), (30, 70, 40), (240, 240, 120)),
)
"""Colors (RGB) of the shell, its stripes and the head, for four kinds of beetles."""
LENGTH, WIDTH = 24.0, 17.0
"""Half-axes of who is hidden, in pixels."""
LANE = 96
"""Pixels from one lane to the next: patches of a background closer than 6 % are one."""
LANES = 5
EMPTY = 300
"""Frames before anyone comes: a camera that stands still knows its background."""
BRIEF = 3
"""Frames for which one is hidden whole where they cross without a pause."""
APART = 40
"""Frames for which nobody is hidden, not even in part, between two meetings."""
LEAST = (240, 150)
"""The smallest frame."""


class Meetings(NamedTuple):
    """A clip, and from which frame on its meetings are of the way that is asked for."""

    clip: Clip
    since: int


class Hidden(NamedTuple):
    """A target that is hidden whole from a frame to another one."""

    target: int
    first: int
    last: int


def meetings(
    way: Way, length: int, objects: int = 2, *, alike: bool = False, seed: int = 0
) -> Meetings:
    """Return a clip in which objects come from the left, and as many from the right.

    They walk in up to five lanes, in each of which everyone from the left meets everyone from the
    right, until the first have met the last; there they turn back, if that is asked for. Who comes
    from the right is larger, and in front.

    Parameters
    ----------
    way
        How they meet.
    length
        For about how many frames one is hidden whole, 3 or more.
    objects
        How many there are, as many from the left as from the right in each lane.
    alike
        Whether those who meet have the same colors, and only other edges: stripes across.
    seed
        Chooses the colors, the scenery, and how high they walk.
    """
    rng = np.random.default_rng((seed, 3))
    lanes = min(objects // 2, LANES)
    each = objects // (2 * lanes)
    stay = length - BRIEF
    pace, front = (0.8, (0.8 * stay, 8.0)) if way == "passing" else (1.6, (3.0, 3.0))
    large = LENGTH + front[0], WIDTH + front[1]
    together = LENGTH + large[0]
    period = 2 * (together + APART * pace)
    width, height = max(math.ceil(each * period), LEAST[0]), max(lanes * LANE, LEAST[1])
    stops = (width - 1) / 2 + np.arange(each) * period / 2
    here = -large[0]
    way_there = [np.full(EMPTY, here)]
    for stop in stops:
        way_there += [np.arange(here, stop, pace)]
        way_there += [np.full(0 if way == "passing" else stay, stop)]
        here = stop
    since = sum(map(len, way_there)) - stay - APART if way == "turning back" else 0
    on = pace * np.arange(math.ceil(together / 2 / pace) + APART)
    s = np.concatenate([*way_there, here + (-on if way == "turning back" else on)])
    back = np.arange(len(s)) >= since if since else np.zeros(len(s), bool)
    behind, before = [], []
    for lane in range(lanes):
        y = height * (lane + 0.5) / lanes + rng.uniform(-4, 4)
        mine, other = (COATS[k] for k in rng.permutation(len(COATS))[:2])
        for k in range(each):
            x = s - k * period
            behind.append(Target(_walk(x, y, (LENGTH, WIDTH), back), mine))
            walk = _walk(width - 1 - x, y, large, ~back)
            before.append(Target(walk, mine if alike else other, crosswise=alike))
    return Meetings(Clip((width, height), (*behind, *before), seed=seed), since)


def _walk(
    x: NDArray[np.float64], y: float, axes: tuple[float, float], left: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return the states of who goes through x, to the left or to the right."""
    columns = np.broadcast_arrays(x, y, *axes, np.where(left, math.pi, 0.0))
    return np.stack(columns, axis=1)


def hidden(visible: NDArray[np.float64], within: NDArray[np.bool_], unseen: float) -> list[Hidden]:
    """Return who is hidden when.

    Parameters
    ----------
    visible
        (frames, targets), which share of each target is seen.
    within
        (frames, targets), whether its center is in the frame.
    unseen
        Share below which a target is hidden whole.
    """
    found = []
    for target, gone in enumerate(((visible < unseen) & within).T):
        edges = np.flatnonzero(np.diff(gone.astype(int), prepend=0, append=0))
        pairs = edges.reshape(-1, 2).tolist()
        found += [Hidden(target, first, end - 1) for first, end in pairs]
    return found
