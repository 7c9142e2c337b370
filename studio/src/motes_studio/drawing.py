"""The annotated film of a session."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec.structs import replace

from motes import Regions, Status, StepInfo, Track, VideoWriter
from motes.cli import Moment, ScenePainter, TargetPainter
from motes.core import FRAME_INTERVAL
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
    painter = ScenePainter(Regions()) if len(found) > 1 else TargetPainter()
    with VideoWriter(path, film.fps or 1 / FRAME_INTERVAL) as writer:
        for frame in film.forward(first, last):
            here = by_frame.get(frame.index, [])
            info = StepInfo(here[0]) if here else None
            drawn = painter.painted(Moment(frame, here, info))
            writer.write(drawn, frame.time - film.times[first])
            place.check()
    return b""
