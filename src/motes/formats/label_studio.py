"""Label Studio's JSON of video object tracking: a task with a region for each object.

A region has a sequence of keyframes, between which Label Studio interpolates. Coordinates are in
percent of the picture's sides, frames count from 1. https://labelstud.io/tags/videorectangle
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from motes import __version__
from motes.core.frame import FRAME_INTERVAL
from motes.core.track import Status
from motes.formats.recording import (
    FilmFacts,
    Recorded,
    Recording,
    frames_between,
    recording_of,
    visible,
)
from motes.formats.shapes import Corners, classes_of, label_or_none, visible_box
from motes.formats.text import read_json
from motes.formats.thinning import KEYFRAME_ERROR, keyframes
from motes.output.journal import ObjectRow

VIDEO, BOX = "video", "box"
"""Names of the tags in the labeling configuration, as in Label Studio's own template."""


def write(recorded: Recorded, keyframe_error: float = KEYFRAME_ERROR) -> Iterator[bytes]:
    """Yield a list of one task, with the objects as a prediction.

    The keyframes are as few as keep every side of the interpolated boxes within `keyframe_error`
    pixels of the rows.
    """
    task = {
        "data": {VIDEO: recorded.head.source},
        "predictions": [
            {"model_version": f"motes {__version__}", "result": regions(recorded, keyframe_error)}
        ],
    }
    yield msgspec.json.encode([task]) + b"\n"


def regions(
    recorded: Recorded, keyframe_error: float, names: tuple[str, str] = (BOX, VIDEO)
) -> list[dict[str, Any]]:
    """Return the regions of all objects; `names` are those of the tags of the box and the video."""
    head, classes = recorded.head, classes_of(recorded)
    places: dict[int, list[tuple[int, float, Corners, float]]] = {}
    count, seconds = 0, FRAME_INTERVAL
    for row in recorded:
        count = row.frame + 1
        seconds = row.time / row.frame if row.frame and row.time else seconds
        for each in visible(row):
            box = visible_box(each, head)
            if box is not None:
                place = (row.frame, row.time, box, each.confidence)
                places.setdefault(each.identity, []).append(place)
    listed = [row.frame for row in recorded]
    following = dict(pairwise(listed))
    return [
        {
            "id": f"motes-{identity}",
            "type": "videorectangle",
            "from_name": names[0],
            "to_name": names[1],
            "origin": "prediction",
            "score": round(float(np.mean([place[3] for place in here])), 5),
            "value": {
                "framesCount": count,
                "duration": round(count * seconds, 6),
                "labels": [classes[identity]],
                "sequence": _sequence(here, following, keyframe_error, head.width, head.height),
            },
        }
        for identity, here in places.items()
    ]


def _sequence(
    here: list[tuple[int, float, Corners, float]],
    following: dict[int, int],
    error: float,
    width: int,
    height: int,
) -> list[dict[str, Any]]:
    """Return the keyframes of an object; its line ends where `enabled` is false."""
    frames = [frame for frame, *_ in here]
    last = [
        following.get(frame, frame + 1) != after
        for frame, after in zip(frames, [*frames[1:], -1], strict=True)
    ]
    first = [True, *last[:-1]]
    forced = np.array(last) | np.array(first)
    boxes = np.array([box for _, _, box, _ in here])
    keys = keyframes(np.array(frames), boxes, forced, error)
    return [
        {
            "frame": frame + 1,
            "time": round(time, 6),
            "enabled": not end,
            "rotation": 0,
            "x": round(100 * box.left / width, 6),
            "y": round(100 * box.top / height, 6),
            "width": round(100 * (box.right - box.left) / width, 6),
            "height": round(100 * (box.bottom - box.top) / height, 6),
        }
        for (frame, time, box, _), end, key in zip(here, last, keys.tolist(), strict=True)
        if key
    ]


class Keyframe(msgspec.Struct):
    """A rectangle, in percent of the picture; frames count from 1.

    Label Studio interpolates from here to the next one if `enabled`; else the object ends here.
    """

    frame: int
    x: float
    y: float
    width: float
    height: float
    time: float | None = None
    enabled: bool = True


class Value(msgspec.Struct):
    """The rectangles of a region, and its classes."""

    sequence: list[Keyframe] = []
    labels: list[str] = []


class Region(msgspec.Struct):
    """An object."""

    value: Value
    type: str = ""


class _Result(msgspec.Struct):
    result: list[Region] = []


class _Task(msgspec.Struct):
    annotations: list[_Result] = []
    predictions: list[_Result] = []


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of the first task: of its last annotation, or else of its prediction."""
    tasks: list[_Task] = read_json(path, list[_Task])
    task = tasks[0] if tasks else _Task()
    results = [*task.predictions, *task.annotations]
    objects = []
    times: dict[int, float] = {}
    drawn = [each for each in (results[-1].result if results else []) if each.value.sequence]
    for identity, region in enumerate(drawn, start=1):
        label = label_or_none(next(iter(region.value.labels), None), facts.label)
        for frame, time, box, key in _frames(region.value.sequence, facts):
            row = ObjectRow(identity, box.ellipse, 1.0, Status.TRACKING, label=label, keyframe=key)
            objects.append((frame, row))
            if time is not None:
                times[frame] = time
    return recording_of(facts, objects, times)


def _frames(
    sequence: list[Keyframe], facts: FilmFacts
) -> Iterator[tuple[int, float | None, Corners, bool]]:
    """Yield frame, time, box and whether it is a keyframe, with those that are interpolated."""
    ordered = sorted(sequence, key=lambda each: each.frame)
    for key, after in zip(ordered, [*ordered[1:], None], strict=True):
        start = _corners(key, facts)
        yield key.frame - 1, key.time, Corners(*start.tolist()), True
        if after is None or not key.enabled:
            continue
        between = frames_between(key.frame - 1, after.frame - 1)
        step = (_corners(after, facts) - start) / (len(between) + 1)
        for frame in range(key.frame + 1, after.frame):
            yield frame - 1, None, Corners(*(start + (frame - key.frame) * step).tolist()), False


def _corners(key: Keyframe, facts: FilmFacts) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    sides = np.array([key.x, key.y, key.x + key.width, key.y + key.height])
    corners: np.ndarray[tuple[int], np.dtype[np.float64]] = (
        sides / 100 * [facts.width, facts.height, facts.width, facts.height]
    )
    return corners
