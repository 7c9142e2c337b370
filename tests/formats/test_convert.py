"""`motes convert`: which format is meant, what is lost, and what does not fit the film."""

import csv
import json
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import disks
from clips import write_pictures
from commands import Tell, read_csv
from motes.formats import FilmFacts, registry
from motes.video.film import DamagedError, Film
from recordings import crowd, turning

TRACK = "track film --preset mean_shift"
"""The quickest tracker: what is made of rows does not depend on it."""
BLACK = np.zeros((48, 64, 3), np.uint8)


@pytest.fixture
def go(here: Path, capfd: pytest.CaptureFixture[str]) -> Tell:
    """Run motes in a folder with rows of one target and of two objects."""
    registry.write(Path("one.csv"), "csv", turning())
    rows = Path("one.csv").read_text()
    Path("one.csv").write_text(rows.replace("absent", "searching"))  # as rows of a run have it
    registry.write(Path("two.json"), "coco", crowd())
    return Tell(capfd)


def film(names: Iterable[object], size: tuple[int, int] = (64, 48), folder: str = "film") -> None:
    """Make a folder of images of noise."""
    Path(folder).mkdir()
    Image.effect_noise(size, 60).convert("RGB").save("noise.png")
    for name in names:
        Path(folder, f"{name}.png").write_bytes(Path("noise.png").read_bytes())


def contents(folder: str) -> dict[Path, bytes]:
    """Return what is in the files of a folder, and of folders in it."""
    return {path: path.read_bytes() for path in Path(folder).rglob("*") if path.is_file()}


def test_formats_are_recognized_and_losses_are_named(go: Tell) -> None:
    said = "wrote groundtruth_rect.txt (truth of OTB) with the 40 frames in one.csv."
    said = go.says("convert one.csv groundtruth_rect.txt", 0, said)
    assert "otb does not hold angles, confidences, times; one.csv has them." in said
    Path("first.csv").write_text("".join(Path("one.csv").read_text().splitlines(keepends=True)[:2]))
    assert "with the 1 frame in first.csv." in go("convert first.csv first.txt")[1]
    said = go.says("convert two.json gt.txt", 0, "mot-truth does not hold confidences, times")
    assert "has no class" not in said  # it has one for a car
    lines = "0,1,cup,1,1,9,9\n0,2,Person,1,1,9,9\n0,3,bus,1,1,9,9\n"
    Path("own.csv").write_text("frame,id,label,left,top,width,height\n" + lines)
    for form in ("mot", "mot-truth"):
        said = f"{form} has no class 'bus', 'cup'; it writes -1."
        go.says(f"convert own.csv own.txt --to {form} --overwrite", 0, said)
    go.says("convert one.csv one.jsonl", 0, "does not hold", told=False)
    assert go("convert one.csv a.txt --to vot")[0] == 0
    assert go("convert a.txt b.jsonl --from vot --fps 25")[0] == 0
    rows = [json.loads(line) for line in Path("b.jsonl").read_text().splitlines()]
    assert rows[25]["time"] == pytest.approx(1.0)
    assert rows[25]["theta"] == pytest.approx(0.5, abs=1e-3)


def test_times_that_a_file_does_not_have_are_not_told_as_lost(go: Tell) -> None:
    Path("own.csv").write_text("frame,left,top,width,height\n0,1,1,9,9\n")
    assert "times" not in go("convert own.csv own.txt")[1]
    assert go("convert own.csv own.json --size 320x240 --fps 5")[0] == 0
    assert "mot does not hold times; own.json has them." in go("convert own.json b.txt")[1]
    others = json.loads(Path("own.json").read_text())
    for image in others["images"]:
        del image["time"]
    Path("others.json").write_text(json.dumps(others))
    assert "times; others.json has them" not in go("convert others.json c.txt")[1]


def test_frames_of_a_film_are_counted_where_its_file_does_not_say(go: Tell) -> None:
    """Its length and its rate give 26."""
    write_pictures("film.mkv", [BLACK] * 4, times=(0.0, 0.04, 0.08, 1.0))
    Path("ten.csv").write_text("frame,left,top,width,height\n9,8,8,20,20\n")
    go.says("convert ten.csv ten.json --video film.mkv", 3, "in frame 9, but the film has 4 frames")


def test_frames_at_another_rate_are_mapped_by_the_films_own_times(go: Tell) -> None:
    """Also into a format that holds no times."""
    write_pictures("film.mkv", [BLACK] * 4, times=(0.0, 0.04, 0.08, 1.0))
    key = {"rotation": 0, "enabled": True, "y": 10, "width": 50, "height": 50}
    keys = [
        {"frame": 1, "x": 10, **key},
        {"frame": 6, "x": 20, **key},
        {"frame": 11, "x": 40, **key},
    ]
    value = {"labels": ["cup"], "sequence": [{**each, "time": each["frame"] / 10} for each in keys]}
    result = {"type": "videorectangle", "value": value}
    Path("task.ls.json").write_text(json.dumps([{"annotations": [{"result": [result]}]}]))
    for name in ("a.csv", "a.xml", "b.csv"):
        source = "a.xml" if name == "b.csv" else "task.ls.json"
        assert go(f"convert {source} {name} --video film.mkv")[0] == 0
    places = [[float(each["left"]) for each in read_csv(name)] for name in ("a.csv", "b.csv")]
    assert places[0] == pytest.approx(places[1], abs=0.01)


def test_what_a_run_wrote_beside_its_rows_is_not_asked_for_again(go: Tell) -> None:
    film(range(5), (32, 24))
    assert go(f"{TRACK} --init 8,6,10,8 --fps 10 -o run.csv")[0] == 0
    assert go("convert run.csv run.json")[0] == 0
    document = json.loads(Path("run.json").read_text())
    assert {(each["width"], each["height"]) for each in document["images"]} == {(32, 24)}
    assert len(document["images"]) == 5
    assert go("convert run.csv same.json --size 32x24 --fps 10 --video film")[0] == 0
    go.says("convert run.csv other.json --size 64x48", 2, "is 64x48, and the film has 32x24; omit")
    film(range(1), folder="other")
    go.says("convert run.csv other.json --video other", 3, "has 64x48, but the rows are of film, ")
    assert not Path("other.json").exists()


def test_rows_of_a_run_are_refused_for_a_film_of_other_times(go: Tell) -> None:
    """As of one that was made anew at another rate; its frames are others."""
    for name, fps in (("film.mkv", 25), ("anew.mkv", 50)):
        write_pictures(name, [BLACK] * 5, fps)
    assert go("track film.mkv --preset mean_shift --init 8,6,10,8 -o run.csv")[0] == 0
    assert go("convert run.csv run.xml --video film.mkv")[0] == 0
    Path("moved.csv").write_bytes(Path("run.csv").read_bytes())  # without what is beside it
    for rows in ("run.csv", "moved.csv"):
        said = f"{rows} has frame 1 at 0.04 s, but anew.mkv at 0.02 s; give the film of these rows"
        go.says(f"convert {rows} anew.xml --video anew.mkv", 3, said)
    assert go("convert moved.csv anew.xml --video anew.mkv --fps 25")[0] == 0
    film(range(3))
    assert go(f"{TRACK} --init 8,6,10,8 --fps 10 -o slow.csv")[0] == 0
    assert go("convert slow.csv slow.xml --video film")[0] == 0  # its rate is beside the rows


@pytest.mark.parametrize(
    ("source", "seen"),
    [("two.csv", [0, 1, 7]), ("two.jsonl", [0, 1, 7]), ("two.txt", [*range(8)]),
     ("two.xml", [*range(8)])],
)  # fmt: skip
def test_frames_that_nobody_has_looked_at_are_no_negatives(
    go: Tell, source: str, seen: list[int]
) -> None:
    """How long the film is does not tell what is in it."""
    lines = [f"{frame},{who},9,9,8,8" for frame in (0, 1, 7) for who in (1, 2)]
    Path("two.csv").write_text("\n".join(["frame,id,left,top,width,height", *lines, ""]))
    if source != "two.csv":
        assert go(f"convert two.csv {source} --size 320x240")[0] == 0
    assert go(f"convert {source} a.json --frames 40 --size 320x240")[0] == 0
    images = json.loads(Path("a.json").read_text())["images"]
    assert [each["frame"] for each in images] == seen
    assert images[-1]["time"] == pytest.approx(7 / 25)
    assert go(f"convert {source} labels --frames 40 --size 320x240")[0] == 0
    assert len([*Path("labels/labels").iterdir()]) == len(seen)
    for truth in ("otb", "vot"):
        assert go(f"convert {source} a.{truth}.txt --frames 40 --identity 1")[0] == 0
        assert len(Path(f"a.{truth}.txt").read_text().splitlines()) == 40


def test_of_one_target_a_frame_without_a_row_is_not_known(go: Tell) -> None:
    lines = Path("one.csv").read_text().splitlines(keepends=True)
    Path("cut.csv").write_text("".join([lines[0], *lines[11:]]))
    assert go("convert cut.csv a.json --frames 60 --size 320x240")[0] == 0
    images = json.loads(Path("a.json").read_text())["images"]
    assert [each["frame"] for each in images] == [*range(10, 20), *range(25, 40)]


def boxes_back(go: Tell, document: str) -> list[int]:
    """Return the frames of the boxes that are read from a document."""
    assert go(f"convert {document} back.txt --size 320x240 --frames 60 --overwrite")[0] == 0
    return [int(line.partition(",")[0]) - 1 for line in Path("back.txt").read_text().splitlines()]


@pytest.mark.parametrize("target", ["a.xml", "a.ls.json"])
@pytest.mark.parametrize("source", ["gap.csv", "gap.txt", "gap.gt.txt", "gap.json"])
def test_no_box_is_made_up_between_those_of_a_file(go: Tell, source: str, target: str) -> None:
    frames = [0, 1, 2, 8, 9]
    lines = [f"{frame},1,{10 + 9 * frame},9,20,20" for frame in frames]
    Path("gap.csv").write_text("\n".join(["frame,id,left,top,width,height", *lines, ""]))
    if source != "gap.csv":
        assert go(f"convert gap.csv {source} --size 320x240")[0] == 0
    assert go(f"convert {source} {target} --size 320x240 --frames 60")[0] == 0
    assert boxes_back(go, target) == frames


def test_an_object_goes_on_through_what_a_stride_skips(go: Tell) -> None:
    """What is skipped is not known, and no box is read there."""
    film(range(20), (320, 240))
    assert go(f"{TRACK} --init 8,6,10,8 --stride 3 -o run.csv")[0] == 0
    assert go(f"{TRACK} --init 8,6,10,8 --stride 3 -o run.xml")[0] == 0
    assert go("convert run.csv same.xml")[0] == 0
    Path("run.csv.run.json").unlink()
    assert go("convert run.csv lone.xml --video film")[0] == 0
    for document in ("run.xml", "same.xml", "lone.xml"):
        assert 'outside="1"' not in Path(document).read_text()
        assert boxes_back(go, document) == [*range(0, 20, 3)]


def test_two_frames_tell_no_stride_but_their_run_does(go: Tell) -> None:
    film(range(7), (320, 240))
    assert go(f"{TRACK} --init 8,6,10,8 --stride 3 --end 4 -o run.csv")[0] == 0
    for ends, document in (([6], "known.xml"), ([1, 4], "lone.xml")):
        assert go(f"convert run.csv {document} --video film")[0] == 0
        Path("run.csv.run.json").unlink(missing_ok=True)
        boxes = ElementTree.parse(document).findall("track/box")
        assert [int(box.get("frame", "")) for box in boxes if box.get("outside") == "1"] == ends


@pytest.mark.parametrize("source", ["film", "film.mkv"])
@pytest.mark.parametrize(
    ("options", "ends"),
    [("--init BOX", []), ("--init BOX --end 4", [4]), ("--init BOX --stride 2", []),
     ("--at 0=BOX", []), ("--at 0=BOX --end 4", [4])],
)  # fmt: skip
def test_a_track_ends_where_its_film_goes_on(
    go: Tell, source: str, options: str, ends: list[int]
) -> None:
    """CVAT would go on with the last box; and it takes none after the film."""
    film(range(7))
    write_pictures("film.mkv", [np.asarray(Image.open("noise.png").convert("RGB"))] * 7)
    line = f"{TRACK} {options.replace('BOX', '8,6,20,16')}".replace("film", source)
    assert go(f"{line} -o run.xml")[0] == 0
    assert go(f"{line} -o run.csv")[0] == 0
    code, said = go("convert run.csv open.xml")
    cut = options == "--init BOX --end 4"  # keyframes tell how many frames they have read
    assert (code, "stays to the end of the task; give --video" in said) == (0, cut), said
    go.says("convert open.xml again.xml", 0, "stays to the end of the task", told=False)
    titles = "frame,id,left,top,width,height,status,confidence"
    Path("lost.csv").write_text(f"{titles}\n0,1,9,9,20,20,tracking,1\n1,1,9,9,20,20,lost,0\n")
    go.says("convert lost.csv lost.xml --size 320x240", 0, "stays to the end", told=False)
    go.says(f"convert run.csv same.xml --video {source}", 0, "stays to the end of the", told=False)
    for document in ("run.xml", "same.xml"):
        boxes = ElementTree.parse(document).findall("track/box")
        assert [int(box.attrib["frame"]) for box in boxes if box.get("outside") == "1"] == ends


def test_frames_before_a_run_are_none_of_its_document(go: Tell) -> None:
    film(range(9))
    assert go(f"{TRACK} --init 8,6,20,16 --start 4 --end 7 -o run.xml")[0] == 0
    assert go("convert run.xml labels --video film")[0] == 0
    assert {path.stem for path in Path("labels/labels").glob("*.txt")} == {"4", "5", "6"}


def test_an_object_goes_on_between_keyframes(go: Tell) -> None:
    Path("a.keyframes.csv").write_text("frame,x,y,width,height\n0,9,9,20,20\n7,9,9,20,20\n")
    go.says("convert a.keyframes.csv a.xml --size 320x240", 0, "read as its left and top, not")
    assert boxes_back(go, "a.xml") == [*range(8)]


def test_an_object_goes_on_between_images_that_were_picked(go: Tell) -> None:
    """Nobody has looked in between; in the image of frame 20 it is not."""
    lines = [f"{frame},1,{9 + frame},9,20,20" for frame in (0, 7, 10, 31)] + ["20,2,99,9,20,20"]
    Path("a.csv").write_text("\n".join(["frame,id,left,top,width,height", *lines, ""]))
    assert go("convert a.csv a.json --size 320x240")[0] == 0
    assert go("convert a.json a.xml")[0] == 0
    track = ElementTree.parse("a.xml").findall("track")[0]
    boxes = {int(each.attrib["frame"]): each.get("outside") for each in track.findall("box")}
    assert [frame for frame, outside in boxes.items() if outside == "1"] == [20]
    assert go("convert a.xml a.yolo")[0] == 0
    for frame in range(11):
        assert Path(f"a.yolo/labels/frame_{frame:06d}.txt").read_text()


def test_label_studio_is_told_the_rate_of_the_film(go: Tell) -> None:
    """It shows a film at 24 frames a second, or 25, unless its labeling configuration has another.

    Boxes would stand in other frames.
    """
    rows = [f"{frame},{frame / 30:.6f},9,9,20,20" for frame in range(3, 9)]
    Path("a.csv").write_text("\n".join(["frame,time,left,top,width,height", *rows, ""]))
    said = 'a.ls.json: Label Studio has a rate of its own; give its tag Video framerate="$fps"'
    go.says("convert a.csv a.ls.json --size 320x240", 0, said)
    (task,) = json.loads(Path("a.ls.json").read_text())
    assert task["data"] == {"video": "unknown", "fps": 30}


def test_several_objects_have_no_folder_of_masks(go: Tell) -> None:
    """Nothing would tell whose a white pixel is."""
    said = "A folder of masks holds one object, and there are several; choose one with --identity"
    go.says("convert two.json masks", 5, said)
    assert not Path("masks").exists()
    assert go("convert two.json masks --identity 1")[0] == 0


def test_two_images_of_one_name_have_no_labels(go: Tell) -> None:
    film(range(2))
    Image.open("film/1.png").save("film/1.bmp")
    assert go(f"{TRACK} --init 8,6,10,8 -o run.csv")[0] == 0
    for line in (f"{TRACK} --init 8,6,10,8 -o", "convert run.csv --video film"):
        for target in ("a.yolo", "masks"):
            go.says(f"{line} {target}", 5, "1.bmp and 1.png have one name")
            assert not Path(target).exists()
            assert not Path(f"{target}.rows.jsonl").exists()


@pytest.mark.parametrize(
    ("target", "label", "place", "found"),
    [
        ("a.txt", "Car", slice(7, 8), {"3"}),
        ("gt.txt", "person", slice(7, 8), {"1"}),
        ("a.csv", "cup", slice(3, 4), {"label", "cup", ""}),
    ],
)
def test_a_class_for_those_without_one_is_in_rows_too(
    go: Tell, target: str, label: str, place: slice, found: set[str]
) -> None:
    assert go(f"convert one.csv {target} --label {label}")[0] == 0
    lines = Path(target).read_text().splitlines()
    assert {name for line in lines for name in line.split(",")[place]} == found


def test_rows_without_a_class_have_that_of_their_object(go: Tell) -> None:
    """Whoever names each object once has named all its rows; boxes without identity stay apart."""
    rows = "frame,id,label,left,top,width,height\n0,4,cup,1,1,9,9\n1,4,,2,1,9,9\n2,4,,3,1,9,9\n"
    Path("own.csv").write_text(f"{rows}0,-1,car,30,1,9,9\n1,-1,,30,1,9,9\n")
    assert go("convert own.csv own.labels --to yolo --size 64x48 --label toy")[0] == 0
    found = [each.read_text() for each in sorted(Path("own.labels/labels").iterdir())]
    assert [[line[0] for line in text.splitlines()] for text in found] == [[*"01"], [*"02"], ["0"]]
    Path("own.csv").write_text(rows)
    for target in ("own.json", "own.xml"):
        assert go(f"convert own.csv {target} --size 64x48 --label toy")[0] == 0
        assert "cup" in (text := Path(target).read_text())
        assert "toy" not in text


def test_a_class_that_changes_is_said(go: Tell) -> None:
    """As detectors' do; a box without identity is an object of its own."""
    rows = "frame,id,label,left,top,width,height\n0,4,car,1,1,9,9\n1,4,bus,2,1,9,9\n"
    Path("own.csv").write_text(f"{rows}0,2,car,30,1,9,9\n")
    for target, form in (
        ("own.json", "coco"),
        ("own.xml", "cvat"),
        ("own.ls.json", "label-studio"),
    ):
        said = f"own.csv has several classes for object 4; {form} has that of its last row."
        go.says(f"convert own.csv {target} --size 64x48", 0, said)
    go.says("convert own.csv own.jsonl", 0, "several classes", told=False)
    Path("own.csv").write_text(rows.replace(",4,", ",-1,"))
    go.says("convert own.csv own.json --size 64x48 --overwrite", 0, "several classes", told=False)


def test_one_of_several_objects(go: Tell) -> None:
    go.says("convert two.json groundtruth.txt", 5, "choose one with --identity N")
    assert not Path("groundtruth.txt").exists()
    assert go("convert two.json groundtruth.txt --identity 1")[0] == 0
    assert Path("groundtruth.txt").read_text().startswith("10.0000,40.0000,50.0000,40.0000,50")
    go.says("convert two.json x.vot.txt --identity 7", 2, "two.json has no object 7; it has 1, 2.")


def test_the_film_gives_what_a_file_does_not_hold(go: Tell) -> None:
    film(range(40), (320, 240))
    go.says("convert one.csv a.json", 2, "coco needs the size of the picture; give --size or --vid")
    assert go("convert one.csv a.json --video film")[0] == 0
    assert json.loads(Path("a.json").read_text())["images"][0]["width"] == 320
    assert go("convert one.csv b.json --size 320x240")[0] == 0
    go.says("convert two.json labels --size 640x480", 3, "of a film of 320x240 pixels, not of 640")
    go.says("convert one.csv c.xml --size 320x240 --frames 30", 3, "frame 39, but the film has 30 ")
    assert go("convert two.json labels")[0] == 0
    go.says("convert labels d.csv", 2, "labels holds shares of the picture; give its --size")
    assert go("convert labels d.csv --video film")[0] == 0
    assert len(list(csv.reader(Path("d.csv").read_text().splitlines()))) == 56


def test_a_frame_rate_that_is_assumed_is_said_once(go: Tell) -> None:
    said_once = "has no times, 25 frames a second are assumed; give --fps, or a --video with times."
    assert go("convert one.csv one.vot.txt")[0] == 0
    for line, assumed in [
        ("convert one.vot.txt a.csv", True),
        ("convert one.vot.txt b.csv --fps 25", False),
        ("convert one.csv c.jsonl", False),  # with times of its own
        ("convert one.vot.txt one.keyframes.csv", False),  # which holds no times
        ("convert one.keyframes.csv d.csv", True),
        ("convert two.json e.csv", False),
    ]:
        code, said = go(line)
        assert (code, said.count(said_once)) == (0, int(assumed)), (line, said)
    document = json.loads(Path("two.json").read_text())
    for image in document["images"]:
        del image["time"]  # as of other tools
    Path("two.json").write_text(json.dumps(document))
    code, said = go("convert two.json f.csv")
    assert (code, said.count(said_once)) == (0, 1), said
    film(range(40), (320, 240))
    code, said = go("convert one.vot.txt g.csv --video film")
    assert (code, said.count("a second are assumed"), said_once in said) == (0, 1, True), said
    go.says("convert one.csv i.jsonl --video film", 0, "are assumed", told=False)
    assert go("convert one.vot.txt h.csv --video film --fps 10")[0] == 0
    last = read_csv("h.csv")[-1]
    assert float(last["time"]) == pytest.approx(int(last["frame"]) / 10)
    assert go(f"{TRACK} --init 20,10,16,20 --fps 10 -o run.csv")[0] == 0
    go.says("convert run.csv run.json --video film", 0, "assumed", told=False)


@pytest.mark.parametrize("name", ["gt/gt.txt", "det/det.txt", "results.txt"])
def test_the_rate_of_a_seqinfo_is_that_of_the_rows_beside_it(go: Tell, name: str) -> None:
    Path("gt").mkdir()
    Path("det").mkdir()
    Path("seqinfo.ini").write_text("[Sequence]\nframeRate=10\n")
    Path(name).write_text("1,1,9,9,9,9,1,-1,-1,-1\n3,1,9,9,9,9,1,-1,-1,-1\n")
    for fps, expected in (("", 0.2), (" --fps 20", 0.1)):
        go.says(f"convert {name} rows.csv --overwrite{fps}", 0, "assumed", told=False)
        assert float(read_csv("rows.csv")[-1]["time"]) == expected


VARYING = [0.0, 0.02, 0.04, 0.1, 0.16, 0.18]


@pytest.mark.parametrize("damaged", [False, True])
def test_times_are_those_of_a_film_of_a_varying_rate(
    go: Tell, monkeypatch: pytest.MonkeyPatch, damaged: bool
) -> None:
    """They are read from its packets, unless its beginning is damaged."""
    write_pictures("film.mkv", [BLACK] * len(VARYING), 50, VARYING)
    if damaged:

        def first(film: Film, _: float | None) -> None:
            raise DamagedError(film.name)

        monkeypatch.setattr(Film, "_first", first)
    Path("det.txt").write_text("".join(f"{i},-1,9,9,20,20,0.9\n" for i in range(1, 7)))
    assert go("convert det.txt a.csv --video film.mkv")[0] == 0
    found = read_csv("a.csv")
    assert [float(row["time"]) for row in found] == pytest.approx(VARYING, abs=1e-3)
    assert go("convert det.txt b.csv --video film.mkv --fps 10")[0] == 0
    found = read_csv("b.csv")
    assert [float(row["time"]) for row in found] == pytest.approx([i / 10 for i in range(6)])
    facts = FilmFacts(times=VARYING, fps=50)
    assert [facts.time(frame) for frame in (1, 5, 7)] == pytest.approx([0.02, 0.18, 0.22])


def test_times_after_the_end_of_the_film_are_refused(go: Tell) -> None:
    write_pictures("film.mkv", [BLACK] * 10)
    rows = ["0,0", "9,0.36", "9,1.3", "9,360"]  # the last one is in milliseconds
    for row, code in zip(rows, (0, 0, 0, 3), strict=True):
        Path("a.csv").write_text(f"frame,time,left,top,width,height\n{row},9,9,20,20\n")
        found, said = go("convert a.csv b.csv --video film.mkv --overwrite")
        assert found == code, said
    assert "a.csv has times up to 360, in seconds, but the film's last frame is at 0.36;" in said
    film(range(10))  # of which no times are known
    assert go("convert a.csv c.csv --video film")[0] == 0


def test_no_advice_on_times_in_milliseconds_leads_back(go: Tell) -> None:
    """That on --fps does not help, but that on the column does."""
    film(range(3))
    rows = [f"{frame},{40 * frame},9,9,20,20" for frame in range(3)]
    Path("a.csv").write_text("\n".join(["frame,time,left,top,width,height", *rows, ""]))
    assert go("convert a.csv whole.csv")[0] == 0
    for line in (
        "draw film a.csv -o a.mkv",
        "draw film a.csv -o a.mkv --fps 25",
        "check film whole.csv",
    ):
        go.says(line, 3, "or correct the column time, in seconds.")
    go.says("convert a.csv b.csv --fps 25", 2, "omit it, or remove these times from a copy.")
    rows = [f"{frame},9,9,20,20" for frame in range(3)]
    Path("a.csv").write_text("\n".join(["frame,left,top,width,height", *rows, ""]))
    assert go("draw film a.csv -o a.mkv --fps 25")[0] == 0
    assert go("convert a.csv b.csv --fps 25")[0] == 0


def test_what_is_remembered_beside_other_rows_is_not_replaced_unasked(go: Tell) -> None:
    film(range(3))
    assert go(f"{TRACK} --init 20,10,16,20 -o a.csv")[0] == 0
    Path("b.jsonl.run.json").write_text("corrections of other rows, which were moved away")
    said = "b.jsonl.run.json exists; choose another name, or allow it"
    go.says("convert a.csv b.jsonl", 5, said, lines=1)
    assert not Path("b.jsonl").exists()
    assert go("convert a.csv b.txt")[0] == 0  # which remembers nothing
    assert go("convert a.csv b.jsonl --overwrite")[0] == 0
    assert json.loads(Path("b.jsonl.run.json").read_text())["lines"] == 3
    Path("a.csv.run.json").unlink()
    assert go("convert a.csv b.jsonl")[0] == 5
    assert go("convert a.csv b.jsonl --overwrite")[0] == 0
    assert not Path("b.jsonl.run.json").exists(), "it was of other rows"


def test_what_is_left_out_is_said(go: Tell) -> None:
    assert go("convert two.json labels")[0] == 0
    Path("labels/labels/readme.txt").write_text("of somebody\n")
    Path("labels/classes.txt").write_text("car\nobject\n")
    code, said = go("convert labels a.csv --size 320x240")
    assert (code, said.count("left out")) == (0, 1), said
    assert "left out of labels: readme.txt, whose name has no number of a frame." in said

    assert go("convert two.json a.ls.json")[0] == 0
    (task,) = json.loads(Path("a.ls.json").read_text())
    regions = task["predictions"][0]["result"]
    regions += [{"type": kind, "value": {}} for kind in ("choices", "choices", "timelinelabels")]
    Path("a.ls.json").write_text(json.dumps([task]))
    code, said = go("convert a.ls.json b.csv --size 320x240")
    assert "left out of a.ls.json: 2 regions of choices; 1 region of timelinelabels." in said

    assert go("convert two.json a.xml")[0] == 0
    text = Path("a.xml").read_text().replace("</track>", "<cuboid frame='0'/></track>")
    only = "<track id='9' label='car'><cuboid frame='0'/></track></annotations>"
    Path("a.xml").write_text(text.replace("</annotations>", only))
    assert "left out of a.xml: 3 cuboids." in go("convert a.xml c.csv")[1]

    head = '{"motes": "rows 2", "source": "film", "width": 9, "height": 9, "label": "object"}\n'
    Path("a.json.rows.jsonl").write_text(head + '{"frame": 0, "time": 0.0, "objects": []}\n{"fra')
    go.says("convert a.json.rows.jsonl a.json", 0, "the last line, which is cut off")


def test_angles_of_other_tools_are_not_misread_in_silence(go: Tell) -> None:
    """An ellipse of theirs may begin upright, and go on in degrees; a box has no angle."""
    rows = "frame,id,x,y,a,b,theta\n0,1,50,40,9,5,0\n1,1,50,40,9,5,6\n2,1,50,40,9,5,14\n"
    Path("a.csv").write_text(rows)
    go.says(
        "convert a.csv b.csv", 3, "row 3: theta goes from 6 to 14; it is in radians, and a turn"
    )
    Path("a.csv").write_text("frame,left,top,width,height,theta\n0,50,40,9,5,30\n")
    go.says("convert a.csv b.csv", 0, "left out of a.csv: the columns theta.")


def test_a_folder_is_whole_or_not_there(go: Tell, monkeypatch: pytest.MonkeyPatch) -> None:
    """A part of one would read as whole: there are fewer frames, and nothing says so."""
    with monkeypatch.context() as patch:
        disks.fill_after(patch, 6)
        go.says("convert two.json labels", 5, "labels cannot be written: No space left on device")
    assert list(Path().glob("labels*")) == []
    assert go("convert two.json labels")[0] == 0
    whole = contents("labels")
    assert len(whole) == 32
    with monkeypatch.context() as patch:
        disks.fill_after(patch, 6)
        assert go("convert one.csv labels --size 320x240 --overwrite")[0] == 5
    assert contents("labels") == whole
    assert go("convert one.csv labels --size 320x240 --overwrite")[0] == 0
    assert len(contents("labels")) == 37  # in five of 40 frames it is searched for
    assert go("convert two.json labels/ --overwrite")[0] == 0  # and no frame of another film
    assert contents("labels") == whole
    assert len(list(Path().glob("labels*"))) == 1


def test_a_folder_with_other_files_is_not_replaced(go: Tell) -> None:
    Path("mine").mkdir()
    assert go("convert two.json mine --to yolo")[0] == 0
    Path("mine/thesis.doc").write_text("all of it")
    go.says("convert two.json mine --to yolo --overwrite", 5, "holds thesis.doc, which is no part")
    assert Path("mine/thesis.doc").read_text() == "all of it"
    go.says("convert two.json . --to yolo --overwrite", 5, ". is the current folder; name another")


@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        ("convert one.csv", 2, "Two names are needed"),
        ("convert one.csv b.xml --from xls", 2, "There is no format 'xls'; known are csv"),
        ("convert one.csv b.xml --to journal", 2, "journal cannot be written"),
        ("convert one.csv b.ZIP --to cvat", 2, "b.ZIP: no archives are made; give another name"),
        ("convert one.csv b.xml --size 3", 2, "--size is '3'; give width and height as 640x480"),
        ("convert one.csv b.xml --fps 0", 2, "--fps is 0; give a number"),
        ("convert one.csv b.csv --fps 10", 2, "--fps is 10, and one.csv has times of its own"),
        ("convert one.csv b.csv --from deeplabcut", 2, "deeplabcut is only written; motes"),
        ("convert one.csv b.xml --frames 0", 2, "--frames is 0; give 1 or more"),
        ("convert one.csv b.xml --keyframe-error -1", 2, "--keyframe-error is -1; give"),
        ("convert one.csv b.csv --keyframe-error 3", 2, "is for CVAT, Label Studio and keyframes;"),
        ("convert one.csv b.xml --to coco --keyframe-error 3", 2, "others have none: omit it."),
        ("convert one.csv b.csv -o c.csv", 2, "b.csv and c.csv are two files to make; give one."),
        ("convert one.csv two.json --size 320x240", 5, "two.json exists; choose another name"),
        ("convert one.csv b.txt --label cup", 2, "mot has no class cup; it has pedestrian, person"),
        ("convert one.csv gt.txt --label cup", 2, "--label: mot-truth has no class cup; it has"),
        ("convert one.csv det.txt --label car", 2, "mot-detections holds no classes; omit it."),
        ("convert none.csv b.xml", 3, "none.csv cannot be read: No such file"),
        ("convert one.csv b.yolo --from coco", 3, "one.csv: JSON is malformed"),
        ("convert no.rows.jsonl -o a.json", 3, "no.rows.jsonl cannot be read"),
        ("convert . a.json --size 9x9", 3, "as of labelme, to COCO first"),
        ("convert r.csv -o a.json", 3, "format of r.csv is not clear; name it: csv, jsonl"),
        ("convert r.csv -o r.csv", 2, "cannot be an output"),
        ("convert r.csv -o a.mp4 --from csv", 2, "a.mp4 ends in none of .csv, .jsonl"),
    ],
)
def test_errors_are_one_line(go: Tell, line: str, code: int, message: str) -> None:
    Path("r.csv").write_text("1,2,3\n")
    go.says(line, code, message, lines=1)


@pytest.mark.parametrize(
    ("name", "text", "code", "message"),
    [
        ("a.txt", "0,10,20,30,40,0.9\n1,11,20,30,40,0.8\n", 0, "read as frame,x,y,a,b,theta of el"),
        (
            "a.csv",
            "0,10,20,30,40,0.9\n0,90,20,30,40,0.8\n",
            3,
            "keep one. Or if the numbers are f",
        ),
        ("det.txt", "1,10,20,30,40,0.9\n", 3, "6 numbers, but a line has 7 to 10: frame, id, x, y"),
        ("a.txt", "1,10,20,30,40,0.9,2\n", 3, "none of its boxes is higher than a pixel; if the"),
    ],
)
def test_boxes_with_a_score_are_not_taken_for_others_in_silence(
    go: Tell, name: str, text: str, code: int, message: str
) -> None:
    Path(name).write_text(text)
    go.says(f"convert {name} b.csv", code, message)
    if not code:
        Path(name).write_text(f"frame,x,y,a,b,theta\n{text}")
        go.says(f"convert {name} b.csv --overwrite", 0, message, told=False)


def test_a_truth_of_frames_that_nobody_has_looked_at_is_said(go: Tell) -> None:
    film(range(8))
    command, told = f"{TRACK} --init 20,10,16,20 --stride 3", "absent: {} frames without a row"
    go.says(f"{command} -o a.vot.txt", 0, told.format(4))  # up to its last one, frame 6
    go.says(f"{command} -o a.csv", 0, "absent", told=False)
    go.says("convert a.csv a.otb.txt --video film", 0, told.format(5))
    go.says("convert a.csv a.json --video film", 0, "absent", told=False)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a.parquet", "a.vot.txt", "a.keyframes.csv", "a.dlc.csv",
                                  "a.ls.json", "a.yolo", "a.gt.txt"])  # fmt: skip
def test_track_writes_all_formats(go: Tell, name: str) -> None:
    film(range(3))
    command = f"{TRACK} --init 20,10,16,20 -o"
    if name == "a.parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    go.says(f"{command} {name}", 0, f"wrote {name}")
    form = registry.format_for(name)
    if registry.FORMATS.resolve(form).single:
        go.says(f"{command} b.x --format {form} --init 5,5,20,20", 2, "one object, and there may")
        assert "holds one object" in go(f"watch film -o {name} --overwrite")[1]
    if form == "parquet":
        assert go(f"{command} a.csv")[0] == 0
        assert go("convert a.parquet b.csv")[0] == 0
        assert Path("a.csv").read_text() == Path("b.csv").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("rows", ["one.csv", "one.vot.txt", "one.xml"])
def test_files_made_of_rows_have_the_names_of_a_folders_images(go: Tell, rows: str) -> None:
    names = [f"img_{10 * frame:04d}" for frame in range(1, 41)]
    film(names, (320, 240), "Übung")
    if rows != "one.csv":
        assert go(f"convert one.csv {rows} --size 320x240")[0] == 0
    for target in ("a.json", "a.yolo", "masks"):
        assert go(f"convert {rows} {target} --video Übung")[0] == 0
    kept = names[:20] + names[25:] if rows == "one.csv" else names  # not where it is searched for
    images = json.loads(Path("a.json").read_text())["images"]
    assert [each["file_name"] for each in images] == [f"{name}.png" for name in kept]
    assert sorted(path.stem for path in Path("a.yolo/labels").glob("*.txt")) == kept
    assert sorted(path.stem for path in Path("masks").iterdir()) == names


@pytest.mark.parametrize("target", ["a.json", "a.yolo"])
def test_names_of_images_that_are_made_up_are_said(go: Tell, target: str) -> None:
    """Rows of a folder of images do not hold their names."""
    film(["b7", "b8", "b9"])
    assert go(f"{TRACK} --init 5,5,20,20 --start 1 -o own.csv")[0] == 0
    said = f"are called frame_000001.png and so on in {target}; give --video FOLDER"
    go.says(f"convert own.csv {target}", 0, said)
    go.says(f"convert own.csv {target} --video film --overwrite", 0, "frame_000001", told=False)
    assert "frame_000" not in go("convert own.csv own.xml")[1]


@pytest.mark.parametrize(("first", "told"), [(8, True), (10, False)])
def test_another_order_of_images_in_cvat_is_said(go: Tell, first: int, told: bool) -> None:
    """A task of 8.png, 9.png and 10.png begins with the last, and tracks have no names."""
    film(range(first, first + 3))
    for line in (f"{TRACK} --init 5,5,20,20 -o a.xml", "convert a.xml a.csv --video film"):
        go.says(line, 0, "10.png before 2.png, unless the sorting method", told=told)
    go.says(f"{TRACK} --init 5,5,20,20 -o a.json", 0, "sorting method", told=False)


@pytest.mark.parametrize("step", [1, 10])
def test_labels_belong_to_the_images_of_their_names(go: Tell, step: int) -> None:
    """The numbers in the names count from 1, or by tens; the frames are 0 to 5."""
    film(f"img_{step * (frame + 1):04d}" for frame in range(6))
    for name in ("rows.csv", "a.yolo"):
        assert go(f"{TRACK} --fps 25 --init 20,10,16,20 -o {name}")[0] == 0
    last = Path(f"a.yolo/labels/img_{6 * step:04d}.txt")
    kept = last.read_text()
    last.unlink()
    Path("a.yolo/labels/frame_000005.txt").write_text(kept)  # as motes names a frame of a video
    assert go("convert a.yolo back.csv --video film --fps 25")[0] == 0
    for row, same in zip(read_csv("rows.csv"), read_csv("back.csv"), strict=True):
        assert row["frame"] == same["frame"]
        assert float(row["left"]) == pytest.approx(float(same["left"]), abs=0.01)
    go.says("draw film a.yolo --fps 25 -o a.mp4", 0, "6 frames")


def test_labels_of_other_images_are_refused(go: Tell) -> None:
    film((1, 2))
    film((3,), folder="twins")
    Image.open("twins/3.png").save("twins/3.jpg")
    Path("labels").mkdir()
    Path("labels/3.txt").write_text("0 0.5 0.5 0.1 0.1\n")
    said = "labels: 3.txt: the film has no image of this name; give the film that it"
    go.says("convert labels a.csv --video film --fps 25", 3, said, lines=1)
    code, said = go("convert labels a.csv --video twins --fps 25")
    assert (code, said.count("\n")) == (3, 2), said
    assert "twins has several images 3, so that a text is of none of them" in said


STATES = (
    ("tracking", True), ("lost", True), ("searching", True), ("searching", False),
    ("absent", False), ("tracking", True),
)  # fmt: skip
"""Those of the frames of a row, and whether it has a place."""


def test_guesses_that_are_marked_are_counted_where_their_frame_is_written(go: Tell) -> None:
    """The guess in frame 1 is not, as another object is searched for in it."""
    lines = ["frame,id,x,y,a,b,theta,confidence,status"]
    for frame, state in enumerate(("tracking", "searching", "tracking")):
        lines += [f"{frame},1,50,40,8,6,0,0.9,{state}", f"{frame},2,200,100,9,9,0,0.2,tracking"]
    Path("rows.csv").write_text("\n".join(lines) + "\n")
    counted = {
        "a.json": "corrects that, or marks it as absent; 2 guesses marked (",
        "a.xml": "with the 3 frames in rows.csv; 3 guesses marked (",
        "a.yolo": "marks it as absent; 3 guesses left out (",
    }
    for target, said in counted.items():
        go.says(f"convert rows.csv {target} --size 320x240", 0, said)


def test_that_a_target_is_not_found_does_not_say_that_it_is_not_there(go: Tell) -> None:
    """The frames 1 to 3 are no pictures without it; frame 4 is one, as a user has marked it."""
    lines = ["frame,id,x,y,a,b,theta,confidence,status"]
    for frame, (state, placed) in enumerate(STATES):
        place = f"{50 + frame},40,8,6,0,0.5" if placed else ",,,,,"
        lines += [f"{frame},1,{place},{state}", f"{frame},2,200,100,9,9,0,1,tracking"]
    Path("rows.csv").write_text("\n".join(lines) + "\n")
    for target in ("a.yolo", "b --to yolo-predictions", "a.json"):
        line = f"convert rows.csv {target} --size 320x240 --identity 1"
        said = go.says(line, 0, "with 3 of the 6 frames in rows.csv; in the others a target is")
        assert " lost or searched for: motes refine corrects that, or marks it as absent" in said
    for folder in ("a.yolo", "b"):
        texts = {path.stem: path.read_text() for path in Path(folder, "labels").glob("*.txt")}
        assert [*sorted(texts)] == ["frame_000000", "frame_000004", "frame_000005"]
        assert [bool(text) for _, text in sorted(texts.items())] == [True, False, True]
    document = json.loads(Path("a.json").read_text())
    assert [each["frame"] for each in document["images"]] == [0, 4, 5]
    assert [each["image_id"] for each in document["annotations"]] == [1, 6]
    assert go("convert rows.csv a.keyframes.csv --identity 1")[0] == 0
    marks = [line.split(",")[:2] for line in Path("a.keyframes.csv").read_text().splitlines()]
    assert marks == [["frame", "x"], ["0", "42.5"], ["4", "absent"], ["5", "47.5"]]
    assert "with 3 of the 6 frames" in go("convert rows.csv both.yolo --size 320x240")[1]
    assert "with the 6 frames" in go("convert rows.csv 2.yolo --size 320x240 --identity 2")[1]


SEEN = [0, 1, 4]
"""Of the frames 0 to 4, those that are no guesses: 2 is interpolated, and 3 of low confidence."""
SHOWN = ["a.yolo", "a.json", "a.xml", "a.gt.txt", "a.otb.txt", "a.ls.json", "a.keyframes.csv"]


def shown(name: str) -> list[int]:
    """Return the frames in which a document shows the object."""
    facts = FilmFacts(width=320, height=240, fps=25)
    rows = registry.read(Path(name), registry.recognized(Path(name)), facts)
    return [
        row.frame
        for row in rows
        if any(each.status == "tracking" and each.confidence > 0 for each in row.objects)
    ]


@pytest.mark.parametrize("target", SHOWN)
def test_guesses_are_not_exported_as_seen(go: Tell, target: str) -> None:
    states = ["tracking,1", "tracking,0.5", "interpolated,0.9", "tracking,0.49", "tracking,0.8"]
    lines = [f"{i},1,{50 + i * i},40,8,6,0,{state}" for i, state in enumerate(states)]
    titles = "frame,id,x,y,a,b,theta,status,confidence"
    Path("rows.csv").write_text("\n".join([titles, *lines]) + "\n")
    made = f"convert rows.csv {target} --size 320x240 --fps 25 --overwrite"
    made += " --keyframe-error 0" * target.endswith((".xml", ".ls.json", "keyframes.csv"))
    assert "2 guesses" in go(made)[1]
    assert shown(target) == SEEN
    assert "guess" not in go(f"{made} --with-guesses")[1]
    assert shown(target) == [*range(5)]


def test_a_frame_of_objects_alone_that_do_not_count_is_no_empty_example(go: Tell) -> None:
    """Flag 0 marks them in a truth; in frame 2 one stands beside another that counts."""
    rows = "1,1,9,9,20,40,1,1,1", "2,1,9,9,20,40,0,1,1", "3,1,9,9,20,40,1,1,1", "3,2,99,9,9,9,0,8,1"
    Path("gt.txt").write_text("\n".join(rows) + "\n")
    said = "with 2 of the 3 frames in gt.txt; in the others a target is lost or"
    assert "motes refine" not in go.says("convert gt.txt a.yolo --size 320x240", 0, said)
    texts = {path.stem: path.read_text() for path in Path("a.yolo/labels").glob("*.txt")}
    lines = {stem: len(text.splitlines()) for stem, text in texts.items()}
    assert lines == {"frame_000000": 1, "frame_000002": 1}


def test_where_a_tracker_of_vot_began_or_failed_is_no_empty_example(go: Tell) -> None:
    """Its results have 1 and 2 there; 0 is a frame without a target in a truth."""
    Path("truth.txt").write_text("1\n10,20,30,40\n2\n0\n10,20,30,40\n")
    assert "with 2 of the 4" in go("convert truth.txt a.yolo --from vot --size 320x240")[1]
    texts = {path.stem[-1]: path.read_text() for path in Path("a.yolo/labels").glob("*.txt")}
    assert {stem: bool(text) for stem, text in texts.items()} == {"1": True, "3": False, "4": True}


def test_a_frame_of_a_crowd_or_skeletons_alone_is_no_empty_example(go: Tell) -> None:
    images = [
        {"id": i, "file_name": f"frame_{i:06d}.png", "width": 99, "height": 99} for i in range(4)
    ]
    one = {"category_id": 1, "bbox": [9, 9, 20, 20]}
    bare = {"bbox": [0, 0, 0, 0], "keypoints": [9, 9, 2]}
    given = [one | {"image_id": 0}, one | {"image_id": 0, "iscrowd": 1}]
    given += [one | {"image_id": 1, "iscrowd": 1}, one | {"image_id": 2} | bare]
    document = {"images": images, "annotations": given, "categories": [{"id": 1, "name": "car"}]}
    Path("a.json").write_text(json.dumps(document))
    bones = '<skeleton label="car" frame="{}"/>'
    box = '<box frame="0" xtl="9" ytl="9" xbr="29" ybr="29"/>'
    parts = box + bones.format(0), bones.format(1), '<cuboid frame="2" outside="0"/>'
    end = box.replace("<box", '<box outside="1"')
    ends = [end.replace('frame="0"', f'frame="{i + 1}"') for i in range(3)]
    tracks = [
        f'<track id="{i}" label="car">{part}{end}</track>'
        for i, (part, end) in enumerate(zip(parts, ends, strict=True))
    ]
    size = "<original_size><width>99</width><height>99</height></original_size>"
    task = f"<meta><task><size>4</size>{size}</task></meta>"
    Path("tracks.xml").write_text(f"<annotations>{task}{''.join(tracks)}</annotations>")
    named = [f'<image id="{i}" name="frame_{i:06d}.png" width="99" height="99">' for i in range(4)]
    held = box.replace("<box", '<box label="car"') + bones, bones, '<cuboid label="car"/>', ""
    shown = (f"{image}{part}</image>" for image, part in zip(named, held, strict=True))
    Path("images.xml").write_text(f"<annotations>{task}{''.join(shown)}</annotations>")
    for name in ("a.json", "tracks.xml", "images.xml"):
        assert go(f"convert {name} a.yolo --overwrite")[0] == 0
        texts = {path.stem[-1]: path.read_text() for path in Path("a.yolo/labels").glob("*.txt")}
        assert {stem: bool(text) for stem, text in texts.items()} == {"0": True, "3": False}, name


@pytest.mark.parametrize("others", [0, 1])
def test_rows_keep_where_an_object_is_not_there(go: Tell, others: int) -> None:
    """Keyframes of a track of CVAT that is interrupted say so, also by way of rows."""
    box = '<box frame="{}" outside="{}" xtl="9" ytl="9" xbr="19" ybr="19"/>'
    track = "".join(box.format(frame, outside) for frame, outside in ((2, 0), (4, 1), (7, 0)))
    other = f'<track id="2" label="cup">{box.format(5, 0)}{box.format(6, 1)}</track>' * others
    Path("a.xml").write_text(
        "<annotations><meta><task><size>9</size></task></meta>"
        f'<track id="1" label="cup">{track}</track>{other}</annotations>'
    )
    assert go("convert a.xml a.csv")[0] == 0
    for source in ("a.xml", "a.csv"):
        assert go(f"convert {source} keyframes.csv --identity 1 --overwrite")[0] == 0
        lines = Path("keyframes.csv").read_text().splitlines()
        assert [line for line in lines if "absent" in line] == ["0:1,absent", "4:6,absent"], source


def test_rows_of_a_truth_tell_absent_frames_from_unknown_ones(go: Tell) -> None:
    Path("a.vot.txt").write_text("9,9,9,9\nnan,nan,nan,nan\n2\n9,9,9,9\n")
    assert go("convert a.vot.txt a.csv")[0] == 0
    found = [row["status"] for row in read_csv("a.csv")]
    assert found == ["tracking", "absent", "searching", "tracking"]


def test_boxes_outside_of_the_picture_are_counted(go: Tell) -> None:
    """A document lacks them, and all boxes of another film's rows may be some."""
    Path("a.csv").write_text("frame,left,top,width,height\n0,9,9,9,9\n1,64,9,9,9\n")
    said = "a.csv: the picture of 64x48 has nothing of 1 of its 2 boxes; formats that cut boxes"
    go.says("convert a.csv a.yolo --size 64x48", 0, said)
    go.says("convert a.csv b.yolo --size 65x48", 0, "has nothing of", told=False)
