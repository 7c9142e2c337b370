"""What objects do at lines and in zones: events, and counts of them."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.errors import ConfigError
from motes.core.track import Status
from motes.mot.analytics.regions import SETTLED, Line, Point, Regions, crossing, distance
from motes.mot.boxes import foot_of
from motes.mot.tracked_object import SceneTrack

EDGE = "visits to its edge alone"
BRIEF = "events of objects that were seen for less than half a second and had hardly moved"
"""Reasons for which an event does not count."""

Kind: TypeAlias = Literal["appears", "disappears", "crosses", "enters", "stays", "leaves"]

MINUTE = 60.0
SPEED_OVER = 0.5
"""Seconds over which a speed is measured."""
CLEAR = 0.1
"""A foot is clearly on one side of a line from this share of its object's height on."""
LEAST_AGE = 0.5
"""Seconds for which an object must be known before anything that it does counts, unless it has
walked as far as it is high."""
JUMP = 0.5
"""A foot that is farther from its path than this share of its object's mean side has not walked."""
JOINED = 1.0
"""Longest gap in seconds between two parts of one path."""
PAST = 0.5
"""Seconds before its first place over which the path of an object is continued backwards."""


class Event(msgspec.Struct, frozen=True, rename={"identity": "id"}):
    """Something that an object does."""

    frame: int
    time: float
    """Index of the frame, and its time in seconds."""
    event: Kind
    """The kind of event."""
    identity: int
    """The object's; in JSON the key is `id`, as in rows."""
    x: float
    y: float
    """The place of its foot: the middle of its box's lower edge."""
    speed: float | None
    """In pixels a second, over the last half second; None where it is seen for the first time."""
    place: str | None = None
    direction: str | None = None
    """The name of the line or zone, and the line's label for the side to which it is crossed."""
    seconds: float | None = None
    """How long it has been in the zone where it stays or that it leaves, or in the picture."""
    metres_per_second: float | None = None
    """The speed on the ground, if that is known."""
    label: str | None = None
    """The object's class so far, if the detector knows classes."""

    def fields(self) -> dict[str, Any]:
        """Return its fields by their names in JSON, with numbers rounded, without empty ones."""
        pairs = zip(self.__struct_encode_fields__, msgspec.structs.astuple(self), strict=True)
        return {
            key: round(value, 3) if isinstance(value, float) else value
            for key, value in pairs
            if value is not None
        }

    def json(self) -> str:
        """Return a line of JSON."""
        return msgspec.json.encode(self.fields()).decode()


@dataclass(slots=True)
class _Trajectory:
    """The recent places of an object, its zones, and where it stays."""

    since: float
    """Time of its first place."""
    feet: deque[tuple[float, Point]]
    """Times and places of its foot in the last half second."""
    zones: dict[str, float]
    """For each zone that it is in, the time when it entered."""
    clear: dict[str, Point]
    """For each line, the last place of its foot that was clearly on one side. So an object that
    trembles on a line does not cross it."""
    stays: set[str]
    """Names of the zones in which it stays."""
    first: Point
    """Its first place."""
    over: dict[str, Event]
    """For each line, the event of crossing it, until the object is clearly on the other side."""
    pending: dict[str, Event]
    """For each line or zone, an event that does not count yet, as the object may come back."""
    inside: set[str] = field(default_factory=set)
    """Names of the zones in which it has clearly been since it entered."""
    sure: list[Event] = field(default_factory=list)
    """Events that count as soon as the object does."""
    walked: bool = False
    """Whether it has walked as far as it is high, without a jump."""
    jumped: bool = False
    """Whether it has ever jumped."""
    continued: bool = False
    """Whether another object has gone on with its path."""
    frame: int = 0
    """The frame of its last place."""

    def off(self, foot: Point, now: float, longest: float) -> float:
        """Return how far a foot is from where the last half second leads; NaN if that is old."""
        (began, first), (last, place) = self.feet[0], self.feet[-1]
        if last == began or not 0 < now - last <= longest:
            return math.nan
        share = (now - last) / (last - began)
        return math.dist([place[i] + share * (place[i] - first[i]) for i in range(2)], foot)

    def speed(self, start: Point, end: Point) -> float | None:
        """Return the speed of a way that it went in the last half second; None of one place."""
        began, now = self.feet[0][0], self.feet[-1][0]
        return math.dist(start, end) / (now - began) if now > began else None

    def counts(self, now: float) -> bool:
        """Return whether it is known well enough for its events to count."""
        return self.walked or now - self.since >= LEAST_AGE

    def settle(self, now: float, settled: float) -> None:
        """Make pending events sure that happened `settled` seconds before `now`, or earlier."""
        done = [name for name, event in self.pending.items() if now - event.time >= settled]
        self.sure += [self.pending.pop(name) for name in done]

    def counted(self, now: float) -> list[Event]:
        """Return the sure events, in order of time, if the object counts by now."""
        if not self.counts(now):
            return []
        events, self.sure = sorted(self.sure, key=lambda each: each.time), []
        self.stays -= {event.place for event in events if event.event == "leaves"}
        return events


class EventCounter:
    """Turns the tracks of a scene into events, and counts them.

    The place of an object is that of its foot. An occluded object has no events; what it did
    meanwhile becomes events when it is visible again.

    A crossing, an entry or an exit has the frame in which it happens. It is returned when it is
    sure: `SETTLED` seconds later, if the object has not come back. A visit is sure at once if the
    foot was farther from the zone's edge than a share of the object's height, `CLEAR`, however
    short it was. The object must be known for `LEAST_AGE` seconds, or have walked. An object that
    is found on a line has crossed it if its path, continued backwards, begins on the other side.

    Parameters
    ----------
    places
        Lines and zones.

    Attributes
    ----------
    left_out
        Number of events that do not count, for each (place, reason).
    """

    counts: Counter[tuple[int, str, str, str, str]]
    """Number of events for each (minute, event, place, direction, class)."""

    def __init__(self, places: Regions | None = None) -> None:
        if places is not None and not isinstance(places, Regions):
            raise ConfigError(
                f"An EventCounter takes Regions, such as motes.Regions(line=(line,)); got {places}."
            )
        places = places or Regions()
        self._lines, self._zones, self._ground = places.lines, places.zones, places.ground
        self._walks: dict[int, _Trajectory] = {}
        self._ended: list[_Trajectory] = []
        self.counts = Counter()
        self.left_out = Counter[tuple[str, str]]()

    def update(self, tracks: Sequence[SceneTrack]) -> list[Event]:
        """Return the events of a frame, from the scene's tracks in it."""
        events: list[Event] = []
        seen = {each.identity for each in tracks if each.track.status is Status.TRACKING}
        for each in tracks:
            if each.identity in seen:
                events += self._walk(each, seen)
            elif each.track.status is Status.LOST and each.identity in self._walks:
                events += self._end(each)
        return self._counted(events)

    def finish(self) -> list[Event]:
        """Return the events of the last frames that no later frame can undo, at a film's end."""
        walks, self._walks = self._walks, {}
        return self._counted([event for walk in walks.values() for event in self._last(walk)])

    def _last(self, walk: _Trajectory) -> list[Event]:
        """Return the last events of an object; those that do not count are noted."""
        now = walk.feet[-1][0]
        walk.settle(now, 0)
        events = walk.counted(now)
        self.left_out.update((event.place or "", BRIEF) for event in walk.sure)
        return events

    def remarks(self) -> list[str]:
        """Return a line for each place at which nothing counted, or something was left out."""
        seen = {place for _, _, place, _, _ in self.counts}
        lines = []
        for name in (*self._lines, *self._zones):
            verb = "crossed" if name in self._lines else "entered"
            said = [] if name in seen else [f"nothing {verb} it"]
            said += [
                f"{why} left out: {n}" for (place, why), n in self.left_out.items() if place == name
            ]
            lines += [f"{name}: {', '.join(said)}"] if said else []
        return lines

    def _counted(self, events: list[Event]) -> list[Event]:
        """Return events, which are counted."""
        for event in events:
            key = event.event, event.place or "", event.direction or "", event.label or ""
            self.counts[(int(event.time // MINUTE), *key)] += 1
        return events

    def _begin(self, foot: Point, time: float, limit: float, seen: set[int]) -> _Trajectory:
        """Return a new path, or one that goes on with that of an object that is not seen."""
        walk = _Trajectory(time, deque([(time, foot)]), {}, {}, set(), foot, {}, {})
        self._ended = [old for old in self._ended if time - old.feet[-1][0] <= JOINED]
        unseen = [old for identity, old in self._walks.items() if identity not in seen]
        before = [old for old in (*self._ended, *unseen) if old.off(foot, time, JOINED) <= limit]
        before = [old for old in before if not old.continued]
        if len(before) == 1:  # of two it could be either
            before[0].continued = True
            walk.clear, walk.walked = dict(before[0].clear), before[0].walked
        return walk

    def _walk(self, each: SceneTrack, seen: set[int]) -> list[Event]:
        """Return the events of a visible object."""
        foot, time = foot_of(each.box), each.track.time
        walk = self._walks.get(each.identity)
        height, limit = each.track.box.height, JUMP * math.sqrt(np.prod(each.track.box[2:]))
        events = []
        if walk is None:
            walk = self._walks[each.identity] = self._begin(foot, time, limit, seen)
            events.append(self._event(each, walk, foot, "appears"))
        # It then holds something else than before, such as two objects that touch. What was hidden
        # for longer than it had been seen may be anywhere.
        seen_for = walk.feet[-1][0] - walk.feet[0][0]
        jumped = walk.continued or walk.off(foot, time, seen_for) > limit
        walk.continued = False
        walk.feet.append((time, foot))
        walk.frame = each.track.frame
        while len(walk.feet) > 2 and walk.feet[1][0] <= time - SPEED_OVER:
            walk.feet.popleft()
        walk.jumped = walk.jumped or jumped
        walk.walked = not walk.jumped and (walk.walked or math.dist(walk.first, foot) >= height)
        walk.settle(time, SETTLED)
        events += walk.counted(time)
        for name, line in self._lines.items():
            if jumped:
                walk.clear[name] = foot
                walk.over.pop(name, None)
            else:
                self._cross(each, walk, foot, name, line)
        for name, zone in self._zones.items():
            holds = zone.holds(foot)
            if holds and name not in walk.zones:
                left = walk.pending.pop(name, None)  # and is back
                walk.zones[name] = time if left is None else left.time - (left.seconds or 0)
                if left is None:
                    walk.pending[name] = self._event(each, walk, foot, "enters", name)
            elif not holds and name in walk.zones:
                since, entry = walk.zones.pop(name), walk.pending.pop(name, None)
                if entry is not None and name not in walk.inside:
                    self.left_out[name, EDGE] += 1
                else:
                    walk.sure += [] if entry is None else [entry]
                    left = self._event(each, walk, foot, "leaves", name, seconds=time - since)
                    walk.pending[name] = left
                walk.inside.discard(name)
            elif holds and zone.dwell is not None and not {name} & {*walk.stays, *walk.pending}:
                inside = time - walk.zones[name]
                if inside >= zone.dwell:
                    walk.stays.add(name)
                    walk.sure.append(self._event(each, walk, foot, "stays", name, seconds=inside))
            if holds and zone.depth(foot) >= CLEAR * height:
                walk.inside.add(name)
        return events + walk.counted(time)

    def _cross(
        self, each: SceneTrack, walk: _Trajectory, foot: Point, name: str, line: Line
    ) -> None:
        """Note where an object is beside a line, and whether it has crossed it."""
        margin, before = CLEAR * each.track.box.height, walk.clear.get(name)
        clear = distance(line.points, foot) >= margin
        if before is None and clear:
            past = _past(walk, foot, each.track.time)
            before = past if distance(line.points, past) >= margin else foot
        side = None if before is None else crossing(line.points, before, foot)
        if side is None:
            walk.over.pop(name, None)
        else:
            event = self._event(each, walk, foot, "crosses", name, line.label[side == "right"])
            walk.over.setdefault(name, event)
        if clear:
            walk.clear[name] = foot
            crossed = walk.over.pop(name, None)
            if crossed is not None and walk.pending.pop(name, None) is None:  # else it is back
                walk.pending[name] = crossed

    def _end(self, each: SceneTrack) -> list[Event]:
        """Return the events of an object that is lost, at its last visible place.

        It left its zones when it was seen last, and disappears now.
        """
        walk = self._walks.pop(each.identity)
        self._ended.append(walk)
        last, foot = walk.feet[-1]
        events = self._last(walk)
        if walk.counts(last):
            left = [
                self._event(each, walk, foot, "leaves", name, seconds=last - since)
                for name, since in walk.zones.items()
            ]
            events += [replace(event, frame=walk.frame, time=last) for event in left]
        return [*events, self._event(each, walk, foot, "disappears", seconds=last - walk.since)]

    def _event(
        self,
        each: SceneTrack,
        walk: _Trajectory,
        foot: Point,
        kind: Kind,
        place: str | None = None,
        direction: str | None = None,
        seconds: float | None = None,
    ) -> Event:
        first, last, track = walk.feet[0][1], walk.feet[-1][1], each.track
        speed, metres_per_second = walk.speed(first, last), None
        if self._ground is not None:
            start, end = self._ground.metres(first), self._ground.metres(last)
            if start is not None and end is not None:
                metres_per_second = walk.speed(start, end)
        return Event(
            track.frame, track.time, kind, each.identity, *foot, speed, place, direction, seconds,
            metres_per_second, each.label,
        )  # fmt: skip


def _past(walk: _Trajectory, foot: Point, now: float) -> Point:
    """Return where an object was before its first place, if it has gone evenly; or its place.

    A foot that was clear of a line from the start has no past there: its first place is its place.
    A path is continued for no longer than it is: that of a few frames shows how a box grows.
    """
    if now == walk.since:
        return foot
    share = min(1.0, PAST / (now - walk.since))
    x, y = walk.first
    return x - share * (foot[0] - x), y - share * (foot[1] - y)
