"""Stage 8: detections that are left begin objects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.mot.detection_outcome import DetectionOutcome, LoggedDetection
from motes.mot.scene_config import SceneConfig
from motes.mot.track_initiation import TrackInitiation
from motes.mot.tracked_object import TrackedObject


def initiate(
    seed: int,
    initiation: TrackInitiation,
    free: Sequence[Detection],
    frame: Frame,
    config: SceneConfig,
) -> tuple[list[TrackedObject], TrackInitiation, list[LoggedDetection]]:
    """Return the objects that begin in a frame, the tentative tracks after it, and outcomes.

    An object's random numbers depend only on the seed and its identity.
    """
    after, hits = initiation.update(frame.time, free, config.association.overlap, config.initiation)
    begun, log = list[TrackedObject](), list[LoggedDetection]()
    for each, confirmed in zip(free, hits, strict=True):
        if confirmed is None:
            log.append(LoggedDetection(each, DetectionOutcome.DOUBTFUL))
        elif len(confirmed) < config.initiation.min_hits:
            log.append(LoggedDetection(each, DetectionOutcome.CANDIDATE))
        else:
            identity = initiation.created + len(begun) + 1
            rng = np.random.Generator(np.random.PCG64((seed, identity)))
            new = TrackedObject.begin(identity, config.tracker, rng, frame, confirmed)
            begun.append(new.vote(each.label))
            log.append(LoggedDetection(each, DetectionOutcome.BORN, identity))
    return begun, after, log
