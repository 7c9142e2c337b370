"""Every format: written, recognized and read again, and what it cannot hold."""

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from msgspec import structs

from motes import ConfigError, Ellipse, FormatError, SourceError
from motes.core.labels import unguarded
from motes.core.track import COLUMNS, Status
from motes.formats import registry
from motes.formats.keyframes import keyframes
from motes.formats.recording import FilmFacts, Recording
from motes.formats.shapes import box_of_rectangle
from motes.formats.visibility import ANGLES, CLASSES, CONFIDENCES, HIDDEN, aspects
from motes.rows.schema import FrameRow
from recordings import FACTS, crowd, placed, turning

NAMES = {
    "csv": "a.csv", "jsonl": "a.jsonl", "parquet": "a.parquet", "mot": "a.txt",
    "mot-truth": "gt.txt", "mot-detections": "det.txt", "otb": "groundtruth_rect.txt",
    "vot": "groundtruth.txt", "coco": "a.json", "cvat": "a.xml", "yolo": "labels",
    "label-studio": "a.ls.json", "keyframes": "keyframes.csv",
}  # fmt: skip
ONE_OBJECT = sorted(set(NAMES) - {"mot-detections", "yolo"})
MANY = sorted(set(NAMES) - {"otb", "vot", "mot-detections", "yolo", "keyframes"})


def round_trip(recorded: Recording, name: str, folder: Path) -> Recording:
    path = folder / NAMES[name]
    assert registry.format_for(str(path)) == name
    registry.write(path, name, recorded, 0.0)
    assert registry.recognized(path) == name
    return registry.read(path, name, FACTS)


def boxes(recorded: Recording) -> dict[tuple[int, int], list[float]]:
    """Return the boxes of visible objects by frame and identity."""
    return {
        (row.frame, each.identity): list(each.box)
        for row in recorded
        for each in row.objects
        if each.status is Status.TRACKING
    }


def same_boxes(found: Recording, expected: Recording, tolerance: float) -> None:
    ours, theirs = boxes(found), boxes(expected)
    assert ours.keys() == theirs.keys()
    for key, box in ours.items():
        np.testing.assert_allclose(box, theirs[key], atol=tolerance)


def with_boxes_of_rectangles(recorded: Recording) -> Recording:
    """Return a recording of the rectangles around its ellipses."""
    return replace(recorded, frames=[
        structs.replace(row, objects=tuple(
            structs.replace(each, bounds=box_of_rectangle(each.ellipse)) for each in row.objects
        ))
        for row in recorded
    ])  # fmt: skip


@pytest.mark.parametrize("name", ONE_OBJECT)
def test_one_target(name: str, tmp_path: Path) -> None:
    found, expected = round_trip(turning(), name, tmp_path), turning()
    if name == "vot":  # its rectangles are turned
        expected = with_boxes_of_rectangles(expected)
    same_boxes(found, expected, 0.011)
    held = registry.FORMATS.resolve(name).holds
    before = {row.frame: row.objects for row in turning()}
    for row in found:
        there = (each for each in row.objects if each.placed)
        for each, known in zip(there, before[row.frame], strict=True):
            if ANGLES in held:
                assert each.ellipse.theta == pytest.approx(known.ellipse.theta, abs=2e-3)
                np.testing.assert_allclose(each.ellipse[:4], known.ellipse[:4], atol=0.05)
            if CONFIDENCES in held:
                assert each.confidence == pytest.approx(known.confidence, abs=1e-4)


@pytest.mark.parametrize("name", MANY)
def test_several_objects(name: str, tmp_path: Path) -> None:
    found = round_trip(crowd(), name, tmp_path)
    same_boxes(found, crowd(), 0.011)
    held, row = registry.FORMATS.resolve(name).holds, next(row for row in found if row.frame == 12)
    if CLASSES in held:
        assert row.objects[0].label == "car"
    statuses = [each.status for each in row.objects]
    assert statuses == [Status.TRACKING, *[Status.OCCLUDED] * (HIDDEN in held)]


@pytest.mark.parametrize("name", ["mot-detections", "yolo"])
def test_detections_have_no_identity(name: str, tmp_path: Path) -> None:
    found = round_trip(crowd(), name, tmp_path)
    expected = {frame: 1 + (not 10 <= frame < 15) for frame in range(30)}
    assert {row.frame: len(row.objects) for row in found} == expected
    assert {each.identity for row in found for each in row.objects} == {-1}
    for other in ("cvat", "deeplabcut", "label-studio"):
        with pytest.raises(FormatError, match="boxes without identities"):
            registry.write(tmp_path / "a.xml", other, found)
    registry.write(tmp_path / "a.json", "coco", found)
    again = aspects(registry.read(tmp_path / "a.json", "coco", FACTS))
    assert again - {"times"} <= aspects(found)


@pytest.mark.parametrize("name", ["csv", "jsonl", "parquet"])
def test_rows_keep_all_columns(name: str, tmp_path: Path) -> None:
    lines = [
        ",".join(COLUMNS),
        "0,0.000000,1,,,,,,,,,,,,,searching,,,",
        "1,0.040000,1,,6.011,16.510,9.978,7.980,"
        "10.500,20.000,5.000,4.000,0.12345,0.87654,0.99000,tracking,0.10000,99.25,",
        "2,0.080000,1,,7.011,16.510,9.978,7.980,"
        "11.500,20.000,5.000,4.000,0.12345,0.00000,,lost,0.90000,99.25,",
    ]
    (tmp_path / "rows.csv").write_text("\n".join(lines) + "\n")
    rows = registry.read(tmp_path / "rows.csv", "csv", FACTS)
    registry.write(tmp_path / "b.csv", "csv", round_trip(rows, name, tmp_path))
    assert (tmp_path / "b.csv").read_text() == (tmp_path / "rows.csv").read_text()


CLASSED = sorted(name for name in NAMES if CLASSES in registry.FORMATS.resolve(name).holds)


@pytest.mark.slow
@given(st.text(st.characters(exclude_categories=()), min_size=1, max_size=8))
@example("a\u2028b").via("a line break for some, and none for others")
@example("a\x85b").via("a line break of YAML")
@example("a\x0bb\x1f").via("no characters of XML")
@example("a\nb").via("a row of two lines")
@example("\ufffe").via("no character at all")
@example("\ud800").via("half a character")
@example(" \ufeff'\"<&]]>#: ").via("what must be quoted somewhere")
@example("=1+1").via("a formula")
@example("  ").via("no name")
@example("NA").via("a name that is a word for nothing elsewhere")
@settings(max_examples=60)
def test_a_class_of_any_characters_is_read_again_or_refused(label: str) -> None:
    """In every format, by motes and by the readers that other programs use."""
    yaml = pytest.importorskip("yaml")
    row = placed(3, Ellipse(60, 50, 9, 7), 1, 0.9, label=label)
    try:
        recorded = Recording.of(FACTS, [row])
    except ConfigError:
        with pytest.raises(ConfigError, match="rename it"):
            FrameRow(3, 0.12, (row,)).values(row)
        return
    with TemporaryDirectory() as place:
        folder = Path(place)
        for name in CLASSED:
            [found] = [each for row in round_trip(recorded, name, folder) for each in row.objects]
            fixed = name.startswith("mot")  # which has thirteen classes
            assert fixed or (found.label or "object") == label, name
        text = (folder / "a.csv").read_bytes().decode()
        [fields] = csv.DictReader(io.StringIO(text, newline=""))
        assert unguarded(fields["label"]) == label
        [line] = (folder / "a.jsonl").read_text(encoding="utf-8").splitlines()
        assert json.loads(line)["label"] == label
        tree = ElementTree.parse(folder / "a.xml")
        assert [each.get("label") for each in tree.iter("track")] == [label]
        assert yaml.safe_load((folder / "labels/data.yaml").read_text())["names"] == {0: label}


def test_what_a_format_cannot_hold() -> None:
    present = aspects(turning())
    assert registry.lost(present, "csv", "otb") == ["angles", "confidences", "times"]
    assert registry.lost(present, "csv", "parquet") == []
    assert registry.lost(aspects(crowd()), "coco", "mot") == ["hidden objects", "times"]
    assert registry.lost({"angles", "identities", "times"}, "cvat", "cvat") == ["angles"]


def test_keyframes_are_few_and_interpolation_is_near(tmp_path: Path) -> None:
    """CVAT reads the boxes that are keyframes, and interpolates each side between them."""
    for error, most in ((0.0, 35), (1.0, 14), (5.0, 8)):
        registry.write(tmp_path / "a.xml", "cvat", turning(), error)
        text = (tmp_path / "a.xml").read_text().splitlines()
        kept = [line for line in text if 'keyframe="0"' not in line]
        assert sum("<box" in line for line in kept) <= most + 1  # and the end of the first part
        (tmp_path / "b.xml").write_text("\n".join(kept))
        found = boxes(registry.read(tmp_path / "b.xml", "cvat", FACTS))
        for key, box in boxes(turning()).items():
            sides = np.array([*box[:2], box[0] + box[2], box[1] + box[3]])
            x, y, width, height = found[key]
            assert np.abs(sides - [x, y, x + width, y + height]).max() <= error + 0.006


@given(
    st.lists(st.floats(-50, 50), min_size=2, max_size=60), st.floats(0, 20), st.integers(0, 2**32)
)
def test_rows_between_keyframes_are_within_the_error(
    values: list[float], error: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    frames = np.cumsum(rng.integers(1, 4, len(values)))
    places = np.stack([values, rng.uniform(-9, 9, len(values))], axis=1)
    keys = keyframes(frames, places, rng.random(len(values)) < 0.1, error)
    assert keys[0]
    assert keys[-1]
    for column in places.T:
        between = np.interp(frames, frames[keys], column[keys])
        assert np.abs(between - column).max() <= error + 1e-9


@pytest.mark.parametrize(("error", "found"), [(0.0, [1, 1, 1]), (0.1, [1, 0, 1])])
def test_without_an_error_each_row_is_a_keyframe(error: float, found: list[int]) -> None:
    even = np.array([[0.0], [1.0], [2.0]])
    assert keyframes(np.arange(3), even, np.zeros(3, bool), error).tolist() == found


def test_a_file_of_keyframes(tmp_path: Path) -> None:
    path = tmp_path / "keyframes.csv"
    registry.write(path, "keyframes", turning(), 1.0)
    lines = path.read_text().splitlines()
    assert lines[0] == "frame,x,y,a,b,theta"
    assert {line.count(",") for line in lines[1:] if "absent" not in line} == {5}
    assert lines[1].startswith("0,60,120,20,12,0.1")
    assert "20:24,absent" in lines
    assert len(lines) < 20
    registry.write(tmp_path / "a.xml", "cvat", turning(), 2.0)
    text = (tmp_path / "a.xml").read_text()
    drawn = text.count('keyframe="1"') - text.count('outside="1"')
    registry.write(path, "keyframes", registry.read(tmp_path / "a.xml", "cvat", FACTS), 0.0)
    rows = [line for line in path.read_text().splitlines()[1:] if "absent" not in line]
    assert len(rows) == drawn  # those that the user has drawn, and no others


UPRIGHT = {
    "keyframes": "frame,x,y,a,b,theta\n0,60,50,20,12,0\n5,70,50,20,12,0\n",
    "cvat": '<annotations><track id="4" label="cup"><ellipse frame="0" cx="60.5" cy="50.5" rx="20" '
    'ry="12"/><ellipse frame="5" cx="70.5" cy="50.5" rx="20" ry="12"/></track></annotations>',
}


@pytest.mark.parametrize("form", UPRIGHT)
def test_upright_ellipses_stay_ellipses(form: str, tmp_path: Path) -> None:
    (tmp_path / "a").write_text(UPRIGHT[form])
    path = tmp_path / "keyframes.csv"
    registry.write(path, "keyframes", registry.read(tmp_path / "a", form, FACTS), 0.0)
    assert path.read_text() == UPRIGHT["keyframes"]


@pytest.mark.parametrize(
    ("file", "text", "name"),
    [
        ("groundtruth_rect.1.txt", "1,2,3,4\n", "otb"),
        ("a.vot.txt", "1 2 3 4\n", "vot"),
        ("a.txt", "1,2,3,4,5,6,7,8\n", "vot"),
        ("a.txt", "m1,2,3,4,0,12\n", "vot"),
        ("a.txt", "1,1,2,3,4,5,1,1,1\n", "mot-truth"),
        ("a.txt", "1,-1,2,3,4,5,0.9,-1,-1,-1\n", "mot-detections"),
        ("a.txt", "1,4,2,3,4,5,0.9,-1,-1,-1\n", "mot"),
        ("a.txt", "1.0e+00 4.0e+00 2.0e+00 3e0 4e0 5e0 1e0 -1 -1 -1\n", "mot"),
        ("a.txt", "1.0e+00 -1.0e+00 2e0 3e0 4e0 5e0 1e0 -1 -1 -1\n", "mot-detections"),
        ("gt.txt", "1,4,2,3,4,5,1,1\n", "mot-truth"),
        ("det.txt", "1,-1,2,3,4,5,0.9,-1\n", "mot-detections"),
        ("a.txt", "0 0.5 0.5 0.1 0.1\n", None),
        ("a.txt", "hello, world; what is this\n", None),
        ("a.csv", '"frame","time","id"\n', "csv"),
        ("a.csv", '"frame","x","y","width","height"\n', "keyframes"),
        ("a.jsonl", '{"time": 0.0, "frame": 0}\n', "jsonl"),
        ("a.json", '{"images": [{"frame": 0}]}', "coco"),
        ("a.json", '{"info": {"shapes": "boxes"}, "images": []}', "coco"),
        ("a.csv", "frame,x,y,width,height\n", "keyframes"),
        ("a.csv", "frame,x,y,a,b,theta\n", "keyframes"),
        ("a.csv", "frame,left,top,width,height\n", "csv"),
        ("a.csv", "id,frame,left,top,width,height,status\n", "csv"),
        ("a.csv", "frame,id,x,y,a,b,theta\n", "csv"),
        ("a.csv", "film,frame,region\n", "keyframes"),
        ("a.csv", "7,absent\n", "keyframes"),
        ("a.csv", "frame,color\n", None),
    ],
)
def test_recognition(file: str, text: str, name: str | None, tmp_path: Path) -> None:
    path = tmp_path / file
    path.write_text(text)
    if name is not None:
        assert registry.recognized(path) == name
        return
    with pytest.raises(SourceError, match="is not clear; name it: csv, jsonl"):
        registry.recognized(path)


def test_spaces_behind_commas_belong_to_no_title_or_value(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        'frame, left, top, width, height, status, label\n3, 20, 21, 8, 9, occluded, "car, red"\n'
    )
    (row,) = registry.read(path, registry.recognized(path), FilmFacts())
    (each,) = row.objects
    assert (row.frame, each.box, each.label) == (3, (20, 21, 8, 9), "car, red")
    assert each.status is Status.OCCLUDED


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1,2,3,4\n", "--from otb if that is 1"),
        ("31,5;61,5;40,0;40,0\n", "separated in two ways"),
        ("31,5 61,5 40,0 40,0\n", "separated in two ways"),
        ("1;1;31,5;61,5;40,0;40,0;1\n", "separated in two ways"),
        ("frame;id;x\n", "its columns are separated by ';'"),
        ('"frame"\t"id"\t"x"\n', r"its columns are separated by '\\t'"),
        (
            '[{"image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5}]',
            "results of COCO",
        ),
        ('[{"video_id": 1, "score": 0.5, "segmentations": [null]}]', "results of COCO"),
        ("\ufeffframe,time\n".encode("utf-16-le"), "UTF-16; save it as UTF-8"),
    ],
)
def test_what_is_no_file_of_ours_is_refused_in_one_line(
    text: str | bytes, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(SourceError, match=said):
        registry.recognized(path)


@pytest.mark.parametrize(
    ("marks", "first", "present"),
    [
        ({"full_occlusion.txt": "0,1,0", "out_of_view.txt": "0,0,1\n"}, 1, [0]),
        ({"absence.label": "0\n0\n1\n", "meta_info.ini": ""}, 1, [0, 1]),
        ({"sequence": ""}, 0, [0, 1]),
    ],
)
def test_a_truth_is_of_the_dataset_whose_files_lie_beside_it(
    marks: dict[str, str], first: int, present: list[int], tmp_path: Path
) -> None:
    """First pixel and absent frames are those of LaSOT, GOT-10k or VOT."""
    path = tmp_path / "groundtruth.txt"
    absent = "1,1,-1,-1" if "full_occlusion.txt" in marks else "0,0,0,0"
    path.write_text(f"11,21,30,40\n12,21,30,40\n{absent}\n")
    for name, text in marks.items():
        (tmp_path / name).write_text(text)
    found = registry.read(path, registry.recognized(path), FACTS)
    assert [row.frame for row in found if row.objects] == present
    assert [*found.frames[0].objects[0].box] == [11 - first, 21 - first, 30, 40]
    if marks and first:
        (tmp_path / next(iter(marks))).write_text("0\n1\n")
        with pytest.raises(SourceError, match="is for 2 frames, not 3"):
            registry.read(path, registry.recognized(path), FACTS)


@pytest.mark.parametrize(
    ("names", "classes"),
    [
        (None, {0: "car", 1: "class 27", 2: None}),
        ("dog\ncat\nperson\n" + "\n" * 23 + "owl\n", {0: "person", 1: "owl", 2: None}),
        ("dog\n", "class 3 is none of the 1 of labels.txt"),
    ],
)
def test_identities_from_0_and_names_of_classes_beside_the_truth(
    names: str | None, classes: dict[int, str | None] | str, tmp_path: Path
) -> None:
    path = tmp_path / "gt.txt"
    path.write_text("1,0,5,6,20,30,1,3,1\n1,1,5,6,20,30,1,27,1\n1,2,5,6,20,30,1,-1,-1\n")
    if names is not None:
        (tmp_path / "labels.txt").write_text(names)
    if isinstance(classes, str):
        with pytest.raises(SourceError, match=classes):
            registry.read(path, "mot-truth", FACTS)
        return
    found = registry.read(path, "mot-truth", FACTS)
    assert {each.identity: each.label for each in found.frames[0].objects} == classes
    assert ["first pixel is read as 1" in note for note in found.notes] == [True] * bool(names)
    again = round_trip(found, "coco", tmp_path)
    assert {each.identity for each in again.frames[0].objects} == {0, 1, 2}


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ('"frame","id","left","top","width","height","label"\r\n'
         '1e+05,1.0,1,2,30,4e1,"a, b"\r\n', [100_000]),
        ("\ufeffframe,id,left,top,width,height,label\n7.0,1,1,2,30,40,\"a, b\"\n", [7]),
        ('{"id": 1.0, "frame": 7.0, "left": 1, "top": 2, "width": 30, "height": 4e1, '
         '"label": "a, b"}\n', [7]),
        ("frame,id,left,top,width,height\n7,car 1,1,2,30,40\n", "'car 1' is not a number"),
        ("frame,id,left,top,width,height\n7,1.5,1,2,30,40\n", "'1.5' is no whole number"),
        ("frame,id,left,top,width,height\n7,1,NA,2,30,40\n", "'NA' is not a number"),
        ("frame,id,left,top,width,height\n7,1,\"1,5\",2,30,40\n", "'1,5' is not a number"),
    ],
)  # fmt: skip
def test_rows_of_r_and_pandas_are_read_or_refused(
    text: str, frames: list[int] | str, tmp_path: Path
) -> None:
    path = tmp_path / ("a.jsonl" if text.startswith("{") else "a.csv")
    path.write_bytes(text.encode())
    if isinstance(frames, str):
        with pytest.raises(SourceError, match=frames):
            registry.read(path, registry.recognized(path), FACTS)
        return
    found = registry.read(path, registry.recognized(path), replace(FACTS, frames=None))
    [row] = [row for row in found if row.objects]
    assert [row.frame] == frames
    assert (row.objects[0].identity, row.objects[0].label) == (1, "a, b")


@pytest.mark.parametrize(
    ("source", "names", "frames"),
    [
        ("street.mp4", ("street_1", "street_12"), [0, 11]),
        ("street.mp4", ("street_0", "street_1"), [0, 1]),
        ("street.mp4", ("street_01", "frame_000012", "img-13"), [1, 12, 13]),
        ("frame.mp4", ("frame_100000", "frame_100001"), [100_000, 100_001]),
        ("n.mp4", ("cam-10-00-01_0001a", "cam-10-00-02_0002a"), [1, 2]),  # times, of one film
        ("n.mp4", ("street_12_jpg.rf.4f3e2a19b",), [12]),  # the hash behind it is no number
    ],
)
def test_labels_of_ultralytics_count_from_one(
    source: str, names: tuple[str, ...], frames: list[int], tmp_path: Path
) -> None:
    for name in names:
        (tmp_path / f"{name}.txt").write_text("0 0.5 0.5 0.1 0.1\n")
    facts = FilmFacts(source=source, width=320, height=240)
    assert [row.frame for row in registry.read(tmp_path, "yolo", facts)] == frames


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        (("0.9", "1", "0"), [(-1, 0.9), (-1, 1), (-1, 0)]),
        (("1", "12", ""), [(1, 1), (12, 1), (-1, 1)]),
        (("1", "1", ""), [(1, 1), (1, 1), (-1, 1)]),
        (("0", "1", "1"), [(0, 1), (1, 1), (1, 1)]),
        (("0", "0", "0"), [(-1, 0), (-1, 0), (-1, 0)]),
        (("1.0", "1.0", "1.0"), [(-1, 1), (-1, 1), (-1, 1)]),
        (("0.5 1", "0.25 12", "0.75"), [(1, 0.5), (12, 0.25), (-1, 0.75)]),
    ],
)
def test_a_sixth_number_of_yolo_is_an_identity_where_all_are_whole(
    lines: tuple[str, ...], found: list[tuple[int, float]], tmp_path: Path
) -> None:
    for frame, line in enumerate(lines):
        (tmp_path / f"{frame}.txt").write_text(f"0 0.5 0.5 0.1 0.1 {line}\n")
    recorded = registry.read(tmp_path, "yolo", FilmFacts(width=320, height=240))
    assert [(each.identity, each.confidence) for row in recorded for each in row.objects] == found
    taken = "identities" if found[0][0] >= 0 else "confidences"
    said = [f"the sixth numbers of its lines, 0 or 1, are read as {taken}."]
    assert [*recorded.notes] == said * ({*lines} <= {"0", "1", ""})


def test_a_sixth_number_that_a_frame_has_twice_is_a_confidence(tmp_path: Path) -> None:
    (tmp_path / "3.txt").write_text("0 0.5 0.5 0.1 0.1 1\n0 0.2 0.2 0.1 0.1 1\n")
    (row,) = registry.read(tmp_path, "yolo", FilmFacts(width=320, height=240))
    assert [each.identity for each in row.objects] == [-1, -1]


CVAT_BOX = '<box frame="{}" xtl="1" ytl="1" xbr="9" ybr="9" outside="0"/>'
CVAT = (
    "<annotations><meta><task><size>{}</size></task></meta><track id='0'>{}</track></annotations>"
)
LABELED = {"x": 1, "y": 1, "width": 9, "height": 9, "rotation": 0, "enabled": True, "time": 0}


@pytest.mark.parametrize(("stated", "known"), [(7, None), (None, 7), (9, 7), (7, 9)])
def test_a_region_that_is_not_switched_off_stays(
    stated: int | None, known: int | None, tmp_path: Path
) -> None:
    value = {"sequence": [{"frame": 3, **LABELED}], "framesCount": stated}
    region = {"type": "videorectangle", "value": value}
    path = tmp_path / "a.ls.json"
    path.write_text(json.dumps([{"annotations": [{"result": [region]}]}]))
    found = registry.read(path, "label-studio", FilmFacts(width=320, height=240, frames=known))
    assert [row.frame for row in found if row.objects] == [2, 3, 4, 5, 6]
    assert [row.objects[0].keyframe for row in found if row.objects] == [True, *[False] * 4]
    assert len({row.objects[0].ellipse for row in found if row.objects}) == 1


@pytest.mark.parametrize(("stated", "known"), [(7, None), (None, 7), (9, 7), (7, 9)])
@pytest.mark.parametrize(("step", "frames"), [(1, [2, 3, 4, 5, 6]), (2, [2, 4, 6])])
def test_a_track_that_is_not_outside_stays(
    stated: int | None, known: int | None, step: int, frames: list[int], tmp_path: Path
) -> None:
    size = "" if stated is None else -(-stated // step)
    boxes = CVAT_BOX.format(2), CVAT_BOX.format(0) + CVAT_BOX.format(1).replace('"0"/', '"1"/')
    text = CVAT.format(size, boxes[0] + f"</track><track id='1'>{boxes[1]}")
    path = tmp_path / "a.xml"
    path.write_text(text.replace("</size>", f"</size><frame_filter>step={step}</frame_filter>"))
    found = registry.read(path, "cvat", FilmFacts(width=320, height=240, frames=known))
    here = [(row.frame, each) for row in found for each in row.objects if each.identity == 0]
    assert [frame for frame, _ in here] == frames
    assert [each.keyframe for _, each in here] == [True, *[False] * (len(frames) - 1)]
    assert len({each.ellipse for _, each in here}) == 1
    assert [row.frame for row in found for each in row.objects if each.identity == 1] == [0]


@pytest.mark.parametrize(
    ("names", "identities"),
    [(("motes-5", "motes-2"), [5, 2]), (("motes-5", "x7"), [1, 2]), ((None, None), [1, 2])],
)
def test_regions_that_motes_has_named_keep_their_numbers(
    names: tuple[str | None, ...], identities: list[int], tmp_path: Path
) -> None:
    value = {"sequence": [{"frame": 1, **LABELED}], "framesCount": 1}
    result = [{"type": "videorectangle", "value": value, "id": name} for name in names]
    path = tmp_path / "a.ls.json"
    path.write_text(json.dumps([{"annotations": [{"result": result}]}]))
    (row,) = registry.read(path, "label-studio", FilmFacts(width=320, height=240))
    assert [each.identity for each in row.objects] == identities


@pytest.mark.parametrize("fps", [None, 30_000 / 1001])
@pytest.mark.parametrize("begin", [0.0, 3.5])
def test_times_between_keyframes_are_those_of_the_film(
    begin: float, fps: float | None, tmp_path: Path
) -> None:
    """Also of the frames after the last one, where the object stays."""
    times = [begin + frame * 1001 / 30_000 for frame in range(12)]
    keys = [{"frame": i + 1, **LABELED, "time": round(times[i], 6)} for i in (2, 6, 9)]
    region = {"type": "videorectangle", "value": {"sequence": keys, "framesCount": 12}}
    path = tmp_path / "a.ls.json"
    path.write_text(json.dumps([{"annotations": [{"result": [region]}]}]))
    found = registry.read(path, "label-studio", FilmFacts(width=320, height=240, fps=fps))
    assert [row.frame for row in found] == [*range(2, 12)]
    assert [row.time for row in found] == pytest.approx(times[2:], abs=2e-6)
    assert not found.assumed


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("cvat", CVAT.format(9, CVAT_BOX.format(0) + CVAT_BOX.format(4_000_000_000))),
        ("cvat", CVAT.format(9, CVAT_BOX.format(0) + CVAT_BOX.format(2_000_000))),
        ("cvat", CVAT.format(4_000_000_000, CVAT_BOX.format(0))),
        ("label-studio", [{"frame": 1, **LABELED}, {"frame": 2_000_000_000, **LABELED}]),
    ],
)
def test_gaps_without_end_are_not_filled(
    name: str, text: str | list[dict[str, Any]], tmp_path: Path
) -> None:
    if not isinstance(text, str):
        region = {"type": "videorectangle", "value": {"sequence": text}}
        text = json.dumps([{"annotations": [{"result": [region]}]}])
    path = tmp_path / NAMES[name]
    path.write_text(text)
    facts = FilmFacts(source="film", width=FACTS.width, height=FACTS.height)
    with pytest.raises(SourceError, match=r"no film has|neighboring keyframes of a film"):
        registry.read(path, name, facts)
