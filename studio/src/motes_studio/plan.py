"""What an object needs: its stretches, and the passes over them, each with a name that is its own.

A pass depends only on the tracker, its first frame and region, and the keyframe at its other end,
if there is one. So a correction needs only the passes on its two sides.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import NamedTuple

import msgspec

from motes import Box, Ellipse, TrackerConfig
from motes.correction import Stretch
from motes_studio.document import DrawnTarget


class RunPass(NamedTuple):
    """A target is followed from its region in frame `start` to frame `stop`, both included.

    `stop` before `start` is a pass backward. The models also learn from `other`, the frame and the
    region of the keyframe at the other end.
    """

    config: TrackerConfig
    seed: int
    start: int
    region: tuple[float, ...]
    stop: int
    other: tuple[int, tuple[float, ...]] | None = None


class PassNeed(NamedTuple):
    """A pass, and the number of its frames that are needed."""

    key: str
    task: RunPass
    frames: int


class StretchNeed(NamedTuple):
    """A stretch between keyframes, and the passes over it; one may be missing."""

    key: str
    stretch: Stretch
    forward: PassNeed | None
    backward: PassNeed | None

    @property
    def passes(self) -> tuple[PassNeed, ...]:
        """The passes that there are."""
        return tuple(each for each in (self.forward, self.backward) if each is not None)


def needs(target: DrawnTarget) -> list[StretchNeed]:
    """Return the stretches of an object, in order."""
    config, seed = target.tracker, target.seed
    own = [target.imported] if target.imported else []
    found = []
    for stretch in Stretch.between(target.frames, target.marks):
        first, last, begin, end, _ = stretch
        at_begin, at_end = _mark(first, begin), _mark(last, end)
        forward = backward = None
        if at_begin is not None:
            forward = _pass(RunPass(config, seed, *at_begin, last, at_end), *own)
        if at_end is not None:
            backward = _pass(RunPass(config, seed, *at_end, first, at_begin), *own)
        key = name_of("stretch", config, seed, *stretch[:4], sorted(stretch.absent), *own)
        found.append(StretchNeed(key, stretch, forward, backward))
    return found


def pass_to(target: DrawnTarget, frame: int) -> RunPass:
    """Return the pass of an object that ends in a frame: forward where that is possible."""
    each = next(each for each in reversed(needs(target)) if each.stretch.first <= frame)
    need = each.forward or each.backward
    assert need is not None  # each stretch has a keyframe at one end at least
    return need.task._replace(stop=frame)


def _mark(frame: int, region: Box | Ellipse | None) -> tuple[int, tuple[float, ...]] | None:
    return None if region is None else (frame, tuple(region))


def _pass(task: RunPass, *own: str) -> PassNeed:
    direction = "backward" if task.stop < task.start else "forward"
    key = name_of(direction, task.config, task.seed, task.start, task.region, task.other, *own)
    return PassNeed(key, task, abs(task.stop - task.start) + 1)


def name_of(kind: str, config: TrackerConfig, *values: object) -> str:
    """Return a short name of values, which are the same if and only if the names are."""
    data = msgspec.json.encode((config.to_dict(), *values), order="deterministic")
    return f"{kind}:{hashlib.blake2b(data, digest_size=16).hexdigest()}"


def own_frames(found: list[StretchNeed]) -> Iterator[tuple[StretchNeed, int]]:
    """Yield each stretch with its first frame that is not of the one before, as they share one."""
    for i, need in enumerate(found):
        yield need, need.stretch.first + (i > 0)
