"""COCO's JSON: an image for each frame, and an annotation for each object in it.

Coordinates are measured from the upper left corner of the frame. Parts outside the frame are cut
off. Frames count from 0. https://cocodataset.org/#format-data
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PureWindowsPath
from typing import Any

import msgspec
import numpy as np

from motes import __version__
from motes.core.errors import FormatError, counted
from motes.core.geometry import Box, Ellipse
from motes.core.track import Status, Track
from motes.formats import masks, shapes
from motes.formats.image_names import NO_IMAGE, OF_VIDEO, check_one_film, frame_of, images_of
from motes.formats.recording import (
    ANONYMOUS,
    MAX_FRAME,
    UNTIMED,
    FilmFacts,
    Recording,
    are_samples,
    searched_in,
    sound,
    stride_of,
)
from motes.formats.text import angle, at, read_json, unread
from motes.formats.truth import region_of_corners
from motes.rows.schema import FrameRow, Header, text_name

ROUNDING = 0.05
"""An ellipse that an angle changes by less, in pixels, is upright: corners have two decimals."""
KNOWN = {"occluded", "rotation", "track_id", "keyframe"}
"""The attributes that CVAT has of each object; the others are a user's."""
FOLLOWS = {"area", "num_keypoints", "video_id"}
"""Keys of an annotation that others tell too."""
FROM_1 = "the {}s of its images count from 1, so that the first is frame 0."
FROM_0 = (
    "frames are the numbers in the {}s of its images, from 0; if these count from 1, give the "
    "images with --video FOLDER."
)
"""How frames that may count from 1 are understood."""
EMPTY = (b"null", b"false", b"0", b"[]", b"{}", b'""')
"""Values of keys that tell nothing."""


def write(recorded: Recording) -> Iterator[bytes]:
    """Yield a COCO document: `info`, `licenses`, `categories`, `images` and `annotations`.

    `categories` has the classes of the objects; an object's class is that of its last row, and that
    of a detection its own. `images` has one entry for each frame, with its `frame` and `time`. The
    `file_name` is that of the image if the source is a folder of images; otherwise it is the name
    that CVAT gives to a frame of a video. `annotations` has one entry for each object in each
    frame, also if it is occluded: its `bbox`, the `score`, and the `attributes` `track_id` and
    `occluded`. An object with a mask has its `segmentation` and `area`; a box has no segmentation,
    and its own area.
    """
    head = recorded.head
    about = {
        "description": f"Objects in {head.source}, as motes followed them",
        "version": __version__,
        "video": head.source,
    }
    yield b'{"info": ' + msgspec.json.encode(about) + b',\n"licenses": [],\n"categories": '
    names = shapes.classes_of(recorded)
    every = [_class(each, names, head) for row in recorded for each in row.objects]
    numbers = {name: number for number, name in enumerate(shapes.labels_of(every, head), start=1)}
    yield msgspec.json.encode(
        [{"id": number, "name": name, "supercategory": ""} for name, number in numbers.items()]
    )
    yield b',\n"images": ['
    yield from _json_list(_image(row, head) for row in recorded)
    yield b'],\n"annotations": ['
    yield from _json_list(_annotations(recorded, names, numbers))
    yield b"]}\n"


def _json_list(items: Iterable[dict[str, object]]) -> Iterator[bytes]:
    for index, item in enumerate(items):
        yield (b",\n" if index else b"\n") + msgspec.json.encode(item)


def _image(row: FrameRow, head: Header) -> dict[str, object]:
    return {
        "id": row.frame + 1,
        "file_name": shapes.image_of(row),
        "width": head.width,
        "height": head.height,
        "frame": row.frame,
        "time": round(row.time, 6),
    }


def _class(each: Track, names: dict[int, str], head: Header) -> str:
    return (each.label or head.label) if each.identity == ANONYMOUS else names[each.identity]


def _annotations(
    recorded: Recording, names: dict[int, str], numbers: dict[str, int]
) -> Iterator[dict[str, object]]:
    number, head = 0, recorded.head
    for row in recorded:
        for each in row.objects:
            corners = shapes.visible_box(each, head)
            if corners is None:
                continue
            number += 1
            known = {} if each.identity == ANONYMOUS else {"track_id": each.identity}
            yield {
                "id": number,
                "image_id": row.frame + 1,
                "category_id": numbers[_class(each, names, head)],
                **_place(each, corners, head),
                "iscrowd": 0,
                "score": round(each.confidence, 5),
                "attributes": {**known, "occluded": each.status is Status.OCCLUDED},
            }


def _place(each: Track, corners: shapes.Corners, head: Header) -> dict[str, object]:
    width, height = corners.right - corners.left, corners.bottom - corners.top
    bbox = [corners.left, corners.top, round(width, 2), round(height, 2)]
    if each.mask is None:
        return {"bbox": bbox, "segmentation": [], "area": round(width * height, 2)}
    mask = {"size": [head.height, head.width], "counts": each.mask}
    area = masks.area(each.mask, head.height, head.width)
    return {"bbox": bbox, "segmentation": mask, "area": area}


class _Image(msgspec.Struct):
    id: int
    file_name: str = ""
    width: int = 0
    height: int = 0
    frame: int | None = None
    frame_id: int | None = None
    time: float | None = None
    video_id: Any = None
    prev_image_id: int | None = None


class _Category(msgspec.Struct):
    id: int
    name: str


class _Annotation(msgspec.Struct):
    image_id: int
    category_id: int
    bbox: tuple[float, float, float, float] | None = None
    segmentation: Any = None
    score: float = 1.0
    track_id: int | None = None
    instance_id: int | None = None
    attributes: dict[str, Any] = {}
    id: int | None = None
    iscrowd: Any = 0
    keypoints: Any = None
    rotation: Any = None
    angle: Any = None

    @property
    def is_crowd(self) -> bool:
        """Whether it is of several objects."""
        return _flag({"iscrowd": self.iscrowd}, "iscrowd")

    @property
    def is_skeleton(self) -> bool:
        """Whether it is of points alone: then CVAT writes a box without a size."""
        return bool(self.keypoints) and self.bbox is not None and not any(self.bbox[2:])

    @property
    def is_outline(self) -> bool:
        """Whether it has polygons, of which more than its box is told."""
        if not (isinstance(self.segmentation, list) and self.segmentation):
            return False
        first = self.segmentation[0]
        sides = [{*map(str, first[axis::2])} for axis in (0, 1)] if isinstance(first, list) else []
        return len(self.segmentation) > 1 or any(len(side) > 2 for side in sides)


class _Document(msgspec.Struct):
    images: list[_Image]
    annotations: list[_Annotation]
    categories: list[_Category] = []


class _Keys(msgspec.Struct):
    """All that its annotations hold, of which tools have their own, such as other identities."""

    annotations: list[dict[str, msgspec.Raw]]

    def others(self) -> set[str]:
        """Return the keys with a value that are not read."""
        known = {*_Annotation.__struct_fields__, *FOLLOWS}
        told = ((key, value) for each in self.annotations for key, value in each.items())
        return {key for key, value in told if key not in known and bytes(value) not in EMPTY}


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the annotations of a COCO document.

    An image's frame is that of the film's image of its name; of a video, its `frame` or `frame_id`;
    without them, the number in its name; without numbers, its place among the names. An object's
    identity is its `track_id` or `instance_id`. Its ellipse fills its box, turned by the attribute
    `rotation`, in degrees, or with the angle and the ratio of half-axes of its polygon if it has
    one. Without a box it has that around its polygons. A crowd (`iscrowd`) is no object.
    """
    document: _Document = read_json(path, _Document)
    _check_once("images", [image.id for image in document.images])
    _check_once("categories", [each.id for each in document.categories])
    _check_once("annotations", [each.id for each in document.annotations if each.id is not None])
    check_one_film(
        video_id=(each.video_id for each in document.images),
        size=(f"{each.width}x{each.height}" for each in document.images if each.width),
    )
    frames, notes = _frames(document.images, images_of(facts))
    images = {image.id: image for image in document.images}
    labels = {each.id: each.name for each in document.categories}
    objects, unplaced = [], set[int]()
    for number, each in enumerate(document.annotations):
        with at(f"annotations[{number}]"):
            if each.image_id not in frames:
                raise ValueError(f"its image {each.image_id} is missing")
            if labels and each.category_id not in labels:
                raise ValueError(f"its category {each.category_id} is missing")
            frame, label = frames[each.image_id], labels.get(each.category_id)
            if each.is_crowd or each.is_skeleton:
                unplaced.add(frame)
            else:
                objects.append(_row(each, frame, images[each.image_id], label, facts))
    size = max(((image.width, image.height) for image in document.images), default=(0, 0))
    times = {frames[image.id]: image.time for image in document.images}
    files = {frames[image.id]: image.file_name for image in document.images}
    if document.annotations and not labels:
        notes.append("it has no categories, so that its objects have no classes.")
    given = document.annotations
    others = {
        "{} of a crowd": (sum(each.is_crowd for each in given), "annotation"),
        "{}": (sum(each.is_skeleton for each in given), "skeleton"),
        "{} beside a box, of which no rule is known": (
            sum(bool(each.rotation or each.angle) for each in given), "angle",
        ),
        "the points of {}": (
            sum(bool(each.keypoints) and not each.is_skeleton for each in given), "skeleton",
        ),
        "{}, but for box and ellipse": (sum(each.is_outline for each in given), "outline"),
    }  # fmt: skip
    left_out = [text.format(counted(*number)) for text, number in others.items() if number[0]]
    names = {name for each in given for name in each.attributes} - KNOWN
    left_out += unread(names | read_json(path, _Keys).others())
    searched = searched_in(unplaced, objects)
    found = Recording.of(facts, objects, times, size, files, left_out, searched)
    numbers = sorted(times)
    return replace(found, notes=notes, stride=stride_of(numbers), listed=are_samples(numbers))


def _check_once(what: str, ids: Sequence[int]) -> None:
    """Check that numbers differ; raise a FormatError that names the first one that does not."""
    seen = dict[int, int]()
    for place, each in enumerate(ids):
        if seen.setdefault(each, place) != place:
            raise FormatError(f"{what}[{place}]: {each} is already in {what}[{seen[each]}]")


def _row(
    each: _Annotation, frame: int, image: _Image, label: str | None, facts: FilmFacts
) -> Track:
    mask = masks.mask_runs(each.segmentation, image.height, image.width)
    ellipse, bounds = _place_of(each, image)
    status = Status.OCCLUDED if _flag(each.attributes, "occluded") else Status.TRACKING
    return sound(Track(
        frame, UNTIMED, ellipse, confidence=each.score, status=status, identity=_identity(each),
        label=shapes.label_or_none(label, facts.label), mask=mask, bounds=bounds,
    ))  # fmt: skip


def _frames(images: list[_Image], known: Mapping[str, int]) -> tuple[dict[int, int], list[str]]:
    """Return the frame of each image, by its id, and what was assumed for it."""
    stated = {each.id: each.frame if each.frame is not None else each.frame_id for each in images}
    paths = {each.id: PureWindowsPath(each.file_name) for each in images}  # it splits at both
    stems = {key: text_name(path.stem) for key, path in paths.items()}
    if None not in stated.values() and not {*stems.values()} <= {*known}:
        frames = {key: frame for key, frame in stated.items() if frame is not None}
        _check_once("images", [*frames.values()])
        if any(each.frame is not None for each in images) or min(frames.values(), default=0) != 1:
            return frames, []
        # Those who link an image to the one before, without any for the first, count from 1.
        linked = any(each.prev_image_id == -1 and each.frame_id == 1 for each in images)
        if linked or sorted(frames.values()) == [*range(1, len(images) + 1)]:
            first_is_0 = {key: frame - 1 for key, frame in frames.items()}
            return first_is_0, [FROM_1.format("frame_id")] * (not linked)
        return frames, [FROM_0.format("frame_id")]
    check_one_film(folder=(path.parent for path in paths.values() if path.name))
    numbers = dict[int, int]()
    for key, stem in stems.items():
        with at(f"image {stem}"):
            number = frame_of(stem, known)
            if number is None and known:
                raise FormatError(NO_IMAGE)
        if number is not None:
            numbers[key] = number
    if len({*numbers.values()}) < len(numbers):
        raise FormatError("several of its images have one number, as of several films; keep one's.")
    if len(numbers) < len(images) or max(numbers.values(), default=0) > MAX_FRAME:
        ordered = sorted(images, key=lambda each: [
            int(part) if part.isdigit() else part for part in re.split(r"(\d+)", each.file_name)
        ])  # fmt: skip
        return {each.id: frame for frame, each in enumerate(ordered)}, [
            "the names of its images do not number frames; each has its place among them."
        ]
    of_video = all(map(OF_VIDEO.fullmatch, stems.values()))
    if known or 0 in numbers.values() or (of_video and 1 not in numbers.values()):
        return numbers, []
    if not of_video and sorted(numbers.values()) == [*range(1, len(images) + 1)]:
        first_is_0 = {key: number - 1 for key, number in numbers.items()}
        return first_is_0, [FROM_1.format("name")]
    return numbers, [FROM_0.format("name")]


def _flag(given: Mapping[str, Any], name: str) -> bool:
    """Return whether a mark is set, which some tools write as text; it is not where it is missing.

    Raises a ValueError if it is neither true nor false.
    """
    text = str(given.get(name) or 0).lower()
    if text not in ("0", "1", "false", "true"):
        raise ValueError(f"{name} is {text[:20]!r}, neither true nor false")
    return text in ("1", "true")


def _identity(each: _Annotation) -> int:
    stated = (each.attributes.get("track_id"), each.track_id, each.instance_id)
    value = next((value for value in stated if value is not None), ANONYMOUS)
    if isinstance(value, bool) or not re.fullmatch(r"-1|\d+(\.0)?", str(value)):
        raise ValueError(f"its track_id is {str(value)[:20]!r}; an identity is a whole number")
    return int(float(value))


def _place_of(each: _Annotation, image: _Image) -> tuple[Ellipse, Box]:
    """Return the ellipse of an annotation, and the upright box around the annotation."""
    x, y, width, height = each.bbox or _around(each.segmentation)
    if not (width > 0 and height > 0):
        raise ValueError(f"an object of {width:g}x{height:g} pixels has no area")
    box = shapes.Corners(x, y, x + width, y + height)
    if turn := each.attributes.get("rotation"):  # of the box, around its center, as CVAT writes it
        turned = box.ellipse._replace(theta=angle(float(turn)))
        return turned, shapes.box_of_rectangle(turned)
    return _ellipse(each, box, image), Box(x, y, width, height)


def _ellipse(each: _Annotation, box: shapes.Corners, image: _Image) -> Ellipse:
    """Return the ellipse of a box, with the angle and the ratio of half-axes of its polygon."""
    polygon = each.segmentation
    # A polygon that is cut at a border of the picture has other moments than its ellipse.
    cut = box.left <= 0 or box.top <= 0 or box.right >= image.width or box.bottom >= image.height
    if cut or not isinstance(polygon, list) or len(polygon) != 1 or len(polygon[0]) < 16:
        return box.ellipse
    corners = np.reshape(np.array(polygon[0], np.float64), (-1, 2))
    turned = region_of_corners(corners).ellipse
    if abs(turned.theta * (turned.a - turned.b)) < ROUNDING:
        return box.ellipse
    # The moments of a polygon are a little smaller than those of the ellipse through its corners.
    size = (box.right - box.left) * (box.bottom - box.top)
    scale = math.sqrt(size / (turned.box.width * turned.box.height))
    return box.ellipse._replace(a=scale * turned.a, b=scale * turned.b, theta=turned.theta)


def _around(polygons: Any) -> list[float]:
    """Return the box around all corners of polygons."""
    if not (isinstance(polygons, list) and polygons):
        raise ValueError("it has neither bbox nor polygon")
    corners = np.concatenate([np.reshape(each, (-1, 2)) for each in polygons]).astype(np.float64)
    return [*corners.min(axis=0).tolist(), *np.ptp(corners, axis=0).tolist()]
