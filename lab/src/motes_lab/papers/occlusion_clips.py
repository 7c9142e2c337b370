"""Rendered clips in which objects meet, and one fully hides the other for a known time."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.synthetic.beetle import Colors, Target
from motes.synthetic.clips import Clip

Way = Literal["passing", "crossing", "turning back"]
"""The motion of the hidden object.

It passes behind a longer one that moves at the same speed; it pauses behind one that stands, and
walks onward; or it does the same, and walks back.
"""

COATS: tuple[Colors, ...] = (
    ((238, 196, 92), (44, 30, 26), (196, 78, 40)),
    ((90, 140, 220), (30, 40, 80), (200, 200, 240)),
    ((200, 80, 80), (90, 20, 20), (250, 180, 120)),
    ((120, 190, 110), (30, 70, 40), (240, 240, 120)),
)
"""Colors (RGB) of the shell, its stripes and the head, for four kinds of beetles."""
LENGTH, WIDTH = 24.0, 17.0
"""Half-axes of the hidden object, in pixels."""
LANE_HEIGHT = 96
"""Distance between lanes in pixels. The background model joins patches closer than 6 %."""
MAX_LANES = 5
EMPTY = 300
"""Frames before the first object enters, so that a background model can learn."""
CROSSING_FRAMES = 3
"""Frames for which an object is fully hidden if the two cross without a pause."""
VISIBLE_FRAMES = 40
"""Frames between two meetings in which no object is hidden, even in part."""
MIN_SIZE = (240, 150)
"""The smallest frame."""


class OcclusionClip(NamedTuple):
    """A clip, and the first frame from which its meetings have the chosen motion."""

    clip: Clip
    since: int


class HiddenTarget(NamedTuple):
    """A target that is fully hidden from a first to a last frame."""

    target: int
    first: int
    last: int


def occlusion_clip(
    way: Way, length: int, objects: int = 2, *, same_colors: bool = False, seed: int = 0
) -> OcclusionClip:
    """Return a clip in which objects enter from the left, and equally many from the right.

    They walk in up to five lanes. In each lane, every object from the left meets every object from
    the right; with `turning back`, they turn around when the first has met the last. Objects from
    the right are larger and in front.

    Parameters
    ----------
    way
        The motion.
    length
        Approximate number of frames for which an object is fully hidden, 3 or more.
    objects
        Number of objects, equally many from the left and from the right in each lane.
    same_colors
        Whether objects that meet have the same colors, and differ only in their edges: stripes
        across.
    seed
        Determines the colors, the scenery, and the vertical positions.
    """
    rng = np.random.default_rng((seed, 3))
    lanes = min(objects // 2, MAX_LANES)
    per_side = objects // (2 * lanes)
    pause = length - CROSSING_FRAMES
    speed, front = (0.8, (0.8 * pause, 8.0)) if way == "passing" else (1.6, (3.0, 3.0))
    large = LENGTH + front[0], WIDTH + front[1]
    together = LENGTH + large[0]
    period = 2 * (together + VISIBLE_FRAMES * speed)
    width, height = (
        max(math.ceil(per_side * period), MIN_SIZE[0]),
        max(lanes * LANE_HEIGHT, MIN_SIZE[1]),
    )
    stops = (width - 1) / 2 + np.arange(per_side) * period / 2
    position = -large[0]
    way_there = [np.full(EMPTY, position)]
    for stop in stops:
        way_there += [np.arange(position, stop, speed)]
        way_there += [np.full(0 if way == "passing" else pause, stop)]
        position = stop
    since = sum(map(len, way_there)) - pause - VISIBLE_FRAMES if way == "turning back" else 0
    onward = speed * np.arange(math.ceil(together / 2 / speed) + VISIBLE_FRAMES)
    s = np.concatenate([*way_there, position + (-onward if way == "turning back" else onward)])
    back = np.arange(len(s)) >= since if since else np.zeros(len(s), bool)
    rear, front_targets = [], []
    for lane in range(lanes):
        y = height * (lane + 0.5) / lanes + rng.uniform(-4, 4)
        own_colors, other_colors = (COATS[k] for k in rng.permutation(len(COATS))[:2])
        for k in range(per_side):
            x = s - k * period
            rear.append(Target(_walk(x, y, (LENGTH, WIDTH), back), own_colors))
            walk = _walk(width - 1 - x, y, large, ~back)
            front_targets.append(
                Target(walk, own_colors if same_colors else other_colors, crosswise=same_colors)
            )
    return OcclusionClip(Clip((width, height), (*rear, *front_targets), seed=seed), since)


def _walk(
    x: NDArray[np.float64], y: float, axes: tuple[float, float], left: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return the states of an object that walks through x, to the left or to the right."""
    columns = np.broadcast_arrays(x, y, *axes, np.where(left, math.pi, 0.0))
    return np.stack(columns, axis=1)


def full_occlusions(
    visible: NDArray[np.float64], within: NDArray[np.bool_], unseen: float
) -> list[HiddenTarget]:
    """Return all full occlusions.

    Parameters
    ----------
    visible
        (frames, targets), visible share of each target.
    within
        (frames, targets), whether its center is in the frame.
    unseen
        Visible share below which a target is fully hidden.
    """
    found = []
    for target, gone in enumerate(((visible < unseen) & within).T):
        edges = np.flatnonzero(np.diff(gone.astype(int), prepend=0, append=0))
        pairs = edges.reshape(-1, 2).tolist()
        found += [HiddenTarget(target, first, end - 1) for first, end in pairs]
    return found
