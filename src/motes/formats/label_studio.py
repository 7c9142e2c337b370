"""Label Studio's JSON of video object tracking: a task with a region for each object.

A region has a sequence of keyframes, between which Label Studio interpolates. Coordinates are in
percent of the picture's sides, frames count from 1. https://labelstud.io/tags/videorectangle
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from motes import __version__
from motes.core.errors import FormatError
from motes.core.frame import FRAME_INTERVAL
from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.core.types import Floats
from motes.formats.recording import FilmFacts, Recording, frames_between, recording_of, sound
from motes.formats.shapes import Corners, classes_of, label_or_none, visible_box
from motes.formats.text import at, counted, read_json
from motes.formats.thinning import KEYFRAME_ERROR, keyframes
from motes.formats.visibility import check_identities, visible
from motes.rows.journal import ObjectRow

REGION = "videorectangle"
VIDEO, BOX = "video", "box"
"""Names of the tags in the labeling configuration, as in Label Studio's own template."""


def write(recorded: Recording, keyframe_error: float = KEYFRAME_ERROR) -> Iterator[bytes]:
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
    recorded: Recording, keyframe_error: float, names: tuple[str, str] = (BOX, VIDEO)
) -> list[dict[str, Any]]:
    """Return the regions of all objects; raise a FormatError if a box has no identity.

    `names` are those of the tags of the box and the video.
    """
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
    check_identities(places, "Label Studio")
    listed = [row.frame for row in recorded]
    following = dict(pairwise(listed))
    return [
        {
            "id": f"motes-{identity}",
            "type": REGION,
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


class VideoKeyframe(msgspec.Struct):
    """A rectangle, in percent of the picture; frames count from 1.

    It is turned around its upper left corner, by degrees. Label Studio interpolates from here to
    the next one if `enabled`; else the object ends here.
    """

    frame: int
    x: float
    y: float
    width: float
    height: float
    time: float | None = None
    enabled: bool = True
    rotation: float = 0.0


class Value(msgspec.Struct):
    """The rectangles of a region, its classes, and the number of frames of the film."""

    sequence: list[VideoKeyframe] = []
    labels: list[str] = []
    frames: int | None = msgspec.field(default=None, name="framesCount")


class VideoRegion(msgspec.Struct):
    """An object."""

    value: Value
    type: str = ""


class _Result(msgspec.Struct):
    result: list[VideoRegion] = []


class _VideoTask(msgspec.Struct):
    annotations: list[_Result] = []
    predictions: list[_Result] = []


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of the one task: of its last annotation, or else of its prediction."""
    tasks: list[_VideoTask] = read_json(path, list[_VideoTask])
    if len(tasks) != 1:
        raise FormatError(f"it has {len(tasks)} tasks; keep the one of this film.")
    (task,) = tasks
    results = [*task.predictions, *task.annotations]
    if not results:
        raise FormatError("it has no annotation and no prediction")
    objects = []
    times: dict[int, float] = {}
    drawn = [each for each in results[-1].result if each.type == REGION]
    others = Counter(each.type or "no type" for each in results[-1].result if each.type != REGION)
    left_out = [f"{counted(count, 'region')} of {kind}" for kind, count in others.items()]
    for identity, region in enumerate(drawn, start=1):
        label = label_or_none(next(iter(region.value.labels), None), facts.label)
        with at(f"region {identity}"):
            if not region.value.sequence:
                raise ValueError("it has no sequence of keyframes")
            for frame, time, ellipse, key in _frames(region.value, facts):
                row = ObjectRow(identity, ellipse, 1.0, Status.TRACKING, label=label, keyframe=key)
                objects.append((frame, row))
                if time is not None:
                    times[frame] = time
    return recording_of(facts, objects, times, left_out=left_out)


def _frames(value: Value, facts: FilmFacts) -> Iterator[tuple[int, float | None, Ellipse, bool]]:
    """Yield frame, time, place and whether it is a keyframe, with those that are interpolated.

    After its last keyframe an object that is still enabled stays there until the film ends.
    """
    ordered = sorted(value.sequence, key=lambda each: each.frame)
    end = min((count for count in (value.frames, facts.frames) if count), default=0)
    for key, after in zip(ordered, [*ordered[1:], None], strict=True):
        start = _numbers(key)
        with at(f"keyframe of frame {key.frame}"):
            place = _ellipse(start, facts)
        yield key.frame - 1, key.time, place, True
        if not key.enabled:
            continue
        until = max(key.frame, end) + 1 if after is None else after.frame
        between = frames_between(key.frame - 1, until - 1)
        step = (_numbers(after or key) - start) / (len(between) + 1)
        for frame in range(key.frame + 1, until):
            yield frame - 1, None, _ellipse(start + (frame - key.frame) * step, facts), False


def place_of(key: VideoKeyframe, facts: FilmFacts) -> Ellipse:
    """Return the ellipse in a rectangle; raise a ValueError if it has no area."""
    return _ellipse(_numbers(key), facts)


def _numbers(key: VideoKeyframe) -> Floats:
    return np.array([key.x, key.y, key.width, key.height, key.rotation])


def _ellipse(numbers: Floats, facts: FilmFacts) -> Ellipse:
    x, y, width, height, degrees = numbers.tolist()
    a, b = width / 200 * facts.width, height / 200 * facts.height
    if not min(a, b) > 0:
        raise ValueError(f"a rectangle of {width:g} by {height:g} percent has no area")
    theta = math.radians(degrees)
    cos, sin = math.cos(theta), math.sin(theta)
    left, top = x / 100 * facts.width, y / 100 * facts.height
    center = left + a * cos - b * sin - 0.5, top + a * sin + b * cos - 0.5
    return sound(ObjectRow(1, Ellipse(*center, a, b, theta), 1.0, Status.TRACKING)).ellipse
