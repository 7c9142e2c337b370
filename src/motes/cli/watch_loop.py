"""`motes watch` frame by frame: the objects of a scene, their events, and a summary."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import replace

from motes.cli.frame_loop import Moment, Tally
from motes.cli.streams import log
from motes.cli.track_units import placed_by
from motes.core.errors import MotesError, counted
from motes.core.frame import Frame
from motes.core.track import Track
from motes.formats.recording import ANONYMOUS
from motes.mot.analytics.event_counter import EventCounter
from motes.mot.analytics.real_units import GroundMotion, RealUnits
from motes.mot.scene import DOUBTS, Scene
from motes.video.sources import Source


def scene_moments(
    film: Source,
    scene: Scene,
    counter: EventCounter,
    units: RealUnits | None,
    frames: Iterator[Frame],
) -> Generator[Moment, None, None]:
    """Yield the moments of the objects of a film; with units, they have places on the ground."""
    motion = None if units is None else GroundMotion(units, (film.width, film.height))
    with contextlib.closing(scene.watch(frames, ahead=not film.live)) as watched:
        yield from counted_moments(watched, counter, motion)


def counted_moments(
    found: Iterable[tuple[Frame, Sequence[Track]]],
    counter: EventCounter,
    motion: GroundMotion | None = None,
) -> Generator[Moment, None, None]:
    """Yield the objects of each frame with their events; the last one ends all that is open.

    That is the last frame of a film, before an error, or before an interrupt, which may also be
    thrown into the generator. So each moment comes a frame late.
    """
    last: Moment | None = None
    end: MotesError | KeyboardInterrupt | None = None
    try:
        for frame, tracks in found:
            named = [each for each in tracks if each.identity != ANONYMOUS]
            events = counter.update(named, frame.time)
            placed, totals = placed_by(motion, tracks) if motion else tracks, dict(counter.totals)
            moment = Moment(frame, placed, None, 0.0, events, counter.undecided, totals)
            before, last = last, moment
            if before is not None:
                yield before
    except (MotesError, KeyboardInterrupt) as raised:
        end = raised
    if last is not None:
        events = [*last.events, *counter.finish()]
        yield replace(last, events=events, totals=counter.totals)
    if end is not None:
        raise end


class SceneTally(Tally):
    """Statistics of the frames that are written, and a scene's warnings as they come.

    `turns` is whether the summary has a table of turns.
    """

    def __init__(self, scene: Scene, counter: EventCounter, *, turns: bool) -> None:
        super().__init__()
        self._scene, self._counter, self._turns = scene, counter, turns
        self._printed = set[str]()
        self._came = self._gone = self._last = 0

    def add(self, moment: Moment) -> str:
        """Count a frame; return how many objects are there, came and went."""
        super().add(moment)
        self._last = moment.frame.index
        for kind, text in self._scene.warnings.items():
            if kind not in self._printed:
                self._printed.add(kind)
                log(text)
        self._came = max([self._came, *(each.identity for each in moment.tracks)])
        self._gone += sum(each.gone for each in moment.tracks)
        here = counted(self._came - self._gone, "object")
        return f"{here}, {self._came} came, {self._gone} went"

    def remarks(self) -> Sequence[str]:
        """Return the events of each minute, and what is to be known of them."""
        unused = [*getattr(self._scene.detector, "unused_detections", [])]
        if self._came and (unseen := self._scene.unseen_classes) is not None:
            unused.append(unseen)
        turns = turn_table(self._counter.turns) if self._turns else []
        doubts = [
            f"counts are in doubt from frame {first} on: {DOUBTS[kind]}"
            for kind, first in sorted(self._scene.doubts.items(), key=lambda pair: pair[1])
            if first <= self._last
        ]
        return [*table(self._counter.counts), *turns, *doubts, *self._counter.remarks(), *unused]

    @property
    def missing(self) -> str | None:
        """What to say if there was no object."""
        if self._came:
            return None
        why = self._scene.left_out
        if self.frames < 3:
            why = "one is reported with its third frame; give a film"
        more = "; try another --detector" if why is None else f": {why}"
        return f"No object was ever found{more}."

    def __str__(self) -> str:
        tracker = self._scene.config.tracker
        return (
            f"{super().__str__()}, {counted(self._came, 'object')}, {self._gone} of them gone; "
            f"each tracked by {tracker.particles} particles and {' and '.join(tracker.cues)}"
        )


def table(counts: Counter[tuple[int, str, str, str, str]]) -> list[str]:
    """Return a line for each minute with events, and with several one for all of them."""
    minutes: dict[int, list[str]] = {}
    total = Counter[str]()
    for (minute, *parts), count in sorted(counts.items()):
        what = " ".join(part for part in parts if part)
        minutes.setdefault(minute, []).append(f"{what} {count}")
        total[what] += count
    lines = [f"minute {minute}: {', '.join(whats)}" for minute, whats in minutes.items()]
    if len(lines) > 1:
        lines.append(f"in all: {', '.join(f'{what} {n}' for what, n in sorted(total.items()))}")
    return lines


def turn_table(turns: Counter[tuple[str, str]]) -> list[str]:
    """Return the lines of a table of how many objects went from each line to each other one.

    `turns` has their number for each (first, last) line, as `EventCounter.turns`.
    """
    starts = sorted({start for start, _ in turns})
    ends = [*sorted({end for _, end in turns if end}), *[""] * any(not end for _, end in turns)]
    rows = [["from / to", *(end or "no other" for end in ends)]]
    rows += [[start, *(str(turns[start, end]) for end in ends)] for start in starts]
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join([row[0].ljust(wide[0]), *map(str.rjust, row[1:], wide[1:])]) for row in rows]
    return ["objects from line to line:", *lines] if turns else ["objects from line to line: none"]
