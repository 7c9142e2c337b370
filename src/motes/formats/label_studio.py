"""Label Studio's JSON of video object tracking: a task with a region for each object.

A region has a sequence of keyframes, between which Label Studio interpolates. Coordinates are in
percent of the picture's sides, frames count from 1. https://labelstud.io/tags/videorectangle
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

import msgspec
import numpy as np
from msgspec import Meta

from motes import __version__
from motes.core.errors import FormatError, counted
from motes.core.frame import FRAME_INTERVAL
from motes.core.geometry import Ellipse
from motes.core.track import Track
from motes.core.types import Floats
from motes.formats.keyframes import KEYFRAME_ERROR, boxes_by_identity, thinned
from motes.formats.recording import (
    UNTIMED,
    FilmFacts,
    Recording,
    frames_between,
    rate_of,
    sound,
)
from motes.formats.shapes import Corners, box_of_rectangle, classes_of, label_or_none
from motes.formats.text import angle, at, read_json
from motes.formats.visibility import visible
from motes.rows.schema import Header

REGION = "videorectangle"
SAME_RATE = 1e-5
"""Rates that differ by a smaller share are one: 29.97 is 30000/1001."""
LENGTHS, ENDS = 0.02, 0.3
"""The share, and the seconds beside it, by which the length of a film in a browser may differ, as
sound is often longer."""
LARGEST = 2**53
"""The largest number of a frame that is read at all: JSON of a browser has no other."""
VIDEO, BOX, RATE = "video", "box", "fps"
"""Names of the tags in the labeling configuration, as in Label Studio's own template; and that of
the film's rate in the task's data, as Label Studio's own examples have it."""


def write(recorded: Recording, keyframe_error: float = KEYFRAME_ERROR) -> Iterator[bytes]:
    """Yield a list of one task, with the objects as a prediction.

    The keyframes are as few as keep every side of the interpolated boxes within `keyframe_error`
    pixels of the rows. The tag Video takes its rate from the task if it has framerate="$fps".
    """
    rate = rate_of({row.frame: row.time for row in recorded}) or 1 / FRAME_INTERVAL
    task = {
        "data": {VIDEO: recorded.head.source, RATE: round(rate, 3)},
        "predictions": [
            {"model_version": f"motes {__version__}", "result": _regions(recorded, keyframe_error)}
        ],
    }
    yield msgspec.json.encode([task]) + b"\n"


def _regions(recorded: Recording, keyframe_error: float) -> list[dict[str, Any]]:
    """Return the regions of all objects; raise a FormatError if a box has no identity."""
    head, classes = recorded.head, classes_of(recorded)
    count, seconds = 0, FRAME_INTERVAL
    for row in recorded:
        count = row.frame + 1
        seconds = row.time / row.frame if row.frame and row.time else seconds
    after = recorded.following()
    return [
        {
            "id": f"motes-{identity}",
            "type": REGION,
            "from_name": BOX,
            "to_name": VIDEO,
            "origin": "prediction",
            "score": round(float(np.mean([each.confidence for each, _ in here])), 5),
            "value": {
                "framesCount": count,
                "duration": round(count * seconds, 6),
                "labels": [classes[identity]],
                "sequence": [
                    _keyframe(each, box, head, end=end)
                    for each, box, key, end in thinned(here, after, keyframe_error)
                    if key
                ],
            },
        }
        for identity, here in boxes_by_identity(recorded, visible, "Label Studio").items()
    ]


def _keyframe(each: Track, box: Corners, head: Header, *, end: bool) -> dict[str, Any]:
    """Return a keyframe of an object; its line ends where `enabled` is false."""
    return {
        "frame": each.frame + 1,
        "time": round(each.time, 6),
        "enabled": not end,
        "rotation": 0,
        "x": round(100 * box.left / head.width, 6),
        "y": round(100 * box.top / head.height, 6),
        "width": round(100 * (box.right - box.left) / head.width, 6),
        "height": round(100 * (box.bottom - box.top) / head.height, 6),
    }


class VideoKeyframe(msgspec.Struct):
    """A rectangle, in percent of the picture; frames count from 1.

    It is turned around its upper left corner, by degrees. Label Studio interpolates from here to
    the next one if `enabled`; else the object ends here.
    """

    frame: Annotated[int, Meta(ge=-LARGEST, le=LARGEST)]
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
    id: Any = None


class _Result(msgspec.Struct):
    result: list[VideoRegion]
    was_cancelled: bool = False
    ground_truth: bool = False
    model_version: str | None = None


class _VideoTask(msgspec.Struct):
    annotations: list[_Result] = []
    predictions: list[Any] = []  # numbers, where Label Studio exports their ids alone


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of the one task: of its annotation, or without one of its prediction.

    Label Studio shows a film at a rate of its own, that of its tag `Video`: frames are those of the
    film at the same time. Only in a prediction of motes they are the film's own.
    """
    found: list[_VideoTask] | _VideoTask = read_json(path, list[_VideoTask] | _VideoTask)
    tasks = found if isinstance(found, list) else [found]
    results = [each for task in tasks for result in task.annotations for each in result.result]
    kinds = {each.type or "no type" for each in results}
    if kinds and REGION not in kinds:
        raise FormatError(
            f"it has no box of a video, but {', '.join(sorted(kinds))}; export images as COCO."
        )
    if len(tasks) != 1:
        raise FormatError(f"it has {len(tasks)} tasks; keep the one of this film.")
    result, ignored = _result(tasks[0])
    drawn = [each for each in result.result if each.type == REGION]
    others = Counter(each.type or "no type" for each in result.result if each.type != REGION)
    left_out = [f"{counted(count, 'region')} of {kind}" for kind, count in others.items()]
    left_out += [f"{counted(ignored, 'annotation')}, cancelled or beside the truth"] * (ignored > 0)
    further = sum(len(region.value.labels) > 1 for region in drawn)
    left_out += [f"further classes of {counted(further, 'region')}"] * (further > 0)
    keys = [key for region in drawn for key in region.value.sequence]
    own = (result.model_version or "").startswith("motes ")
    rate = None if own else _rate_of(keys)
    counts = [region.value.frames for region in drawn if region.value.frames]
    count = max(counts, default=0)
    end = min((each for each in (count, facts.frames) if each), default=0)
    clock = _Clock(end=end) if own else _Clock.of(facts, rate, count, end)
    objects = []
    numbered = zip(_identities(drawn), drawn, strict=True)
    for place, (identity, region) in enumerate(numbered, start=1):
        label = label_or_none(next(iter(region.value.labels), None), facts.label)
        with at(f"region {place}"):
            if not region.value.sequence:
                raise ValueError("it has no sequence of keyframes")
            if len({key.frame for key in region.value.sequence}) < len(region.value.sequence):
                raise ValueError("it has two keyframes in one frame")
            for frame, (ellipse, key) in _frames(region.value, facts, clock).items():
                objects.append(Track(
                    frame, UNTIMED, ellipse, identity=identity, label=label, keyframe=key,
                    bounds=box_of_rectangle(ellipse),
                ))  # fmt: skip
    times = {} if rate else {key.frame - 1: key.time for key in keys if key.time is not None}
    if not facts.fps:
        facts = replace(facts, fps=rate)
    recorded = Recording.of(facts, objects, times, left_out=left_out)
    return replace(recorded, notes=clock.notes, timed=bool(rate or times))


def _identities(regions: Sequence[VideoRegion]) -> list[int]:
    """Return the identities of objects: those by which motes has named them, or their numbers."""
    named = (re.fullmatch(r"motes-(\d{1,9})", str(each.id)) for each in regions)
    found = [int(name[1]) for name in named if name]
    whole = len({*found}) == len(regions)
    return found if whole else [*range(1, len(regions) + 1)]


def _result(task: _VideoTask) -> tuple[_Result, int]:
    """Return the one annotation that counts, else the prediction, and how many do not count.

    Those that do not are cancelled, or stand beside one that is marked as the truth. Raises a
    FormatError if there is none, or it is not clear which one counts.
    """
    kept = [each for each in task.annotations if not each.was_cancelled]
    kept = [each for each in kept if each.ground_truth] or kept
    what = "annotations"
    if not kept:
        if task.annotations:
            raise FormatError("its annotations are cancelled; annotate the task, or remove them")
        what, given = "predictions", [each for each in task.predictions if isinstance(each, dict)]
        try:
            kept = [msgspec.convert(each, _Result) for each in given]
        except msgspec.ValidationError as error:
            raise FormatError(f"predictions: {error}") from None
    if not kept:
        raise FormatError("it has no annotation and no prediction; submit one, and export as JSON")
    if len(kept) > 1:
        raise FormatError(f"it has {len(kept)} {what}, as of several people or models; keep one.")
    return kept[0], len(task.annotations) - 1 if task.annotations else 0


def _rate_of(keys: Sequence[VideoKeyframe]) -> float | None:
    """Return the rate at which Label Studio showed the film: it writes frame / rate as time.

    None where other times are written, as those of the film.
    """
    timed = [(key.frame, key.time) for key in keys if key.time is not None]
    rate = rate_of(dict(timed))
    if rate is None or any(abs(frame - time * rate) >= 0.5 for frame, time in timed):
        return None
    return rate


@dataclass(frozen=True)
class _Clock:
    """How frames of an annotation, which count from 1, become frames of the film."""

    rate: float | None = None
    """The frames per second of an annotation at another rate than the film's; else None."""
    fps: float = 0.0
    times: Sequence[float] = ()
    """Those of the film, and the times of its frames where its rate varies."""
    end: int = 0
    """The number of frames of the film, as far as it is known."""
    notes: Sequence[str] = ()

    @classmethod
    def of(cls, facts: FilmFacts, rate: float | None, count: int, end: int) -> Self:
        """Return the clock of an annotation of `count` frames; 0 if that is unknown.

        `end` is the number of frames if it needs no mapping. Raises a FormatError if it is of a
        film of another length.
        """
        known, fps = facts.frames or 0, facts.fps or 0.0
        if rate is None:
            other = count and known and abs(count - known) > 2
            note = f"it tells no rate, and {count} frames of {known}: they are taken as the first."
            return cls(end=end, notes=[note] if other else [])
        shown = known * rate / (fps or rate)
        if count and known and abs(count - shown) > ENDS * rate + LENGTHS * shown:
            raise FormatError(
                f"it is of a film of {count} frames at {rate:g} a second, and this one would have "
                f"{shown:.0f}; give the film that it belongs to."
            )
        even = all(abs(time * fps - i) < 0.5 for i, time in enumerate(facts.times))
        if not fps or (abs(rate - fps) < SAME_RATE * fps and even):
            return cls(end=end)
        note = f"annotated at {rate:g} frames a second, and the film has {fps:g}: mapped by time."
        return cls(rate, fps, facts.times, known or round(count / rate * fps), [note])

    def index(self, frame: int) -> float:
        """Return the place of a frame among those of the film, which count from 0."""
        if self.rate is None:
            return float(frame - 1)
        time = (frame - 1) / self.rate
        if self.times:
            return float(np.interp(time, self.times, range(len(self.times))))
        place = time * self.fps
        return min(place, self.end - 1) if self.end else place


def _frames(value: Value, facts: FilmFacts, clock: _Clock) -> dict[int, tuple[Ellipse, bool]]:
    """Return place and whether it is a keyframe, by frame, with those that are interpolated.

    After its last keyframe an object that is still enabled stays there until the film ends.
    """
    ordered = sorted(value.sequence, key=lambda each: each.frame)
    found: dict[int, tuple[Ellipse, bool]] = {}
    for key, after in zip(ordered, [*ordered[1:], None], strict=True):
        start, begin = _numbers(key), clock.index(key.frame)
        first = round(begin)
        with at(f"keyframe of frame {key.frame}"):
            if key.frame < 1:
                raise ValueError("Label Studio's frames count from 1; correct its number")
            found[first] = _ellipse(start, facts), True
        if not key.enabled:
            continue
        end = float(max(first + 1, clock.end)) if after is None else clock.index(after.frame)
        step = (_numbers(after or key) - start) / max(end - begin, 1e-9)
        for frame in frames_between(first, max(first, round(end))):
            place = start + min(max(frame - begin, 0.0), end - begin) * step
            found[frame] = _ellipse(place, facts), False
    return found


def _numbers(key: VideoKeyframe) -> Floats:
    return np.array([key.x, key.y, key.width, key.height, key.rotation])


def _ellipse(numbers: Floats, facts: FilmFacts) -> Ellipse:
    x, y, width, height, degrees = numbers.tolist()
    theta = angle(degrees)
    a, b = width / 200 * facts.width, height / 200 * facts.height
    if not min(a, b) > 0:
        raise ValueError(f"a rectangle of {width:g} by {height:g} percent has no area")
    cos, sin = math.cos(theta), math.sin(theta)
    left, top = x / 100 * facts.width, y / 100 * facts.height
    center = left + a * cos - b * sin - 0.5, top + a * sin + b * cos - 0.5
    return sound(Track(0, UNTIMED, Ellipse(*center, a, b, theta))).ellipse
