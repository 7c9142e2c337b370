"""Detections go to visible objects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.types import Floats
from motes.mot.association import SAME, assign_pairs, impostors, model_distances
from motes.mot.overlaps import as_rows, merged_blobs, overlapping_pairs
from motes.mot.scene_config import SceneConfig
from motes.mot.tracked_object import TrackedObject


def associate(
    objects: Sequence[TrackedObject],
    detections: Sequence[Detection],
    frame: Frame,
    dt: float,
    config: SceneConfig,
) -> tuple[list[TrackedObject], list[Detection], list[Detection]]:
    """Return the objects, the visible ones where they are detected; free detections; and covers.

    A detection in which several objects lie is divided between them. The others are assigned one to
    one, by overlap and by appearance. Covers are those of the free ones that are at an object's
    place, but look like another one: somebody is before it.
    """
    after = list(objects)
    visible = [n for n, each in enumerate(objects) if not each.occluded]
    if not visible or not detections:
        return after, list(detections), []
    places = as_rows(objects[n].predicted.box for n in visible)
    boxes = as_rows(each.box for each in detections)

    def detect(i: int, box: Box) -> None:
        after[visible[i]] = objects[visible[i]].detect(box, frame.time, config.smoothing.size)

    blobs = merged_blobs(places, boxes)
    taken, held = set(blobs), [i for inside in blobs.values() for i in inside]
    for j, inside in blobs.items():
        shared = split_merged_blob(places[inside], detections[j].box)
        for i, box in zip(inside, shared.tolist(), strict=True):
            detect(i, Box(*box))
    rows, columns, overlaps = overlapping_pairs(places, boxes, config.association.overlap)
    free = ~(np.isin(rows, held) | np.isin(columns, list(blobs)))
    rows, columns, overlaps = rows[free], columns[free], overlaps[free]
    seen = [objects[n] for n in visible]
    distances = model_distances(seen, frame, boxes, rows, columns)
    costs = config.association.costs(overlaps, distances)
    apart = np.flatnonzero(overlaps < SAME)
    others = apart[impostors(seen, frame, boxes, rows[apart], columns[apart])]
    costs[others] = np.inf
    for i, j in assign_pairs(rows, columns, costs, (len(visible), len(detections))):
        detect(i, detections[j].box)
        found = after[visible[i]].update_velocity(config.smoothing.velocity, dt)
        after[visible[i]] = found.vote(detections[j])
        taken.add(j)
    covering = set(columns[others].tolist()) - taken
    left = [j for j in range(len(detections)) if j not in taken]
    return after, [detections[j] for j in left], [detections[j] for j in left if j in covering]


def split_merged_blob(places: Floats, blob: Box) -> Floats:
    """Return where objects are in a box that holds them all, each with its own size: (n, 4).

    They are where they are predicted, in `places` (n, 4), or as near to it as the box allows. Its
    edges do not tell where an object is: an unknown one may be there too.
    """
    low, room = np.array(blob[:2]), np.array(blob[2:]) - places[:, 2:]
    inside = np.clip(places[:, :2], low, low + np.maximum(room, 0))
    middle = low + room / 2  # of one that is larger than the box
    return np.hstack([np.where(room < 0, middle, inside), places[:, 2:]])
