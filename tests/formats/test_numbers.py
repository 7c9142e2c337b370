"""What we write, as the tools that it is for read it: frames, identities, boxes, and absence.

The expected numbers stand here, and no reader of ours takes part. Where a tool is not installed, a
plain reader follows the rule that its documentation, or its source, has.
"""

import json
import os
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from crowds import trackeval
from motes.core.geometry import Ellipse, area, clipped
from motes.core.track import Status
from motes.formats import masks, registry
from motes.formats.recording import FilmFacts, Recording
from recordings import placed

WIDTH, HEIGHT, FRAMES = 320, 240, 13
FACTS = FilmFacts(source="film.mp4", width=WIDTH, height=HEIGHT, fps=10.0, frames=FRAMES)
Truth = dict[int, tuple[str | None, Status, tuple[float, float, float, float]]]
"""Class, status and box of each object in a frame."""
Boxes = dict[tuple[int, int], list[float]]
"""x, y, width and height by frame and identity; the left side of the picture is 0."""


def truth(frame: int) -> Truth:
    """Return class, status and box of each object: a car that drives out, a walker, a van.

    The walker is absent in the frames 4 to 6; the van is hidden in 8 and 9, lost in 10, and
    found again in 11. The last frame is empty.
    """
    if frame == FRAMES - 1:
        return {}
    there: Truth = {1: ("car", Status.TRACKING, (200.25 + 9 * frame, 41.5, 40.75, 24.5))}
    if not 4 <= frame <= 6:
        there[2] = (None, Status.TRACKING, (100.0 - 2 * frame, 100.5 + frame**1.5, 16.0, 48.25))
    van = {8: Status.OCCLUDED, 9: Status.OCCLUDED, 10: Status.LOST}.get(frame, Status.TRACKING)
    there[7] = ("van", van, (20.5 + 3 * frame, 150.0, 60.5, 30.25 + frame))
    return there


def street() -> Recording:
    """Return the recording of `truth`."""
    objects = [
        placed(frame, Ellipse.from_box(box), identity, 0.75, status, label)
        for frame in range(FRAMES)
        for identity, (label, status, box) in truth(frame).items()
    ]
    return Recording.of(FACTS, objects, {frame: frame / 10 for frame in range(FRAMES)})


CERTAIN = [frame for frame in range(FRAMES) if frame != 10]
"""The frames in which no object is lost: those of a set for training."""


def expected(
    *, cut: bool = True, hidden: bool = False, lost: bool = False, frames: Iterable[int] = ()
) -> Boxes:
    """Return the boxes that a format holds: cut at the border, with hidden or lost objects.

    They are those of some frames, or of all.
    """
    kept = {Status.TRACKING, *[Status.OCCLUDED] * hidden, *[Status.LOST] * lost}
    found = {}
    for frame in frames or range(FRAMES):
        for identity, (_, status, (x, y, width, height)) in truth(frame).items():
            right = min(x + width, WIDTH) if cut else x + width
            if status in kept:
                found[frame, identity] = [x, y, right - x, height]
    return found


def turned(frame: int) -> Ellipse | None:
    """Return the place of an object that turns and grows; it is absent in the frames 4 and 5."""
    if frame in (4, 5):
        return None
    return Ellipse(60.5 + 9 * frame, 100 - frame**1.5, 30 + frame / 2, 14.25, 0.1 * frame - 0.3)


def one() -> Recording:
    """Return the recording of `turned`."""
    places = {frame: turned(frame) for frame in range(FRAMES)}
    objects = [placed(frame, place, 1, 0.75) for frame, place in places.items() if place]
    return Recording.of(FACTS, objects, {frame: frame / 10 for frame in range(FRAMES)})


def same(found: Boxes, known: Boxes, tolerance: float = 0.011) -> None:
    assert found.keys() == known.keys()
    for key, box in known.items():
        np.testing.assert_allclose(found[key], box, atol=tolerance, err_msg=str(key))


def without_identity(boxes: Boxes) -> list[tuple[int, list[float]]]:
    return sorted((frame, np.round(box, 2).tolist()) for (frame, _), box in boxes.items())


def same_places(found: list[tuple[int, list[float]]], known: Boxes) -> None:
    """Compare boxes without identities."""
    ours, theirs = sorted(found), without_identity(known)
    assert [frame for frame, _ in ours] == [frame for frame, _ in theirs]
    np.testing.assert_allclose([box for _, box in ours], [box for _, box in theirs], atol=0.02)


def motchallenge(folder: Path, *, is_gt: bool) -> Boxes:
    """Return what TrackEval reads; its frames and pixels count from 1."""
    box = trackeval().datasets.MotChallenge2DBox
    dataset = box.__new__(box)
    dataset.data_is_zipped = False
    dataset.config = {"GT_LOC_FORMAT": "{gt_folder}/{seq}.txt"}
    dataset.gt_fol, dataset.tracker_fol, dataset.tracker_sub_fol = str(folder), str(folder), ""
    dataset.seq_lengths = {"film": FRAMES}
    raw = dataset._load_raw_file("", "film", is_gt)
    kind = "gt" if is_gt else "tracker"
    return {
        (frame, int(identity)): (box - (1, 1, 0, 0)).tolist()
        for frame in range(FRAMES)
        for identity, box in zip(raw[f"{kind}_ids"][frame], raw[f"{kind}_dets"][frame], strict=True)
    }


def datumaro(path: Path, form: str) -> list[tuple[int, Any]]:
    """Return the boxes that Datumaro reads, each with its frame."""
    reason = "datumaro is not installed; `make test` installs it"
    dataset = pytest.importorskip("datumaro.components.dataset", reason=reason).Dataset
    return [
        (int(str(item.id).split("_")[-1]), each)
        for item in dataset.import_from(str(path), form)
        for each in item.annotations
        if each.type.name == "bbox" and not each.attributes.get("outside")
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "hidden"), [("mot", False), ("mot-truth", True)])
def test_trackeval_and_datumaro_read_the_motchallenge(
    name: str, hidden: bool, tmp_path: Path
) -> None:
    (tmp_path / "gt").mkdir()
    for path in (tmp_path / "film.txt", tmp_path / "gt" / "gt.txt"):
        registry.write(path, name, street())
    known = expected(cut=False, hidden=hidden)
    same(motchallenge(tmp_path, is_gt=hidden), known)
    (tmp_path / "gt" / "labels.txt").write_text("".join(f"class {i}\n" for i in range(1, 14)))
    found = datumaro(tmp_path, "mot_seq")
    boxes = {
        (frame - 1, each.attributes["track_id"]): list(np.subtract(each.get_bbox(), (1, 1, 0, 0)))
        for frame, each in found
    }
    same(boxes, known)
    unseen = {(frame - 1, each.attributes["track_id"]) for frame, each in found
              if each.attributes["visibility"] == 0}  # fmt: skip
    assert unseen == ({(8, 7), (9, 7)} if hidden else set())
    assert {each.attributes["track_id"]: each.label for _, each in found} == (
        {1: 2, 2: 0, 7: None}  # of the classes: 3 is a car, 1 a pedestrian; a van is none
    )


def test_datumaro_reads_detections(tmp_path: Path) -> None:
    reader = pytest.importorskip(
        "datumaro.plugins.data_formats.mot", reason="datumaro is not installed"
    )
    (tmp_path / "det").mkdir()
    registry.write(tmp_path / "det" / "det.txt", "mot-detections", street())
    found = [
        (int(item.id) - 1, np.subtract(each.get_bbox(), (1, 1, 0, 0)).tolist())
        for item in reader.MotSeqBase(str(tmp_path / "det" / "det.txt"))
        for each in item.annotations
    ]
    same_places(found, expected(cut=False))


def test_a_plain_reader_of_otb(tmp_path: Path) -> None:
    """A line for each frame from the first one on; pixels from 1, as in their MATLAB."""
    registry.write(tmp_path / "groundtruth_rect.txt", "otb", one())
    table = np.loadtxt(tmp_path / "groundtruth_rect.txt", delimiter=",")
    assert table.shape == (FRAMES, 4)
    for frame, row in enumerate(table):
        place = turned(frame)
        known = (0, 0, 0, 0) if place is None else np.add(place.box, (1, 1, 0, 0))
        np.testing.assert_allclose(row, known, atol=0.006)


def test_a_plain_reader_of_vot(tmp_path: Path) -> None:
    """By the toolkit's rule: 4 numbers are a rectangle, 8 and more a polygon, NaN is unknown."""
    registry.write(tmp_path / "groundtruth.txt", "vot", one())
    lines = (tmp_path / "groundtruth.txt").read_text().splitlines()
    assert len(lines) == FRAMES
    for frame, line in enumerate(lines):
        numbers, place = np.array(line.split(","), float), turned(frame)
        if place is None:
            assert np.isnan(numbers).all()
            continue
        corners = numbers.reshape(4, 2)
        np.testing.assert_allclose(corners.mean(axis=0), np.add(place[:2], 0.5), atol=1e-3)
        sides = np.linalg.norm(corners[1] - corners[0]), np.linalg.norm(corners[2] - corners[1])
        np.testing.assert_allclose(sides, (2 * place.a, 2 * place.b), atol=1e-3)
        along = corners[1] - corners[0]
        assert np.arctan2(along[1], along[0]) == pytest.approx(place.theta, abs=1e-3)


@pytest.fixture
def images(tmp_path: Path) -> Path:
    """Return a folder of images with the names that documents give to the frames."""
    (tmp_path / "images").mkdir()
    for frame in range(FRAMES):
        name = tmp_path / "images" / f"frame_{frame:06d}.png"
        Image.new("RGB", (WIDTH, HEIGHT)).save(name)
    return tmp_path / "images"


def by_supervision(found: Any) -> list[tuple[int, list[float]]]:
    """Return frame and box of the objects of a DetectionDataset."""
    return [
        (int(Path(name).stem.split("_")[1]), [left, top, right - left, bottom - top])
        for name, each in found.annotations.items()
        for left, top, right, bottom in each.xyxy.tolist()
    ]


@pytest.mark.slow
def test_three_tools_read_coco(images: Path, tmp_path: Path) -> None:
    tool = pytest.importorskip("pycocotools.coco", reason="pycocotools is not installed")
    sv = pytest.importorskip("supervision", reason="supervision is not installed")
    (tmp_path / "annotations").mkdir()
    path = tmp_path / "annotations" / "instances_all.json"
    registry.write(path, "coco", street())
    document = tool.COCO(str(path))
    known = expected(hidden=True, frames=CERTAIN)
    each = document.loadAnns(document.getAnnIds())
    frames = {image["id"]: image["frame"] for image in document.loadImgs(document.getImgIds())}
    assert sorted(frames.values()) == CERTAIN
    same({(frames[one["image_id"]], one["attributes"]["track_id"]): one["bbox"] for one in each},
         known)  # fmt: skip
    for one in each:  # a box has no mask, and its own area
        assert one["segmentation"] == []
        assert one["area"] == pytest.approx(one["bbox"][2] * one["bbox"][3], abs=0.5)
    labels = {one["attributes"]["track_id"]: document.cats[one["category_id"]]["name"]
              for one in each}  # fmt: skip
    assert labels == {1: "car", 2: "object", 7: "van"}
    found = sv.DetectionDataset.from_coco(str(images), str(path))
    same_places(by_supervision(found), known)
    boxes = {
        (frame, each.attributes["track_id"]): list(each.get_bbox())
        for frame, each in datumaro(tmp_path, "coco_instances")
    }
    same(boxes, known)


def test_cocos_own_tool_reads_masks() -> None:
    """Their runs and ours are the same text, and the same pixels."""
    tool = pytest.importorskip("pycocotools.mask", reason="pycocotools is not installed")
    rng = np.random.default_rng(0)
    for shape in ((1, 1), (7, 5), (48, 64), (300, 2)):
        for share in (0.0, 0.03, 0.5, 1.0):
            mask = rng.random(shape) < share
            theirs = tool.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"].decode()
            assert masks.encode(mask) == theirs
            assert (masks.decode(theirs, *shape) == mask).all()
    big = np.zeros((1080, 1920), bool)
    big[200:900, 300:1700] = True
    assert (
        masks.encode(big) == tool.encode(np.asfortranarray(big.astype(np.uint8)))["counts"].decode()
    )


def test_an_outline_is_cut_to_the_picture() -> None:
    """As counted: which points of a fine grid in the picture are in the ellipse."""
    rng = np.random.default_rng(0)
    y, x = (np.mgrid[0:600, 0:1000] + 0.5) / 10
    for _ in range(30):
        ellipse = Ellipse(*rng.uniform((-20, -20, 5, 5, 0), (120, 80, 40, 40, 4)).tolist())
        cos, sin = np.cos(ellipse.theta), np.sin(ellipse.theta)
        u = ((x - ellipse.x) * cos + (y - ellipse.y) * sin) / ellipse.a
        v = ((y - ellipse.y) * cos - (x - ellipse.x) * sin) / ellipse.b
        inside = (u**2 + v**2 <= 1).sum() / 100
        outline = clipped(ellipse.polygon(), 100, 60)
        assert area(outline) == pytest.approx(inside, rel=0.01, abs=1)
        if len(outline):
            assert (outline >= -1e-9).all()
            assert (outline <= np.add((100, 60), 1e-9)).all()


def test_datumaro_reads_cvat(tmp_path: Path) -> None:
    registry.write(tmp_path / "a.xml", "cvat", street(), 0.0)
    found = datumaro(tmp_path / "a.xml", "cvat")
    boxes = {(frame, each.attributes["track_id"]): list(each.get_bbox()) for frame, each in found}
    same(boxes, expected(hidden=True))
    hidden = {(frame, each.attributes["track_id"]) for frame, each in found
              if each.attributes["occluded"]}  # fmt: skip
    assert hidden == {(8, 7), (9, 7)}


def ultralytics(path: Path, classes: int) -> list[tuple[int, list[float]]]:
    """Return class and box (center and sizes, in shares) of a text, by the rule of their trainer.

    More than 6 columns are a polygon. Otherwise there must be 5, none beyond 0 to 1 by more than a
    hundredth; else the image is left out as corrupt.
    """
    rows = [line.split() for line in path.read_text().strip().splitlines() if line]
    assert not any(len(row) > 6 for row in rows), "read as polygons"
    found = [(int(row[0]), [float(part) for part in row[1:]]) for row in rows]
    for number, box in found:
        assert len(box) == 4, f"labels require 5 columns, {1 + len(box)} columns detected"
        assert max(box) <= 1.01, "non-normalized or out of bounds coordinates"
        assert min(box) >= -0.01, "negative coordinate"
        assert 0 <= number < classes
    return found


def trained(yaml: Any, data: Path) -> dict[Path, Path]:
    """Return the texts of the images that Ultralytics trains with, by the rule of its trainer.

    The folder is that of `data.yaml` without a `path`, which would be looked for in the current
    one. Lines that begin with "./" are beside the text in which they are. The text of an image is
    where the image is, with `labels` for the last `images`; without one there is nothing in it.
    """
    stated = yaml.safe_load(data.read_text())
    listed = (Path(stated.get("path") or data.parent) / stated["train"]).resolve()
    parent = str(listed.parent) + os.sep
    lines = listed.read_text(encoding="utf-8").strip().splitlines()
    files = [line.replace("./", parent) if line.startswith("./") else line for line in lines]
    pairs = {}
    for file in files:
        place = f"{os.sep}labels{os.sep}".join(file.rsplit(f"{os.sep}images{os.sep}", 1))
        pairs[Path(file)] = Path(place.rsplit(".", 1)[0] + ".txt")
    return pairs


def test_a_folder_of_yolo_trains_as_it_is(
    images: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With all images of the film beside the labels, also those that are left out."""
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    registry.write(tmp_path / "a.yolo", "yolo", street())
    images.rename(tmp_path / "a.yolo/images")
    monkeypatch.chdir("/")
    found = trained(yaml, tmp_path / "a.yolo/data.yaml")
    assert all(image.is_file() and text.is_file() for image, text in found.items())
    assert [*found.values()] == sorted((tmp_path / "a.yolo/labels").iterdir())
    assert [int(image.stem.removeprefix("frame_")) for image in found] == CERTAIN


@pytest.mark.parametrize(("frames", "x", "left_out"), [(6, 12.0, 0), (5, 12.0, 1), (6, 100.0, 1)])
def test_a_frame_in_which_an_object_leaves_shows_the_others(
    tmp_path: Path, frames: int, x: float, left_out: int
) -> None:
    """Who is lost far from the edge may still be there, or come back after the film's end."""
    place = Ellipse(x, 100.0, 20.0, 20.0, 0.0)
    ends = [Status.TRACKING, Status.OCCLUDED, Status.OCCLUDED, Status.OCCLUDED, Status.LOST]
    objects = [placed(frame, place, 2, 0.5, status) for frame, status in enumerate(ends)]
    objects += [placed(frame, place, 7, 0.5) for frame in range(frames)]
    recorded = Recording.of(FACTS, objects, {frame: frame / 10 for frame in range(frames)})
    assert registry.write(tmp_path / "a.json", "coco", recorded).missed == left_out
    images = json.loads((tmp_path / "a.json").read_text())["images"]
    assert len(images) == frames - left_out


@pytest.mark.slow
def test_trainers_read_yolo(images: Path, tmp_path: Path) -> None:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    sv = pytest.importorskip("supervision", reason="supervision is not installed")
    folder, labels = tmp_path / "a.yolo", tmp_path / "a.yolo/labels"
    registry.write(folder, "yolo", street())
    known = expected(frames=CERTAIN)
    names = yaml.safe_load((folder / "data.yaml").read_text())["names"]
    assert names == {0: "car", 1: "object", 2: "van"}
    boxes, classes = [], []
    assert len([*labels.glob("*.txt")]) == len(CERTAIN)
    for frame in CERTAIN:  # a frame without objects has an empty text
        for number, (x, y, width, height) in ultralytics(labels / f"frame_{frame:06d}.txt", 3):
            sides = ((x - width / 2) * WIDTH, (y - height / 2) * HEIGHT, width * WIDTH,
                     height * HEIGHT)  # fmt: skip
            boxes.append((frame, list(sides)))
            classes.append((frame, names[number]))
    same_places(boxes, known)
    usual = {(frame, who): each[0] or "object" for frame in CERTAIN
             for who, each in truth(frame).items()}  # fmt: skip
    assert sorted(classes) == sorted((frame, usual[frame, who]) for frame, who in known)
    found = sv.DetectionDataset.from_yolo(str(images), str(labels), str(folder / "data.yaml"))
    same_places(by_supervision(found), known)
    assert found.classes == ["car", "object", "van"]


def between(keys: list[tuple[int, bool, list[float]]]) -> dict[int, list[float]]:
    """Return the place in each frame from keyframes: frame, whether the object goes on, place."""
    found = {}
    for (frame, on, place), (after, _, end) in pairwise([*keys, (keys[-1][0], False, keys[-1][2])]):
        for step in range(after - frame) if on else [0]:
            share = step / (after - frame) if on and after > frame else 0
            found[frame + step] = [u + share * (v - u) for u, v in zip(place, end, strict=True)]
    found[keys[-1][0]] = keys[-1][2]
    return found


def test_a_plain_reader_of_label_studio(tmp_path: Path) -> None:
    """By its documentation: frames from 1, percent, and lines that end where `enabled` is false."""
    registry.write(tmp_path / "a.ls.json", "label-studio", street(), 0.0)
    (task,) = json.loads((tmp_path / "a.ls.json").read_text())
    found: Boxes = {}
    for region in task["predictions"][0]["result"]:
        keys = [
            (key["frame"] - 1, key["enabled"],
             [key["x"] * WIDTH / 100, key["y"] * HEIGHT / 100, key["width"] * WIDTH / 100,
              key["height"] * HEIGHT / 100])
            for key in region["value"]["sequence"]
        ]  # fmt: skip
        identity = int(region["id"].removeprefix("motes-"))
        found |= {(frame, identity): place for frame, place in between(keys).items()}
        assert region["value"]["labels"] == [{1: "car", 2: "object", 7: "van"}[identity]]
    same(found, expected())


@pytest.mark.parametrize("length", [FRAMES, 0])  # or unknown
def test_pandas_reads_points_as_movement_does(length: int, tmp_path: Path) -> None:
    """Their file is a table with titles of four rows; NaN is where an individual is absent."""
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    seen = [row for row in street() if row.frame % 2]  # as of a run with --start and --stride
    registry.write(
        tmp_path / "a.dlc.csv", "deeplabcut", replace(street(), frames=seen, length=length)
    )
    table = pandas.read_csv(tmp_path / "a.dlc.csv", header=[0, 1, 2, 3], index_col=0)
    assert table.columns.names == ["scorer", "individuals", "bodyparts", "coords"]
    assert table.index.tolist() == list(range(length or seen[-1].frame + 1))
    found: Boxes = {}
    for identity in (1, 2, 7):
        points = table["motes"][f"object_{identity}"]
        for frame in points["center"].dropna().index:
            x, y, likelihood = points["center"].loc[frame, ["x", "y", "likelihood"]]
            a = np.hypot(*(points["axis_a"].loc[frame, ["x", "y"]] - (x, y)))
            b = np.hypot(*(points["axis_b"].loc[frame, ["x", "y"]] - (x, y)))
            assert likelihood == 0.75
            # The first pixel's center is 0 here; in boxes its left side is.
            found[frame, identity] = [x + 0.5 - a, y + 0.5 - b, 2 * a, 2 * b]
    same(found, expected(cut=False, frames=range(1, FRAMES, 2)))


def test_every_format_that_is_written_is_here() -> None:
    named = {
        "csv", "jsonl", "parquet", "mot", "mot-truth", "mot-detections", "otb", "vot", "coco",
        "cvat", "yolo", "yolo-predictions", "label-studio", "deeplabcut", "keyframes",
        "masks",  # tests/cli/test_masks.py
    }  # fmt: skip
    written = {name for name, form in registry.OWN.items() if form.write is not None}
    assert named == written
