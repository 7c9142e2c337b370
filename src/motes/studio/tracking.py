"""The tasks of a tracking worker: passes, joins, doubts and layers, as the library makes them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import msgspec

from motes.core.config import from_dict
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.correction.correct import tracks_of
from motes.correction.join import Stretch, join
from motes.correction.passes import run_pass
from motes.correction.suspects import doubts
from motes.mot.pipeline_config import WatchConfig
from motes.sot.algorithm import Algorithm
from motes.sot.presets import TrackerConfig
from motes.sot.step_info import StepInfo
from motes.studio import messages
from motes.studio.document import regions_of
from motes.studio.line import WorkerLine
from motes.studio.opening import facts_of, opened
from motes.studio.overlays import overlay_of
from motes.studio.tables import as_pass, line, pack, table_of, tracks, unpack
from motes.studio.tasks import (
    Annotate,
    Done,
    DrawFigures,
    DrawForeground,
    DrawSlit,
    FindDoubts,
    JoinStretch,
    LookAt,
    Part,
    RunPass,
    RunPasses,
    Task,
    WatchFilm,
)
from motes.video.shared import FrameReader, shared

EVERY = 0.025
"""Seconds between parts: there are up to 40 overlays a second."""


class Work:
    """A film, and what is done with it.

    Parameters
    ----------
    path
        The film, which has been checked.
    line
        The line to the server.
    whole
        Whether the film is known to be damaged.
    """

    def __init__(self, path: str, line: WorkerLine, *, whole: bool = False) -> None:
        self._line = line
        self._film = opened(path, line.check, whole=whole)
        self._tasks: dict[type, Callable[[Any], Done]] = {
            RunPasses: self._passes,
            JoinStretch: self._join,
            FindDoubts: self._doubts,
            LookAt: self._look,
            WatchFilm: self._watch,
            Annotate: self._annotate,
            DrawFigures: self._figures,
            DrawSlit: self._slit,
            DrawForeground: self._foreground,
        }

    @property
    def facts(self) -> messages.OpenFilm:
        """Size and length of the film."""
        return facts_of(self._film)

    def do(self, task: Task) -> Done:
        """Do a task."""
        return self._tasks[type(task)](task)

    def _passes(self, task: RunPasses) -> Done:
        ends = [frame for each in task.passes for frame in (each.start, each.stop)]
        several = len(task.passes) > 1
        film = shared(self._film, min(ends), max(ends)) if several else self._film
        for place, each in enumerate(task.passes):
            self._pass(each, place, film)
        return Done()

    def _pass(self, task: RunPass, place: int, film: FrameReader) -> None:
        config, cues = _config(task.config), 0
        lines: list[list[float]] = []
        sent, count, begun = time.monotonic(), 0, 0.0

        def frames() -> Iterator[Frame]:
            nonlocal begun
            for frame in _between(film, task.start, task.stop):
                begun = time.perf_counter()
                yield frame

        def observe(info: StepInfo) -> None:
            nonlocal sent, count, cues
            took = round(1000 * (time.perf_counter() - begun), 3)
            weights = [*info.cue_weights.values()]
            cues = len(weights)
            found = line(
                info.track, weights, final=False, milliseconds=took, supporting=info.n_supporting
            )
            lines.append(found)
            count += 1
            if time.monotonic() - sent > EVERY or count == 1:
                self._line.send(Part(pack(table_of(lines, cues)), place, overlay_of(info)))
                lines.clear()
                sent = time.monotonic()
            self._line.check()

        _run(task, config, film, frames(), observe)
        if lines:
            self._line.send(Part(pack(table_of(lines, cues)), place))

    def _join(self, task: JoinStretch) -> Done:
        absent = frozenset(t for first, last in task.absent for t in range(first, last + 1))
        begin, end = (None if each is None else Ellipse(*each) for each in (task.begin, task.end))
        stretch = Stretch(task.first, task.last, begin, end, absent)
        tables = [
            None if data is None else unpack(data, task.cues)
            for data in (task.forward, task.backward)
        ]
        joined = join(stretch, *(None if each is None else as_pass(each) for each in tables))
        found = table_of(
            (
                line(track, [0.0] * task.cues, final=True)
                for track in tracks_of(stretch, joined, self._film.times)
            ),
            task.cues,
        )
        return Done(pack(found))

    def _doubts(self, task: FindDoubts) -> Done:
        keys = {
            frame: None if region is None else Ellipse(*region) for frame, region in task.keyframes
        }
        found = doubts(tracks(unpack(task.table, task.cues)), keys, task.count)
        items = [messages.DoubtfulFrame(each.frame, each.gain, [*each.reasons]) for each in found]
        return Done(msgspec.json.encode(items))

    def _look(self, task: LookAt) -> Done:
        from motes.studio.layers import layers_of

        seen: list[StepInfo] = []
        kept: list[Frame] = []

        def observe(info: StepInfo) -> None:
            seen[:] = [info]
            self._line.check()

        def frames() -> Iterator[Frame]:
            for frame in _between(self._film, task.run.start, task.run.stop):
                kept[:] = [frame]
                yield frame

        config = _config(task.run.config)
        _run(task.run, config, self._film, frames(), observe)
        found = layers_of(task.object, config, kept[0], seen[0], task.layers)
        return Done(msgspec.json.encode(found))

    def _watch(self, task: WatchFilm) -> Done:
        from motes.studio.scenes import ScenePart, SceneRun, joined

        config: WatchConfig = from_dict(task.config, WatchConfig)
        run = SceneRun(config, regions_of(task.places), task.seed)
        last = len(self._film.times) - 1
        run.prepare(self._film.forward(0, last))
        found: list[ScenePart] = []
        sent = time.monotonic()
        for part in run.parts(self._film.forward(0, last)):
            found.append(part)
            self._line.check()
            if time.monotonic() - sent > EVERY:
                self._line.send(Part(msgspec.json.encode(joined(found))))
                found.clear()
                sent = time.monotonic()
        if found:
            self._line.send(Part(msgspec.json.encode(joined(found))))
        return Done()

    def _annotate(self, task: Annotate) -> Done:
        from motes.studio.drawing import annotated

        found = {number: tracks(unpack(data, cues)) for number, data, cues in task.objects}
        annotated(self._film, found, task.path, self._line.check)
        return Done()

    def _figures(self, task: DrawFigures) -> Done:
        from motes.studio.drawing import figures

        figures(self._film, _config(task.config), task, self._line.check)
        return Done()

    def _foreground(self, task: DrawForeground) -> Done:
        from motes.studio.foreground import foreground

        return Done(foreground(self._film, task.method, task.index, self._line.check))

    def _slit(self, task: DrawSlit) -> Done:
        from motes.studio.drawing import slit

        return Done(slit(self._film, task, self._line.check))


def _run(
    task: RunPass,
    config: TrackerConfig,
    film: FrameReader,
    frames: Iterable[Frame],
    observe: Callable[[StepInfo], None],
) -> None:
    other = None
    if task.other is not None:
        index, region = task.other
        (frame,) = film.forward(index, index)
        other = frame, Ellipse(*region)
    run_pass(
        config,
        task.seed,
        frames,
        Ellipse(*task.region),
        backward=task.stop < task.start,
        other=other,
        observe=observe,
    )


def _between(film: FrameReader, start: int, stop: int) -> Iterator[Frame]:
    return film.backward(start, stop) if stop < start else film.forward(start, stop)


def _config(values: dict[str, Any]) -> TrackerConfig:
    config: TrackerConfig = from_dict(values, Algorithm)
    return config
