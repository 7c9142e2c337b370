"""Objects in the forms of COCO and CVAT, and in the tools that these are for."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from motes.core.errors import SourceError
from motes.core.geometry import Ellipse, area, clipped
from motes.core.track import Status, Track
from motes.formats.coco import write as coco
from motes.formats.cvat import write as cvat
from motes.formats.recording import FilmFacts, Recording
from motes.formats.registry import read, write
from motes.formats.rows import recording_of_journal
from motes.rows.schema import FrameRow, Header
from motes.rows.writer import JournalWriter
from sightings import seen

SIZE = (100, 60)
HEAD = Header("film.mp4", *SIZE, "sea & <bird>")


def frames() -> dict[int, list[Track]]:
    """Return two objects: one walks out by the left border, one is hidden and then lost."""
    return {
        4: [seen(4, (20, 40), identity=1), seen(4, (50, 30), identity=2)],
        5: [seen(5, (2, 40), identity=1), seen(5, (52, 30), Status.OCCLUDED, identity=2)],
        6: [seen(6, (-20, 40), identity=1), seen(6, (54, 30), Status.LOST, identity=2)],
        7: [seen(7, (20, 40), Status.SEARCHING, identity=1)],
        8: [seen(8, (20, 40), identity=1)],
    }


def pictures(tracks: Mapping[int, Sequence[Track]]) -> list[FrameRow]:
    return [FrameRow(index, index / 4, tuple(here)) for index, here in tracks.items()]


def journal(folder: Path, kept: Sequence[FrameRow]) -> Recording:
    writer = JournalWriter(folder / "kept.rows.jsonl", HEAD)
    for picture in kept:
        writer.add(picture)
    writer.close()
    return recording_of_journal(folder / "kept.rows.jsonl")


def test_a_journal_of_another_version_is_said_to_be_one(tmp_path: Path) -> None:
    (tmp_path / "old.rows.jsonl").write_text(
        '{"motes":"rows 1","source":"film.mp4","width":9,"height":9,"label":"object"}\n'
    )
    with pytest.raises(SourceError, match="the rows of a document of this version of motes"):
        recording_of_journal(tmp_path / "old.rows.jsonl")


def test_coco(tmp_path: Path) -> None:
    document = json.loads(b"".join(coco(journal(tmp_path, pictures(frames())))))
    assert list(document) == ["info", "licenses", "categories", "images", "annotations"]
    assert document["info"]["video"] == "film.mp4"
    assert [(each["id"], each["frame"], each["time"]) for each in document["images"]] == [
        (i + 1, i, i / 4) for i in range(4, 9)
    ]
    assert [each["file_name"] for each in document["images"]] == [
        f"frame_{i:06d}.png" for i in range(4, 9)
    ]
    assert {(each["width"], each["height"]) for each in document["images"]} == {SIZE}
    (category,) = document["categories"]
    assert category["name"] == HEAD.label
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
    assert {each["iscrowd"] for each in found} == {0}
    assert [each["segmentation"] for each in found] == [[]] * 5
    assert [each["area"] for each in found] == [121, 121, 88, 121, 121]


def test_an_outline_is_cut_to_the_picture() -> None:
    """As counted: which points of a fine grid in the picture are in the ellipse."""
    rng = np.random.default_rng(0)
    y, x = (np.mgrid[0:600, 0:1000] + 0.5) / 10
    for _ in range(30):
        ellipse = Ellipse(*rng.uniform((-20, -20, 5, 5, 0), (120, 80, 40, 40, 4)).tolist())
        cos, sin = math.cos(ellipse.theta), math.sin(ellipse.theta)
        u = ((x - ellipse.x) * cos + (y - ellipse.y) * sin) / ellipse.a
        v = ((y - ellipse.y) * cos - (x - ellipse.x) * sin) / ellipse.b
        inside = (u**2 + v**2 <= 1).sum() / 100
        outline = clipped(ellipse.polygon(), *SIZE)
        assert area(outline) == pytest.approx(inside, rel=0.01, abs=1)
        if len(outline):
            assert (outline >= -1e-9).all()
            assert (outline <= np.add(SIZE, 1e-9)).all()


def test_cvat(tmp_path: Path) -> None:
    root = ElementTree.fromstring(b"".join(cvat(journal(tmp_path, pictures(frames())))))
    assert root.tag == "annotations"
    assert root.findtext("version") == "1.1"
    assert root.findtext("meta/task/size") == "9"
    assert root.findtext("meta/task/original_size/width") == "100"
    assert root.findtext("meta/task/labels/label/name") == HEAD.label
    tracks = {track.get("id"): track for track in root.iter("track")}
    assert list(tracks) == ["1", "2"]
    assert {track.get("label") for track in tracks.values()} == {HEAD.label}

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


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    """Return a folder with all forms, laid out as datumaro wants each of them."""
    kept = journal(tmp_path, pictures(frames()))
    for folder in ("images", "annotations", "gt"):
        (tmp_path / folder).mkdir()
    write(tmp_path / "annotations" / "instances_all.json", "coco", kept)
    write(tmp_path / "cvat.xml", "cvat", kept)
    write(tmp_path / "gt" / "gt.txt", "mot", kept)
    (tmp_path / "gt" / "labels.txt").write_text("bird\n")
    return tmp_path


def datumaro() -> Any:
    reason = "datumaro is not installed; `make test` installs it"
    return pytest.importorskip("datumaro.components.dataset", reason=reason).Dataset


def test_polygons_without_a_box_have_the_box_around_them(tmp_path: Path) -> None:
    polygons = [[10, 20, 30, 20, 30, 50], [5, 25, 8, 25, 8, 28]]
    document = {
        "images": [{"id": 1, "file_name": "a.png", "width": SIZE[0], "height": SIZE[1]}],
        "annotations": [{"image_id": 1, "category_id": 1, "segmentation": polygons}],
    }
    (tmp_path / "a.json").write_text(json.dumps(document))
    (row,) = read(tmp_path / "a.json", "coco", FilmFacts())
    assert row.objects[0].box == pytest.approx((5, 20, 25, 30))
