"""The command line: what users see, what they get, and how it fails."""

import contextlib
import importlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from PIL import Image

from clips import write_film
from commands import Go, read_csv, running
from motes import Ellipse, Frame, Source, SourceError, StepInfo, Tracker, open_source, synthetic
from motes.cli import Moment, main
from motes.cli.app import commands
from motes.cli.option_groups import Help
from motes.cli.track_frames import ObjectsTally, TargetTally
from motes.core.track import COLUMNS, Status, Track
from motes.rows.schema import FrameRow
from motes.video.prefetch import prefetch
from waiting import wait_until

FRAMES = 30
SIZE = (160, 120)
PROGRAM = [sys.executable, "-m", "motes"]


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """Return a small video and, as an option takes it, the target's box in its first frame."""
    path = tmp_path_factory.mktemp("film") / "film.mkv"
    clip = synthetic.still(SIZE, target=(30, 40), frames=FRAMES)
    write_film(path, clip)
    box = clip[0][1][0].ellipse.box
    return str(path), ",".join(f"{value:.1f}" for value in box)


@pytest.fixture
def go(film: tuple[str, str], here: Path, capfd: pytest.CaptureFixture[str]) -> Go:
    """Run a command in an empty folder; return exit code, standard output, standard error.

    In the arguments, FILM is the video and BOX its target.
    """
    return running(capfd, FILM=film[0], BOX=film[1])


def count(path: Path) -> int:
    """Return the number of whole lines in a file that may not be there yet."""
    return path.read_bytes().count(b"\n") if path.exists() else 0


@contextlib.contextmanager
def started(arguments: list[str], **streams: Any) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [*PROGRAM, *arguments], stderr=streams.pop("stderr", subprocess.PIPE), text=True, **streams
    )
    with process:
        try:
            yield process
        finally:
            process.kill()


@pytest.fixture(scope="module")
def slow_film(film: tuple[str, str], tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a source that takes long enough to be interrupted: many links to few pictures."""
    folder = tmp_path_factory.mktemp("slow")
    with open_source(film[0]) as source:
        for frame in source:
            Image.fromarray(frame.pixels).save(folder / f"{frame.index}.png")
    for index in range(FRAMES, 2000):
        (folder / f"{index}.png").symlink_to(folder / f"{index % FRAMES}.png")
    return str(folder)


def test_rows_are_what_the_tracker_says(go: Go, film: tuple[str, str]) -> None:
    code, out, error = go("track FILM --init BOX --end 12 -o r.csv")
    assert (code, out) == (0, "")
    assert re.fullmatch(
        r"motes: 12 frames, tracked in 100\.0 %, tracker [\d.]+ ms a frame; wrote r\.csv\.\n", error
    )
    tracker = Tracker(seed=0)
    region = [float(number) for number in film[1].split(",")]
    with open_source(film[0], end=12) as source:
        tracks = [
            tracker.update(frame) if frame.index else tracker.init(frame, region)
            for frame in source
        ]
    read = read_csv("r.csv")
    for track, row in zip(tracks, read, strict=True):
        assert (int(row["frame"]), row["status"]) == (track.frame, track.status)
        assert float(row["x"]) == round(track.ellipse.x, 3)
        assert float(row["confidence"]) == round(track.confidence, 5)


def test_standard_output_holds_rows_and_nothing_else(go: Go) -> None:
    code, out, error = go("track FILM --init BOX -o - --end 4")
    assert code == 0
    assert out.splitlines()[0] == ",".join(COLUMNS)
    assert out.count("\n") == 5
    assert error.count("\n") == 1
    assert go("track FILM --init BOX --end 4")[1] == out
    lines = go("track FILM --init BOX -o - --format jsonl --end 4")[1].splitlines()
    assert [json.loads(line)["frame"] for line in lines] == [0, 1, 2, 3]


def test_an_ellipse_is_taken_as_it_is(go: Go) -> None:
    _, out, _ = go("track FILM --init 60,50,20,10,0.5 --end 1 -o -")
    assert ",60.000,50.000,20.000,10.000,0.50000," in out.splitlines()[1]


@pytest.mark.slow
def test_overlay(go: Go, film: tuple[str, str]) -> None:
    code, out, error = go("track FILM --init BOX --preset nummiaro --start 5 --overlay o.mp4")
    assert (code, out) == (0, "")
    assert error.rstrip().endswith("wrote o.mp4.")
    assert os.listdir() == ["o.mp4"]
    with av.open("o.mp4") as drawn_file:
        assert drawn_file.streams.video[0].start_time == 0
    with open_source("o.mp4") as drawn, open_source(film[0], start=5) as plain:
        pairs = list(zip(drawn, plain, strict=True))
    assert [round(a.time - b.time, 3) for a, b in pairs] == [-0.2] * (FRAMES - 5)
    changed = [np.abs(a.pixels.astype(int) - b.pixels).max() > 100 for a, b in pairs]
    assert all(changed)


@pytest.mark.slow
def test_nothing_is_overwritten_unasked(go: Go) -> None:
    Path("r.csv").write_text("precious")
    Path("o.mp4").write_text("precious")
    for option in ("-o r.csv", "--overlay o.mp4"):
        code, _, error = go(
            f"track FILM --init BOX -o new.csv {option}".replace("-o new.csv -o", "-o")
        )
        assert (code, "exists; choose another" in error) == (5, True)
        assert "--overwrite" in error
        assert not Path("new.csv").exists()
    assert Path("r.csv").read_text() == Path("o.mp4").read_text() == "precious"
    assert go("track FILM --init BOX --end 3 -o r.csv --overlay o.mp4 --overwrite")[0] == 0
    assert len(read_csv("r.csv")) == 3
    assert Path("o.mp4").stat().st_size > 1000


@pytest.mark.parametrize(("frames", "said"), [(25, False), (26, True)])
def test_who_was_away_for_long_may_be_another(frames: int, said: bool) -> None:
    tally, several = TargetTally(), ObjectsTally(2)
    pixels = np.zeros((9, 9, 3), np.uint8)
    states = [Status.TRACKING, Status.LOST, *[Status.SEARCHING] * (frames - 1), Status.TRACKING]
    for i, status in enumerate(states):
        track = Track(i, i / 25, Ellipse(4, 4, 2, 2, 0), status=status)
        tally.add(Moment(Frame(i, i / 25, pixels), [track], StepInfo(track)))
        other = Track(i, i / 25, Ellipse(4, 4, 2, 2, 0), status=Status.TRACKING)
        several.add(Moment(Frame(i, i / 25, pixels), [other, track]))
    changes = f"lost at frame 1, found at frame {frames + 1}"
    if said:
        changes += ", found after more than a second, look whether it is the same one"
    assert str(tally).endswith(changes)
    assert "object 1 tracked in 100.0 %, object 2 tracked in" in str(several)
    assert f" % ({changes}), trackers" in str(several)


@pytest.mark.slow
def test_never_found(go: Go) -> None:
    pytest.importorskip("dlib", reason="faces need dlib")
    for index in range(3):
        Image.new("RGB", SIZE, (0, 90, 90)).save(f"{index}.png")
    code, _, error = go("track *.png --detect face -o r.csv")
    assert code == 4
    assert error.splitlines()[-1].startswith("motes: error: The target was never found; ")
    assert len(read_csv("r.csv")) == 3


def test_layers_preset_then_file_then_options(go: Go) -> None:
    Path("c.toml").write_text("particles = 30\n[motion.noise]\nposition = 0.25\nsize = 0.0625\n")
    code, out, _ = go(
        "track --preset nummiaro:adaptive --config c.toml --set motion.noise.size=0.5 "
        "--set color.bins=16,16,16 --set color.space=hsv --dump-config"
    )
    assert code == 0
    Path("all.toml").write_text(out)
    assert go("track --config all.toml --dump-config")[1] == out
    for line in ("particles = 30", "position = 0.25", "size = 0.5", 'space = "hsv"', "rate = 0.05"):
        assert f"{line}\n" in out


@pytest.mark.slow
@pytest.mark.parametrize("command", ["track", "watch"])
def test_help_shows_what_people_use_and_help_all_the_rest(go: Go, command: str) -> None:
    usual, every = (
        re.findall(r"^│ (--[a-z-]+)", go(f"{command} {flag}")[1], re.MULTILINE)
        for flag in ("--help", "--help-all")
    )
    assert set(usual) < set(every)
    formatter = commands([])[command].help_formatter
    assert isinstance(formatter, Help)
    assert formatter.usual == set(usual)  # none is misspelled


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        ("track", 2, "There is no source; name a video"),
        ("track FILM", 2, "Give one of --init, --detect, --at, --keyframes, for"),
        ("track FILM --init BOX --detect face", 2, "--init and --detect contradict each other"),
        ("track FILM --init 1,2,3", 2, "--init takes x,y,width,height"),
        ("track FILM --init BOX --init BOX", 2, "is given twice; give each object once"),
        ("track FILM --init 900,900,10,10", 2, "center outside the frame of 160x120; choose"),
        ("track FILM --init BOX --config bad.toml", 2, "bad.toml: .*did you mean 'particles'"),
        ("track FILM --init BOX --config FILM", 3, "it is not text; save it as UTF-8"),
        ("track FILM --init BOX --seed -1", 2, "--seed is -1; give 0 or more"),
        ("track FILM --init BOX --end 10.7", 2, "--end: 10.7 is no whole number"),
        ("track FILM --init BOX --start 0:01", 2, "0:01 is no whole number. Frames count from 0"),
        ("track FILM --at 00:01=BOX", 2, "by its number, which counts from 0, and not by a time"),
        ("track FILM --init 50,40,9,9,45", 2, "theta begins with 45; it is in radians"),
        ("track FILM --preset nummiaro --network a.onnx", 2, "Preset nummiaro takes no network"),
        ("track FILM --init 30 40 20 20", 2, "No option takes 40 20 20; numbers .*need commas"),
        ("track FILM my.csv", 2, r"No option takes .*; a name with spaces needs quotes, and"),
        ("track FILM FILM", 2, r"No option takes .*; motes batch goes through several films; qu"),
        ("watch FILM FILM", 2, r"several films; quote a pattern, as 'img/\*.png', which the shell"),
        ("track FILM --init BOX --start 99", 3, "choose a smaller start"),
        ("track FILM --init BOX -o r.text", 2, "in none of .csv, .*, .yolo; rename"),
        ("track FILM --init BOX -o none/r.csv", 5, "There is no folder none for r.csv; make it"),
        ("track FILM --init BOX --overlay o.avi", 2, "does not end like a video; use"),
        ("track FILM --init BOX --overlay FILM --overwrite", 2, "is the source"),
        ("track FILM --init BOX -o x.mp4 --format csv --overlay x.mp4", 2, "same file; give each"),
        ("track FILM --init BOX --resume -o -", 2, "cannot be resumed; write the rows to a file"),
        ("track FILM --init BOX -o /dev/full --format csv", 5, "No space left on device"),
        ("watch -o r.csv -- --end", 3, "no file or folder --end; an option comes before --."),
        ("track none.mp4 --init BOX", 3, "There is no file or folder none.mp4; check the name"),
        ("track images/%05d.png --init BOX", 3, "images/%05d.png; a pattern has [*]"),
        ("track -dash.mp4 --init BOX", 2, "no option -dash.mp4; for the file write ./-dash.mp4"),
        ("track empty.mp4 --init BOX", 3, "empty.mp4 is empty; give a video"),
        ("track FILM --init BOX --init 5,5,20,20 --detect face", 2, "--detect contradict each"),
        ("track FILM --init BOX --init 5,5,20,20 --figures f", 2, "--figures is for one --init"),
        ("track FILM --init BOX --init 5,5,9,9 --label cup,car", 2, "--label is one class"),
        ("track FILM --at 0=BOX --resume", 2, "not for keyframes: motes refine finishes such rows"),
        ("track FILM --init BOX --init 1,2,-3,4", 2, ".*has no area"),
        ("track FILM --init BOX -o r.xml --resume", 2, "--resume continues rows; r.xml holds none"),
        ("trak FILM", 2, 'Did you mean "track"'),
    ],
)
def test_wrong_input_is_one_line(go: Go, line: str, code: int, message: str) -> None:
    Path("bad.toml").write_text("particle = 3\n")
    Path("empty.mp4").touch()
    Path("-dash.mp4").touch()
    before = set(os.listdir())
    named = "-o " in line or "--overlay" in line
    found, out, error = go(line if named else f"{line} -o r.csv")
    assert (found, out, error.count("\n")) == (code, "", 1), error
    assert re.match(f"motes: error: .*{message}", error), error
    assert set(os.listdir()) == before
    assert not Path("/dev/full.run.json").exists()  # nothing is remembered beside a device


def test_an_unexpected_fault_asks_for_a_report(go: Go, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("two\nlines")

    monkeypatch.setattr(Tracker, "update", broken)
    code, _, error = go("track FILM --init BOX -o r.csv")
    assert code == 1
    assert error.count("\n") == 1
    assert "ZeroDivisionError: two lines. This is a defect of motes; please report it" in error
    assert len(read_csv("r.csv")) == 1
    monkeypatch.setenv("MOTES_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        go("track FILM --init BOX -o r.csv --overwrite")


def test_a_source_that_fails_halfway_leaves_its_rows(go: Go) -> None:
    for index in range(4):
        size = SIZE if index < 3 else (80, 60)
        Image.new("RGB", size, (200, 10 * index, 0)).save(f"{index}.png")
    code, _, error = go("track *.png --fps 25 --init 40,40,30,30 -o r.csv")
    _, summary, failure = error.splitlines()  # the first one says that the box is bare
    assert code == 3
    assert summary.startswith("motes: 3 frames, ")
    assert failure.startswith("motes: error: Frame 3 of *.png has 80x60 pixels")
    assert len(read_csv("r.csv")) == 3


@pytest.mark.slow
def test_help_into_a_closed_pipe() -> None:
    read, write = os.pipe()
    os.close(read)
    with open(write, "w") as closed, started(["--help"], stdout=closed) as process:
        _, error = process.communicate()
    assert (process.returncode, error) == (0, "")


def test_another_run_is_not_resumed(go: Go) -> None:
    assert go("track FILM --init BOX --preset nummiaro --end 12 -o r.csv")[0] == 0
    whole, remembered = Path("r.csv").read_bytes(), Path("r.csv.run.json").read_bytes()
    for other in ("--seed 5", "--set color.bins=9,9,9", "--start 1", "--stride 2", "--end 5"):
        line = f"track FILM --init BOX --preset nummiaro -o r.csv --resume {other}"
        code, _, error = go(line + " --end 12" * ("--end" not in other))
        assert (code, "r.csv cannot be resumed: " in error) == (5, True)
        assert Path("r.csv").read_bytes() == whole
        assert Path("r.csv.run.json").read_bytes() == remembered


def test_several_objects_are_resumed(go: Go) -> None:
    """A run that has ended amid the objects of a frame has then the bytes of one run."""
    line = "track FILM --init BOX --init 5,5,20,20 --preset mean_shift --end 8 -o r.csv"
    assert go(line)[0] == 0
    rows, history = Path("r.csv"), Path("r.csv.run.json")
    whole, remembered = rows.read_bytes(), history.read_bytes()
    rows.write_bytes(b"".join(whole.splitlines(keepends=True)[:8]))
    code, _, error = go(f"{line} --resume")
    assert (code, "wrote r.csv (rows from 8 on)" in error) == (0, True)
    assert (rows.read_bytes(), history.read_bytes()) == (whole, remembered)
    code, _, error = go(f"{line} --init 40,40,20,20 --resume")
    assert (code, "its line 4 differs" in error) == (5, True)
    assert rows.read_bytes() == whole


KILLED = """
import os, signal, sys
from motes.cli import main
from motes.rows.writer import TrackWriter

at, add = int(sys.argv[1]), TrackWriter.add

def add_or_die(self, picture):
    if picture.frame == at:
        os.kill(os.getpid(), signal.SIGKILL)
    add(self, picture)

TrackWriter.add = add_or_die
main(sys.argv[2:])
"""
"""Runs motes, and kills it when a frame's row is to be written."""


@pytest.mark.slow
def test_killed_then_resumed(film: tuple[str, str], tmp_path: Path) -> None:
    rows, whole = tmp_path / "r.csv", tmp_path / "whole.csv"
    line = ["track", film[0], "--init", film[1]]
    assert main([*line, "-o", str(whole)]) == 0
    done = subprocess.run([sys.executable, "-c", KILLED, "20", *line, "-o", rows])
    assert done.returncode == -signal.SIGKILL
    assert rows.read_bytes().count(b"\n") == 21  # with the header
    assert whole.read_bytes().startswith(rows.read_bytes())
    assert main([*line, "-o", str(rows), "--resume"]) == 0
    assert rows.read_bytes() == whole.read_bytes()


@pytest.mark.slow
def test_interrupted_by_the_keyboard(slow_film: str, film: tuple[str, str], tmp_path: Path) -> None:
    rows, overlay = tmp_path / "r.csv", tmp_path / "o.mp4"
    line = ["track", slow_film, "--fps", "25", "--init", film[1], "-o", str(rows)]
    line += ["--preset", "mean_shift", "--overlay", str(overlay)]
    with started(line) as process:
        wait_until(lambda: count(rows) > 20)
        process.send_signal(signal.SIGINT)
        _, error = process.communicate()
    assert process.returncode == 130
    assert re.match(r"motes: interrupted after \d+ frames, .*wrote .*o\.mp4", error)
    assert rows.read_bytes().endswith(b"\n")
    with open_source(overlay) as drawn:
        assert len(list(drawn)) == len(read_csv(rows))
    whole = rows.read_bytes()
    with started([*line, "--resume"]) as process:  # while it repeats them, they stay
        wait_until(lambda: any(tmp_path.glob("o.mp4.partial*")))
        process.send_signal(signal.SIGINT)
        _, error = process.communicate()
    assert (process.returncode, "cannot be resumed" in error) == (130, False), error
    assert rows.read_bytes().startswith(whole)
    # Resumed, the rows are continued and the overlay is made anew.
    assert main([*line, "--resume", "--end", "90"]) == 0
    with open_source(overlay) as drawn:
        assert len(list(drawn)) == len(read_csv(rows)) == 90


def test_interrupts_wait_until_a_frame_is_written(go: Go, monkeypatch: pytest.MonkeyPatch) -> None:
    from motes.rows.writer import TrackWriter

    add, before = TrackWriter.add, signal.getsignal(signal.SIGINT)

    def interrupting(self: TrackWriter, picture: FrameRow) -> None:
        if picture.frame == 3:
            signal.raise_signal(signal.SIGINT)
        add(self, picture)

    monkeypatch.setattr(TrackWriter, "add", interrupting)
    code, _, error = go("track FILM --init BOX -o r.csv --overlay o.mkv")
    assert (code, "interrupted after 4 frames" in error) == (130, True)
    assert [row["frame"] for row in read_csv("r.csv")] == ["0", "1", "2", "3"]
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.slow
@pytest.mark.parametrize(("more", "code"), [([], 0), (["--overlay", "o.mkv"], 141)])
def test_a_reader_that_leaves_ends_the_run(
    slow_film: str, film: tuple[str, str], more: list[str], code: int, tmp_path: Path
) -> None:
    """Quietly, if it has all that is wanted; else other outputs are finished, which is said."""
    more = [str(tmp_path / each) if "." in each else each for each in more]
    line = ["track", slow_film, "--fps", "25", "--init", film[1], "-o", "-", *more]
    with started(line, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("frame,")
        process.stdout.close()
        assert process.stderr is not None
        said = process.stderr.read()
    assert process.returncode == code
    if more:
        assert "motes: standard output was closed after " in said
        assert [path.name for path in tmp_path.glob("o.*")] == ["o.mkv"]
    else:
        assert said == ""


def test_on_a_terminal_rows_go_to_a_file(go: Go, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setattr("motes.cli.streams._lenient", lambda stream: stream)
    code, out, error = go("track FILM --init BOX --end 3")
    assert (code, out) == (0, "")
    assert error.startswith("motes: Writing film.csv; choose another name with -o.\n")
    assert len(read_csv("film.csv")) == 3
    assert go("track FILM --init BOX --end 3")[0] == 5


@pytest.mark.parametrize("objects", ["--init BOX", "--init BOX --init 20,20,30,40"])
def test_a_photo_is_said_to_be_one_frame(go: Go, objects: str) -> None:
    Image.new("RGB", (160, 120)).save("photo.png")
    code, _, error = go(f"track photo.png {objects} -o photo.csv")
    assert code == 0
    assert error.startswith("motes: photo.png: One frame is read, in which nothing is followed; ")
    assert "One frame" not in go(f"track FILM {objects} -o film.csv --end 2")[2]


def test_doctor(go: Go, monkeypatch: pytest.MonkeyPatch) -> None:
    code, out, _ = go("doctor")
    assert (code, "PROBLEM" in out) == (0, False)
    for what in ("motes", "python", "cores", "kernels", "libavcodec", "H.264 writing"):
        assert re.search(f"^ *{what} +\\S", out, re.MULTILINE), what

    monkeypatch.setattr(metadata, "version", lambda wheel: "5.0")
    code, out, _ = go("doctor")
    assert (code, "opencv-python 5.0 and opencv-python-headless 5.0" in out) == (0, True)

    load = importlib.import_module
    for missing, expected, said in (
        ("dlib", 0, "pip install 'motes[faces]'"),
        ("cv2", 1, "PROBLEM: it is installed, but its import fails (ImportError: no cv2): install"),
        ("av", 1, "PROBLEM: no av; install motes anew"),
        ("scipy", 1, "PROBLEM: no scipy; install motes anew"),
    ):

        def load_or_fail(name: str, missing: str = missing) -> Any:
            if name == missing:
                kind = ModuleNotFoundError if name == "dlib" else ImportError
                raise kind(f"no {name}", name=name)
            return load(name)

        monkeypatch.setattr(importlib, "import_module", load_or_fail)
        code, out, _ = go("doctor")
        assert (code, said in out) == (expected, True)


def test_prefetch_keeps_order_and_stays_bounded() -> None:
    taken: list[int] = []

    def numbers() -> Iterator[int]:
        for number in range(20):
            taken.append(number)
            yield number

    with prefetch(numbers(), ahead=3) as items:
        for number in range(20):
            assert next(items) == number
            most = min(number + 5, 20)  # one delivered, three ready, one in hand
            wait_until(lambda most=most: len(taken) >= most)  # type: ignore[misc]
            assert len(taken) == most
        assert [*items] == []


def test_prefetch_passes_errors_on() -> None:
    def failing() -> Iterator[int]:
        yield 1
        raise SourceError("gone")

    with prefetch(failing()) as items:
        assert next(items) == 1
        with pytest.raises(SourceError, match="gone"):
            next(items)


def test_prefetched_items_end_with_their_context() -> None:
    """Also for a second thread, which takes what a first one has ready, when the user leaves."""
    rest: list[int] = []
    with prefetch(iter(range(10**9)), ahead=2) as items:
        assert next(items) == 0
    reader = threading.Thread(target=lambda: rest.extend(items), daemon=True)
    reader.start()
    reader.join(timeout=600)
    assert (reader.is_alive(), rest) == (False, [])


def test_a_live_source_cannot_be_resumed(go: Go, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Source, "live", True, raising=False)
    monkeypatch.setattr(
        Source,
        "__setattr__",
        lambda self, name, value: None if name == "live" else object.__setattr__(self, name, value),
    )
    code, _, error = go("track FILM --init BOX -o s.csv --resume")
    assert (code, "is live and cannot be read again" in error) == (2, True)
    assert not os.path.exists("s.csv")
