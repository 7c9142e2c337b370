"""Several cameras at once: each with a scene in a process of its own, from which sightings come.

Frames stay in the process that reads them. What its scene says of a frame travels as a small
`Report`, and only here do the cameras' objects get identities that hold for all of them.
"""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Self

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.association import inside
from motes.cues.color import Color
from motes.errors import MotesError
from motes.frame import Frame
from motes.geometry import Box
from motes.handover import GAP, Camera, Handover, Report, Rig, Sighting
from motes.live import Live, open_watched
from motes.objects import SceneTrack
from motes.processes import cause, deaf
from motes.reconnect import LONGEST_PAUSE
from motes.scene import Scene
from motes.track import Status
from motes.watching import named_detector

CUE = Color()
"""What makes the histograms by which cameras know each other's objects."""
COMING = 1.0
"""Seconds for which somebody who comes in by a door at the border is not told of until seen whole.

Half of a person looks like nobody who is expected.
"""
MARGIN = 2.0
"""Pixels; what is as near to the border may go on beyond it."""
WAITING = 100
"""So many reports of a recording wait for the other cameras before it has to wait as well."""


class Notice(msgspec.Struct, frozen=True, tag=True):
    """What there is to say about a camera, for people."""

    camera: str
    text: str


class Over(msgspec.Struct, frozen=True, tag=True):
    """A camera is at its end: how many frames it had and dropped, and what failed, if anything."""

    camera: str
    frames: int
    dropped: int = 0
    failure: str | None = None


class Ready(msgspec.Struct, frozen=True, tag=True):
    """A camera is open. Live ones have the same clock; recordings wait for each other's time."""

    camera: str
    live: bool


Message = Report | Notice | Over | Ready


@dataclass(slots=True)
class _View:
    """What is known of an object: since when, where and how it was seen, and whether that is told.

    Until it is told of, `places` are those where it came in.
    """

    since: float
    places: tuple[str, ...]
    look: bytes
    seen: bool = True
    told: bool = False


class Lookout:
    """Turns a camera's frames into reports.

    Parameters
    ----------
    camera
        Whose frames.
    scene
        What finds and follows the objects in them.
    """

    def __init__(self, camera: Camera, scene: Scene) -> None:
        self._camera, self._scene = camera, scene
        self._views: dict[int, _View] = {}
        self._places: dict[str, NDArray[np.float64]] | None = None

    def report(self, frame: Frame) -> Report:
        """Return what there is to tell of a frame, whose time is that of the rig.

        Raises
        ------
        ConfigError
            If one of the camera's places lies outside the frame.
        SourceError
            If frames change their size.
        """
        if self._places is None:
            self._places = {
                place.name: np.array(place.boxes(frame), np.float64) for place in self._camera.place
            }
        sightings = (self._sighting(frame, track) for track in self._scene.update(frame))
        told = tuple(sighting for sighting in sightings if sighting is not None)
        return Report(self._camera.name, frame.index, frame.time, told)

    def _sighting(self, frame: Frame, each: SceneTrack) -> Sighting | None:
        """Return what to tell of an object, None for nothing; see `COMING`.

        Its histogram is that of its last whole view.
        """
        track, seen, whole = each.track, each.track.status is Status.TRACKING, False
        view = self._views.get(each.identity)
        if view is None or seen:
            whole = _whole(track.box, frame)
            places = self._at(track.box)
            if view is None:
                view = self._views[each.identity] = _View(frame.time, places, b"")
            if view.told:
                view.places = places
            if not view.look or (whole and each.detected):
                look = CUE.learn(frame, track.ellipse).histogram
                view.look = look.astype(np.float32).tobytes()
        appears = not view.told and seen
        if appears and view.places and not whole and frame.time - view.since < COMING:
            return None
        vanishes, view.seen = view.seen and not seen, seen
        if track.status is Status.LOST:
            del self._views[each.identity]
        if not (view.told or seen):
            return None
        view.told = True
        return Sighting(
            each.identity,
            track.status,
            track.box,
            track.confidence,
            each.behind,
            each.detected,
            view.places,
            view.look if appears or vanishes else None,
        )

    def _at(self, box: Box) -> tuple[str, ...]:
        """Return the names of the places that a box touches."""
        assert self._places is not None
        one = np.array([box])
        return tuple(name for name, boxes in self._places.items() if inside(one, boxes).any())


def _whole(box: Box, frame: Frame) -> bool:
    """Return whether all of a box is in the frame, and not cut off by its border."""
    right, bottom = box.x + box.width, box.y + box.height
    room = min(box.x, box.y, frame.width - right, frame.height - bottom)
    return room >= MARGIN


class Watch:
    """The cameras of a rig, watched: a context manager and an iterator of what they tell.

    In the order of time it yields each `Report`, with the identities in the rig of its objects by
    those that they have in their camera; and each `Notice` and `Over`. It ends when every camera
    has. Their processes end with the context, and with this process, whatever ends it; one that
    dies is started again.

    Parameters
    ----------
    rig
        Which cameras, and how they are joined.
    seed
        Of the random numbers.

    Attributes
    ----------
    pids
        Process identifiers by the cameras' names.
    """

    def __init__(self, rig: Rig, seed: int = 0) -> None:
        self.handover = Handover(rig)
        origin = time.monotonic()
        with deaf():
            self._eyes = [_Eye(camera, seed, origin) for camera in rig.camera]

    @property
    def pids(self) -> dict[str, int | None]:
        """Process identifiers by the cameras' names."""
        return {eye.name: eye.process.pid for eye in self._eyes}

    def __iter__(self) -> Iterator[tuple[Report, Mapping[int, int]] | Notice | Over]:
        while any(not eye.over or eye.reports for eye in self._eyes):
            for eye in self._eyes:
                eye.revive()
            listening = {
                eye.pipe: eye
                for eye in self._eyes
                if not eye.over and eye.due is None and len(eye.reports) < WAITING
            }
            pauses = [eye.due - time.monotonic() for eye in self._eyes if eye.due is not None]
            if listening or pauses:
                for pipe in wait(list(listening), max(min(pauses), 0) if pauses else None):
                    yield from listening[pipe].listen()  # type: ignore[index]
            while (report := self._next()) is not None:
                yield report, self.handover.update(report)

    def _next(self) -> Report | None:
        """Return the report that comes next in time; None while an earlier one may still come."""
        waiting = [eye for eye in self._eyes if eye.reports]
        if not waiting or any(eye.behind for eye in self._eyes):
            return None
        return min(waiting, key=lambda eye: eye.reports[0].time).reports.popleft()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with deaf():
            for eye in self._eyes:
                eye.process.kill()
                eye.process.join()
                eye.pipe.close()


class _Eye:
    """The process of a camera, as seen from here.

    One that ends without having said so is started again, after growing pauses. A live camera's
    new process knows nobody: who it tells of is new to the rig, which may find them again by what
    they look like. A recording's tells once more what the last one did, which is left out; where
    it ends at the same frame again, it is given up.
    """

    def __init__(self, camera: Camera, seed: int, origin: float) -> None:
        self.name = camera.name
        self.reports: deque[Report] = deque()
        self.live = self.over = False
        self.due: float | None = None
        """When it is started again; None while it runs, and after its end."""
        self._args = camera, seed, origin
        self._told = self._frames = self._identities = 0
        """How many frames it has told of, and the first numbers that no frame and nobody has."""
        self._ended: float | None = None
        self._failed_at, self._pause = -1, GAP
        self._start()

    def _start(self) -> None:
        """Start its process."""
        context = multiprocessing.get_context("spawn")
        with deaf():
            self.pipe, theirs = context.Pipe(duplex=False)
            args = (theirs, *self._args)
            self.process = context.Process(target=_serve, args=args, daemon=True)
            self.process.start()
            theirs.close()
        self.due = None
        self._known = 0 if self.live else self._told
        self._offsets = (self._frames, self._identities) if self.live else (0, 0)

    @property
    def behind(self) -> bool:
        """Whether others have to wait for what it will tell."""
        return not (self.live or self.over or self.reports)

    def revive(self) -> None:
        """Start it again if it is time to."""
        if self.due is not None and time.monotonic() >= self.due:
            self.pipe.close()
            self._start()

    def listen(self) -> Iterator[Notice | Over]:
        """Take its next message; yield what is not to be handled in the order of time."""
        try:
            message = msgspec.msgpack.decode(self.pipe.recv_bytes(), type=Message)
        except (EOFError, OSError):
            self.process.join()
            yield from self._fail(f"its process ended with {cause(self.process.exitcode)}")
            return
        if isinstance(message, Report):
            yield from self._take(message)
        elif isinstance(message, Ready):
            self.live = message.live
        else:
            self.over = isinstance(message, Over)
            yield message

    def _take(self, report: Report) -> Iterator[Notice]:
        """Keep a report that is new, under numbers that no former process has used."""
        if self._known:
            self._known -= 1
            return
        if self._ended is not None:
            away = time.monotonic() - self._ended
            self._ended = None
            yield Notice(self.name, f"it is back after {away:.1f} s.")
        self._told += 1
        first, someone = self._offsets
        sightings = tuple(_renumbered(each, someone) for each in report.sightings)
        report = replace(report, frame=report.frame + first, sightings=sightings)
        self._frames = report.frame + 1
        self._identities = max([self._identities, *(each.identity for each in sightings)])
        self.reports.append(report)

    def _fail(self, why: str) -> Iterator[Notice | Over]:
        """Say once that it failed, and when it is started again, unless that is in vain."""
        again = self._failed_at == self._told
        if again and not self.live:
            self.over = True
            yield Over(self.name, self._told, failure=why)
            return
        self._pause = min(2 * self._pause, LONGEST_PAUSE) if again else GAP
        self.due, self._failed_at = time.monotonic() + self._pause, self._told
        if self._ended is None:
            self._ended = time.monotonic()
            yield Notice(self.name, f"{why}. It is started again, with growing pauses.")


def _renumbered(sighting: Sighting, offset: int) -> Sighting:
    """Return a sighting with identities that are larger by an offset."""
    behind = None if sighting.behind is None else sighting.behind + offset
    return replace(sighting, identity=sighting.identity + offset, behind=behind)


# In a camera's process


def _serve(pipe: Connection, camera: Camera, seed: int, origin: float) -> None:
    """Watch a camera until it ends, and tell what it sees."""
    os.dup2(2, 1)  # standard output is for rows
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    frames, dropped, failure = 0, 0, None

    def tell(message: Message) -> None:
        pipe.send_bytes(msgspec.msgpack.encode(message))

    with suppress(BrokenPipeError):
        try:
            lookout = Lookout(camera, Scene(named_detector(camera.detector), camera.preset, seed))
            with open_watched(camera.source, origin) as film:
                live = isinstance(film, Live)
                tell(Ready(camera.name, live))
                for news in film:
                    if isinstance(news, str):
                        tell(Notice(camera.name, news))
                        continue
                    offset = 0.0 if live else camera.offset
                    tell(lookout.report(Frame(news.index, news.time + offset, news.pixels)))
                    frames, dropped = frames + 1, film.dropped if isinstance(film, Live) else 0
        except MotesError as error:
            failure = str(error)
        except BrokenPipeError:
            raise
        except Exception as error:  # whatever happens to one camera, the others shall know
            failure = f"{type(error).__name__}: {error}"
        tell(Over(camera.name, frames, dropped, failure))


def _end_with(sentinel: int) -> None:
    """End this process with the program, whatever ends that."""
    wait([sentinel])
    os._exit(1)
