"""`motes watch` frame by frame: the objects of a scene, their events, and a summary."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import replace

from motes.cli.frame_loop import Moment, Sink, Tally, run
from motes.cli.messages import counted, log
from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.formats.recording import ANONYMOUS
from motes.mot.analytics.events import EventCounter
from motes.mot.scene import Scene
from motes.mot.tracked_object import SceneTrack
from motes.video.sources import Source


def watch_scene(film: Source, scene: Scene, counter: EventCounter, outputs: Sequence[Sink]) -> int:
    """Track the objects of the film, write the outputs and print a summary."""

    def moments(pictures: Iterator[Frame]) -> Generator[Moment, None, None]:
        with contextlib.closing(scene.watch(pictures, ahead=not film.live)) as watched:
            yield from counted_moments(watched, counter, live=film.live)

    return run(film, outputs, moments, SceneTally(scene, counter))


def counted_moments(
    found: Iterable[tuple[Frame, Sequence[SceneTrack]]], counter: EventCounter, *, live: bool
) -> Generator[Moment, None, None]:
    """Yield the objects of each frame with their events; the last frame of a recording ends all."""
    last: Moment | None = None  # of a recorded film, which gets its open events
    error: MotesError | None = None
    try:
        for frame, tracks in found:
            if last is not None:
                yield last
            events = counter.update([each for each in tracks if each.identity != ANONYMOUS])
            last = Moment(frame, tracks=tracks, events=events, single=False)
            if live:
                yield last
                last = None
    except MotesError as raised:  # after the frames before it
        error = raised
    if last is not None:
        yield replace(last, events=[*last.events, *counter.finish()])
    if error is not None:
        raise error


class SceneTally(Tally):
    """Statistics of a scene, and its warnings as they come.

    Parameters
    ----------
    scene, counter
        The scene, and the counter of its events.
    """

    def __init__(self, scene: Scene, counter: EventCounter) -> None:
        super().__init__()
        self._scene, self._counter = scene, counter
        self._printed = set[str]()

    def add(self, moment: Moment) -> str:
        """Count a frame; return how many objects are there, came and went."""
        super().add(moment)
        scene = self._scene
        for kind, text in scene.warnings.items():
            if kind not in self._printed:
                self._printed.add(kind)
                log(text)
        here = scene.created - scene.terminated
        return f"{counted(here, 'object')}, {scene.created} came, {scene.terminated} went"

    def remarks(self) -> Sequence[str]:
        """Return the events of each minute, and what is to be known of them."""
        return [*table(self._counter.counts), *self._counter.remarks()]

    @property
    def missing(self) -> str | None:
        """What to say if there was no object."""
        if self._scene.created:
            return None
        why = self._scene.left_out
        if why is not None:
            return f"No object was ever found: {why}."
        return "No object was ever found; try another --detector."

    def __str__(self) -> str:
        scene, tracker = self._scene, self._scene.config.tracker
        return (
            f"{super().__str__()}, {counted(scene.created, 'object')}, {scene.terminated} of them "
            f"gone; each tracked by {tracker.particles} particles and {' and '.join(tracker.cues)}"
        )


def table(counts: Counter[tuple[int, str, str, str, str]]) -> list[str]:
    """Return a line for each minute with events: the number of events of each kind."""
    minutes: dict[int, list[str]] = {}
    for (minute, *parts), count in sorted(counts.items()):
        what = " ".join(part for part in parts if part)
        minutes.setdefault(minute, []).append(f"{what} {count}")
    return [f"minute {minute}: {', '.join(whats)}" for minute, whats in minutes.items()]
