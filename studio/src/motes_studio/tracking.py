"""The tasks that track, or that are about rows: as the library does them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence

import msgspec
import numpy as np
from msgspec.structs import replace

from motes import Ellipse, Frame, Regions, StepInfo, doubts
from motes.core import Part
from motes.correction import Course, Stretch, run_pass
from motes.mot import WatchConfig
from motes.video import FrameReader, shared
from motes_studio import messages
from motes_studio.messages import Overlay
from motes_studio.plan import RunPass
from motes_studio.tables import Table, line, pack, table_of, tracks
from motes_studio.workplace import Workplace

PARTICLES = 200
"""Particles of an overlay at most."""
Places = list[tuple[float, float, float, float, float]]
EVERY = 0.025
"""Seconds between parts: there are up to 40 overlays a second."""


class PassPart(msgspec.Struct, frozen=True):
    """Some rows of pass number `run`, and what its tracker sees."""

    rows: bytes
    run: int
    overlay: Overlay | None = None
    note: str | None = None
    """What the tracker says of the region that it began on."""


def run_passes(place: Workplace, passes: Sequence[RunPass]) -> bytes:
    """Run passes over the same frames, decoded once for all. `Part`s have `PassPart`s."""
    ends = [frame for run in passes for frame in (run.start, run.stop)]
    film = shared(place.film, min(ends), max(ends)) if len(passes) > 1 else place.film
    for number, run in enumerate(passes):
        _send_pass(place, run, number, film)
    return b""


def _send_pass(place: Workplace, run: RunPass, number: int, film: FrameReader) -> None:
    lines: list[list[float]] = []
    cues, sent, begun = 0, 0.0, 0.0
    note: str | None = None

    def frames() -> Iterator[Frame]:
        nonlocal begun
        for frame in _between(film, run.start, run.stop):
            begun = time.perf_counter()
            yield frame

    def send(overlay: Overlay | None = None) -> None:
        found = PassPart(pack(table_of(lines, cues)), number, overlay, note)
        place.send(Part(msgspec.msgpack.encode(found)))

    def observe(info: StepInfo) -> None:
        nonlocal sent, cues, note
        note = note or info.note
        took = round(1000 * (time.perf_counter() - begun), 3)
        weights = [*info.cue_weights.values()]
        cues = len(weights)
        lines.append(
            line(info.track, weights, final=False, milliseconds=took, supporting=info.n_supporting)
        )
        if time.monotonic() - sent > EVERY:
            send(overlay_of(info))
            lines.clear()
            sent = time.monotonic()
        place.check()

    _run(run, film, frames(), observe)
    if lines:
        send()


def join_stretch(
    place: Workplace,
    stretch: Stretch,
    forward: Table | None,
    backward: Table | None,
    cues: int,
) -> bytes:
    """Return the smoothed rows of a stretch from its passes: tables over its frames, in order."""
    passes = (None if table is None else Course.of(tracks(table)) for table in (forward, backward))
    joined = stretch.joined(place.film.times, *passes)
    return pack(table_of((line(track, [0.0] * cues, final=True) for track in joined), cues))


def find_doubts(place: Workplace, table: Table, marks: Iterable[int], count: int) -> bytes:
    """Return the JSON of a list of doubtful frames."""
    return msgspec.json.encode(
        [
            messages.DoubtfulFrame(doubt.frame, doubt.gain, [*doubt.reasons])
            for doubt in doubts(tracks(table), marks, count)
        ]
    )


def look_at(place: Workplace, number: int, run: RunPass) -> bytes:
    """Return the JSON of an `Overlay`: of an object in the last frame of a pass."""
    seen: list[StepInfo] = []

    def observe(info: StepInfo) -> None:
        seen[:] = [info]
        place.check()

    _run(run, place.film, _between(place.film, run.start, run.stop), observe)
    return msgspec.json.encode(replace(overlay_of(seen[0]), object=number))


def watch_film(place: Workplace, config: WatchConfig, places: Regions, seed: int) -> bytes:
    """Track all that moves. `Part`s have the JSON of `ScenePart`s."""
    from motes_studio.scenes import ScenePart, joined, scene_parts

    found: list[ScenePart] = []
    sent = time.monotonic()
    for part in scene_parts(place.film, config, places, seed):
        found.append(part)
        place.check()
        if time.monotonic() - sent > EVERY:
            place.send(Part(msgspec.json.encode(joined(found))))
            found.clear()
            sent = time.monotonic()
    if found:
        place.send(Part(msgspec.json.encode(joined(found))))
    return b""


def _run(
    run: RunPass, film: FrameReader, frames: Iterable[Frame], observe: Callable[[StepInfo], None]
) -> None:
    other = None
    if run.other is not None:
        index, region = run.other
        (frame,) = film.forward(index, index)
        other = frame, region
    start, backward = run.region, run.stop < run.start
    run_pass(run.config, run.seed, frames, start, backward=backward, other=other, observe=observe)


def _between(film: FrameReader, start: int, stop: int) -> Iterator[Frame]:
    return film.backward(start, stop) if stop < start else film.forward(start, stop)


def overlay_of(info: StepInfo) -> Overlay:
    """Return what a tracker sees, for the page."""
    covariance, ellipse = info.track.covariance, Ellipse(*map(float, info.track.ellipse))
    xx, xy, yy = (float(covariance[at]) for at in ((0, 0), (0, 1), (1, 1)))
    return Overlay(0, 0, info.track.frame, ellipse, (xx, xy, yy), *_heaviest(info))


def _heaviest(info: StepInfo) -> tuple[Places, list[float]]:
    """Return the heaviest particles of a step, and their weights, of which the largest is 1."""
    weights = np.asarray(info.weights, np.float64)
    if not len(weights):
        return [], []
    order = np.argsort(-weights, kind="stable")[:PARTICLES]
    top = max(float(weights[order[0]]), np.finfo(np.float64).tiny)
    particles = np.round(np.asarray(info.ellipses)[order], 2).tolist()
    return [tuple(each) for each in particles], np.round(weights[order] / top, 4).tolist()
