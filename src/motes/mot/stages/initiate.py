"""Detections that are left begin objects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.mot.overlaps import as_rows
from motes.mot.scene_config import SceneConfig
from motes.mot.track_initiation import TrackInitiation
from motes.mot.tracked_object import TrackedObject


def initiate(
    seed: int,
    created: int,
    initiation: TrackInitiation,
    objects: Sequence[TrackedObject],
    free: Sequence[Detection],
    frame: Frame,
    config: SceneConfig,
) -> tuple[list[TrackedObject], TrackInitiation]:
    """Return the objects that begin in a frame, and the tentative tracks after it.

    Identities go on from the number of objects that have been created. An object's random numbers
    depend only on the seed and its identity.
    """
    places = as_rows(each.box for each in objects)
    after, confirmed = initiation.update(
        frame.time, free, places, config.association.overlap, config.initiation
    )
    begun = list[TrackedObject]()
    for identity, (each, so_far) in enumerate(confirmed, start=created + 1):
        rng = np.random.Generator(np.random.PCG64((seed, identity)))
        new = TrackedObject.begin(identity, config.tracker, rng, frame, so_far.hits)
        begun.append(replace(new.vote(each), best=so_far.best))
    return begun, after
