"""Objects in the forms that annotation tools read: COCO's JSON and CVAT's XML.

Both are written piece by piece from a journal. Coordinates are measured from the upper left corner
of the picture, as these tools do; what is outside of the picture is cut off. Frames count from 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes import __version__
from motes.core.geometry import area, clipped
from motes.core.track import Status
from motes.output.journal import Head, Journal, Picture, Sighting

SHOWN = (Status.TRACKING, Status.OCCLUDED)
"""Where an object is searched for nobody has seen it, and nothing is annotated."""
LEAST = 0.01
"""An object with less of it in the picture, in square pixels, is not annotated."""


class Corners(NamedTuple):
    """A box, in pixels."""

    left: float
    top: float
    right: float
    bottom: float


def coco(journal: Journal) -> Iterator[bytes]:
    """Yield a COCO document: `info`, `licenses`, `categories`, `images` and `annotations`.

    An image for each frame, with its `frame` and `time`. Its `file_name` is that of the image if
    the source is a folder of images; else the one that CVAT gives to the frame of a video. An
    annotation for each object in each frame, also of hidden ones: `segmentation` and `area` of the
    ellipse, the `bbox` around it, `score`, and `track_id` and `occluded` among its `attributes`.
    """
    head = journal.head
    about = {
        "description": f"Objects in {head.source}, as motes followed them",
        "version": __version__,
        "video": head.source,
    }
    yield b'{"info": ' + msgspec.json.encode(about) + b',\n"licenses": [],\n"categories": '
    yield msgspec.json.encode([{"id": 1, "name": head.label, "supercategory": ""}])
    yield b',\n"images": ['
    yield from _listed(_image(picture, head) for picture in journal)
    yield b'],\n"annotations": ['
    yield from _listed(_annotations(journal))
    yield b"]}\n"


def _listed(items: Iterable[dict[str, object]]) -> Iterator[bytes]:
    for index, item in enumerate(items):
        yield (b",\n" if index else b"\n") + msgspec.json.encode(item)


def _image(picture: Picture, head: Head) -> dict[str, object]:
    return {
        "id": picture.frame + 1,
        "file_name": picture.file or f"frame_{picture.frame:06d}.png",
        "width": head.width,
        "height": head.height,
        "frame": picture.frame,
        "time": round(picture.time, 6),
    }


def _annotations(journal: Journal) -> Iterator[dict[str, object]]:
    number = 0
    for picture in journal:
        for each in picture.objects:
            corners = _visible(each, journal.head)
            if corners is None:
                continue
            number += 1
            outline = _outline(each, journal.head)
            yield {
                "id": number,
                "image_id": picture.frame + 1,
                "category_id": 1,
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
    """Yield a CVAT document (for video, 1.1): a track for each object.

    Every box is a keyframe. In the first frame without the object a box that is `outside` ends it,
    as CVAT would draw it on otherwise.
    """
    from xml.sax.saxutils import escape  # which imports all that talks over networks

    head, end = journal.head, 0
    spans: dict[int, tuple[int, int]] = {}
    for offset, picture in journal.pictures():
        end = picture.frame + 1
        for each in picture.objects:
            if each.status in SHOWN:
                spans[each.identity] = spans.get(each.identity, (offset, 0))[0], offset
    yield f"""\
<?xml version="1.0" encoding="utf-8"?>
<annotations>
  <version>1.1</version>
  <meta>
    <task>
      <size>{end}</size>
      <mode>interpolation</mode>
      <labels>
        <label>
          <name>{escape(head.label)}</name>
        </label>
      </labels>
      <original_size>
        <width>{head.width}</width>
        <height>{head.height}</height>
      </original_size>
    </task>
  </meta>
""".encode()
    for identity, (first, last) in spans.items():
        yield from _track(journal, identity, first, last)
    yield b"</annotations>\n"


def _track(journal: Journal, identity: int, first: int, last: int) -> Iterator[bytes]:
    """Yield the track of an object that is in pictures from one offset to another."""
    from xml.sax.saxutils import quoteattr

    begun, hidden = False, False
    shown: Corners | None = None
    for offset, picture in journal.pictures(first):
        before, shown = shown, None
        for each in picture.objects:
            if each.identity == identity:
                shown, hidden = _visible(each, journal.head), each.status is Status.OCCLUDED
        if shown and not begun:
            label = quoteattr(journal.head.label)
            yield f'  <track id="{identity}" label={label} source="automatic">\n'.encode()
            begun = True
        if shown:
            yield _box(picture.frame, shown, occluded=hidden)
        elif before:
            yield _box(picture.frame, before, outside=True)
        if offset > last:
            break
    if begun:
        yield b"  </track>\n"


def _box(frame: int, corners: Corners, *, outside: bool = False, occluded: bool = False) -> bytes:
    return (
        f'    <box frame="{frame}" outside="{outside:d}" occluded="{occluded:d}" keyframe="1" '
        f'xtl="{corners.left}" ytl="{corners.top}" xbr="{corners.right}" ybr="{corners.bottom}" '
        f'z_order="0"/>\n'
    ).encode()


def _visible(each: Sighting, head: Head) -> Corners | None:
    """Return the box of an object in the picture; None where it is not in it, or not seen."""
    if each.status not in SHOWN:
        return None
    x, y, width, height = each.box
    whole = Corners(round(x, 2), round(y, 2), round(x + width, 2), round(y + height, 2))
    left, right = (min(max(end, 0.0), head.width) for end in (whole.left, whole.right))
    top, bottom = (min(max(end, 0.0), head.height) for end in (whole.top, whole.bottom))
    cut = Corners(left, top, right, bottom)
    if left >= right or top >= bottom:
        return None
    # A box may be in the picture with a corner alone, which the ellipse does not fill.
    return cut if cut == whole or area(_outline(each, head)) >= LEAST else None


def _outline(each: Sighting, head: Head) -> NDArray[np.float64]:
    # Of the pixel at 0, the center is at 0 in an ellipse, at 0.5 where its corner is at 0.
    return clipped(each.ellipse.polygon() + 0.5, head.width, head.height)
