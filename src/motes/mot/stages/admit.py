"""Expected objects begin in the first frame in which they are seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.types import Floats
from motes.mot.association import assign
from motes.mot.expected import Expected
from motes.mot.scene_config import SceneConfig
from motes.mot.tracked_object import TrackedObject


def admit(
    seed: int,
    created: int,
    expected: Sequence[Expected],
    objects: Sequence[TrackedObject],
    free: Sequence[Detection],
    frame: Frame,
    config: SceneConfig,
) -> tuple[list[TrackedObject], dict[int, int], list[Detection]]:
    """Return the expected objects that begin in a frame, their keys, and the detections left.

    Identities go on from the number of objects that have been created; keys are by identity.

    An expected object begins at the free detection that holds most of its samples, and at least the
    share of the appearance rule, without further confirmation. It begins nowhere if an object is
    there already. A certain one without a detection begins where its samples fulfill the appearance
    rule.
    """
    begun, keys, used = list[TrackedObject](), dict[int, int](), set[int]()
    if not expected:
        return begun, keys, list(free)
    visible = [each for each in objects if not each.occluded]
    boxes = [*(each.box for each in visible), *(each.box for each in free)]
    held = _held([each.samples for each in expected], boxes, frame)
    fraction = config.tracker.presence.fraction
    places = dict(assign(np.where(held > fraction, 1 - held, np.inf)))
    for i, each in enumerate(expected):
        identity = created + len(begun) + 1
        rng = np.random.Generator(np.random.PCG64((seed, identity)))
        n = places.get(i, len(boxes)) - len(visible)
        if n < 0 or (i not in places and not each.certain):
            continue
        detection = free[n] if i in places else None
        box = None if detection is None else detection.box
        found = TrackedObject.take_over(identity, config.tracker, rng, frame, each, box)
        if found is None:
            continue
        if detection is not None:
            used.add(n)
            found = found.vote(detection)
        begun.append(found)
        keys[identity] = each.key
    return begun, keys, [each for n, each in enumerate(free) if n not in used]


def _held(samples: Sequence[Floats], boxes: Sequence[Box], frame: Frame) -> Floats:
    """Return the share of each set of samples (N, 5) that each box holds: (sets, boxes).

    A box holds a sample if it holds the middle of the part that lies in the frame: at the border,
    only a part of an object is detected.
    """
    held = np.zeros((len(samples), len(boxes)))
    ends = np.array([frame.width, frame.height]) - 0.5
    for i, each in enumerate(samples):
        low = (each[:, :2] - each[:, 2:4]).clip(-0.5, ends)
        high = (each[:, :2] + each[:, 2:4]).clip(-0.5, ends)
        middles = (low + high) / 2
        for j, (x, y, width, height) in enumerate(boxes):
            center = x + (width - 1) / 2, y + (height - 1) / 2
            inside = np.abs(middles - center) <= (width / 2, height / 2)
            held[i, j] = (inside.all(axis=1) & (high > low).all(axis=1)).mean()
    return held
