"""Damaged and wrong files of every format: one line with the place, and no silent wrong result."""

import math
import re
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest

from motes import Ellipse, Track
from motes.cli.track_options import KeyframeOptions
from motes.core.errors import ConfigError, InputError, SourceError
from motes.formats import registry
from motes.formats.recording import FilmFacts
from motes.formats.registry import FORMATS
from motes.rows.schema import FrameRow, Header
from motes.rows.writer import JournalWriter
from recordings import placed


class Sample(NamedTuple):
    """A sound file of two frames with an object that moves; of YOLO, the second of two files."""

    text: str
    record: str
    """The text of the second object, as far as it may be there twice."""
    place: str
    """Pattern of the place of the second object in messages."""
    x: str = "12.5"
    width: str = "40.5"
    frame: str = ""
    """The text in which its frame is the first number; likewise that of its identity."""
    identity: str = ""


TRACK = "frame,time,x,y,a,b,theta,confidence,status,distance,effective_sample_size\n"
TRACK_ROW = "1,0.04,12.5,40.0,40.5,9.0,0.1,0.9,tracking,0.1,99.0\n"
JSON_ROW = (
    '{"frame": 1, "time": 0.04, "x": 12.5, "y": 40.0, "a": 40.5, "b": 9.0, "theta": 0.1, '
    '"confidence": 0.9, "status": "tracking", "distance": 0.1, "effective_sample_size": 99.0}\n'
)
COCO_BOX = '{"id": 2, "image_id": 2, "category_id": 1, "bbox": [12.5, 40, 40.5, 24]}'
CVAT_BOX = (
    '<box frame="1" outside="0" occluded="0" xtl="12.5" ytl="40" xbr="53.5" ybr="64" keyframe="1"/>'
)
KEY = '{"frame": 2, "x": 12.5, "y": 40, "width": 40.5, "height": 24}'
SAMPLES = {
    "csv": Sample(
        TRACK + TRACK_ROW.replace("1,0.04,12.5", "0,0.0,10.0") + TRACK_ROW, TRACK_ROW, "row 2",
        frame="1,0.04",
    ),
    "jsonl": Sample(
        JSON_ROW.replace('"frame": 1', '"frame": 0').replace("12.5", "10.0") + JSON_ROW, JSON_ROW,
        "(row|line) 2", frame='"frame": 1',
    ),
    "mot": Sample(
        "1,7,10,40,40,24,0.9,1,1,-1\n2,7,12.5,40,40.5,24,0.9,1,1,-1\n",
        "2,7,12.5,40,40.5,24,0.9,1,1,-1\n", "line 2", frame="2,7,", identity="7,12",
    ),
    "mot-truth": Sample(
        "1,7,10,40,40,24,1,1,1\n2,7,12.5,40,40.5,24,1,1,1\n", "2,7,12.5,40,40.5,24,1,1,1\n",
        "line 2", frame="2,7,", identity="7,12",
    ),
    "mot-detections": Sample(
        "1,-1,10,40,40,24,0.9,-1,-1,-1\n2,-1,12.5,40,40.5,24,0.9,-1,-1,-1\n", "", "line 2",
        frame="2,-1,",
    ),
    "otb": Sample("10,40,40,24\n12.5,40,40.5,24\n", "", "line 2"),
    "vot": Sample("10,40,40,24\n12.5,40,40.5,24\n", "", "line 2"),
    "coco": Sample(
        '{"images": [{"id": 1, "width": 320, "height": 240, "frame": 0}, '
        '{"id": 2, "width": 320, "height": 240, "frame": 1}], '
        '"categories": [{"id": 1, "name": "car"}], "annotations": ['
        + COCO_BOX.replace('"id": 2', '"id": 1').replace('image_id": 2', 'image_id": 1')
        + ", " + COCO_BOX + "]}",
        COCO_BOX, r"annotations\[1\]",
    ),
    "cvat": Sample(
        "<annotations><meta><task><size>2</size></task></meta><track id='0' label='car'>"
        + CVAT_BOX.replace('frame="1"', 'frame="0"').replace("12.5", "10") + CVAT_BOX
        + "</track></annotations>",
        CVAT_BOX, "track 0: box of frame 1", width="53.5", frame='frame="1"', identity="id='0'",
    ),
    "yolo": Sample(
        "0 12.5 0.2 40.5 0.1 0.9 7\n".replace("12.5", "0.125").replace("40.5", "0.405"),
        "0 0.125 0.2 0.405 0.1 0.9 7\n", "frame_000001.txt, line 1", x="0.125", width="0.405",
        identity=" 7\n",
    ),
    "label-studio": Sample(
        '[{"annotations": [{"result": [{"type": "videorectangle", "value": {"labels": ["car"], '
        '"framesCount": 2, "sequence": ['
        + KEY.replace("2", "1", 1).replace("12.5", "10") + ", " + KEY + "]}}]}]}]",
        KEY, "region 1: keyframe of frame 2", frame='"frame": 2',
    ),
    "keyframes": Sample(
        "frame,x,y,width,height\n0,10,40,40,24\n1,12.5,40,40.5,24\n", "", "(row 3|frame 1)",
        frame="1,12.5",
    ),
}  # fmt: skip

READERS = ("csv", "mot", "otb", "yolo", "keyframes", "coco", "jsonl", "label-studio", "cvat")
"""One format for each way of reading: other texts of the MOTChallenge are as mot, vot as otb."""
DECODED = ("csv", "mot", "coco", "cvat")
"""Characters are decoded in one place for all texts, and in one for all documents of JSON."""
FACTS = FilmFacts(width=320, height=240, frames=100, fps=25)


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def written(name: str, content: bytes) -> Path:
    """Write the file of a sample; that of YOLO is in a folder with a sound one."""
    if name != "yolo":
        path = Path("a" + FORMATS.resolve(name).endings[0])
        path.write_bytes(content)
        return path
    Path("labels").mkdir(exist_ok=True)
    Path("labels/frame_000000.txt").write_text("0 0.1 0.2 0.4 0.1 0.9 7\n")
    Path("labels/frame_000001.txt").write_bytes(content)
    return Path("labels")


def read(name: str, text: str) -> list[FrameRow]:
    return list(registry.read(written(name, text.encode()), name, FACTS))


def objects(name: str, text: str) -> list[Track]:
    return [each for row in read(name, text) for each in row.objects]


def check_refused(path: Path, name: str, place: str = "") -> None:
    """Check that a file is refused, with one line that names it, the place, and what to do."""
    with pytest.raises((SourceError, ConfigError)) as caught:
        list(registry.read(path, name, FACTS))
    said = str(caught.value)
    assert "\n" not in said
    assert str(path) in said
    assert ";" in said
    assert re.search(place, said), said


def refuse(name: str, text: str, place: str = "") -> None:
    check_refused(written(name, text.encode()), name, place)


@pytest.mark.parametrize("name", SAMPLES)
def test_the_samples_are_sound(name: str) -> None:
    assert [row.frame for row in read(name, SAMPLES[name].text)] == [0, 1]


def _cut(data: bytes) -> bytes:
    """Return the text up to the middle of its last width."""
    width = re.search(rb"(?s).*(40|53|405?)(?=[.\" ])", data)
    assert width
    return data[: width.end() - 1]


OWN: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda data: b"",
    "cut": _cut,
    "half": lambda data: data[: len(data) // 2 + 3],
    "list": lambda data: b'[[1, 2], {"frame": null}]',
}
"""What each reader finds by itself."""
WHOLE: dict[str, Callable[[bytes], bytes]] = {
    **OWN,
    "blank": lambda data: b"\x00" * 300,
    "rubbish": lambda data: Random(3).randbytes(2000),
    "latin-1": lambda data: data + "\näöü".encode("latin-1"),
    "utf-16": lambda data: data.decode().encode("utf-16"),
    "other": lambda data: b"Dear all,\nplease find the boxes attached.\n",
    "html": lambda data: b"<!DOCTYPE html><html><body>404</body></html>",
    "nested": lambda data: b'{"a": ' * 3000,
}


@pytest.mark.parametrize("name", READERS)
def test_the_last_record_is_cut_off(name: str) -> None:
    """Beside each of its signs, and anywhere inside of its last number."""
    text = SAMPLES[name].text
    last = SAMPLES[name].record or text.splitlines(keepends=True)[-1]
    start = text.rindex(last) + (name != "yolo")  # whose text is empty without it
    last_number = max(text.rfind(digit) for digit in "0123456789") - 6
    for end in range(start + (name == "yolo"), len(text)):
        if text[end - 1 : end + 1].isalnum() and end < last_number:
            continue  # as the cut beside it
        if text[end:].strip() or name not in ("coco", "cvat", "label-studio", "jsonl"):
            refuse(name, text[:end])


@pytest.mark.parametrize("name", READERS)
def test_the_whole_file_is_wrong(name: str) -> None:
    for damage in WHOLE if name in DECODED else OWN:
        if (name, damage) == ("yolo", "empty"):  # a frame without objects has an empty text
            continue
        check_refused(written(name, WHOLE[damage](SAMPLES[name].text.encode())), name)


@pytest.mark.parametrize("damage", ["empty", "rubbish", "other", "html", "list"])
def test_what_is_of_no_format_is_not_recognized(damage: str) -> None:
    path = written("csv", WHOLE[damage](b""))
    with pytest.raises(SourceError, match=r"a\.csv"):
        list(registry.read(path, registry.recognized(path), FACTS))


def test_a_folder_in_place_of_a_file() -> None:
    Path("a.csv").mkdir()
    check_refused(Path("a.csv"), "csv", "a folder")
    Path("labels").write_text("0 1 2 3 4\n")
    check_refused(Path("labels"), "yolo", "a folder")


def spoiled(name: str) -> Iterator[tuple[str, str]]:
    """Yield texts of a format in which one value is wrong, each with what is said of its place."""
    sample = SAMPLES[name]

    def with_last(old: str, new: str) -> str:
        before, _, after = sample.text.rpartition(old)
        return before + new + after

    for number in (sample.x, sample.width):
        for value in ("nan", "1e300", "1e999", "abc", ""):
            yield with_last(number, value), "" if "{" in sample.text else sample.place
    if name != "otb":  # where a target without area is one that is not seen
        no_width = sample.x if name == "cvat" else "0"  # CVAT has right sides
        yield with_last(sample.width, no_width), sample.place
    yield with_last(sample.width, sample.x if name == "cvat" else "-7.5"), sample.place
    for part, values in (
        (sample.frame, ("-3", "1.5", "99999999999", "x")),
        (sample.identity, ("1.5", "x")),
    ):
        for value in values if part else ():
            yield with_last(part, re.sub(r"\d+", value, part, count=1)), ""
    if sample.record:
        between = ", " if "{" in sample.record and name != "jsonl" else ""
        yield with_last(sample.record, sample.record + between + sample.record), ""


@pytest.mark.parametrize("name", READERS)
def test_a_value_is_wrong(name: str) -> None:
    """A number of the box, the frame, or the identity; or an object is there twice."""
    for text, place in spoiled(name):
        refuse(name, text, place)


@pytest.mark.parametrize("name", ["csv", "jsonl", "mot", "cvat", "label-studio"])
def test_records_in_another_order_are_the_same(name: str) -> None:
    sample = SAMPLES[name]
    before, record, after = sample.text.rpartition(sample.record)
    comma = ", " if name == "label-studio" else ""
    before = before.removesuffix(comma)
    cut = {
        "csv": len(TRACK), "jsonl": 0, "mot": 0, "cvat": before.find("<box"),
        "label-studio": before.find('{"frame'),
    }[name]  # fmt: skip
    text = before[:cut] + record + comma + before[cut:] + after
    assert [*map(str, read(name, text))] == [*map(str, read(name, sample.text))]


@pytest.mark.parametrize("name", ["csv", "mot", "otb", "coco", "cvat", "keyframes"])
def test_a_box_outside_of_the_picture_stays_there(name: str) -> None:
    sample = SAMPLES[name]
    inside = objects(name, sample.text)[-1].ellipse.x
    record = sample.record or sample.text.splitlines()[-1]
    moved = record.replace("53.5", "-39.0").replace("53.0", "-39.5").replace("12.5", "-80")
    before, _, after = sample.text.rpartition(record)
    found = objects(name, before + moved + after)[-1]
    assert found.ellipse.x == pytest.approx(inside - 92.5)


WRONG = [
    ("csv", TRACK, TRACK.replace("x,y", "east,north"), "rows have no column east, north"),
    ("csv", ",theta,", ",width,", "it has no (theta|height)"),
    ("csv", "0.9,tracking,0.1,99.0\n", "0.9,followed,0.1,99.0\n", "row .: status is 'followed'"),
    ("csv", "1,0.04,12.5,40.0", "1,,12.5,40.0", "row 2: it has no time"),
    ("csv", "1,0.04,12.5,40.0", "1,0.04,,", "row 2: it has no x"),
    ("csv", TRACK_ROW, TRACK_ROW.replace(",99.0", ""), "row 2 has 10 fields instead of 11"),
    ("csv", TRACK_ROW, TRACK_ROW.replace("0.9,", ","), "row 2: it has no confidence"),
    ("csv", TRACK_ROW, TRACK_ROW.replace("0.9,", "87,"), "row 2: confidence is 87; it is a prob"),
    ("jsonl", '"confidence": 0.9', '"confidence": -0.5', "row 1: confidence is -0.5; it is a prob"),
    ("jsonl", '"y": 40.0, "a": 40.5', '"a": 40.5', "it has no y"),
    ("jsonl", '"x": 12.5', '"x": null', "row 2: it has no x"),
    ("mot", "2,7,12.5,40,40.5,24,0.9,1,1,-1", "2,7,12.5,40,40.5,24", "line 2: 6 fields, and"),
    ("mot-truth", "24,1,1,1\n", "24,1,0,1\n", "line 1: 0 is not a class"),
    ("mot-truth", "24,1,1,1\n", "24,1,1,7\n", "line 1: the visibility 7 is no share"),
    ("mot", "1,7,10", "1,-2,10", "-2 is no identity"),
    ("mot", "1,7,10", "0,7,10", "line 1: there is no frame 0: frames count from 1"),
    ("mot", "2,7,12.5,40", "2;7;12,5;40", "line 2: its numbers are separated in two ways"),
    ("otb", "10,40,40,24\n", "10,0;40,0;40,0;24,0\n", "line 1: its numbers are separated in two"),
    ("otb", "10,40,40,24\n", "10,0 40,0 40,0 24,0\n", "line 1: its numbers are separated in two"),
    ("otb", "10,40,40,24\n", "10,0,40,0,40,8,9,24\n", "more than the four numbers of a box"),
    ("csv", "9.0,0.1,0.9", "9.0,40,0.9", "row .: theta begins with 40; it is in radians"),
    ("csv", "frame,time", ",frame", "its first column has no title"),
    ("keyframes", "frame,x,y,width,height\n0,10,40,40,24\n1,12.5,40,40.5,24\n",
     "1,1,31,61,40,40\n", "row 1: theta begins with 40; if the numbers are frame,id,x,y"),
    ("keyframes", "frame,x,y,width,height\n0,10,40,40,24\n1,12.5,40,40.5,24\n",
     "1,1,31,61,9,5\n2,1,32,61,9,5\n", "row 1: theta begins with 5; if the numbers are fr"),
    ("keyframes", "frame,x,y,width,height\n0,10,40,40,24\n1,12.5,40,40.5,24\n",
     "1,1,31,61,3,3\n", "row 1: theta begins with 3; if the numbers are frame,id,x,y"),
    ("otb", "12.5,40,40.5,24", "12.5,40,40.5", "line 2: a row has 4 numbers"),
    ("coco", '"annotations"', '"boxes"', "missing required field"),
    ("coco", '"image_id": 2', '"image_id": 9', r"annotations\[1\]: its image 9 is missing"),
    ("coco", '"image_id": 2, ', "", r"missing required field `image_id` - at `\$.annotations\[1\]"),
    ("coco", '[{"id": 1, "width"', '[{"id": 2, "width"', r"images\[1\]: 2 is already in images\[0"),
    ("coco", '"frame": 1', '"frame": 0', r"images\[1\]: 0 is already"),
    ("coco", '2, "category_id": 1', '2, "category_id": 4', r"annotations\[1\]: its category 4"),
    ("coco", '"id": 2, "image_id"', '"id": 1, "image_id"', r"annotations\[1\]: 1 is already"),
    ("coco", "[12.5, 40, 40.5, 24]", "[12.5, 40, 40.5]", r"annotations\[0\].bbox"),
    ("coco", "40.5, 24]}]", '40.5, 24], "score": 1.01}]',
     r"annotations\[1\]: confidence is 1.01; it is a probability, 0 to 1"),
    ("coco", ', "bbox": [12.5, 40, 40.5, 24]}]', "}]",
     r"annotations\[1\]: it has neither bbox nor polygon"),
    ("coco", '"bbox": [12.5, 40, 40.5, 24]}]', '"segmentation": [[1, 2, 3]]}]',
     r"annotations\[1\]: "),
    ("coco", '"bbox": [12.5, 40, 40.5, 24]}]', '"segmentation": [["a", 2]]}]',
     r"annotations\[1\]: "),
    ("coco", '40.5, 24]}]', '40.5, 24], "segmentation": {"counts": [4], "size": [240, 320]}}]',
     r"annotations\[1\]: a mask's runs do not fill"),
    ("coco", '40.5, 24]}]', '40.5, 24], "segmentation": {"counts": [4], "size": 2}}]',
     r"annotations\[1\]: "),
    ("coco", '40.5, 24]}]', '40.5, 24], "segmentation": {"counts": [99999999999999999], '
     '"size": [1, 99999999999999999]}}]', r"annotations\[1\]: "),
    ("coco", '40.5, 24]}]', '40.5, 24], "segmentation": [["a", "b", "c", "d", "e", "f", "g", "h", '
     '1, 2, 3, 4, 5, 6, 7, 8]]}]', r"annotations\[1\]: "),
    ("cvat", "annotations>", "labels>", "it has no annotations of CVAT"),
    ("cvat", "track", "path", "a shape that is in no track"),
    ("cvat", ' xtl="12.5"', "", "box of frame 1: it has no xtl"),
    ("cvat", 'frame="1" ', "", "track 0: it has no frame"),
    ("cvat", 'outside="0"', 'outside="maybe"', "outside is 'maybe', neither 0 nor 1"),
    ("cvat", "</track>", "</track><track id='0'></track>", "track 0: its id is"),
    ("cvat", "</track>", "</track><image name='a.png'/>", "image a.png: it has no id"),
    ("cvat", "</track>", "</track><image id='1'/><image id='1'/>", "image 1: its id is that of"),
    ("yolo", "0 0.125", "0 0.125 0.3 0.4 0.5", "line 1: 10 numbers"),
    ("yolo", "0 0.125", "car 0.125", "line 1: 'car' is not a number"),
    ("yolo", "0.125", "125", "line 1: the center 125, 0.2 is not a share"),
    ("yolo", " 0.9 7", " 1.5", "line 1: confidence is 1.5; it is a probability, 0 to 1"),
    ("label-studio", '"sequence"', '"keys"', "region 1: it has no sequence"),
    ("label-studio", '"y": 40, "width": 40.5', '"width": 40.5', "missing required field `y`"),
    ("label-studio", '"annotations"', '"results"', "and no prediction; submit one"),
    ("label-studio", "]}}]}]}]", "]}}]}]}, {}]", "it has 2 tasks"),
    ("label-studio", '"frame": 1', '"frame": 0', "frame 0: Label Studio's frames count"),
    ("keyframes", "x,y,width,height", "y,x,width,height", "row 1: the columns are frame, y, x"),
    ("keyframes", "1,12.5,40,40.5,24", "1,12.5,40,40.5", "row 3: A region has 4 numbers"),
    ("keyframes", "1,12.5,40", "0,12.5,40", "frame 0 contradict each other"),
    ("keyframes", "1,12.5,40,40.5,24", "9:4,absent", "row 3: The frames 9:4 are no range"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "old", "new", "message"), WRONG, ids=[f"{each[0]}-{each[3]}" for each in WRONG]
)
def test_a_part_is_wrong(name: str, old: str, new: str, message: str) -> None:
    text = SAMPLES[name].text
    assert old in text
    refuse(name, text.replace(old, new), message)


@pytest.mark.parametrize("name", ["mot", "mot-detections"])
def test_scores_of_the_motchallenge_that_are_no_probabilities_are_1(name: str) -> None:
    found = objects(name, SAMPLES[name].text.replace("0.9", "87"))
    assert [each.confidence for each in found] == [1, 1]


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"a_1.txt": "", "b_1.txt": ""}, "b_1.txt: another file is of frame 1 too"),
        ({"a.txt": ""}, "it has no labels"),
        ({}, "it has no labels"),
        ({"a_99999999999.txt": ""}, "no film has a frame 99999999999"),
        ({"1.txt": "", "data.yaml": "names: [a,"}, "data.yaml: the list of names has no end"),
        ({"1.txt/x": ""}, "1.txt is not a file"),
    ],
)
def test_a_folder_of_labels_is_wrong(files: dict[str, str], message: str) -> None:
    for name, text in {"a": "", **files}.items():
        path = Path("labels", name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    check_refused(Path("labels"), "yolo", message)


PARQUET = {"frame": [0, 1], "time": [0.0, 0.04], "left": [10.0, 12.5], "top": [1.0, 1.0],
           "width": [9.0, 9.0], "height": [9.0, 9.0], "id": [1, 1]}  # fmt: skip


@pytest.mark.parametrize(
    ("column", "values", "message"),
    [
        ("frame", None, "its columns are time, left, top"),
        ("frame", [0, 0], "frame 0 has the object 1 twice"),
        ("frame", [0, -4], "no film has a frame -4"),
        ("frame", [0.0, 1.5], "row 2: '1.5' is not a whole number"),
        ("frame", ["a", "b"], "row 1: 'a' is not a number"),
        ("left", None, "row 1: it has no left"),
        ("left", [10.0, float("nan")], "row 2: it has no left"),
        ("left", [10.0, float("inf")], "row 2: a number of the object is not finite"),
        ("left", [10.0, 1e300], "row 2: a number of the object"),
        ("left", [[1], [2]], "column left holds lists"),
        ("width", [9.0, 0.0], "row 2: an object of 0x9 pixels has no area"),
        ("id", [1.0, 1.5], "row 2: '1.5' is not a whole number"),
        ("time", [0.0, float("inf")], "frame 1 has the time inf"),
        ("speed", [[1], [2]], "column speed holds lists"),
        ("label", ["x" * 2000] * 2, "a text of 2,000 characters"),
    ],
)
def test_parquet(column: str, values: list[object] | None, message: str) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    table = {name: each for name, each in {**PARQUET, column: values}.items() if each is not None}
    parquet.write_table(pyarrow.table(table), "a.parquet")
    check_refused(Path("a.parquet"), "parquet", message)


def test_parquet_that_is_cut() -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    pytest.importorskip("pyarrow.parquet").write_table(pyarrow.table(PARQUET), "a.parquet")
    data = Path("a.parquet").read_bytes()
    for wrong in (data[: len(data) // 2], b"PAR1" + data[8:40], b""):
        check_refused(written("parquet", wrong), "parquet")


def test_a_file_of_another_format_is_no_keyframes() -> None:
    for name in DECODED:
        path = written(name, SAMPLES[name].text.encode())
        with pytest.raises(InputError, match=f"holds no keyframes, but has the format {name}"):
            KeyframeOptions(keyframes=path).marks("film")


def test_every_format_that_is_read_is_here() -> None:
    known = {name for name, each in registry.FORMATS.usable().items() if each.read is not None}
    assert known - {"journal", "yolo-predictions", "lasot", "got10k"} == {*SAMPLES, "parquet"}


def test_frames_that_a_camera_has_dropped_end_no_track(tmp_path: Path) -> None:
    writer = JournalWriter(tmp_path / "a.xml.rows.jsonl", Header("camera 0", 64, 48, "object"))
    for frame in (0, 1, 2, 5, 6):
        each = placed(frame, Ellipse(9.5, 20, 8, 5, 0.1), 1, 0.75)
        writer.add(FrameRow(frame, frame / 25, (each,)))
    writer.close()
    recorded = registry.read(tmp_path / "a.xml.rows.jsonl", "journal", FilmFacts())
    assert recorded.following() == {0: 1, 1: 2, 2: 5, 5: 6, 6: 7}


@pytest.mark.slow
def test_a_journal_bit_by_bit(tmp_path: Path) -> None:
    """Bits are turned and each end cut off: the rows before, or one clear line; never others.

    A turned bit may make another digit of a digit, which no reader could tell; it stays a number.
    """
    path = tmp_path / "a.json.rows.jsonl"
    writer = JournalWriter(path, Header("film", 64, 48, "object"))
    for frame in range(3):
        each = placed(frame, Ellipse(9.5, 20, 8, 5, 0.1), 1, 0.75, label="car")
        writer.add(FrameRow(frame, frame / 25, (each,)))
    writer.close()
    whole = path.read_bytes()
    sound = [row.to_dict() for row in registry.read(path, "journal", FilmFacts())]
    head = whole.index(b"\n") + 1

    def rows_in(data: bytes) -> list[FrameRow] | None:
        path.unlink()  # what replaces a file's content waits for the disk
        path.write_bytes(data)
        try:
            return list(registry.read(path, "journal", FilmFacts()))
        except SourceError as error:
            said.add(str(error).partition(str(path))[2])
            return None

    said = set[str]()
    for end in range(len(whole)):
        kept = rows_in(whole[:end])
        found = None if kept is None else [row.to_dict() for row in kept]
        assert found == (sound[: whole[head:end].count(b"\n")] if end >= head else None) or (
            end == head - 1 and found == []
        )
    for place in range(0, 8 * len(whole), 21):  # in time each of the eight bits
        data = bytearray(whole)
        data[place // 8] ^= 1 << place % 8
        for row in rows_in(bytes(data)) or []:
            for each in row.objects:
                assert all(map(math.isfinite, (row.time, *each.ellipse, each.confidence)))
    assert "" not in said  # all of them name the file
    assert not any("\n" in text for text in said)


def test_a_journal_whose_object_is_of_another_frame(tmp_path: Path) -> None:
    path = tmp_path / "a.json.rows.jsonl"
    writer = JournalWriter(path, Header("film", 64, 48, "object"))
    for frame, of_object in ((0, 0), (1, 2)):
        each = placed(of_object, Ellipse(9.5, 20, 8, 5, 0.1), 1, 0.75)
        writer.add(FrameRow(frame, frame / 25, (each,)))
    writer.close()
    with pytest.raises(SourceError, match="is damaged in line 3"):
        registry.read(path, "journal", FilmFacts())


def test_a_journal_that_is_nested_without_end(tmp_path: Path) -> None:
    path = tmp_path / "a.json.rows.jsonl"
    JournalWriter(path, Header("film", 64, 48, "object")).close()
    with path.open("a") as file:
        file.write('{"frame": 0, "more": ' + "[" * 100_000 + "\n")
    with pytest.raises(SourceError, match="is damaged in line 2"):
        registry.read(path, "journal", FilmFacts())


def test_a_journal_of_another_version_is_said_to_be_one() -> None:
    Path("old.rows.jsonl").write_text(
        '{"motes":"rows 1","source":"film.mp4","width":9,"height":9,"label":"object"}\n'
    )
    with pytest.raises(SourceError, match="the rows of a document of this version of motes"):
        registry.read(Path("old.rows.jsonl"), "journal", FilmFacts())


def test_rows_of_several_objects_need_their_identities(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("frame,left,top,width,height\n0,1,1,9,9\n0,20,1,9,9\n")
    with pytest.raises(SourceError, match=r"a\.csv: it has several objects in a frame, and no col"):
        registry.read(tmp_path / "a.csv", "csv", FilmFacts())


@pytest.mark.parametrize(
    ("title", "first", "second", "said"),
    [
        ("status", "tracking", "seen", "row 2: status is 'seen'; it is one of searching, "),
        ("time", "5", "0.08", "frame 0 has the time 5, and 1 0.08"),
    ],
)
def test_rows_of_other_words_or_times(
    title: str, first: str, second: str, said: str, tmp_path: Path
) -> None:
    lines = [f"frame,left,top,width,height,{title}", f"0,1,1,9,9,{first}", f"1,1,1,9,9,{second}"]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(SourceError, match=f"a.csv: {said}"):
        registry.read(tmp_path / "a.csv", "csv", FilmFacts())


def test_frames_that_all_have_one_time_are_refused(tmp_path: Path) -> None:
    """As a column that nobody has filled in; rounded times may be equal for a few frames."""
    for times, ends in ((("0.0", "0.0", "0.1"), None), (("3", "3", "3"), "all frames .* time 3")):
        rows = "".join(f"{n},{time},1,1,9,9\n" for n, time in enumerate(times))
        (tmp_path / "a.csv").write_text(f"frame,time,left,top,width,height\n{rows}")
        with pytest.raises(SourceError, match=ends) if ends else nullcontext():
            registry.read(tmp_path / "a.csv", "csv", FilmFacts())
