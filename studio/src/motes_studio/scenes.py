"""The many-object mode: `motes watch` in a worker, and what it has found so far."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec
from msgspec.structs import replace

from motes import ConfigError, Event, EventCounter, Regions, Scene, Track
from motes.core import from_toml
from motes.mot import GroundMotion, RealUnits, WatchConfig
from motes.rows import FrameRow
from motes.video import Film
from motes_studio.commands import Watch
from motes_studio.messages import SceneFrame, SceneObject

REFUSED = ("detector",)
"""Keys of a configuration file that may name files and code; the page chooses the detector."""


class ScenePart(msgspec.Struct, frozen=True):
    """Some frames of the many-object mode."""

    frames: list[dict[str, Any]]
    """As of `FrameRow.to_dict`."""
    events: list[dict[str, Any]]
    """What is new."""
    objects: int
    """Number of objects in the last frame."""
    totals: dict[str, int]
    """How often each event has happened so far, by its name."""
    note: str | None = None
    """What the scene, or the ground, has to say so far."""


def config_of(watch: Watch) -> WatchConfig:
    """Return the configuration of a run.

    Raises
    ------
    ConfigError
        For an unknown preset or key, a value that does not fit, or a key that may not be given.
    """
    changes = from_toml(watch.config or "", "the configuration")
    for key in REFUSED:
        if key in changes:
            raise ConfigError(f"The configuration has {key!r}; choose it in the page instead.")
    return WatchConfig.of(watch.preset).changed(changes, detector=watch.detector)


def scene_parts(film: Film, config: WatchConfig, places: Regions, seed: int) -> Iterator[ScenePart]:
    """Yield a part for each frame of a film, and one with the events that are still open then."""
    scene = Scene(config.detector.detector(), config, seed)
    size = film.width, film.height
    counter = EventCounter(places, size)
    motion = None if places.ground is None else GroundMotion(RealUnits(places.ground), size)
    last = len(film.times) - 1
    scene.prepare(film.forward(0, last))

    def part(rows: list[FrameRow], events: list[Event]) -> ScenePart:
        fields = [event.fields() for event in events]
        here = scene.created - scene.terminated
        said = " ".join(filter(None, [*scene.warnings.values(), motion.note if motion else ""]))
        found = [row.to_dict() for row in rows]
        return ScenePart(found, fields, here, dict(counter.totals), said or None)

    for frame, tracks in scene.watch(film.forward(0, last), ahead=False):
        events = counter.update(tracks, frame.time)
        placed = motion.update(tracks) if motion else tracks
        yield part([FrameRow(frame.index, frame.time, tuple(placed))], events)
    yield part([], counter.finish())


def joined(parts: list[ScenePart]) -> ScenePart:
    """Return parts as one; all but frames and events is that of the last."""
    frames = [row for part in parts for row in part.frames]
    return replace(
        parts[-1], frames=frames, events=[each for part in parts for each in part.events]
    )


def shown(frame: Mapping[str, Any]) -> SceneFrame:
    """Return a frame of a part for the page."""
    row = FrameRow.from_dict(frame)
    return SceneFrame(row.frame, row.time, [*map(_object, row.objects)])


def _object(each: Track) -> SceneObject:
    x, y, width, height = (round(value, 2) for value in each.box)
    return SceneObject(
        each.identity, x, y, width, height, each.confidence, str(each.status), each.occluded_by,
        each.label,
    )  # fmt: skip
