"""motes watch, from the outside."""

import json
import signal
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from clips import write_pictures
from commands import Go, read_csv, running
from motes import EventCounter, Frame, Scene, SourceError, open_source
from motes.cli import main
from motes.cli.outputs import EventsOutput
from motes.cli.watch_loop import counted_moments, table
from motes.cli.watch_options import CountingOptions
from motes.core.track import COLUMNS, GROUND, Status, Track
from motes.mot.analytics.regions import SETTLED, Line, Regions, Zone
from red_box import walk
from sightings import seen, told

FRAMES = 90
WALKED = 11
"""Frames after which the box has walked as far as it is high, and appears."""


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a film of a red box that walks over noise from frame 35 on, to the right, and out."""
    path = tmp_path_factory.mktemp("film") / "film.mkv"
    walk(path, FRAMES, enters=35)
    return str(path)


@pytest.fixture
def go(film: str, here: Path, capfd: pytest.CaptureFixture[str]) -> Go:
    """Run motes watch in an empty folder; FILM in the arguments is the video."""
    return running(capfd, "watch", FILM=film)


@pytest.mark.slow
def test_one_walks_by(go: Go) -> None:
    """With no setting but the source, what is counted, and where results go."""
    outputs = "-o r.csv --events e.jsonl --overlay o.mkv"
    lines = "--line 80,0,80,95 --line 110,0,110,95 --turns --scale 20"
    code, out, error = go(f"FILM {outputs} {lines}")
    assert (code, out) == (0, "")
    assert "90 frames, 1 object, 1 of them gone; " in error
    assert "each tracked by 100 particles and color; " in error
    assert "wrote o.mkv, e.jsonl, r.csv" in error
    assert "minute 0: appears 1, crosses line 1 in 1, crosses line 2 in 1, disappears 1" in error
    assert "from / to  line 2\nmotes: line 1          1\n" in error
    rows = read_csv("r.csv")
    assert tuple(rows[0]) == COLUMNS + GROUND
    assert {row["id"] for row in rows} == {"1"}
    assert {row["speed"] == "" for row in rows if row["status"] != "tracking"} == {True}
    speeds = [float(row["speed"]) for row in rows if row["speed"]]
    assert speeds[6:] == pytest.approx([5] * len(speeds[6:]), abs=0.7)  # also at the edge
    middle = next(row for row in rows if row["frame"] == "60")
    assert float(middle["left"]) == pytest.approx(4 * 25 - 16, abs=2)
    assert float(middle["width"]) == pytest.approx(16, abs=2)
    events = [json.loads(line) for line in Path("e.jsonl").read_text().splitlines()]
    assert [event["event"] for event in events] == ["appears", *["crosses"] * 2, "disappears"]
    assert events[1]["speed"] == pytest.approx(100, abs=8)  # 4 pixels in 1/25 s
    with open_source("o.mkv") as overlay:
        assert sum(1 for _ in overlay) == FRAMES


def test_an_interrupted_run_counts_what_it_has_written(
    go: Go, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The interrupt comes after the frame with the first event is found, before it is written."""
    watch = Scene.watch

    def interrupted(scene: Scene, *frames: Any, **options: Any) -> Iterator[object]:
        there = 0
        for found in watch(scene, *frames, **options):
            yield found
            there += scene.created
            if there == WALKED:
                raise KeyboardInterrupt

    monkeypatch.setattr(Scene, "watch", interrupted)
    code, _, error = go("FILM -o r.csv --events e.jsonl")
    assert (code, "frames, 1 object, 0 of them gone; " in error) == (130, True), error
    assert "minute 0: appears 1\n" in error
    assert Path("e.jsonl").read_text().count("\n") == 1
    assert Path("r.csv").read_text().count("\n") == 1 + WALKED


WALK = [
    (Frame(i, i / 4, np.zeros((9, 9, 3), np.uint8)), [seen(i, (80, 31 + 9 * i))]) for i in range(4)
]
"""It crosses y = 50 in the last frame: too late for a report 0.4 seconds later."""


def test_the_beginning_of_a_film_has_the_rows_of_the_whole(go: Go) -> None:
    """The background is that of the film, also where only a few frames of it are watched."""
    assert go("FILM --start 38 -o whole.csv")[0] == 0
    assert go("FILM --start 38 --end 46 -o part.csv")[0] == 0
    whole, part = (Path(name).read_text().splitlines() for name in ("whole.csv", "part.csv"))
    assert len(part) > 2
    assert part == whole[: len(part)]


@pytest.mark.parametrize("end", [KeyboardInterrupt(), SourceError("The camera is gone.")])
def test_what_ends_a_run_loses_no_crossing_that_has_happened(end: BaseException) -> None:
    def found() -> Iterator[tuple[Frame, list[Track]]]:
        yield from WALK
        raise end

    moments = counted_moments(found(), EventCounter(Regions((Line((0, 50, 200, 50)),))))
    told = [(each.frame, each.event) for _ in WALK for each in next(moments).events]
    assert told == [(0, "appears"), (3, "crosses")]
    with pytest.raises(type(end)):
        next(moments)


def test_events_in_a_file_are_in_the_order_of_frames(tmp_path: Path) -> None:
    """One stands on the line for 2 s before it is over; another appears and vanishes meanwhile."""
    counter = EventCounter(Regions((Line((0, 50, 200, 50)),), (Zone((0, 60, 200, 60, 9, 99)),)))
    path = tmp_path / "e.jsonl"

    def found() -> Iterator[tuple[Frame, list[Track]]]:
        for i in range(24):
            y = 40 + 4 * i if i < 3 else 50.5 if i < 12 else 4 * i + 8
            tracks = [seen(i, (80, y))] if i < 18 else []
            tracks += [seen(i, (150, 20 + i), identity=2)] if 5 <= i < 9 else []
            tracks += [seen(i, (150, 28), Status.LOST, 2)] if i == 9 else []
            yield Frame(i, i / 4, np.zeros((9, 9, 3), np.uint8)), tracks

    with EventsOutput(str(path), False) as events:
        moments = [*counted_moments(found(), counter)]
        for moment in moments:
            events.write(moment)
    written = [json.loads(line)["frame"] for line in path.read_text().splitlines()]
    assert written == sorted(written)
    came = [event.frame for moment in moments for event in moment.events]
    assert sorted(came) == written != came
    so_far = Counter[str]()
    for moment in moments:
        so_far.update(event.total for event in moment.events if event.total)
        assert {name: count for name, count in moment.totals.items() if count} == so_far
    assert so_far


def test_nor_does_an_interrupt_while_a_frame_is_written() -> None:
    moments = counted_moments(iter(WALK), EventCounter(Regions((Line((0, 50, 200, 50)),))))
    assert [next(moments).frame.index for _ in range(3)] == [0, 1, 2]
    last = moments.throw(KeyboardInterrupt())
    assert (last.frame.index, [event.event for event in last.events]) == (3, ["crosses"])
    assert last.totals[last.events[0].total] == 1
    with pytest.raises(KeyboardInterrupt):
        next(moments)


@pytest.mark.slow
def test_who_stays_in_a_zone(go: Go) -> None:
    """The walker is in the middle half for 80 pixels, 20 frames; one zone has its own dwell."""
    Path("p.toml").write_text(
        "[[zone]]\nname = 'hall'\npoints = [40, 0, 120, 0, 120, 95, 40, 95]\n"
        "[[zone]]\nname = 'desk'\npoints = [40, 0, 120, 0, 120, 95, 40, 95]\ndwell = 30\n"
    )
    code, out, error = go("FILM --events - --places p.toml --dwell 0.58")
    assert code == 0
    events = [json.loads(line) for line in out.splitlines()]
    (stay,) = (event for event in events if event["event"] == "stays")
    (enter, _) = (event for event in events if event["event"] == "enters")
    assert (stay["place"], stay["seconds"]) == ("hall", 0.6)
    assert stay["frame"] == enter["frame"] + 15
    assert "stays hall 1" in error


def test_a_run_that_fails_in_its_first_frame_leaves_no_file(go: Go) -> None:
    Path("gone.py").write_text("def find(frame): return 1 / 0\n")
    for _ in range(2):
        code, _, error = go("FILM --detector gone:find -o r.csv --events e.jsonl --end 9")
        assert (code, "failed in frame 0: ZeroDivisionError" in error) == (2, True), error
        assert not {*Path().glob("r.*"), *Path().glob("e.*")}


@pytest.mark.slow
def test_a_class_that_no_detection_has_is_said_beside_one_that_some_have(go: Go) -> None:
    Path("vans.py").write_text("def find(frame): return [(10, 60, 44, 30, 0.9, 'van')]\n")
    wanted = "no detection was of class lorry; the detector found van"
    for classes, missed in (("van,lorry", True), ("van", False)):
        line = f"FILM --detector vans:find --classes {classes} -o r.csv --overwrite --end 9"
        code, _, error = go(line)
        assert (code, wanted in error) == (0, missed), error


@pytest.mark.slow
def test_detections_that_could_not_be_used_are_counted(go: Go) -> None:
    text = [f"{i + 1},-1,{4 * (i - 35) - 15},41,16,30,1" for i in range(45, 60)]
    Path("det.txt").write_text("\n".join(text))
    assert "were not used" not in go("FILM --detector det.txt -o a.csv")[2]
    text += ["50,-1,900,41,16,30,1", "50,-1,20,41,1,1,1", "900,-1,20,41,16,30,1"]
    Path("det.txt").write_text("\n".join(text))
    for camera in ("still", "moving"):
        said = go(f"FILM --detector det.txt -o {camera}.csv --camera {camera}")[2]
        line = (
            "3 of 18 detections of det.txt were not used: 2 out of the picture or unfit in size, 1"
        )
        assert line in said
    assert Path("still.csv").read_bytes() == Path("a.csv").read_bytes()


def test_a_dwell_may_be_the_least() -> None:
    (zone,) = CountingOptions(zone=["0,0,9,0,9,9"], dwell=SETTLED).regions().zone
    assert zone.dwell == SETTLED


def test_an_interrupt_while_the_background_is_learned_is_told(
    go: Go, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Scene, "prepare", lambda *_: signal.raise_signal(signal.SIGINT))
    code, _, error = go("FILM -o r.csv")
    assert (code, error) == (130, "motes: interrupted after 0 frames; nothing is written.\n")
    assert not any(Path().iterdir())


@pytest.mark.slow
def test_frames_after_the_last_object_stay_in_what_is_made_of_rows(go: Go) -> None:
    """Not those in which it is lost in mid-picture: it may still be there."""
    text = [f"{i + 1},-1,{4 * (i - 35) - 15},41,16,30,1" for i in range(55, 60)]
    Path("det.txt").write_text("\n".join(text))
    for name in ("r.csv", "whole.json"):
        assert go(f"FILM --detector det.txt --end 80 -o {name}")[0] == 0
    assert main(["convert", "r.csv", "made.json"]) == 0
    made, whole = (
        [each["frame"] for each in json.loads(Path(name).read_text())["images"]]
        for name in ("made.json", "whole.json")
    )
    assert made == whole == [*range(62), *range(77, 80)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "code", "said"),
    [
        ("FILM --detector yolo", 2, "faces, MODULE:CALLABLE, or an .onnx or .txt file"),
        ("FILM --dwell 3", 2, "--dwell is for zones"),
        ("FILM --zone 0,0,9,0,9,9 --dwell 0", 2, "--dwell is 0; give seconds, 0.4 to 1e9."),
        ("FILM --scale 0", 2, "--scale is 0; give pixels per metre, from 1e-9 to 1e9."),
        ("FILM --places empty.toml", 2, "empty.toml has no [[line]], [[zone]] or [ground]; add"),
        ("FILM --zone 1,2,3,4", 2, "--zone takes x,y,x,y,x,y"),
        ("FILM --detector people --set detector.trial=1", 2, "known keys: type."),
        ("FILM --config nothing.toml", 3, "nothing.toml"),
        ("FILM -o - --events -", 2, "give one of them a file"),
        ("FILM --detector nothing.txt", 3, "nothing.txt cannot be read"),
        ("FILM --end 2 -o r.csv", 4, "ever found: one is reported with its third frame; give a"),
        ("FILM --end 5 -o r.csv", 4, "No object was ever found; try another --detector."),
        ("FILM --detector det.txt --least 0.5 -o r.csv", 4, "all scores are below 0.5; the highe"),
        ("FILM --detector own:find --classes 3 -o r.csv", 4, "objects of class 2, none of class 3"),
        ("FILM --detector own:shares -o r.csv", 4, "no detection has its center in the picture"),
        ("FILM --classes walker", 2, "--classes: This detector knows no classes; give"),
        ("FILM --classes ,", 2, "--classes names no class; give some, such as person,car."),
        ("FILM --least 5", 2, "--least is 5; this detector has scores from 0 to 1."),
        ("FILM --reconnect 5", 2, "--reconnect is for live sources, which"),
        ("FILM --events ftp://x/y", 2, "--events ftp://x/y: such addresses are not known; give"),
    ],
)
def test_errors_are_one_line_with_their_code(go: Go, line: str, code: int, said: str) -> None:
    Path("det.txt").write_text("1,-1,10,60,44,30,0.3\n2,-1,10,60,44,30,-2\n")
    Path("empty.toml").write_text("# lines to come\n")
    Path("own.py").write_text(
        "def find(frame): return [(10, 60, 44, 30, 0.9, 2)]\n"
        "def shares(frame): return [(0.1, 0.6, 0.4, 0.3, 0.9), (1e4, 60, 44, 30, 0.9)]\n"
    )
    found, _, error = go(line)
    assert (found, said in error) == (code, True), error
    assert "Traceback" not in error
    assert error.splitlines()[-1].startswith("motes: error: ")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "line"),
    [
        ("--set detector.history=40 --set termination.max-age=2", "history = 40"),
        ("--detector people", 'type = "people"'),
        ("--detector det.txt --set detections.limit=8", 'file = "det.txt"'),
        ("--detector faces", 'type = "faces"'),
        ("--like 64,40,16,30 --set detector.color.bins=4,4,4", 'space = "hsv+v"'),
        ("--set detector.type=background --set detector.noise=5", "noise = 5.0"),
    ],
)
def test_a_dumped_configuration_is_the_same_again(go: Go, options: str, line: str) -> None:
    code, text, error = go(f"--dump-config {options}")
    assert (code, error) == (0, "")
    detector = text[text.index("[detector]") :]
    assert line in detector.splitlines()
    Path("s.toml").write_text(text)
    assert go("--dump-config --config s.toml") == (0, text, "")


def test_the_picture_is_remarked_on_once(go: Go, tmp_path: Path) -> None:
    for index in range(12):  # another color, not another exposure
        color = (100, 100, 100) if index < 8 else (200, 60, 60)
        Image.new("RGB", (64, 48), color).save(tmp_path / f"{index}.png")
    _, _, error = go("*.png -o r.csv")
    assert error.count("Frame 8: the picture changes all over") == 1


def test_the_table_is_by_the_minute() -> None:
    counting = EventCounter(Regions((Line((50, 0, 50, 99), "gate"),)))
    there = zip(
        [0, 1, 2, 3, 4, 299, 300, 301, 302], [42, 47, 52, 57, 62, 58, 53, 48, 43], strict=True
    )
    told(counting, *(seen(frame, (x, 40)) for frame, x in there))
    counting.finish()
    assert table(counting.counts) == [
        "minute 0: appears 1, crosses gate in 1",
        "minute 1: crosses gate out 1",
        "in all: appears 1, crosses gate in 1, crosses gate out 1",
    ]


@pytest.mark.slow
def test_an_onnx_file_finds_classes(go: Go) -> None:
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    models = pytest.importorskip("onnx_models", reason="onnx is not installed")
    models.save(Path("red.onnx"), "yolo", size=(160, 96))
    Path("red.toml").write_text('classes = ["walker", "sky"]\nscore = 0.5\n')
    pixels = np.full((96, 160, 3), 100, np.uint8)
    pixels[48:64, 64:80] = (230, 40, 40)
    write_pictures("still.mkv", [pixels] * 20)
    line = "still.mkv --detector red.onnx -o r.csv --events e.jsonl"
    code, _, error = go(f"{line} --classes walker --least 0.6")
    assert code == 0, error
    assert "appears walker 1" in error
    rows = read_csv("r.csv")
    assert {row["label"] for row in rows} == {"walker"}
    events = [json.loads(each) for each in Path("e.jsonl").read_text().splitlines()]
    assert {each["label"] for each in events} == {"walker"}
    code, _, error = go(f"{line} --classes cat --overwrite")
    assert code == 2
    assert "--classes: The detector has no class 'cat'; it has walker, sky." in error
    assert go(f"{line} --classes sky --overwrite")[0] == 4
    Path("red.toml").unlink()
    code, _, error = go(f"{line} --classes walker --overwrite")
    assert code == 2
    assert "--classes: red.onnx does not name its classes; give their numbers, or" in error
    assert go(f"{line} --classes 0 --overwrite")[0] == 0
