"""Free detections go to occluded objects that reappear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import iou
from motes.mot.association import assign_pairs, impostors, model_distances, near
from motes.mot.overlaps import as_rows
from motes.mot.scene_config import SceneConfig
from motes.mot.tracked_object import TrackedObject


def reidentify(
    objects: Sequence[TrackedObject],
    free: Sequence[Detection],
    covers: Sequence[Detection],
    frame: Frame,
    dt: float,
    config: SceneConfig,
) -> tuple[list[TrackedObject], list[Detection]]:
    """Return the objects, some visible again; and the detections that stay free.

    Detections are assigned one to one, by the distance from where an object, or its occluder,
    should be, and by appearance. Of those that are left, those that overlap an object's place and
    look like another object, as `covers` of visible ones do, are not free: nobody begins there.
    """
    after = list(objects)
    occluded = [n for n, each in enumerate(objects) if each.occluded]
    if not occluded or not free:
        return after, [each for each in free if each not in covers]
    lost = [objects[n] for n in occluded]
    boxes = as_rows(each.box for each in free)
    predicted = {each.identity: each.predicted for each in objects}
    # An occluded object may also stop or turn round behind its occluder.
    places = np.array(
        [(each.predicted, predicted.get(each.occluded_by or 0, each.predicted)) for each in lost]
    )
    kept = config.smoothing.velocity
    variances = np.array([each.variance(frame.time, dt, kept) for each in lost])
    area = frame.width * frame.height
    rows, columns, off = near(places, variances, boxes, area)
    distances = model_distances(lost, frame, boxes, rows, columns)
    costs = config.association.recovery_costs(off, distances)
    others = impostors(lost, frame, boxes, rows, columns)
    costs[others] = np.inf
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    distance_of = dict(zip(pairs, distances.tolist(), strict=True))
    taken = set()
    for i, j in assign_pairs(rows, columns, costs, (len(lost), len(free))):
        found = lost[i].detect(free[j].box, frame.time).vote(free[j])
        track = replace(found.track, distance=distance_of[i, j])
        after[occluded[i]] = replace(found, track=track)
        taken.add(j)
    there = iou(as_rows(lost[i].box for i in rows.tolist()), boxes[columns])
    taken.update(columns[others & (there > 0)].tolist())
    return after, [each for j, each in enumerate(free) if j not in taken and each not in covers]
