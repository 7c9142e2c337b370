"""Objects in the formats of annotation tools: COCO's JSON and CVAT's XML.

Both are written piece by piece from a journal. Coordinates are measured from the upper left corner
of the frame, as these tools do. Parts outside the frame are cut off. Frames count from 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes import __version__
from motes.core.geometry import area, clipped
from motes.core.track import Status
from motes.output.journal import FrameRow, Header, Journal, ObjectRow

ANNOTATED = (Status.TRACKING, Status.OCCLUDED, Status.INTERPOLATED)
"""The states that are annotated; a searched or lost object has no known position."""
MIN_AREA = 0.01
"""Smallest area inside the frame of an object that is annotated, in square pixels."""


class Corners(NamedTuple):
    """The sides of a box, in pixels."""

    left: float
    top: float
    right: float
    bottom: float


def coco(journal: Journal) -> Iterator[bytes]:
    """Yield a COCO document: `info`, `licenses`, `categories`, `images` and `annotations`.

    `categories` has the classes of the objects; an object's class is that of its last row. `images`
    has one entry for each frame, with its `frame` and `time`. The `file_name` is that of the image
    if the source is a folder of images; otherwise it is the name that CVAT gives to a
    frame of a video. `annotations` has one entry for each object in each frame, also if it is
    occluded: `segmentation` and `area` of the ellipse, the `bbox` around it, the `score`, and the
    `attributes` `track_id` and `occluded`.
    """
    head = journal.head
    about = {
        "description": f"Objects in {head.source}, as motes followed them",
        "version": __version__,
        "video": head.source,
    }
    yield b'{"info": ' + msgspec.json.encode(about) + b',\n"licenses": [],\n"categories": '
    names = _classes(journal)
    numbers = {name: number for number, name in enumerate(_labels(names, head), start=1)}
    yield msgspec.json.encode(
        [{"id": number, "name": name, "supercategory": ""} for name, number in numbers.items()]
    )
    yield b',\n"images": ['
    yield from _json_list(_image(row, head) for row in journal)
    yield b'],\n"annotations": ['
    categories = {identity: numbers[name] for identity, name in names.items()}
    yield from _json_list(_annotations(journal, categories))
    yield b"]}\n"


def _json_list(items: Iterable[dict[str, object]]) -> Iterator[bytes]:
    for index, item in enumerate(items):
        yield (b",\n" if index else b"\n") + msgspec.json.encode(item)


def _image(row: FrameRow, head: Header) -> dict[str, object]:
    return {
        "id": row.frame + 1,
        "file_name": row.file or f"frame_{row.frame:06d}.png",
        "width": head.width,
        "height": head.height,
        "frame": row.frame,
        "time": round(row.time, 6),
    }


def _classes(journal: Journal) -> dict[int, str]:
    """Return the class of each identity: that of its last row."""
    usual = journal.head.label
    return {
        each.identity: usual if each.label is None else each.label
        for row in journal
        for each in row.objects
    }


def _labels(classes: Mapping[int, str], head: Header) -> list[str]:
    """Return all classes in the order of their first identities; at least one."""
    return list(dict.fromkeys(classes.values())) or [head.label]


def _annotations(journal: Journal, categories: Mapping[int, int]) -> Iterator[dict[str, object]]:
    number = 0
    for row in journal:
        for each in row.objects:
            corners = _visible_box(each, journal.head)
            if corners is None:
                continue
            number += 1
            outline = _visible_outline(each, journal.head)
            yield {
                "id": number,
                "image_id": row.frame + 1,
                "category_id": categories[each.identity],
                "bbox": [
                    corners.left,
                    corners.top,
                    round(corners.right - corners.left, 2),
                    round(corners.bottom - corners.top, 2),
                ],
                "segmentation": [outline.ravel().round(2).tolist()],
                "area": round(area(outline), 2),
                "iscrowd": 0,
                "score": round(each.confidence, 5),
                "attributes": {
                    "track_id": each.identity,
                    "occluded": each.status is Status.OCCLUDED,
                },
            }


def cvat(journal: Journal) -> Iterator[bytes]:
    """Yield a CVAT document ("CVAT for video 1.1"): a track for each object.

    Every box is a keyframe. In the first frame without the object, a box marked `outside` ends the
    track; otherwise CVAT would continue to draw it.
    """
    from xml.sax.saxutils import escape  # which imports all that talks over networks

    head, end = journal.head, 0
    spans: dict[int, tuple[int, int]] = {}
    for offset, row in journal.rows():
        end = row.frame + 1
        for each in row.objects:
            if each.status in ANNOTATED:
                spans[each.identity] = spans.get(each.identity, (offset, 0))[0], offset
    classes = _classes(journal)
    labels = "\n".join(
        f"        <label>\n          <name>{escape(name)}</name>\n        </label>"
        for name in _labels(classes, head)
    )
    yield f"""\
<?xml version="1.0" encoding="utf-8"?>
<annotations>
  <version>1.1</version>
  <meta>
    <task>
      <size>{end}</size>
      <mode>interpolation</mode>
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
    for identity, (first, last) in spans.items():
        yield from _track(journal, identity, classes[identity], first, last)
    yield b"</annotations>\n"


def _track(journal: Journal, identity: int, name: str, first: int, last: int) -> Iterator[bytes]:
    """Yield the track of an object whose first and last rows begin at two offsets in the file."""
    from xml.sax.saxutils import quoteattr

    started, hidden = False, False
    shown: Corners | None = None
    for offset, row in journal.rows(first):
        before, shown = shown, None
        for each in row.objects:
            if each.identity == identity:
                shown, hidden = _visible_box(each, journal.head), each.status is Status.OCCLUDED
        if shown and not started:
            label = quoteattr(name)
            yield f'  <track id="{identity}" label={label} source="automatic">\n'.encode()
            started = True
        if shown:
            yield _box(row.frame, shown, occluded=hidden)
        elif before:
            yield _box(row.frame, before, outside=True)
        if offset > last:
            break
    if started:
        yield b"  </track>\n"


def _box(frame: int, corners: Corners, *, outside: bool = False, occluded: bool = False) -> bytes:
    return (
        f'    <box frame="{frame}" outside="{outside:d}" occluded="{occluded:d}" keyframe="1" '
        f'xtl="{corners.left}" ytl="{corners.top}" xbr="{corners.right}" ybr="{corners.bottom}" '
        f'z_order="0"/>\n'
    ).encode()


def _visible_box(each: ObjectRow, head: Header) -> Corners | None:
    """Return the part of an object's box inside the frame; None if it is not annotated."""
    if each.status not in ANNOTATED:
        return None
    x, y, width, height = each.box
    whole = Corners(round(x, 2), round(y, 2), round(x + width, 2), round(y + height, 2))
    left, right = (min(max(end, 0.0), head.width) for end in (whole.left, whole.right))
    top, bottom = (min(max(end, 0.0), head.height) for end in (whole.top, whole.bottom))
    cut = Corners(left, top, right, bottom)
    if left >= right or top >= bottom:
        return None
    # If only a corner of the box is inside the frame, the ellipse may still be outside.
    return cut if cut == whole or area(_visible_outline(each, head)) >= MIN_AREA else None


def _visible_outline(each: ObjectRow, head: Header) -> NDArray[np.float64]:
    # The first pixel's center is at 0 in an ellipse, and at 0.5 in coordinates of its corners.
    return clipped(each.ellipse.polygon() + 0.5, head.width, head.height)
