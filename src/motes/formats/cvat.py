"""CVAT's XML ("CVAT for video 1.1", and "for images 1.1" when it is read).

Coordinates are measured from the upper left corner of the frame. Parts outside the frame are cut
off. Frames count from 0. https://docs.cvat.ai/docs/manual/advanced/formats/format-cvat/
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from motes.core.errors import FormatError, counted
from motes.core.files import read_text
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.formats.image_names import NO_IMAGE, OF_VIDEO, check_one_film, frame_of, images_of
from motes.formats.keyframes import KEYFRAME_ERROR, boxes_by_identity, thinned
from motes.formats.recording import (
    ANONYMOUS,
    MOST_FRAMES,
    UNTIMED,
    FilmFacts,
    Recording,
    frames_between,
    searched_in,
    sound,
)
from motes.formats.shapes import (
    Corners,
    box_of_rectangle,
    classes_of,
    label_or_none,
    labels_of,
)
from motes.formats.text import angle, at, number, unread, whole
from motes.formats.visibility import shown
from motes.rows.schema import text_name

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element


def write(recorded: Recording, keyframe_error: float = KEYFRAME_ERROR) -> Iterator[bytes]:
    """Yield a document with a track for each object, and a box for each frame in which it is shown.

    CVAT reads the boxes that are keyframes and interpolates between them; these are as few as keep
    every side of the interpolated boxes within `keyframe_error` pixels of the rows. In the first
    frame without the object, a box marked `outside` ends the track; otherwise CVAT would continue
    to draw it, to the end of the film. CVAT refuses a box that is after that. Frames before the
    first one, and those that a stride has skipped, are none of the task. Raises a FormatError if a
    box has no identity.
    """
    from xml.sax.saxutils import escape, quoteattr  # which imports all that talks over networks

    head, classes = recorded.head, classes_of(recorded)
    end = max((row.frame + 1 for row in recorded), default=0)
    tracks = boxes_by_identity(recorded, shown, "CVAT")
    labels = "\n".join(
        f"        <label>\n          <name>{escape(name)}</name>\n        </label>"
        for name in labels_of(classes.values(), head)
    )
    yield f"""\
<?xml version="1.0" encoding="utf-8"?>
<annotations>
  <version>1.1</version>
  <meta>
    <task>
{_task_lines(recorded, end)}
      <labels>
{labels}
      </labels>
      <original_size>
        <width>{head.width}</width>
        <height>{head.height}</height>
      </original_size>
    </task>
  </meta>
""".encode()
    after, end = recorded.following(), max(end, recorded.length)
    for identity, here in tracks.items():
        label = quoteattr(classes[identity])
        yield f'  <track id="{identity}" label={label} source="automatic">\n'.encode()
        for each, box, key, ends in thinned(here, after, keyframe_error):
            hidden = each.status is Status.OCCLUDED
            yield _box(each.frame, box, occluded=hidden, keyframe=key)
            if ends and after[each.frame] < end:
                yield _box(after[each.frame], box, outside=True)
        yield b"  </track>\n"
    yield b"</annotations>\n"


def _task_lines(recorded: Recording, end: int) -> str:
    """Return the lines on the frames of the task, which ends before the frame `end`."""
    first = recorded.frames[0].frame if end else 0
    seen = range(first, end, recorded.stride)
    lines = [f"<size>{len(seen)}</size>", "<mode>interpolation</mode>"]
    if seen.start or seen.step > 1:
        lines.append(f"<start_frame>{seen.start}</start_frame>")
    if seen.step > 1:
        lines.append(f"<frame_filter>step={seen.step}</frame_filter>")
    return "\n".join(f"      {line}" for line in lines)


def _box(
    frame: int,
    corners: Corners,
    *,
    outside: bool = False,
    occluded: bool = False,
    keyframe: bool = True,
) -> bytes:
    return (
        f'    <box frame="{frame}" outside="{outside:d}" occluded="{occluded:d}" '
        f'keyframe="{keyframe:d}" xtl="{corners.left}" ytl="{corners.top}" '
        f'xbr="{corners.right}" ybr="{corners.bottom}" z_order="0"/>\n'
    ).encode()


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the tracks, and the shapes of single images, of a CVAT document.

    Frames of a track between its keyframes are interpolated as in CVAT, also where the document
    leaves them out, but for those that the task skips; the last one stays to the end of the task,
    unless it is `outside`. Boxes and ellipses may be rotated; of other shapes the box is taken.
    Shapes of single images have no identity. Skeletons, cuboids and tags are left out.
    """
    from xml.etree import ElementTree

    try:
        root = ElementTree.fromstring(read_text(path, FormatError))
    except ElementTree.ParseError as error:
        raise FormatError(f"it is not XML: {error}") from None
    if root.tag != "annotations":
        raise FormatError("it has no annotations of CVAT")
    objects: list[Track] = []
    tracks, images = list(root.iter("track")), list(root.iter("image"))
    if any(each.tag in SHAPES for part in root.iter() if part.tag not in HOLDERS for each in part):
        raise FormatError("it has a shape that is in no track and in no image")
    _check_one_task(root, [*tracks, *images])
    ids, step, unplaced, ellipses = set[int](), _step(root), set[int](), set[int]()
    task = _task_frames(root, step)
    end = min(facts.frames or task.stop, task.stop) if task is not None else facts.frames or 0
    for place, track in enumerate(tracks):
        with at(f"track {track.get('id', place)}"):
            identity = whole(track.get("id", str(place)))
            if identity < 0 or identity in ids:
                raise ValueError("its id is negative, or that of another track")
            ids.add(identity)
            objects += _read_track(track, identity, _label(track, facts), step, end)
            if track.find("ellipse") is not None:
                ellipses.add(identity)
            shapes = (shape for shape in track if shape.tag in UNREAD)
            unplaced |= {_frame(shape) for shape in shapes if not _flag(shape, "outside")}
    frames, notes = _image_frames(images, images_of(facts))
    files = dict[int, str]()
    for image, frame in zip(images, frames, strict=True):
        with at(f"image {image.get('id', image.get('name', ''))}"):
            if frame in files:
                raise ValueError("its frame is that of another image")
            files[frame] = image.get("name", "")
            unplaced |= {frame for shape in image if shape.tag in UNREAD}
            objects += [
                _row(shape, frame, ANONYMOUS, _label(shape, facts))
                for shape in image
                if shape.tag in SHAPES
            ]
    last = max((each.frame for each in objects), default=-1)
    seen = facts.seen(last) if task is None else task
    if len(seen) > MOST_FRAMES:
        raise FormatError(f"it has {len(seen)} frames, which no film has")
    times = dict.fromkeys(files if images and not tracks else seen)
    named = {frame: name for frame, name in files.items() if name}
    others = Counter(each.tag for part in (*tracks, *images) for each in part)
    left_out = [
        counted(count, kind) for kind, count in others.items() if kind not in (*SHAPES, "attribute")
    ]
    left_out += [
        f"{counted(others[kind], kind.removesuffix('s'))}, but for the box"
        for kind in BOXED
        if others[kind]
    ]
    shapes = (shape for part in (*tracks, *images) for shape in part if shape.tag in SHAPES)
    left_out += unread({each.get("name", "") for shape in shapes for each in shape})
    size = _size(root, images)
    searched = searched_in(unplaced, objects)
    found = Recording.of(facts, objects, times, size, named, left_out, searched)
    if tracks and [*facts.files] != sorted(facts.files):
        notes.append(ORDER)
    return replace(found, notes=notes, stride=step, ellipses=ellipses)


def _image_frames(images: list[Element], known: Mapping[str, int]) -> tuple[list[int], list[str]]:
    """Return the frames of images, and what was assumed for them.

    Of a folder they are those of the film's images of their names, and of a video the numbers that
    CVAT gives to its frames. A task of a part of a film's images counts these anew as its ids.
    """
    paths = [Path(image.get("name", "")) for image in images]
    stems = [text_name(path.stem) for path in paths]
    ids = dict[int, str]()
    for image, stem in zip(images, stems, strict=True):
        with at(f"image {image.get('id', image.get('name', ''))}"):
            if (number := whole(image.attrib["id"])) in ids:
                raise ValueError("its id is that of another image")
            ids[number] = stem
    if known:
        frames = list[int]()
        for stem in stems:
            with at(f"image {stem}"):
                if (frame := frame_of(stem, known)) is None:
                    raise FormatError(NO_IMAGE)
                frames.append(frame)
        return frames, []
    sizes = (f"{each.get('width')}x{each.get('height')}" for each in images)
    check_one_film(folder=(path.parent for path in paths if path.name), size=sizes)
    if all(map(OF_VIDEO.fullmatch, stems)):
        return [int(stem.removeprefix("frame_")) for stem in stems], []
    last = ((number, re.search(r"(\d+)\D*$", stem)) for number, stem in ids.items())
    steps = {int(found[1]) - number for number, found in last if found}
    return [*ids], [
        "frames are the ids of its images, which the numbers in their names do not follow; if it "
        "is of a part of a folder's images, give that with --video FOLDER."
    ] * (len(steps) > 1)


def _step(root: Element) -> int:
    """Return how far apart in the film the frames of a task are: more than 1 if it skips some."""
    filters = (root.findtext(f"{place}/frame_filter") for place in METAS)
    found = (re.search(r"step\s*=\s*([1-9]\d*)", text) for text in filters if text)
    return next((int(step[1]) for step in found if step), 1)


def _task_frames(root: Element, step: int) -> range | None:
    """Return the frames that a task of tracks has; None where it does not tell them."""
    for place in METAS:
        size, first = (_whole(root.findtext(f"{place}/{name}")) for name in ("size", "start_frame"))
        if size:
            if size > MOST_FRAMES:
                raise FormatError(f"its size is {size} frames, which no film has")
            if place == "meta/job" and step > 1:  # its first frame counts in steps from another
                return range(0)
            return range(first or 0, (first or 0) + size * step, step)
    return None


def _check_one_task(root: Element, parts: list[Element]) -> None:
    """Raise a FormatError if a project's tracks and images are of several tasks, so of films."""
    tasks = {part.get("task_id") for part in parts}
    listed = len(root.findall("meta/project/tasks/task"))
    if len(tasks) > 1 or (tasks == {None} and listed > 1):
        raise FormatError(
            f"it is of {max(len(tasks), listed)} tasks of a project, each with a film of its own; "
            f"export the task of one film."
        )


def _whole(text: str | None) -> int | None:
    return int(text) if text and text.strip().isdigit() else None


def _size(root: Element, images: list[Element]) -> tuple[int, int] | None:
    for place in METAS:
        width = _whole(root.findtext(f"{place}/original_size/width"))
        height = _whole(root.findtext(f"{place}/original_size/height"))
        if width and height:
            return width, height
    sizes = [(_whole(each.get("width")) or 0, _whole(each.get("height")) or 0) for each in images]
    return max(sizes, default=None)


def _label(element: Element, facts: FilmFacts) -> str | None:
    return label_or_none(element.get("label"), facts.label)


METAS = ("meta/task", "meta/job", "meta/project/tasks/task", "meta")
"""Where a document may describe its film."""
ORDER = (
    "its frames follow the numbers in the names of images; CVAT sorts these by letters, 10.png "
    "before 2.png, unless the sorting method of the task is natural."
)
HOLDERS = ("track", "image", "skeleton")
UNREAD = ("skeleton", "cuboid")
"""Shapes that are objects, but left out."""
BOXED = ("polygon", "polyline", "points", "mask")
"""Shapes of which the box is taken."""
SHAPES = ("box", "ellipse", *BOXED)


def _read_track(
    track: Element, identity: int, label: str | None, step: int, end: int
) -> Iterator[Track]:
    """Yield an object in frames; its last shape stays to the `end` of the task, unless outside."""
    shapes = [shape for shape in track if shape.tag in SHAPES]
    shapes.sort(key=_frame)
    for shape, following in zip(shapes, [*shapes, None][1:], strict=True):
        if _flag(shape, "outside"):
            continue
        frame = _frame(shape)
        row = _row(shape, frame, identity, label)
        yield row
        until = max(frame, end) if following is None else _frame(following)
        goal = row if following is None else _row(following, until, identity, label)
        for between in frames_between(frame, until)[step - 1 :: step]:
            place = _between(row.ellipse, goal.ellipse, (between - frame) / (until - frame))
            bounds = None if row.bounds is None else box_of_rectangle(place)
            yield structs.replace(row, frame=between, ellipse=place, keyframe=False, bounds=bounds)


def _between(start: Ellipse, end: Ellipse, share: float) -> Ellipse:
    """Return the interpolated ellipse; it turns the shorter way."""
    turn = (end.theta - start.theta + math.pi) % (2 * math.pi) - math.pi
    sides = (one + share * (two - one) for one, two in zip(start, end, strict=True))
    return Ellipse(*sides)._replace(theta=start.theta + share * turn)


def _frame(shape: Element) -> int:
    return whole(shape.attrib["frame"])


def _flag(shape: Element, name: str, usual: str = "0") -> bool:
    """Return whether a shape has a mark; raise a ValueError if it is neither 0 nor 1."""
    text = shape.get(name, usual)
    if text not in ("0", "1"):
        raise ValueError(f"{name} is {text[:20]!r}, neither 0 nor 1")
    return text == "1"


def _row(shape: Element, frame: int, identity: int, label: str | None) -> Track:
    """Return the object of a shape; errors name its frame."""
    with at(f"{shape.tag} of frame {shape.get('frame')}" if "frame" in shape.attrib else shape.tag):
        status = Status.OCCLUDED if _flag(shape, "occluded") else Status.TRACKING
        key = _flag(shape, "keyframe", "1")
        ellipse = _ellipse(shape)
        bounds = None if shape.tag == "ellipse" else box_of_rectangle(ellipse)
        return sound(Track(
            frame, UNTIMED, ellipse, status=status, identity=identity, label=label, keyframe=key,
            bounds=bounds,
        ))  # fmt: skip


def _ellipse(shape: Element) -> Ellipse:
    given = shape.attrib
    theta = angle(number(given.get("rotation", "0")))
    if shape.tag == "ellipse":
        x, y, a, b = (number(given[name]) for name in ("cx", "cy", "rx", "ry"))
        return Ellipse(x - 0.5, y - 0.5, a, b, theta)
    if shape.tag == "box":
        sides = Corners(*(number(given[name]) for name in ("xtl", "ytl", "xbr", "ybr")))
    elif shape.tag == "mask":
        left, top, width, height = (number(given[k]) for k in ("left", "top", "width", "height"))
        sides = Corners(left, top, left + width, top + height)
    else:
        if not given["points"]:
            raise ValueError("it has no points")
        pairs = [pair.split(",") for pair in given["points"].split(";")]
        points = np.array([(number(x), number(y)) for x, y in pairs])
        sides = Corners(*points.min(axis=0).tolist(), *points.max(axis=0).tolist())
    return sides.ellipse._replace(theta=theta)
