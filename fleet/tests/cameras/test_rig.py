"""Several cameras from the outside: rows, handover, what goes wrong, and how it ends."""

import contextlib
import itertools
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from operator import gt
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from commands import read_csv
from motes import Ellipse, KnownTarget, Place, Scene, named_detector, open_source, preset
from motes.cli import main
from motes.cues import Color
from motes_fleet.cameras import rig as rig_runner, rig_camera
from motes_fleet.cameras.camera_report import (
    Arrival,
    CameraEnded,
    CameraMessage,
    CameraReady,
    CameraReport,
)
from motes_fleet.cameras.camera_reporter import CameraReporter
from motes_fleet.cameras.rig import RigRunner, announce, next_report
from motes_fleet.cameras.rig_camera import RigCamera
from motes_fleet.cameras.rig_config import Camera, Rig
from red_box import moving, walk
from streams import Stream, camera
from waiting import PATIENCE, runs, wait_until

Go = Callable[..., tuple[int, str, str]]
HALL, OFFICE, PASSAGE = (
    """
[[camera]]
name = "hall"
source = "hall.mkv"
place = [{ name = "door", box = [150, 0, 10, 96] }]
""",
    """
[[camera]]
name = "office"
source = "office.mkv"
offset = 2.0
place = [{ name = "door", box = [0, 0, 10, 96] }]
""",
    """
[[passage]]
between = ["hall/door", "office/door"]
seconds = [0.5, 4]
""",
)


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two films: a red box walks out of one on the right, and into the other.

    It is gone from the hall after 2.6 s, and comes into the office 3.2 s after the hall's start, in
    a film that begins 2 s after the hall's.
    """
    folder = tmp_path_factory.mktemp("rig")
    for name, enters in (("hall", 20), ("office", 30)):
        walk(folder / f"{name}.mkv", 70, enters)
    return folder


@pytest.fixture
def go(
    films: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Go:
    """Run motes watch on a rig in a folder with the films."""
    for film in films.iterdir():
        (tmp_path / film.name).symlink_to(film)
    monkeypatch.chdir(tmp_path)

    def run(text: str, line: str = "-o r.csv") -> tuple[int, str, str]:
        Path("rig.toml").write_text(text)
        code = main(["watch", "rig.toml", *line.split()])
        return code, *capfd.readouterr()

    return run


@pytest.mark.slow
def test_one_walks_from_the_hall_into_the_office(go: Go) -> None:
    code, _, error = go(HALL + OFFICE + PASSAGE)
    assert code == 0, error
    assert "hall 70, office 70 frames; 1 object, 1 time handed over; wrote r.csv." in error
    rows = read_csv("r.csv")
    assert {row["camera"] for row in rows} == {"hall", "office"}
    assert {row["id"] for row in rows} == {"1"}
    times = [float(row["time"]) for row in rows]
    assert times == sorted(times)
    first = next(row for row in rows if row["camera"] == "office")
    assert float(first["time"]) == pytest.approx(int(first["frame"]) / 25 + 2, abs=0.01)


@pytest.mark.slow
def test_two_rooms_wait_for_one_known_person(go: Go) -> None:
    """Nummiaro et al., section VII: both search for a histogram that was saved before."""
    with open_source("hall.mkv", start=32) as hall:
        color = preset("nummiaro").cues["color"]
        assert isinstance(color, Color)
        KnownTarget.learn(color, next(hall), Ellipse.from_box((32, 40, 16, 30))).save("red.json")
    entry = '[{ name = "entry", box = [0, 0, 10, 96] }, {'
    rig = HALL.replace("[{", entry) + OFFICE + PASSAGE
    code, _, error = go(rig, "-o r.csv --histogram red.json")
    assert code == 0, error
    rows = read_csv("r.csv")
    assert {row["id"] for row in rows} == {"1"}
    for name, enters, until in (("hall", 20, 2.9), ("office", 30, 5.0)):
        seen = [row for row in rows if row["camera"] == name and row["status"] == "tracking"]
        assert len(seen) > 20
        assert float(seen[-1]["time"]) < until
        middle = seen[len(seen) // 2]
        x = 4 * (int(middle["frame"]) - enters) - 16
        assert float(middle["left"]) == pytest.approx(x, abs=6)


def test_a_histogram_is_for_several_cameras(go: Go, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["watch", "hall.mkv", "--histogram", "red.json"]) == 2
    assert "--histogram is for a file of several cameras" in capfd.readouterr().err
    code, _, error = go(HALL, "-o r.csv --histogram red.json")
    assert code == 3
    assert "red.json" in error


def no_process(*_: object) -> SimpleNamespace:
    """Stand for the worker of a camera."""
    return SimpleNamespace(pipe=None)


@pytest.mark.parametrize("slow", ["one", "two"])
def test_recordings_go_in_step(slow: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a camera may expect depends on the times of frames alone, not on who is faster.

    The second camera's frames come half a frame later, and one of the two takes its time.
    """
    log: list[str] = []

    class Recording(RigCamera):
        """A recording that works when the test has it work."""

        def _send(self, arrivals: object) -> None:
            log.append(f"{self.name} {arrivals}")

    monkeypatch.setattr(rig_camera, "Worker", no_process)
    monkeypatch.setattr(rig_runner, "RigCamera", Recording)
    watch = RigRunner(Rig((Camera("one", ""), Camera("two", ""))))
    monkeypatch.setattr(watch.handover, "arrivals", lambda _, now: f"{now:.2f} knows {len(times)}")
    times: list[float] = []
    starts = {"one": 0.0, "two": 0.02}
    cameras = {camera.name: camera for camera in watch._cameras}
    frames = {name: iter([start + 0.04 * n for n in range(4)]) for name, start in starts.items()}
    order = sorted(cameras, key=lambda name: name == slow)

    def works(camera: RigCamera) -> bool:
        """Have a camera announce a frame or report one, as its process would."""
        done = len(camera.reports) + sum(each.startswith(camera.name) for each in log)
        if camera.next is None and (time := next(frames[camera.name], None)) is not None:
            camera.next = camera._last = time
        elif camera._working:
            report = CameraReport(camera.name, done, camera._working[0], ())
            assert list(camera._take(report)) == []
        else:
            camera.over = camera.next is None
            return False
        return True

    for _ in range(40):
        while works(cameras[order[0]]):
            while (report := next_report(watch._cameras, watch.handover)) is not None:
                times.append(report.time)
        works(cameras[order[1]])
        while (report := next_report(watch._cameras, watch.handover)) is not None:
            times.append(report.time)
    assert times == sorted(times)
    assert sorted(log) == [
        *(f"one {0.04 * n:.2f} knows {max(2 * n - 1, 0)}" for n in range(4)),
        *(f"two {0.04 * n + 0.02:.2f} knows {2 * n}" for n in range(4)),
    ]


@pytest.mark.slow
def test_a_camera_that_fails_does_not_stop_the_others(go: Go) -> None:
    code, out, error = go(HALL + OFFICE.replace("[0, 0,", "[950, 0,"), "-o -")
    assert code == 6
    assert error.count("camera office: Place 'door' lies outside the frame") == 1
    assert "hall 70, office 0 frames; 1 object, 0 times handed over" in error
    rows = [line.split(",") for line in out.splitlines()[1:]]
    assert len(rows) > 30
    assert {(row[-1], row[2]) for row in rows} == {("hall", "1")}


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (OFFICE.replace("office.mkv", "none.mkv"), 3, "There is no file or folder none.mkv; check"),
        (f'{OFFICE}detector = "none.txt"', 3, "none.txt cannot be read: No such file"),
        (f'{OFFICE}detector = "none.onnx"', 3, "There is no file none.onnx; check the name."),
        (f'{OFFICE}detector = "peple"', 2, "A detector is background, people, faces,"),
        (f'{OFFICE}detector = "none:find"', 2, "The detector none:find cannot be made: ModuleNotF"),
        (f'{OFFICE}preset = "default"', 2, "Objects are followed by particle filters"),
        (f"{OFFICE}fps = 1e8", 2, "fps is 1e+08; give frames per second from"),
    ],
)
def test_a_wrong_name_ends_the_run_before_it_begins(
    text: str, code: int, words: str, go: Go
) -> None:
    found, _, error = go(HALL + text, "-o r.csv --own-code")
    assert (found, error.count("\n")) == (code, 1)
    assert error.startswith(f"motes: error: camera office: {words}")
    assert not Path("r.csv").exists()


@pytest.mark.slow
def test_a_camera_of_images_is_told_where_to_give_their_rate(go: Go) -> None:
    Path("images").mkdir()
    for index in range(3):
        Image.new("RGB", (96, 80)).save(f"images/{index}.png")
    _, _, error = go(HALL + OFFICE.replace("office.mkv", "images"))
    assert "camera office: the images have no frame rate, 25 a second are assumed" in error
    assert "; give fps in its [[camera]] if it is another." in error


@pytest.mark.slow
def test_all_frames_before_one_that_cannot_be_read_are_told(go: Go) -> None:
    Path("images").mkdir()
    for index, height in enumerate((80, 80, 80, 64)):
        Image.new("RGB", (96, height)).save(f"images/{index}.png")
    code, _, error = go(HALL + OFFICE.replace("office.mkv", "images"))
    assert code == 6
    assert "camera office: Frame 3 of images has 96x64 pixels, those before 96x80" in error
    assert "hall 70, office 3 frames" in error


@pytest.mark.slow
def test_what_could_not_be_read_of_a_recording_is_told(go: Go) -> None:
    whole = Path("hall.mkv").read_bytes()
    Path("cut.mkv").write_bytes(whole[: len(whole) // 2])
    _, _, error = go(HALL.replace("hall.mkv", "cut.mkv"))
    assert re.search(r"camera hall: .*cut off at", error)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "line", "code", "words"),
    [
        (HALL + PASSAGE, "", 2, "rig.toml: A passage or overlap got 'office/door', which is not"),
        (HALL + "speed = 3", "", 2, "rig.toml: Config has no key 'camera[0].speed'; known keys"),
        (HALL, "-o rows.xml", 2, "rows.xml ends neither in .csv nor in .jsonl, the forms for sev"),
        (HALL, "--line 1,2,3,4", 2, "--line is for one camera, not for a file of several."),
        (HALL, "-o hall.mkv", 2, "hall.mkv is the source"),
        (HALL.replace("[150,", "[950,"), "", 3, "Place 'door' lies outside the frame"),
    ],
)
def test_nonsense_is_refused(text: str, line: str, code: int, words: str, go: Go) -> None:
    found, out, error = go(text, line)
    assert found == code
    assert words in error
    assert "Traceback" not in out + error


LIVE = f"""
import sys
from motes.cli import main
from motes_fleet.cameras import rig_camera

rig_camera.SILENCE = {PATIENCE}
if __name__ == "__main__":
    sys.exit(main(["watch", "rig.toml", "-o", "r.csv"]))
"""
"""motes watch, for which a camera of a busy machine is not silent."""


@contextlib.contextmanager
def running(folder: Path, *streams: Stream) -> Iterator[tuple[subprocess.Popen[str], Path, Path]]:
    """Run motes watch on live cameras named one, two ...

    Give the program, its rows, once each camera has some, and the file of its messages.
    """
    text = "".join(
        f'[[camera]]\nname = "{name}"\nsource = "{stream.url}"\n'
        for name, stream in zip(("one", "two"), streams, strict=False)
    )
    (folder / "rig.toml").write_text(text)
    (folder / "run.py").write_text(LIVE)
    rows, messages = folder / "r.csv", folder / "messages"
    with messages.open("w") as file:
        program = subprocess.Popen([sys.executable, "run.py"], cwd=folder, stderr=file, text=True)
    try:
        wait_until(lambda: rows.exists() and len(_cameras(rows)) > len(streams))
        yield program, rows, messages
    finally:
        program.kill()


@pytest.mark.slow
def test_a_killed_process_is_started_again_and_a_service_that_is_stopped_keeps_all_rows(
    tmp_path: Path,
) -> None:
    """A service's manager sends the signal to all processes; only the program itself acts on it."""
    with camera(moving) as first, camera(moving) as second:
        with running(tmp_path, first, second) as (program, rows, messages):

            def counts() -> list[int]:
                """Return how many rows both cameras have."""
                return [rows.read_text().count(f",{name}\n") for name in ("one", "two")]

            def go_on() -> None:
                """Wait for more of them."""
                few = [count + 8 for count in counts()]
                wait_until(lambda: all(map(gt, counts(), few)))

            children = _children(program.pid)
            assert len(children) == 2
            os.kill(children[0], signal.SIGKILL)
            # Rows of the killed process may still be on their way, so its return is waited for.
            wait_until(lambda: "camera one: it is back after" in messages.read_text())
            go_on()
            children = _children(program.pid)
            for child in children:
                os.kill(child, signal.SIGTERM)
                os.kill(child, signal.SIGHUP)
            go_on()
            os.kill(program.pid, signal.SIGTERM)
            program.wait()
            error = messages.read_text()
        assert program.returncode == 143
        assert error.count("camera one: its process ended with SIGKILL") == 1
        assert error.count("It is started again, with growing pauses.") == 1
        assert len(re.findall(r"camera one: it is back after \d+\.\d s\.", error)) == 1
        assert error.count("camera") == 2
        assert "Traceback" not in error
        assert re.search(r"terminated after one \d+, two \d+ frames; .* wrote r.csv", error)
        lines = rows.read_text().splitlines()
        assert all(line.count(",") == lines[0].count(",") for line in lines)
        frames = [int(line.split(",")[0]) for line in lines if line.endswith(",one")]
        assert all(a <= b for a, b in itertools.pairwise(frames))
        wait_until(lambda: not any(map(runs, children)))


def kill(watch: RigRunner) -> None:
    """Kill the hall's process."""
    os.kill(process_of(watch), signal.SIGKILL)


def process_of(watch: RigRunner) -> int:
    """Return the process of the one camera."""
    (hall,) = watch._cameras
    return hall.worker.pid


def told(
    watch: RigRunner, when: Callable[[list[CameraReport]], bool]
) -> tuple[list[CameraReport], list[object]]:
    """Return what cameras tell, and what is said of them; the first one is killed if wished."""
    reports: list[CameraReport] = []
    said: list[object] = []
    with watch:
        for news in watch:
            if isinstance(news, tuple):
                reports.append(news[0])
            else:
                said.append(news)
            if when(reports):
                kill(watch)
    return reports, said


@pytest.mark.slow
def test_a_recording_whose_process_was_killed_is_told_to_its_end_once(
    films: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rig_camera, "CAMERA_TIMEOUT", 0.1)
    hall = Camera("hall", str(films / "hall.mkv"))
    calm, (end,) = told(RigRunner(Rig((hall,))), lambda _: False)
    moments = [1]

    def once(reports: list[CameraReport]) -> bool:
        return len(reports) in moments and moments.pop() > 0

    again, said = told(RigRunner(Rig((hall,))), once)
    assert again == calm
    assert len(calm) == 70
    assert said[-1] == end
    assert all(isinstance(each, CameraMessage) for each in said[:-1])
    assert len(said) in (1, 3)  # it may have been over already


def test_who_is_there_when_a_recording_begins_leaves_no_ghost(tmp_path: Path) -> None:
    walk(tmp_path / "hall.mkv", 40, enters=-10)
    reports, _ = told(
        RigRunner(Rig((Camera("hall", str(tmp_path / "hall.mkv")),))), lambda _: False
    )
    assert {len(each.sightings) for each in reports[5:25]} == {1}


def test_a_process_that_dies_at_the_same_place_again_is_given_up(
    films: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rig_camera, "CAMERA_TIMEOUT", 0.1)
    watch = RigRunner(Rig((Camera("hall", str(films / "hall.mkv")),)))
    kill(watch)
    with watch:
        news = iter(watch)
        first = next(news)
        assert isinstance(first, CameraMessage)
        assert "SIGKILL" in first.text
        pid = process_of(watch)

        def kill_next() -> None:
            wait_until(lambda: process_of(watch) != pid)
            kill(watch)

        threading.Thread(target=kill_next).start()
        (last,) = news
    assert isinstance(last, CameraEnded)
    assert last.failure
    assert "SIGKILL" in last.failure


def _cameras(rows: Path) -> set[str]:
    return {line.rpartition(",")[2] for line in rows.read_text().splitlines()}


def _children(pid: int) -> list[int]:
    """Return the cameras' processes, in their order."""
    found = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    lines = {int(each): Path(f"/proc/{each}/cmdline").read_text() for each in found}
    return sorted(each for each, line in lines.items() if "spawn_main" in line)


@pytest.mark.slow
def test_half_of_somebody_is_not_told_of(films: Path) -> None:
    """Who comes in by a door is told of when whole, and with the looks of then."""
    place = Place(name="door", box=(0, 0, 10, 96))
    reports: dict[bool, list[CameraReport]] = {}
    for door in (True, False):
        scene = Scene(named_detector("background"))
        lookout = CameraReporter(Camera("hall", "", place=(place,) * door), scene)
        with open_source(films / "hall.mkv") as film:
            frames = list(film)
        reports[door] = [r for r in map(lookout.report, frames) if r.sightings]
    first, early = reports[True][0].sightings[0], reports[False][0].sightings[0]
    assert early.box.x < 2 <= first.box.x
    assert first.places == ("door",)
    histograms = [np.frombuffer(each.histogram or b"", np.float32) for each in (first, early)]
    assert [histogram.sum() for histogram in histograms] == pytest.approx([1, 1], abs=1e-3)
    told = [s for r in reports[True] for s in r.sightings]
    assert all(each.histogram for each in told if each.seen)
    assert first.velocity[0] > 50  # 4 pixels a frame
    assert len(first.covariance) == 25
    gone = np.frombuffer(told[1].histogram or b"", np.float32)
    np.testing.assert_allclose(gone, histograms[0], atol=0.15)  # whole, not what was left of it


class SilentCamera(RigCamera):
    """A live camera that keeps what it is sent."""

    def __init__(self, camera: Camera) -> None:
        super().__init__(camera, 0, 0.0)
        self.sent: list[object] = []

    def _send(self, arrivals: tuple[Arrival, ...]) -> None:
        self.sent.append(arrivals)


class OnceAnnounced:
    """An association in which an object is announced in each second, once."""

    def __init__(self) -> None:
        self._announced: set[float] = set()

    def arrivals(self, _: str, now: float) -> tuple[object, ...]:
        """Return the objects of all seconds that are new."""
        new = {float(second) for second in range(int(now) + 1)} - self._announced
        self._announced |= new
        return tuple(sorted(new))


def test_arrivals_wait_for_a_camera_that_works_still(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig_camera, "Worker", no_process)
    hall, association = SilentCamera(Camera("hall", "")), OnceAnnounced()
    (*_,) = hall.receive(CameraReady("hall", live=True))
    for second in range(3):
        report = CameraReport("office", second, float(second), ())
        announce(report, [hall], association)  # type: ignore[arg-type]
    assert hall.sent == [(0.0,)]
    (*_,) = hall.receive(CameraReport("hall", 0, 2.5, ()))
    announce(CameraReport("office", 3, 3.0, ()), [hall], association)  # type: ignore[arg-type]
    assert hall.sent == [(0.0,), (1.0, 2.0, 3.0)]
