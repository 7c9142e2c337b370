"""Live cameras of a rig: waited for, on one clock, and noticed when nothing comes from them."""

import threading
import time
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from motes import Frame, SourceError
from motes.video import pauses
from motes_fleet.cameras import live, rig_camera
from motes_fleet.cameras.camera_loop import watch_camera
from motes_fleet.cameras.camera_report import CameraEnded, CameraMessage, CameraReady, CameraReport
from motes_fleet.cameras.live import on_clock, opened
from motes_fleet.cameras.rig_camera import SILENCE, RigCamera
from motes_fleet.cameras.rig_config import Camera
from streams import Stream, camera
from waiting import wait_until

PIXELS = np.zeros((4, 4, 3), np.uint8)


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live, "pauses", partial(pauses, 0.05))


def gray(index: int) -> NDArray[np.uint8]:
    return np.full((64, 96, 3), 20 + index % 200, np.uint8)


class Line:
    """A line whose program hears a number of reports, and then leaves."""

    waiting = False

    def __init__(self, enough: Callable[[], bool]) -> None:
        self.heard: list[msgspec.Struct] = []
        self._enough = enough

    def send(self, message: msgspec.Struct) -> None:
        """Keep a message."""
        self.heard.append(message)
        if self._enough():
            raise BrokenPipeError

    @property
    def said(self) -> list[str]:
        """What it was told in words."""
        return [each.text for each in self.heard if isinstance(each, CameraMessage)]


@pytest.mark.slow
def test_a_camera_that_does_not_answer_yet_is_waited_for_and_opened_again_when_it_drops() -> None:
    with camera(gray) as stream:
        stream.hung_up.set()

        def reports() -> list[CameraReport]:
            return [each for each in line.heard if isinstance(each, CameraReport)]

        def enough() -> bool:
            if len(line.said) == 2 and len(reports()) == 5:
                stream.hung_up.set()
            return len(line.said) == 4 and len(reports()) > 10

        line = Line(enough)
        begun = time.monotonic()
        threading.Thread(target=_answer_at_last, args=(stream,), daemon=True).start()
        watch_camera(line, Camera("hall", stream.url), 0, begun, None)  # type: ignore[arg-type]
    assert line.heard[0] == CameraReady("hall", live=True)
    away, back, dropped, again = line.said
    for text in (away, dropped):
        assert text.endswith("It is tried again, with growing pauses.")
    assert all("is back after" in text for text in (back, again))
    assert "secret" not in "".join(line.said)
    times = [each.time for each in reports()]
    assert (np.diff(times) > 0).all()
    assert 0 < times[0] < times[-1] <= time.monotonic() - begun


def _answer_at_last(stream: Stream) -> None:
    """Let a server that has hung up answer again, each time after some refusals."""
    for refusals in (3, 6):
        wait_until(stream.hung_up.is_set)
        _after(stream, refusals)


def _after(stream: Stream, refusals: int) -> None:
    wait_until(lambda: stream.refusals >= refusals)
    stream.hung_up.clear()


def test_a_file_that_is_missing_is_not_waited_for() -> None:
    with pytest.raises(SourceError, match="There is no file"):
        opened("missing.mp4", None, print, print)


def test_frames_that_waited_in_the_network_are_left_out() -> None:
    """The source's clock is 7 s late; its first ten frames come all at once."""
    arrived = [max(0.04 * n, 0.36) + 107 for n in range(40)]
    frames = [Frame(n, 0.04 * n, PIXELS, arrived=at) for n, at in enumerate(arrived)]
    taken = list(on_clock(frames, 100.0))
    assert [frame.index for frame in taken] == [0, *range(10, 40)]
    times = [frame.time for frame in taken]
    assert times == pytest.approx([arrived[frame.index] - 100 for frame in taken])


def test_frames_that_come_in_bursts_have_the_steps_of_the_source() -> None:
    arrived = [0.04 * (n - n % 5 + 4) + 50 for n in range(400)]
    frames = [Frame(n, 0.04 * n, PIXELS, arrived=at) for n, at in enumerate(arrived)]
    taken = list(on_clock(frames, 50.0))
    assert [frame.index for frame in taken] == [0, *range(5, 400)]
    steps = np.diff([frame.time for frame in taken[1:]])
    assert np.quantile(steps, [0.1, 0.9]) == pytest.approx([0.04, 0.04], abs=0.005)


def test_a_clock_that_drifts_is_followed() -> None:
    arrived = [0.0404 * n + 50 for n in range(2000)]  # one percent slower
    frames = [Frame(n, 0.04 * n, PIXELS, arrived=at) for n, at in enumerate(arrived)]
    times = [frame.time for frame in on_clock(frames, 50.0)]
    assert times[-1] == pytest.approx(arrived[-1] - 50, abs=0.05)


def test_a_live_camera_that_says_nothing_is_noticed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drivers may hang where no time limit of FFmpeg reaches."""
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr(rig_camera, "time", SimpleNamespace(monotonic=lambda: clock.now))
    monkeypatch.setattr(rig_camera, "Worker", lambda *_: SimpleNamespace(pipe=None))
    hall = RigCamera(Camera("hall", "0"), 0, 0.0)

    def said(passed: float) -> list[str]:
        clock.now += passed
        return [each.text for each in hall.look()]

    (*_,) = hall.receive(CameraReady("hall", live=True))
    assert said(2 * SILENCE) == []  # its detector may take long to load
    (*_,) = hall.receive(CameraReport("hall", 0, 0.5, ()))
    assert said(SILENCE) == []
    assert said(1.0) == ["nothing has come from it for 10 s."]
    assert said(SILENCE) == []
    (back,) = hall.receive(CameraReport("hall", 1, 0.6, ()))
    assert isinstance(back, CameraMessage)
    assert back.text == "it is back after 21.0 s."
    (*_,) = hall.receive(CameraMessage("hall", "it does not answer. It is tried again."))
    assert said(2 * SILENCE) == []
    (*_,) = hall.receive(CameraEnded("hall", 2))
    assert said(2 * SILENCE) == []
