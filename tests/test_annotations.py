"""Objects as COCO and CVAT have them."""

from __future__ import annotations

import json
from xml.etree import ElementTree

import pytest

from motes.annotations import coco, cvat
from motes.objects import SceneTrack
from motes.track import Status
from test_counting import seen

SIZE = (100, 60)


def frames() -> dict[int, list[SceneTrack]]:
    """Return two objects: one walks out by the left border, one is hidden and then lost."""
    return {
        4: [seen(4, (20, 40), identity=1), seen(4, (50, 30), identity=2)],
        5: [seen(5, (2, 40), identity=1), seen(5, (52, 30), Status.OCCLUDED, identity=2)],
        6: [seen(6, (-20, 40), identity=1), seen(6, (54, 30), Status.LOST, identity=2)],
        7: [seen(7, (20, 40), Status.SEARCHING, identity=1)],
        8: [seen(8, (20, 40), identity=1)],
    }


def test_coco() -> None:
    document = json.loads(coco(frames(), SIZE))
    pictures = {each["id"]: each["file_name"] for each in document["images"]}
    assert pictures == {i + 1: f"frame_{i:06d}.png" for i in range(4, 9)}
    assert {(each["width"], each["height"]) for each in document["images"]} == {SIZE}
    (category,) = document["categories"]
    found = document["annotations"]
    assert [each["id"] for each in found] == [1, 2, 3, 4, 5]
    assert {each["category_id"] for each in found} == {category["id"]}
    attributes = [each["attributes"] for each in found]
    assert [(each["image_id"] - 1, which["track_id"], which["occluded"])
            for each, which in zip(found, attributes, strict=True)] == [
        (4, 1, False), (4, 2, False), (5, 1, False), (5, 2, True), (8, 1, False),
    ]  # fmt: skip
    assert found[0]["bbox"] == [15, 30, 11, 11]  # an object 11 pixels wide and high, on its foot
    assert found[2]["bbox"] == [0, 30, 8, 11]  # cut at the border
    for each in found:
        assert each["area"] == pytest.approx(each["bbox"][2] * each["bbox"][3])
        assert each["iscrowd"] == 0


def test_cvat() -> None:
    root = ElementTree.fromstring(cvat(frames(), SIZE))
    assert root.tag == "annotations"
    assert root.findtext("version") == "1.1"
    assert root.findtext("meta/task/size") == "9"
    assert root.findtext("meta/task/original_size/width") == "100"
    label = root.findtext("meta/task/labels/label/name")
    tracks = {track.get("id"): track for track in root.iter("track")}
    assert list(tracks) == ["1", "2"]
    assert {track.get("label") for track in tracks.values()} == {label}

    def told(who: str) -> list[tuple[int, bool, bool]]:
        return [
            (int(box.attrib["frame"]), box.get("outside") == "1", box.get("occluded") == "1")
            for box in tracks[who]
        ]

    # A box outside ends what would be drawn on; who comes back goes on in the same track.
    assert told("1") == [(4, False, False), (5, False, False), (6, True, False), (8, False, False)]
    assert told("2") == [(4, False, False), (5, False, True), (6, True, False)]
    first, second = tracks["1"][:2]
    corners = "xtl", "ytl", "xbr", "ybr"
    assert [float(first.attrib[name]) for name in corners] == [15, 30, 26, 41]
    assert [float(second.attrib[name]) for name in corners] == [0, 30, 8, 41]
    assert all(box.get("keyframe") == "1" for track in tracks.values() for box in track)


def test_nothing_at_all() -> None:
    assert json.loads(coco({}, SIZE))["annotations"] == []
    assert ElementTree.fromstring(cvat({0: []}, SIZE)).find("track") is None
