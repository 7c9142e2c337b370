"""Files of each format, as the libraries of others read them."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from crowds import from_files
from motes.formats import registry, runs
from motes.rows.reader import read_track
from motes_lab.datasets.sot import load_dataset
from recordings import FACTS, crowd, ellipse, turning


def test_cocos_own_tool_reads_masks(tmp_path: Path) -> None:
    """Their runs and ours are the same text, and the same pixels."""
    tool = pytest.importorskip("pycocotools.mask", reason="pycocotools is not installed")
    rng = np.random.default_rng(0)
    for shape in ((1, 1), (7, 5), (48, 64), (300, 2)):
        for share in (0.0, 0.03, 0.5, 1.0):
            mask = rng.random(shape) < share
            theirs = tool.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"].decode()
            assert runs.encode(mask) == theirs
            assert (runs.decode(theirs, *shape) == mask).all()
    big = np.zeros((1080, 1920), bool)
    big[200:900, 300:1700] = True
    assert (
        runs.encode(big) == tool.encode(np.asfortranarray(big.astype(np.uint8)))["counts"].decode()
    )


@pytest.mark.slow
def test_supervision_reads_yolo_and_coco(tmp_path: Path) -> None:
    sv = pytest.importorskip("supervision", reason="supervision is not installed")
    registry.write(tmp_path / "a.yolo", "yolo", crowd())
    registry.write(tmp_path / "a.json", "coco", crowd())
    (tmp_path / "images").mkdir()
    for row in crowd():
        Image.new("RGB", (320, 240)).save(tmp_path / "images" / f"frame_{row.frame:06d}.png")
    for file in (tmp_path / "a.yolo/labels").glob("*.txt"):  # supervision takes five numbers a line
        lines = file.read_text().splitlines()
        file.write_text("".join(" ".join(line.split()[:5]) + "\n" for line in lines))
    images = str(tmp_path / "images")
    yolo = sv.DetectionDataset.from_yolo(
        images, str(tmp_path / "a.yolo/labels"), str(tmp_path / "a.yolo/data.yaml")
    )
    coco = sv.DetectionDataset.from_coco(images, str(tmp_path / "a.json"))
    for found in (yolo, coco):
        assert sorted(found.classes) == ["car", "object"]
        by_name = {Path(name).stem: each for name, each in found.annotations.items()}
        np.testing.assert_allclose(
            sorted(by_name["frame_000003"].xyxy.tolist()),
            [[25, 40, 65, 64], [194, 103, 210, 151]], atol=0.01,
        )  # fmt: skip


def test_pyarrow_reads_the_columns_of_the_csv(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    for recorded in (turning(), crowd()):
        registry.write(tmp_path / "a.csv", "csv", recorded)
        registry.write(tmp_path / "a.parquet", "parquet", recorded)
        rows, table = read_track(tmp_path / "a.csv"), parquet.read_table(tmp_path / "a.parquet")
        assert tuple(table.column_names) == rows.dtype.names
        assert len(table) == len(rows)
        for name in table.column_names:
            values = ["" if value is None else value for value in table[name].to_pylist()]
            if rows[name].dtype.kind == "U":
                assert values == rows[name].tolist()
            else:
                numbers = np.array([np.nan if value == "" else value for value in values], float)
                np.testing.assert_allclose(numbers, rows[name], atol=6e-4)


def test_trackeval_reads_the_truth_of_the_motchallenge(tmp_path: Path) -> None:
    """Results against the truth: an object is hidden in five frames."""
    truth = tmp_path / "truth" / "film"
    (truth / "gt").mkdir(parents=True)
    (tmp_path / "results").mkdir()
    (truth / "seqinfo.ini").write_text("[Sequence]\nname=film\nseqLength=30\n")
    people = crowd(label=None)  # the only class that it measures
    registry.write(truth / "gt" / "gt.txt", "mot-truth", people)
    registry.write(tmp_path / "results" / "film.txt", "mot", people)
    found = from_files(tmp_path / "truth", tmp_path / "results", "film")["CLEAR"]
    assert (found["CLR_TP"], found["CLR_FN"]) == (55, 5)


@pytest.mark.parametrize(("name", "file"), [("otb", "groundtruth_rect.txt"),
                                            ("vot", "groundtruth.txt")])  # fmt: skip
def test_the_truth_of_one_object_is_that_of_a_sequence(
    name: str, file: str, tmp_path: Path
) -> None:
    folder = tmp_path / "sequence"
    (folder / "color").mkdir(parents=True)
    for frame in range(40):
        Image.new("RGB", (32, 24)).save(folder / "color" / f"{frame:08d}.png")
    registry.write(folder / file, name, turning())
    (sequence,), problems = load_dataset(tmp_path)
    assert problems == []
    np.testing.assert_allclose(sequence.boxes[7], ellipse(7).box, atol=0.01 if name == "otb" else 9)
    if name == "vot":
        np.testing.assert_allclose(sequence.ellipses[7], ellipse(7), atol=1e-3)
    assert np.isnan(sequence.boxes[20:25]).all()
    assert not np.isnan(sequence.boxes[[19, 25]]).any()


def test_a_region_of_vot_is_the_rectangle_around_the_ellipse(tmp_path: Path) -> None:
    shapely = pytest.importorskip("shapely", reason="shapely is not installed")
    registry.write(tmp_path / "groundtruth.txt", "vot", turning())
    line = (tmp_path / "groundtruth.txt").read_text().splitlines()[7]
    corners = np.reshape([float(field) for field in line.split(",")], (4, 2))
    whole, inner = shapely.Polygon(corners), shapely.Polygon(ellipse(7).polygon() + 0.5)
    assert whole.area == pytest.approx(4 * ellipse(7).a * ellipse(7).b, rel=1e-4)
    assert whole.buffer(1e-3).contains(inner)


def test_movement_reads_points(tmp_path: Path) -> None:
    poses = pytest.importorskip(
        "movement.io.load_poses",
        reason="movement is not installed: it brings another OpenCV, so try it in an environment "
        "of its own",
    )
    registry.write(tmp_path / "one.csv", "deeplabcut", turning())
    found = poses.from_dlc_file(tmp_path / "one.csv", fps=25)
    center = found.position.sel(keypoints="center").squeeze().values
    assert center.shape == (40, 2)
    np.testing.assert_allclose(center[7], ellipse(7)[:2], atol=1e-3)
    assert np.isnan(center[20:25]).all()
    registry.write(tmp_path / "two.csv", "deeplabcut", crowd())
    found = poses.from_dlc_file(tmp_path / "two.csv", fps=25)
    assert found.sizes["individuals"] == 2
    assert found.sizes["keypoints"] == 3


def test_label_studios_own_tool_takes_the_regions(tmp_path: Path) -> None:
    tool = pytest.importorskip(
        "label_studio_sdk.label_interface",
        reason="label-studio-sdk is not installed: it brings another OpenCV, so try it in an "
        "environment of its own",
    )
    registry.write(tmp_path / "a.ls.json", "label-studio", crowd())
    interface: Any = tool.LabelInterface(
        '<View><Labels name="videoLabels" toName="video"><Label value="car"/>'
        '<Label value="object"/></Labels><Video name="video" value="$video"/>'
        '<VideoRectangle name="box" toName="video"/></View>'
    )
    (task,) = json.loads((tmp_path / "a.ls.json").read_text())
    with contextlib.redirect_stdout(io.StringIO()):
        for prediction in task["predictions"]:
            assert interface.validate_prediction(prediction)


def test_sequences_of_label_studio(tmp_path: Path) -> None:
    """By its documentation: frames from 1, percent, and a line that ends where it is disabled."""
    registry.write(tmp_path / "a.ls.json", "label-studio", crowd(), 0.5)
    (task,) = json.loads((tmp_path / "a.ls.json").read_text())
    car, walker = task["predictions"][0]["result"]
    assert task["data"] == {"video": FACTS.source}
    assert car["value"]["framesCount"] == 30
    assert car["value"]["duration"] == pytest.approx(30 / 25)
    assert [each["frame"] for each in car["value"]["sequence"]] == [1, 30]
    assert car["value"]["sequence"][0]["x"] == pytest.approx(100 * 10 / 320)
    ends = [(each["frame"], each["enabled"]) for each in walker["value"]["sequence"]]
    assert ends == [(1, True), (10, False), (16, True), (30, False)]
