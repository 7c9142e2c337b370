"""Results, truth and detections of the MOTChallenge: a line for each box, see `mot_files`.

Frames and pixels count from 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.formats.mot_files import UNKNOWN, Kind, MotRows, read_rows
from motes.formats.recording import ANONYMOUS, FilmFacts, Recording, recording_of
from motes.formats.regions import MAX_FRAME
from motes.formats.shapes import label_or_none
from motes.formats.visibility import shown, visible
from motes.rows.journal import ObjectRow

CLASSES = {
    "pedestrian": 1, "person on vehicle": 2, "car": 3, "bicycle": 4, "motorbike": 5,
    "non-motorized vehicle": 6, "static person": 7, "distractor": 8, "occluder": 9,
    "occluder on the ground": 10, "full occluder": 11, "reflection": 12, "crowd": 13,
}  # fmt: skip
"""Numbers of classes in the MOTChallenge (Milan et al., MOT16, 2016, table 3)."""
SYNONYMS = {"person": "pedestrian", "motorcycle": "motorbike"}
_NAMES = {number: name for name, number in CLASSES.items()}


def write_results(recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each visible object: frame, identity, box, confidence, class, 1, -1.

    The class is 1 for an object without one, and -1 for one that is none of `CLASSES`. An occluded
    object has no line, as the form cannot mark a predicted box, and scores would count it.
    """
    for row in recorded:
        for each in visible(row):
            yield result_line(row.frame, each).encode() + b"\n"


def result_line(frame: int, each: ObjectRow) -> str:
    """Return the line of an object in a frame that counts from 0."""
    box = _box(each)
    return f"{frame + 1},{each.identity},{box},{each.confidence:.4f},{_class(each)},1,-1"


def write_truth(recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each object: frame, identity, box, flag, class, visibility.

    The flag is 0 for an object with confidence 0, which does not count. An occluded object counts,
    with visibility 0.
    """
    for row in recorded:
        for each in shown(row):
            hidden = each.status is Status.OCCLUDED
            flag = int(hidden or each.confidence > 0)
            line = (
                f"{row.frame + 1},{each.identity},{_box(each)},{flag},{_class(each)},{1 - hidden}"
            )
            yield line.encode() + b"\n"


def write_detections(recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each visible object, without its identity, for `motes watch --detector`."""
    for row in recorded:
        for each in visible(row):
            line = f"{row.frame + 1},-1,{_box(each)},{each.confidence:.4f},-1,-1,-1"
            yield line.encode() + b"\n"


def _box(each: ObjectRow) -> str:
    x, y, width, height = each.box
    return f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}"


def _class(each: ObjectRow) -> int:
    if each.label is None:
        return CLASSES["pedestrian"]
    name = each.label.lower()
    return CLASSES.get(SYNONYMS.get(name, name), UNKNOWN)


def read_results(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of results."""
    return _read(path, facts, "results")


def read_truth(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of a truth; the confidence is the flag, and visibility 0 is occluded."""
    return _read(path, facts, "truth")


def read_detections(path: Path, facts: FilmFacts) -> Recording:
    """Return detections, which have no identity."""
    return _read(path, facts, "detections")


def _read(path: Path, facts: FilmFacts, kind: Kind) -> Recording:
    rows = read_rows(path, facts.frames or MAX_FRAME, kind, sized=True)
    return recording_of(facts, _objects(rows, facts.label))


def _objects(rows: MotRows, usual: str) -> Iterator[tuple[int, ObjectRow]]:
    for i, (frame, identity, label) in enumerate(
        zip(rows.frames.tolist(), rows.ids.tolist(), rows.classes.tolist(), strict=True)
    ):
        x, y, width, height = rows.boxes[i].tolist()
        status = Status.OCCLUDED if rows.visibilities[i] == 0 else Status.TRACKING
        yield (
            frame - 1,
            ObjectRow(
                identity if identity > 0 else ANONYMOUS,
                Ellipse.from_box((x - 1, y - 1, width, height)),
                float(rows.scores[i]),
                status,
                label=label_or_none(_NAMES.get(label), usual),
            ),
        )
