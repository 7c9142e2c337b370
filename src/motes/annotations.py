"""Objects as annotation tools take them: COCO's JSON and CVAT's XML.

Both are one document, which is whole only at the end; rows are for whoever reads along. Boxes are
cut to the picture, whose upper left corner is 0, 0; frames count from 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias
from xml.etree import ElementTree

import msgspec

from motes.objects import SceneTrack
from motes.track import Status

Size: TypeAlias = tuple[int, int]
"""Width and height of a picture."""
Corners: TypeAlias = tuple[float, float, float, float]
"""Left, top, right, bottom."""

DECLARATION = '<?xml version="1.0" encoding="utf-8"?>'
LABEL = "object"
SHOWN = (Status.TRACKING, Status.OCCLUDED)
"""Where an object is searched for nobody has seen it, and nothing is annotated."""


def coco(frames: Mapping[int, Sequence[SceneTrack]], size: Size) -> str:
    """Return a COCO document of objects by frame.

    An annotation for each object in each frame, also of hidden ones, with `score`, and with
    `track_id` and `occluded` among its `attributes`; pictures have the names that CVAT and its like
    give to the frames of a video.
    """
    width, height = size
    images = [
        {"id": index + 1, "file_name": f"frame_{index:06d}.png", "width": width, "height": height}
        for index in frames
    ]
    annotations: list[dict[str, object]] = []
    for index, tracks in frames.items():
        for each in tracks:
            corners = _within(each, size)
            if corners is None:
                continue
            left, top, right, bottom = corners
            box = [left, top, round(right - left, 2), round(bottom - top, 2)]
            annotations.append(
                {
                    "id": len(annotations) + 1,
                    "image_id": index + 1,
                    "category_id": 1,
                    "bbox": box,
                    "area": round(box[2] * box[3], 2),
                    "iscrowd": 0,
                    "score": round(each.track.confidence, 5),
                    "attributes": {
                        "track_id": each.identity,
                        "occluded": each.track.status is Status.OCCLUDED,
                    },
                }
            )
    categories = [{"id": 1, "name": LABEL}]
    return msgspec.json.encode(
        {"images": images, "annotations": annotations, "categories": categories}
    ).decode()


def cvat(frames: Mapping[int, Sequence[SceneTrack]], size: Size) -> str:
    """Return a CVAT document (for video, 1.1) of objects by frame: a track for each.

    Every box is a keyframe. In the first frame without the object a box that is `outside` ends it,
    as CVAT would draw it on otherwise.
    """
    root = ElementTree.Element("annotations")
    _text(root, "version", "1.1")
    task = ElementTree.SubElement(ElementTree.SubElement(root, "meta"), "task")
    _text(task, "size", max(frames, default=-1) + 1)
    _text(task, "mode", "interpolation")
    label = ElementTree.SubElement(ElementTree.SubElement(task, "labels"), "label")
    _text(label, "name", LABEL)
    original = ElementTree.SubElement(task, "original_size")
    for name, value in zip(("width", "height"), size, strict=True):
        _text(original, name, value)

    tracks: dict[int, ElementTree.Element] = {}
    last: dict[int, Corners] = {}
    for index, here in frames.items():
        seen: dict[int, tuple[Corners, bool]] = {}
        for each in here:
            corners = _within(each, size)
            if corners is not None:
                seen[each.identity] = corners, each.track.status is Status.OCCLUDED
        for who in [who for who in last if who not in seen]:
            _box(tracks[who], index, last.pop(who), outside=True)
        for who, (corners, hidden) in seen.items():
            if who not in tracks:
                tracks[who] = ElementTree.SubElement(
                    root, "track", id=str(who), label=LABEL, source="automatic"
                )
            _box(tracks[who], index, corners, occluded=hidden)
            last[who] = corners
    ElementTree.indent(root)
    return f"{DECLARATION}\n{ElementTree.tostring(root, encoding='unicode')}\n"


def _box(
    track: ElementTree.Element,
    frame: int,
    corners: Corners,
    *,
    outside: bool = False,
    occluded: bool = False,
) -> None:
    places = dict(zip(("xtl", "ytl", "xbr", "ybr"), map(str, corners), strict=True))
    flags = {"outside": outside, "occluded": occluded, "keyframe": True}
    texts = {name: str(int(flag)) for name, flag in flags.items()}
    ElementTree.SubElement(track, "box", {"frame": str(frame), **texts, **places, "z_order": "0"})


def _text(parent: ElementTree.Element, name: str, value: object) -> None:
    ElementTree.SubElement(parent, name).text = str(value)


def _within(each: SceneTrack, size: Size) -> Corners | None:
    """Return an object's corners in the picture; None where it is not in it, or not seen."""
    if each.track.status not in SHOWN:
        return None
    box = each.track.box
    left, right = _cut((box.x, box.x + box.width), size[0])
    top, bottom = _cut((box.y, box.y + box.height), size[1])
    return (left, top, right, bottom) if left < right and top < bottom else None


def _cut(ends: Iterable[float], most: int) -> list[float]:
    return [round(min(max(end, 0.0), most), 2) for end in ends]
