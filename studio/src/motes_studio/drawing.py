"""The annotated film of a session."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from msgspec.structs import replace

from motes import Frame, Regions, Status, Track, VideoWriter, draw
from motes.core import FRAME_INTERVAL
from motes.output import TRAIL, ScenePainter
from motes_studio.tables import Table, tracks
from motes_studio.workplace import Workplace


def annotated(place: Workplace, tables: Mapping[int, Table], path: str) -> bytes:
    """Write a film with the objects drawn: one object as `motes track --overlay` does.

    Several objects are drawn with their numbers, as `motes watch --overlay` does.
    """
    film, found = place.film, {number: tracks(table) for number, table in tables.items()}
    first = min(shown[0].frame for shown in found.values())
    last = max(shown[-1].frame for shown in found.values())
    by_frame: dict[int, list[Track]] = {}
    for number, shown in found.items():
        for track in shown:
            if track.status is not Status.ABSENT or len(found) == 1:
                by_frame.setdefault(track.frame, []).append(replace(track, identity=number))
    scene, trail = ScenePainter(Regions()), list[tuple[float, float]]()
    with VideoWriter(path, film.fps or 1 / FRAME_INTERVAL) as writer:
        for frame in film.forward(first, last):
            here = by_frame.get(frame.index, [])
            if len(found) > 1:
                pixels = scene.painted(frame, here, ())()
            else:
                pixels = _one(frame, here[0], trail)
            writer.write(pixels, frame.time - film.times[first])
            place.check()
    return b""


def _one(frame: Frame, track: Track, trail: list[tuple[float, float]]) -> np.ndarray:
    seen = track.status is Status.TRACKING
    trail.append(track.ellipse[:2] if seen else (np.nan, np.nan))
    del trail[:-TRAIL]
    return draw(
        frame.pixels, track, particles=np.empty((0, 5)), weights=np.empty(0), trail=[*trail]
    )
