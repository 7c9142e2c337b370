"""Nummiaro et al., section VII: two cameras that wait for one person whose histogram is known.

The paper has two rooms. Here a film is cut in two pictures, as in `cut_films`, so that the truth is
known when the person comes into the second one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from motes import Ellipse, Frame, KnownTarget, Place, Status
from motes.core import iou
from motes.cues import Color
from motes_fleet.cameras.known_target import KnownTargetReporter
from motes_fleet.cameras.reidentification import CrossCameraAssociation
from motes_fleet.cameras.rig_config import Camera, Rig
from motes_lab.datasets.mot import MotSequence
from motes_lab.experiment import Experiment, Result
from motes_lab.metrics.statistics import over
from motes_lab.papers.cut_films import (
    KNOWN,
    MATCH_IOU,
    NAMES,
    Entry,
    Moment,
    entries,
    moments_of,
    overlap_of,
    part,
    views_of,
)
from motes_lab.report.tables import Cell, Row, Table, number, percent

BORDER = 0.15
"""Width of the door of a picture, a strip along its border, as a share of the picture."""
WINDOW = 25
"""Frames after an entry that are measured."""
WAYS = {
    "nothing, search everywhere": (False, False),
    "nothing, search at the door": (True, False),
    "samples, search at the door": (True, True),
}
"""What cameras exchange, and where they search: whether at doors, and whether they exchange."""


class Wait(NamedTuple):
    """What became of an entry: frames until the person is tracked, mean overlap, whether tracked.

    Frames are `WINDOW` if the person is not tracked by then.
    """

    frames: int
    overlap: float
    found: bool


def rig_of(views: Sequence[range], height: int, doors: bool) -> Rig:
    """Return two cameras that overlap; the door of each is its border in the other's picture."""
    cameras = []
    for name, columns in zip(NAMES, views, strict=True):
        width = round(BORDER * len(columns))
        left = len(columns) - width if name == NAMES[0] else 0
        door = Place("door", (float(left), 0.0, float(width), float(height)))
        cameras.append(Camera(name, "", place=(door,) * doors))
    return Rig(tuple(cameras), overlap=(overlap_of(views),))


def wait(moments: Sequence[Moment], entry: Entry, doors: bool, exchange: bool) -> Wait | None:
    """Return what became of an entry; None if the first camera has lost the person before it."""
    person, view, first = entry
    frame = moments[first].frame
    views = views_of(frame.width)
    rig = rig_of(views, frame.height, doors)
    association = CrossCameraAssociation(rig, known_target=True)
    start = moments[first - KNOWN]
    other = views[1 - view]
    region = part(start.truth[person], other)
    assert region is not None
    pixels = start.frame.pixels[:, other.start : other.stop]
    learned = Frame(start.frame.index, start.frame.time, pixels)
    target = KnownTarget.learn(Color(), learned, Ellipse.from_box(region))
    reporters = [KnownTargetReporter(camera, target) for camera in rig.camera]
    # The first camera has found the person already.
    reporters[1 - view].start(learned, Ellipse.from_box(region))
    overlaps: list[float] = []
    for index in range(first - KNOWN + 1, first + WINDOW):
        if index >= len(moments):
            return None
        moment = moments[index]
        coming = [
            association.arrivals(name, moment.frame.time) if exchange else () for name in NAMES
        ]
        for n, reporter in enumerate(reporters):
            columns = views[n]
            reporter.expect(coming[n])
            pixels = moment.frame.pixels[:, columns.start : columns.stop]
            report = reporter.report(Frame(moment.frame.index, moment.frame.time, pixels))
            association.update(report)
            seen = [each for each in report.sightings if each.status is Status.TRACKING]
            truth = part(moment.truth[person], columns) if person in moment.truth else None
            if index == first and n == 1 - view and not seen:
                return None
            if index >= first and n == view:
                boxes = [part(each.box, range(len(columns))) for each in seen]
                right = [box for box in boxes if box is not None and truth is not None]
                overlaps.append(float(iou(np.array(truth), np.array(right))[0]) if right else 0.0)
    hits = [n for n, overlap in enumerate(overlaps) if overlap > MATCH_IOU]
    return Wait(min([*hits, WINDOW]), float(np.mean(overlaps)), bool(hits))


def known_person(films: Sequence[MotSequence]) -> Experiment:
    """Yield how soon the second camera has a known person, with what cameras exchange."""
    waits: dict[str, list[Wait]] = {}
    for done, film in enumerate(films, start=1):
        moments = moments_of(film)
        entered = entries([m.truth for m in moments], views_of(moments[0].frame.width))
        for entry in entered:
            for name, (doors, exchange) in WAYS.items():
                found = wait(moments, entry, doors, exchange)
                if found is not None:
                    waits.setdefault(name, []).append(found)
        yield Result({"": _table(waits)}, progress=f"{done} of {len(films)} films")


def _table(waits: Mapping[str, Sequence[Wait]]) -> Table:
    rows: list[Row] = [
        (
            Cell(name),
            number(len(found), 0),
            number(over(each.frames for each in found), 1),
            number(over(each.overlap for each in found), 3),
            percent(float(np.mean([each.found for each in found]))),
        )
        for name, found in waits.items()
    ]
    head = (
        "cameras exchange", "entries", "frames until tracked", f"IoU over {WINDOW} frames",
        f"tracked within {WINDOW} frames",
    )  # fmt: skip
    note = f"Frames from when a quarter of the person is in the second picture, at most {WINDOW}."
    return Table("Two cameras and a known person", head, rows, note=note)
