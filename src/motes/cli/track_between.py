"""`motes track` between keyframes, in both directions, smoothed.

The rows come first, stretch by stretch. The overlay is made when all of them are there.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from msgspec import structs

from motes.cli.annotated_video import TargetPainter
from motes.cli.correct_run import run_stretches
from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import FrameProgress, Moment, Sink, Tally, summarize
from motes.cli.input_checks import point_out_meant
from motes.cli.option_groups import say_rate
from motes.cli.outputs import Request
from motes.cli.track_units import check_size
from motes.core import interrupts
from motes.core.errors import counted
from motes.core.files import check_writable
from motes.core.frame import Frame
from motes.core.interrupts import deferred
from motes.core.track import Status, Track
from motes.correction.history import History
from motes.correction.join import Stretch
from motes.correction.keyframes import Mark, check_keyframes
from motes.correction.rows import as_read
from motes.mot.analytics.real_units import motion_in_hindsight
from motes.rows.schema import HINDSIGHT
from motes.sot.algorithm import StepInfo
from motes.sot.presets import TrackerConfig
from motes.video.film import Film


def track_between(
    asked: Request[TrackerConfig], marks: Sequence[Mark], region: Sequence[float] | None
) -> int:
    """Track a target between keyframes, write the outputs and print a summary.

    The region is that of --init, in the first frame. Raises a ConfigError if keyframes contradict
    each other or do not fit the film, or the lens does not.
    """
    frames = asked.frames
    film = Film(asked.source, start=frames.start, end=frames.end, fps=frames.fps)
    say_rate(film)
    if region is not None:
        marks = [(film.frames.start, region), *marks]
    history = History.begin(film, asked.config, asked.seed, marks, asked.units, asked.preset)
    check_keyframes(history.keys, film.name, film.frames, film.width, film.height)
    for mark in history.keys.values():
        point_out_meant(mark, film.width, film.height)
    check_size(asked.units, film.name, film.width, film.height)
    if (path := asked.rows_file) is not None:
        for each in (path, History.path(path)):
            check_writable(each, asked.overwrite)
    videos = asked.pictures(film, TargetPainter(metres=asked.units is not None))
    rows = asked.rows(film, HINDSIGHT)
    run = KeyframeRun(film, asked, history)
    try:
        try:
            run.track(rows)
        finally:  # also what an error or an interrupt has left
            run.draw(videos)
    finally:
        summarize(run, film, [*videos, *rows], run.interrupted)
    return interrupts.code(run.interrupted) if run.interrupted else DONE


class KeyframeRun(Tally):
    """A run between keyframes, and what is counted of it so far."""

    def __init__(self, film: Film, asked: Request[TrackerConfig], history: History) -> None:
        super().__init__()
        self.interrupted: KeyboardInterrupt | None = None
        """The interrupt that ended the run, or None."""
        self._film, self._history, self._asked = film, history, asked
        self._quiet = asked.goal is not None and asked.goal.name == "-"
        self._black = np.zeros((film.height, film.width, 3), np.uint8)
        self._moments: dict[int, Moment] = {}
        self._states = Counter[Status]()

    def track(self, outputs: list[Sink]) -> None:
        """Track the target between its keyframes, write its rows in order, and close them.

        Before the first row, the history notes all stretches as not finished, and each one as
        finished after its rows. So `motes refine` can finish a run that was killed. An interrupt
        before the first row is raised, and leaves no file.
        """
        history, path = self._history, self._asked.rows_file
        parts = Stretch.between(self._film.frames, history.keys)
        left = [*parts]

        def write(stretch: Stretch, tracks: list[Track]) -> None:
            if path is not None and not self.frames:
                history.unfinished_with(left).save(path)
            places = motion_in_hindsight(self._asked.units, map(as_read, tracks))
            for track, place in zip(tracks, places, strict=True):
                if track.frame not in self._moments:  # that of a keyframe is in two stretches
                    self._write(structs.replace(track, smoothed=True, further=place), outputs)
            if stretch == left[0]:  # and not only its forward pass, at an interrupt
                left.pop(0)
                if path is not None:
                    history.unfinished_with(left).save(path)

        with contextlib.ExitStack() as opened:
            for output in outputs:
                opened.enter_context(output)
            _, self.interrupted = run_stretches(
                self._film, parts, history, write, quiet=self._quiet
            )
            if self.interrupted and not self.frames:
                raise self.interrupted
        if path is not None and not left:
            history.save(path, whole=True)

    def _write(self, track: Track, outputs: list[Sink]) -> None:
        """Write the row of a track; its frame is black until it is drawn."""
        frame = Frame(track.frame, track.time, self._black)
        moment = Moment(frame, [track], StepInfo(track)).labeled(self._asked.outputs.label)
        for output in outputs:
            output.write(moment)
        self._moments[track.frame] = moment
        self._states[track.status] += 1
        self.add(moment)

    def draw(self, outputs: list[Sink]) -> None:
        """Write all frames so far into the outputs beside the rows."""
        moments = self._moments
        if not (outputs and moments):
            return
        with contextlib.ExitStack() as opened:
            for output in outputs:
                opened.enter_context(output)
            frames = self._film.forward(min(moments), max(moments))
            opened.enter_context(contextlib.closing(frames))
            progress = opened.enter_context(FrameProgress(len(moments), quiet=self._quiet))
            try:
                for frame in frames:
                    with deferred():
                        for output in outputs:
                            output.write(replace(moments[frame.index], frame=frame))
                    progress.count("drawn")
            except KeyboardInterrupt as interrupt:
                self.interrupted = interrupt

    def __str__(self) -> str:
        counts = [f"{status} in {number}" for status, number in self._states.most_common()]
        return ", ".join([super().__str__(), counted(len(self._history.keys), "keyframe"), *counts])
