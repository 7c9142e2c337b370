"""Places and speeds of objects in metres, also for rows that were made without them."""

from __future__ import annotations

import dataclasses
from collections import defaultdict

from msgspec.structs import replace

from motes.core.track import GROUND, Track
from motes.formats.recording import ANONYMOUS, Recording
from motes.mot.analytics.real_units import Columns, RealUnits, motion_in_hindsight


def in_metres(recorded: Recording, units: RealUnits) -> Recording:
    """Return the objects with places and speeds in metres, in hindsight; old ones go."""
    tracks = defaultdict[int, dict[int, Track]](dict)
    for row in recorded:
        for each in row.objects:
            tracks[each.identity][row.frame] = each
    places = dict[tuple[int, int], Columns]()
    for identity, seen in tracks.items():
        span = range(min(seen), max(seen) + 1)
        found = motion_in_hindsight(units, map(seen.get, span))
        places |= {(identity, n): place for n, place in zip(span, found, strict=True)}
    nowhere = dict.fromkeys(GROUND)

    def placed(each: Track) -> Track:
        if each.identity == ANONYMOUS:  # several in a frame, and none has a way
            (place,) = motion_in_hindsight(units, [each])
        else:
            place = places[each.identity, each.frame]
        return replace(each, further={**each.further, **nowhere, **place})

    frames = [replace(row, objects=tuple(map(placed, row.objects))) for row in recorded]
    return dataclasses.replace(recorded, frames=frames)
