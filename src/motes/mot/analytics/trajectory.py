"""The path of an object's foot: what it does at lines and zones follows from it."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from motes.mot.analytics.event import Event
from motes.mot.analytics.ground_plane import Ground, Point

SPEED_OVER = 0.5
"""Seconds over which a speed is measured."""
LEAST_AGE = 0.5
"""Seconds for which an object must be known before anything that it does counts, unless it has
walked as far as it is high."""
PAST = 0.5
"""Seconds before its first place over which the path of an object is continued backwards."""


@dataclass(slots=True)
class Trajectory:
    """The recent places of an object, its zones, and where it stays."""

    since: float
    """Time of its first place."""
    first: Point
    """Its first place."""
    feet: deque[tuple[float, Point]]
    """Times and places of its foot in the last half second."""
    whole: deque[tuple[float, Point]] = field(default_factory=deque)
    """Those of them in turn, up to the last, where no edge of the picture cuts its box."""
    came: Event | None = None
    """That it appears, until this counts."""
    speed: float | None = None
    metres_per_second: float | None = None
    """Its speed when it was last seen whole, in pixels and on the ground; None before."""
    zones: dict[str, float] = field(default_factory=dict)
    """For each zone that it is in, the time when it entered."""
    stays: set[str] = field(default_factory=set)
    """Names of the zones in which it stays."""
    outside: set[str] = field(default_factory=set)
    touched: set[str] = field(default_factory=set)
    """Names of the zones outside of which it has been seen, and of those whose edge alone it has
    touched."""
    found: set[str] = field(default_factory=set)
    upon: set[str] = field(default_factory=set)
    lost: set[str] = field(default_factory=set)
    """Names of the lines and zones in or upon which it was found, was seen last, and was lost."""
    clear: dict[str, Point] = field(default_factory=dict)
    """For each line, the last place of its foot clearly on one side (`event_counter.CLEAR`)."""
    went: dict[str, str | None] = field(default_factory=dict)
    """For each line or zone whose edge it has passed, the direction in which it crossed the line
    last."""
    near: set[str] = field(default_factory=set)
    """Names of those that it has not been away from since."""
    over: dict[str, Event] = field(default_factory=dict)
    """For each line or zone, the event of passing its edge, until the object is clearly beyond."""
    pending: dict[str, Event] = field(default_factory=dict)
    """For each line or zone, an event that does not count yet, as the object may come back."""
    sure: list[Event] = field(default_factory=list)
    """Events that count as soon as the object does."""
    leaving: list[Event] = field(default_factory=list)
    """Events that count once it has ended, unless another object goes on with its path."""
    crossed: list[str] = field(default_factory=list)
    """Names of the lines that it has crossed, also as another object before."""
    walked: bool = False
    """Whether it has walked as far as it is high, without a jump, or another one has before."""
    jumped: bool = False
    """Whether it has ever jumped."""
    continued: bool = False
    """Whether another object has gone on with its path."""
    rows: int = 0
    """Number of frames in which it was seen."""
    frame: int = 0
    turn: int = 0
    """The index of the last frame in which it was seen, and its number among all frames."""

    def step(self, time: float, foot: Point, *, cut: bool, ground: Ground | None) -> None:
        """Add the place of its foot in a frame in which it is seen.

        Where an edge of the picture cuts its box, the foot moves otherwise than the object does: it
        has the speed that it had before.
        """
        self.rows += 1
        _append(self.feet, time, foot)
        if cut:
            self.whole.clear()
            return
        _append(self.whole, time, foot)
        (began, start), (now, end) = self.whole[0], self.whole[-1]
        if now == began:
            return
        self.speed = math.dist(start, end) / (now - began)
        self.metres_per_second = None
        if ground is not None:
            here, there = ground.metres(start), ground.metres(end)
            if here is not None and there is not None:
                self.metres_per_second = math.dist(here, there) / (now - began)

    def off(self, foot: Point, now: float, longest: float) -> float:
        """Return how far a foot is from where the path of the last half second leads.

        NaN if the path is a single place, or ended more than `longest` seconds ago.
        """
        (began, first), (last, place) = self.feet[0], self.feet[-1]
        if last == began or not 0 < now - last <= longest:
            return math.nan
        share = (now - last) / (last - began)
        return math.dist([place[i] + share * (place[i] - first[i]) for i in range(2)], foot)

    def past(self, foot: Point, now: float) -> Point:
        """Return where it was before its first place, if it has gone evenly.

        In its first frame that is its place. A path is continued backwards for no longer than it
        is: that of a few frames shows how a box grows.
        """
        if now == self.since:
            return foot
        share = min(1.0, PAST / (now - self.since))
        x, y = self.first
        return x - share * (foot[0] - x), y - share * (foot[1] - y)

    def known(self, turn: int) -> bool:
        """Return whether it was hidden before a frame for no longer than it had been seen."""
        return turn - self.turn - 1 <= self.rows

    def counts(self, now: float) -> bool:
        """Return whether it is known well enough for its events to count."""
        return self.walked or now - self.since >= LEAST_AGE

    def settle(self, now: float, settled: float) -> None:
        """Make pending events sure that happened `settled` seconds before `now`, or earlier."""
        done = [name for name, event in self.pending.items() if now - event.time >= settled]
        for name in done:
            self.pass_by(name, self.pending[name].direction)
        self.sure += [self.pending.pop(name) for name in done]

    def pass_by(self, name: str, direction: str | None) -> None:
        """Note that it has passed a line or an edge."""
        self.went[name] = direction
        self.near.add(name)

    def direction_at(self, name: str) -> str | None:
        """Return the direction in which it crossed a line last; None if it has not."""
        return self.pending[name].direction if name in self.pending else self.went.get(name)

    def counted(self, now: float) -> list[Event]:
        """Return the sure events, in order of time, if the object counts by now."""
        if not self.counts(now):
            return []
        events, self.sure = sorted(self.sure, key=lambda each: each.time), []
        self.crossed += [event.place or "" for event in events if event.event == "crosses"]
        return events

    def go_on(self, before: Trajectory) -> None:
        """Go on with the path of another object that has ended, or is not seen."""
        self.walked = before.counts(before.feet[-1][0])
        self.clear, self.crossed = dict(before.clear), before.crossed
        self.zones, self.stays = before.zones, before.stays
        self.outside, self.touched = before.outside, before.touched
        self.found = before.found
        self.went, self.near = before.went, before.near
        self.pending, self.sure = before.pending, before.sure
        before.zones, before.stays, before.pending, before.sure = {}, set(), {}, []
        before.outside, before.touched, before.over, before.leaving = set(), set(), {}, []
        before.went, before.near, before.found = {}, set(), set()
        before.continued = True

    def undecided(self) -> list[Event]:
        """Return the events that may be returned later, or not."""
        came = [] if self.came is None else [self.came]
        return [*came, *self.over.values(), *self.pending.values(), *self.sure, *self.leaving]


def _append(places: deque[tuple[float, Point]], time: float, foot: Point) -> None:
    """Add a place, and drop those that are older than a speed needs."""
    places.append((time, foot))
    while len(places) > 2 and places[1][0] <= time - SPEED_OVER:
        places.popleft()
