"""The tasks of a tracking worker: passes, joins, doubts and layers, as the library makes them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np

from motes.core.config import from_dict
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.correction.correct import tracks_of
from motes.correction.join import Stretch, join
from motes.correction.passes import run_pass
from motes.correction.suspects import doubts
from motes.sot.algorithm import Algorithm
from motes.sot.presets import TrackerConfig
from motes.sot.step_info import StepInfo
from motes.studio import protocol
from motes.studio.tables import as_pass, line, pack, table_of, tracks, unpack
from motes.studio.tasks import Done, FindDoubts, JoinStretch, LookAt, Part, RunPass, Task
from motes.studio.worker import Line
from motes.video.film import Film

EVERY = 0.033
"""Seconds between parts: the page draws about 30 overlays a second."""
PARTICLES = 200
"""Particles of an overlay at most."""


class Work:
    """A film, and what is done with it.

    Parameters
    ----------
    path
        The film, which has been checked.
    line
        The line to the server.
    """

    def __init__(self, path: str, line: Line) -> None:
        self._path, self._line = path, line
        self._film = Film(path, quick=True)
        self._tasks: dict[type, Callable[[Any], Done]] = {
            RunPass: self._pass,
            JoinStretch: self._join,
            FindDoubts: self._doubts,
            LookAt: self._look,
        }

    @property
    def facts(self) -> protocol.FilmFacts:
        """Size and length of the film."""
        film = self._film
        fps = film.fps or 1 / FRAME_INTERVAL
        return protocol.FilmFacts(film.name, film.width, film.height, len(film.times), fps)

    def do(self, task: Task) -> Done:
        """Do a task."""
        return self._tasks[type(task)](task)

    def _pass(self, task: RunPass) -> Done:
        config, cues = _config(task.config), 0
        lines: list[list[float]] = []
        sent, count = time.monotonic(), 0

        def observe(info: StepInfo) -> None:
            nonlocal sent, count, cues
            weights = [*info.cue_weights.values()]
            cues = len(weights)
            lines.append(line(info.track, weights, final=False))
            count += 1
            if time.monotonic() - sent > EVERY or count == 1:
                self._line.send(Part(pack(table_of(lines, cues)), overlay_of(info)))
                lines.clear()
                sent = time.monotonic()
            self._line.check()

        frames = self._frames(task.start, task.stop)
        backward = task.stop < task.start
        region = Ellipse(*task.region)
        run_pass(config, task.seed, frames, region, backward=backward, observe=observe)
        if lines:
            self._line.send(Part(pack(table_of(lines, cues))))
        return Done()

    def _frames(self, start: int, stop: int) -> Iterator[Frame]:
        film = self._film
        return film.backward(start, stop) if stop < start else film.forward(start, stop)

    def _join(self, task: JoinStretch) -> Done:
        absent = frozenset(t for first, last in task.absent for t in range(first, last + 1))
        ends = (None if each is None else Ellipse(*each) for each in (task.begin, task.end))
        stretch = Stretch(task.first, task.last, *ends, absent)
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
        items = [protocol.Doubt(each.frame, each.gain, [*each.reasons]) for each in found]
        return Done(msgspec.json.encode(items))

    def _look(self, task: LookAt) -> Done:
        from motes.studio.layers import layers_of

        seen: list[StepInfo] = []
        kept: list[Frame] = []

        def observe(info: StepInfo) -> None:
            seen[:] = [info]
            self._line.check()

        def frames() -> Iterator[Frame]:
            for frame in self._frames(task.start, task.frame):
                kept[:] = [frame]
                yield frame

        config = _config(task.config)
        backward = task.frame < task.start
        region = Ellipse(*task.region)
        run_pass(config, task.seed, frames(), region, backward=backward, observe=observe)
        found = layers_of(task.object, config, kept[0], seen[0], task.layers)
        return Done(msgspec.json.encode(found))


def _config(values: dict[str, Any]) -> TrackerConfig:
    config: TrackerConfig = from_dict(values, Algorithm)
    return config


def overlay_of(info: StepInfo) -> protocol.Overlay:
    """Return what a tracker sees, for the page: the heaviest particles at most."""
    covariance = info.track.covariance
    particles, weights = heaviest(info)
    return protocol.Overlay(
        number=0,
        object=0,
        frame=info.track.frame,
        ellipse=tuple(map(float, info.track.ellipse)),  # type: ignore[arg-type]
        covariance=(float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])),
        particles=particles,
        weights=weights,
        cue_weights={name: float(value) for name, value in info.cue_weights.items()},
    )


def heaviest(info: StepInfo) -> tuple[list[Any], list[float]]:
    """Return the heaviest particles of a step, and their weights, of which the largest is 1."""
    weights = np.asarray(info.weights, np.float64)
    if not len(weights):
        return [], []
    order = np.argsort(-weights, kind="stable")[:PARTICLES]
    top = max(float(weights[order[0]]), np.finfo(np.float64).tiny)
    particles = np.round(np.asarray(info.ellipses)[order], 2).tolist()
    return [tuple(each) for each in particles], np.round(weights[order] / top, 4).tolist()
