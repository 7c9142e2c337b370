"""Films that are cut in two pictures, as of two cameras, and people who pass between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from motes import Box, Detection, Frame, Scene, Status, named_detector
from motes.core import iou
from motes_fleet.cameras.arrivals import VISIBLE
from motes_fleet.cameras.camera_report import ObjectReport
from motes_fleet.cameras.camera_reporter import CameraReporter
from motes_fleet.cameras.reidentification import CrossCameraAssociation
from motes_fleet.cameras.rig_config import Overlap, Rig
from motes_lab.datasets.distractors import evaluated_rows
from motes_lab.datasets.mot import MotSequence

SHARED = 0.25
"""Share of a film's width that both pictures show."""
WINDOW = 10
"""Frames that a film must have after an entry."""
KNOWN = 5
"""Frames for which a person must be in the first picture before entering the second one."""
MATCH_IOU = 0.3
"""An object is a person if their boxes overlap by more than this."""
NAMES = "left", "right"


class Moment(NamedTuple):
    """A frame of a film, the true boxes by number, and given detections, if there are any."""

    frame: Frame
    truth: Mapping[int, Box]
    detections: Sequence[Detection] | None


class Entry(NamedTuple):
    """The entry of a person into a picture: number of the person, picture, frame."""

    person: int
    view: int
    frame: int


def moments_of(sequence: MotSequence) -> list[Moment]:
    """Return the frames of people, with the truth and the detections."""
    truth, _ = evaluated_rows(sequence.truth, sequence.truth, ())
    moments = []
    known = sequence.detections
    for frame in sequence.pictures():
        boxes = {person: box for person, box, _ in truth.listed(frame.index)}
        found = None if known is None else known.detections(frame.index)
        moments.append(Moment(frame, boxes, found))
    return moments


def views_of(width: int, shared: float = SHARED) -> tuple[range, range]:
    """Return the columns of the two pictures of a film; below 0, what is between is unseen."""
    half = round(width * (1 + shared) / 2)
    return range(half), range(width - half, width)


def part(box: Box, columns: range) -> Box | None:
    """Return the part of a box in a picture, in its coordinates; None if it is too small."""
    left, right = max(box.x, columns.start), min(box.x + box.width, columns.stop)
    if right - left < VISIBLE * box.width:
        return None
    return Box(left - columns.start, box.y, right - left, box.height)


def detected_part(found: Detection, columns: range) -> Detection | None:
    """Return a detection as a detector would give it in a picture."""
    box = part(found.box, columns)
    return None if box is None else Detection(box, found.score)


def entries(truths: Sequence[Mapping[int, Box]], views: Sequence[range]) -> list[Entry]:
    """Return the entries of people that have been in the other picture for `KNOWN` frames."""
    found = []
    since: dict[tuple[int, int], int] = {}
    for index, boxes in enumerate(truths):
        here = {(n, v) for n, box in boxes.items() for v in range(2) if part(box, views[v])}
        for person, view in sorted(here):
            first = since.get((person, view)) is None
            known = index - since.get((person, 1 - view), index) >= KNOWN
            if first and known and index + WINDOW <= len(truths):
                found.append(Entry(person, view, index))
        since = {key: since.get(key, index) for key in here}
    return found


def overlap_of(views: Sequence[range]) -> Overlap:
    """Return how the two pictures overlap."""
    shift = float(views[0].start - views[1].start)
    return Overlap(NAMES, ((1.0, 0.0, shift), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


class Found(NamedTuple):
    """What a rig has of a person in a picture: the identity, and the overlap with the truth."""

    identity: int
    overlap: float


def run(
    moments: Sequence[Moment], rig: Rig, exchange: bool, shared: float = SHARED
) -> list[dict[tuple[int, int], Found]]:
    """Return for each frame what a rig has of each (person, picture)."""
    association = CrossCameraAssociation(rig)
    given: list[list[Detection]] = [[], []]

    def scene(view: int) -> Scene:
        if moments[0].detections is None:
            return Scene(named_detector("background"))
        return Scene(lambda _: given[view])

    reporters = [CameraReporter(camera, scene(view)) for view, camera in enumerate(rig.camera)]
    views = views_of(moments[0].frame.width, shared)
    answers = []
    for moment in moments:
        frame = moment.frame
        coming = [association.arrivals(name, frame.time) if exchange else () for name in NAMES]
        answer: dict[tuple[int, int], Found] = {}
        for view, reporter in enumerate(reporters):
            columns = views[view]
            given[view] = [
                each
                for found in moment.detections or ()
                if (each := detected_part(found, columns)) is not None
            ]
            reporter.expect(coming[view])
            pixels = frame.pixels[:, columns.start : columns.stop]
            report = reporter.report(Frame(frame.index, frame.time, pixels))
            found = association.update(report)
            seen = [s for s in report.sightings if s.status is Status.TRACKING]
            answer |= _matched(moment.truth, columns, view, seen, found)
        answers.append(answer)
    return answers


def _matched(
    truth: Mapping[int, Box],
    columns: range,
    view: int,
    seen: Sequence[ObjectReport],
    identities: Mapping[int, int],
) -> dict[tuple[int, int], Found]:
    """Return what a picture's objects are of the people in it."""
    picture = range(len(columns))
    parts = [part(each.box, picture) or Box(0, 0, 0, 0) for each in seen]
    boxes, answer = np.array(parts, np.float64).reshape(-1, 4), {}
    for person, whole in truth.items():
        box = part(whole, columns)
        if box is None or not seen:
            continue
        overlaps = iou(np.array(box), boxes)
        best = int(overlaps.argmax())
        own = seen[best].identity
        if overlaps[best] > MATCH_IOU and own in identities:
            answer[person, view] = Found(identities[own], float(overlaps[best]))
    return answer
