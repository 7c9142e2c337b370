"""Live sources: a camera comes back, a recording ends, frames are late, a pipe is silent."""

import contextlib
import io
import os
import queue
import socket
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from clips import clip, picture, remuxed
from motes.cli import main
from motes.cli.exit_codes import AWAY
from motes.core.errors import AwayError, ConfigError, SourceError
from motes.core.frame import Frame
from motes.correction.history import History
from motes.video import Newest, decoder, newest, pace, reconnect
from motes.video.pace import Pace
from motes.video.sources import is_recorded, open_source
from streams import camera, server
from waiting import PATIENCE, wait_until

HEAD = b"HTTP/1.0 200 OK\r\n"


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconnect, "pauses", partial(reconnect.pauses, 0.02))


def jpegs(connection: socket.socket, number: int) -> None:
    """Send ten pictures as cameras do, then hang up."""
    connection.sendall(HEAD + b"Content-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n")
    for index in range(10 * number, 10 * number + 10):
        data = io.BytesIO()
        Image.fromarray(picture(index)).save(data, "JPEG")
        size = len(data.getvalue())
        part = f"--b\r\nContent-Type: image/jpeg\r\nContent-Length: {size}\r\n\r\n".encode()
        connection.sendall(part + data.getvalue() + b"\r\n")


def gray(index: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    return np.full((64, 96, 3), 20 + index % 200, np.uint8)


def test_a_camera_that_hangs_up_is_opened_again_and_its_frames_go_on() -> None:
    said: list[str] = []
    with server(jpegs) as url, open_source(url, end=25, on_drop=said.append) as source:
        assert source.live
        frames = list(source)
    assert [frame.index for frame in frames] == list(range(25))
    assert (np.diff([frame.time for frame in frames]) > 0).all()
    assert np.abs(frames[22].pixels.astype(int) - picture(22)).mean() < 5
    assert len(said) == 4
    assert said[0] == f"{source.name} ended. It is tried again, with growing pauses."
    assert said[1].startswith(f"{source.name} is back after ")
    assert "secret" not in "".join(said)
    assert source.report.drops == 2
    assert "dropped 2 time(s)" in (source.report.problems or "")


@pytest.mark.slow
def test_a_stream_that_stalls_is_opened_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decoder, "READ_TIMEOUT", 0.4)
    said: list[str] = []

    def listen(line: str) -> None:
        said.append(line)
        stream.stalled.clear()

    with camera(gray) as stream, open_source(stream.url, on_drop=listen) as source:
        before = next(source)
        stream.stalled.set()
        frames = [before]
        while len(said) < 2:
            frames.append(next(source))
    assert "does not answer" in said[0]
    assert "is back" in said[1]
    times = [frame.time for frame in frames]
    assert (np.diff(times) > 0).all()
    assert np.diff(times).max() > 0.4  # as long as it was away


def test_a_camera_that_stays_away_is_an_error_after_all() -> None:
    def once(connection: socket.socket, number: int) -> None:
        if number == 0:
            jpegs(connection, number)

    said: list[str] = []
    with server(once) as url:
        with open_source(url, on_drop=said.append, patience=0.1) as source:
            with pytest.raises(AwayError, match=r"has not come back for 0\.1 s; check it"):
                list(source)
            assert source.report.decoded == 10
        with pytest.raises(ConfigError, match="patience is -1"):
            open_source(url, on_drop=said.append, patience=-1)
    assert len(said) == 1


@pytest.mark.slow
def test_a_stream_that_ends_by_the_other_side_has_a_code_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def once(connection: socket.socket, number: int) -> None:
        if number == 0:
            jpegs(connection, number)

    rows = tmp_path / "rows.csv"
    with server(once) as url:
        assert main(["watch", url, "--reconnect", "0.1", "-o", str(rows)]) == AWAY
    assert "has not come back for 0.1 s" in capsys.readouterr().err
    assert rows.read_text().startswith("frame,")


@pytest.mark.slow
@pytest.mark.parametrize("command", ["watch", "track --init 20,10,16,16"])
def test_the_outputs_of_a_stream_that_is_lost_for_good_are_finished(
    here: Path, capfd: pytest.CaptureFixture[str], command: str
) -> None:
    def once(connection: socket.socket, number: int) -> None:
        if number == 0:
            jpegs(connection, number)

    outputs = "-o rows.csv --overlay film.mp4 --reconnect 0.1"
    with server(once) as url:
        assert main([*command.split(), url, *outputs.split()]) == AWAY
    said = capfd.readouterr().err.splitlines()
    assert (here / "film.mp4").exists(), said
    assert sorted(path.name for path in here.iterdir()) == [
        "film.mp4", "rows.csv", "rows.csv.run.json",
    ]  # fmt: skip
    assert "has not come back for 0.1 s" in said[-1]
    with open_source(here / "film.mp4") as drawn:
        count = len(list(drawn))
    assert count > 1  # late ones are left out
    assert any(line.startswith(f"motes: {count} frames, ") for line in said)
    lines = len((here / "rows.csv").read_bytes().splitlines())
    assert History.load(here / "rows.csv.run.json").lines == lines


@pytest.mark.parametrize("head", [b"Connection: close\r\n", b"Transfer-Encoding: chunked\r\n"])
def test_a_finished_file_that_does_not_say_its_length_ends(tmp_path: Path, head: bytes) -> None:
    """Its last pictures used to be lost, and its end was an error."""
    data = clip(tmp_path / "a.ts", 75).read_bytes()
    chunked = b"%x\r\n%s\r\n0\r\n\r\n" % (len(data), data)

    def send(connection: socket.socket, number: int) -> None:
        version = HEAD.replace(b"1.0", b"1.1")
        connection.sendall(version + head + b"\r\n" + (chunked if b"chunked" in head else data))

    said: list[str] = []
    with server(send) as url, open_source(url, on_drop=said.append) as source:
        assert len(list(source)) == 75
        assert source.report.problems is None
        assert said == []


class Clock:
    """A clock that stands until it is moved."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(pace, "time", SimpleNamespace(monotonic=lambda: self.now))


@pytest.mark.parametrize(
    ("backlog", "speed", "recorded"), [(3.0, 1.0, False), (0.0, 1.1, False), (0.0, 5.0, True)]
)
def test_what_comes_faster_than_its_own_clock_is_recorded(
    monkeypatch: pytest.MonkeyPatch, backlog: float, speed: float, recorded: bool
) -> None:
    clock = Clock(monkeypatch)
    told = Pace()
    for stamp in np.arange(0, 60, 0.04):
        clock.now = 100.0 + max(0.0, stamp - backlog) / speed
        told.note(5000 + stamp)
    assert told.recorded == recorded


def test_a_camera_whose_clock_is_set_is_no_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch)
    told = Pace()
    for index in range(500):
        clock.now += 0.04
        told.note(index * 0.04 + (1e6 if index > 200 else 0) - (2e6 if index > 400 else 0))
    assert not told.recorded


PIXELS = np.zeros((4, 4, 3), np.uint8)


class Film:
    """A source that gives frames when it is told."""

    def __init__(self, *, realtime: bool = True, error: Exception | None = None) -> None:
        self.realtime, self._error = realtime, error
        self.report = SimpleNamespace(late=0)
        self.taken = 0
        self._orders: queue.Queue[bool] = queue.Queue()

    def give(self, count: int) -> None:
        """Give so many frames."""
        for _ in range(count):
            self._orders.put(True)

    def stop(self) -> None:
        """End after them."""
        self._orders.put(False)

    def __iter__(self) -> Iterator[Frame]:
        while self._orders.get():
            self.taken += 1
            yield Frame(self.taken - 1, self.taken / 25, PIXELS, arrived=time.monotonic())
        if self._error is not None:
            raise self._error


def reading(film: Any) -> Newest:
    return Newest(film)


def test_old_frames_are_left_out_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newest, "LONGEST_WAIT", -1.0)  # any wait is too long
    film = Film()
    with reading(film) as frames:
        each = iter(frames)
        film.give(5)
        wait_until(lambda: film.taken == 5 and film.report.late == 4)
        assert next(each).index == 4
        film.give(1)
        assert next(each).index == 5
        film.stop()
        assert list(each) == []
    assert film.report.late == 4


def test_a_recording_waits_and_its_error_comes_after_its_frames(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(newest, "LONGEST_WAIT", -1.0)
    film = Film(realtime=False, error=SourceError("broken"))
    with reading(film) as frames:
        film.give(5)
        film.stop()
        each = iter(frames)
        assert [next(each).index for _ in range(5)] == list(range(5))
        with pytest.raises(SourceError, match="broken"):
            next(each)


@contextlib.contextmanager
def sent(data: bytes, folder: Path) -> Iterator[tuple[str, Callable[[], None]]]:
    """Give a FIFO into which data are written, and a function that closes it at the other end."""
    path = folder / "pipe"
    os.mkfifo(path)
    closing = threading.Event()

    def write() -> None:
        with contextlib.suppress(BrokenPipeError), path.open("wb", buffering=0) as pipe:
            pipe.write(data)
            closing.wait()

    thread = threading.Thread(target=write)
    thread.start()
    try:
        yield str(path), closing.set
    finally:
        closing.set()
        thread.join()


@pytest.mark.parametrize("ending", ["ts", "mkv", "mp4"])
def test_a_pipe_gives_the_pictures_of_the_file(tmp_path: Path, ending: str) -> None:
    path = clip(tmp_path / f"film.{ending}", 30)
    with open_source(path) as file:
        expected = list(file)
    with sent(path.read_bytes(), tmp_path) as (name, close):
        close()
        assert not is_recorded(name)
        with open_source(name) as piped:
            frames = list(piped)
            assert piped.report.problems is None
    assert [frame.time for frame in frames] == [frame.time for frame in expected]
    for frame, other in zip(frames, expected, strict=True):
        assert np.array_equal(frame.pixels, other.pixels)


def test_an_interrupt_ends_the_opening_of_a_silent_pipe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def threads() -> list[threading.Thread]:
        return [each for each in threading.enumerate() if "ThreadPool" in each.name]

    def interrupted(*_: object) -> object:
        wait_until(threads)
        raise KeyboardInterrupt

    with sent(b"G", tmp_path) as (name, _):
        monkeypatch.setattr("concurrent.futures.Future.result", interrupted)
        with pytest.raises(KeyboardInterrupt):
            open_source(name)
    assert not threads()


def test_the_end_ends_who_waits() -> None:
    film = Film()
    got: list[Frame] = []
    frames = reading(film)
    with frames:
        other = threading.Thread(target=lambda: got.extend(frames))
        other.start()
        film.stop()
    other.join(PATIENCE)
    assert not other.is_alive()
    assert got == []


def test_an_error_in_such_a_file_stays_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decoder, "READ_TIMEOUT", 0.4)
    data, done = clip(tmp_path / "a.ts", 75).read_bytes(), threading.Event()

    def send(connection: socket.socket, number: int) -> None:
        connection.sendall(HEAD + b"\r\n" + data)
        done.wait()

    with server(send) as url, open_source(url, on_drop=lambda line: None) as source:
        with pytest.raises(SourceError, match="does not answer"):
            list(source)
        assert source.report.decoded == 75
    done.set()


def test_a_recording_stays_one_while_nobody_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch)
    told = Pace()
    for index in range(2000):
        clock.now += 0.01 if index < 400 else 1.0
        told.note(index * 0.04)
    assert told.recorded


def test_a_camera_that_hangs_up_is_an_error_for_who_does_not_reconnect() -> None:
    with server(jpegs) as url, open_source(url) as source:
        with pytest.raises(SourceError, match="ended"):
            list(source)
        assert source.report.decoded == 10


@pytest.mark.parametrize("frames", [10, pytest.param(70, marks=pytest.mark.slow)])
def test_an_mp4_with_its_index_at_the_end_is_told_from_a_damaged_one(
    tmp_path: Path, frames: int
) -> None:
    film = clip(tmp_path / "film.mp4", frames, width=160, height=120, noisy=True)
    with sent(remuxed(film), tmp_path) as (name, close):
        close()
        with pytest.raises(SourceError, match=r"index at the end.*give the file, or send MPEG-TS"):
            list(open_source(name))


def test_an_mp4_of_fragments_is_read_from_a_pipe(tmp_path: Path) -> None:
    data = remuxed(clip(tmp_path / "film.mp4", 20), movflags="frag_keyframe+empty_moov")
    with sent(data, tmp_path) as (name, close):
        close()
        with open_source(name) as source:
            assert len(list(source)) == 20
