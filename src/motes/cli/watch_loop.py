"""`motes watch` frame by frame: the objects of a scene, their events, and a summary."""

from __future__ import annotations

import contextlib
from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace

from motes.cli.frame_loop import exit_code, run, summarize
from motes.cli.messages import counted, log
from motes.cli.moment import Moment, Sink
from motes.cli.watch_counting import table
from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.mot.analytics.events import EventCounter
from motes.mot.scene import Scene
from motes.video.sources import Source


def watch_scene(film: Source, scene: Scene, counter: EventCounter, outputs: Sequence[Sink]) -> int:
    """Track the objects of the film, write the outputs and print a summary."""
    frames, printed = 0, set[str]()

    def moments(pictures: Iterator[Frame]) -> Generator[Moment, None, None]:
        with contextlib.closing(scene.watch(pictures, ahead=not film.live)) as watched:
            last: Moment | None = None  # of a recorded film, which gets its open events
            error: MotesError | None = None
            try:
                for frame, tracks in watched:
                    if last is not None:
                        yield last
                    events = counter.update(tracks)
                    last = Moment(frame, tracks=tracks, events=events, single=False)
                    if film.live:
                        yield last
                        last = None
            except MotesError as raised:  # after the frames before it
                error = raised
            if last is not None:
                yield replace(last, events=[*last.events, *counter.finish()])
            if error is not None:
                raise error

    def note(moment: Moment) -> str:
        nonlocal frames
        frames += 1
        for kind, text in scene.warnings.items():
            if kind not in printed:
                printed.add(kind)
                log(text)
        here = scene.created - scene.terminated
        return f"{counted(here, 'object')}, {scene.created} came, {scene.terminated} went"

    def report(interrupted: KeyboardInterrupt | None) -> None:
        if not frames:
            return
        tracker = scene.config.tracker
        parts = [
            f"{counted(frames, 'frame')}, {counted(scene.created, 'object')}, "
            f"{scene.terminated} of them gone",
            f"each tracked by {tracker.particles} particles and {' and '.join(tracker.cues)}",
        ]
        summarize(parts, film, outputs, interrupted)
        for text in (*table(counter.counts), *counter.remarks()):
            log(text)

    interrupted = run(film, outputs, moments, note, report)
    missing = "No object was ever found; try another --detector."
    return exit_code(interrupted, scene.created > 0, missing)
