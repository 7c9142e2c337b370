"""What objects do at lines and in zones: events, and counts of them."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Sequence

from msgspec.structs import replace

from motes.core.errors import ConfigError
from motes.core.frame import NUMBER
from motes.core.geometry import Box
from motes.core.track import Status, Track, check_listed
from motes.mot.analytics.event import Event, Kind
from motes.mot.analytics.ground_plane import Point
from motes.mot.analytics.parts import KEPT, usual_of, whole_of
from motes.mot.analytics.regions import (
    SETTLED,
    Line,
    Regions,
    Zone,
    crossing,
    distance,
    meeting_point,
)
from motes.mot.analytics.trajectory import Trajectory

EDGE = "visits to its edge alone"
BRIEF = "objects that were seen for less than half a second and had hardly moved"
PART = "crossings of other parts of what has crossed it"
JUMPED = "boxes that jumped over it"
"""Reasons for which an event does not count."""
UNSURE = 0.25
"""A line's count is unsure if this share of what passed it jumped, or was found or lost upon it."""
MINUTE = 60.0
CLEAR = 0.1
"""A foot is clearly on one side of a line, or of a zone's edge, from this share of its object's
height on."""
AWAY = 0.5
"""An object that has passed a line or an edge may tremble there until it is away, by this share of
its longer side after half a second on one side. Before, it does not pass back."""
LINGERS = 5.0
"""Seconds for which an object may stand on a line or an edge until it is clearly beyond: one that
stands there for longer passes it when it goes on."""
JUMP = 0.5
"""A foot that is farther from its path than this share of its object's mean side has not walked."""
JOINED = 1.0
"""Longest gap in seconds between two parts of one path."""
FOUND = 0.5
"""Seconds after which an object that was found at the inner edge of a zone is in it."""


class EventCounter:
    """Turns the tracks of a scene into events, and counts them.

    The place of an object is that of its foot. An object that is not seen has no events; what it
    did meanwhile becomes events when it is seen again. If it was hidden in more frames than it had
    been seen in, nothing is known of its way, and it counts as another object.

    A crossing, an entry or an exit has the frame in which it happens, and a crossing its place on
    the line. It is returned when the foot is clearly beyond the line or the zone's edge, by a share
    of the object's height, `CLEAR`; crossings and exits also not before `SETTLED` seconds, if the
    object has not come back. It passes back once it is away on the other side (`AWAY`), unless it
    was away before: so one that trembles passes once. The object must be known for `LEAST_AGE`
    seconds, or have walked. It has crossed a line if it was seen on both sides; if it was found on
    the line, its path, continued backwards, must begin clearly on the other side. Where one object
    goes on with the path of another, both are one at lines and in zones; and so are the parts of a
    vehicle at a line (`parts.whole_of`).

    Parameters
    ----------
    places
        Lines and zones.
    size
        Width and height of the picture, in pixels. Objects that its edge cuts keep the speed that
        they had before; sides of zones that lie on it are no edges. By default it has no edge.

    Attributes
    ----------
    left_out
        Number of events that do not count, for each (place, reason), but of objects for `BRIEF`;
        one that does not appear has the place "".
    abrupt
        Number of objects that were found or lost upon each line, which they may have passed or not,
        or inside each zone, where that counts as an entry or an exit.
    turns
        Number of objects for each (first, last) line that they have crossed, of those that have
        ended; the last one is empty for who has crossed one alone.
    """

    counts: Counter[tuple[int, str, str, str, str]]
    """Number of events for each (minute, event, place, direction, class)."""
    totals: Counter[str]
    """Number of events for each `Event.total`, such as `line 1 left`."""

    def __init__(self, places: Regions | None = None, size: tuple[int, int] | None = None) -> None:
        if places is not None and not isinstance(places, Regions):
            raise ConfigError(
                f"An EventCounter takes Regions, such as motes.Regions(line=(line,)); got {places}."
            )
        if size is not None and (not hasattr(size, "__len__") or len(size) != 2):
            raise ConfigError(f"The size of a picture is its width and height; got {size!r}.")
        places = places or Regions()
        self._lines, self._zones, self._ground = places.lines, places.zones, places.ground
        self._size = size
        self._reach = {name: zone.reach for name, zone in self._zones.items()}
        if size is not None:
            places.check(*size)
            self._lines = {name: line.beyond(size) for name, line in self._lines.items()}
            self._zones = {name: zone.beyond(size) for name, zone in self._zones.items()}
        self._shapes = {name: deque[float](maxlen=KEPT) for name in self._lines}
        self._seen: dict[int, Track] = {}
        self._paths: dict[int, Trajectory] = {}
        self._present = set[int]()
        self._brief = set[tuple[str, int]]()  # places and identities that `left_out` counts so
        self._ended: list[Trajectory] = []
        self._turn = 0
        self.counts, self.totals = Counter(), Counter()
        self.left_out = Counter[tuple[str, str]]()
        self.abrupt = Counter[str]()
        self.turns = Counter[tuple[str, str]]()

    def update(self, tracks: Sequence[Track], time: float | None = None) -> list[Event]:
        """Return the events of a frame.

        Parameters
        ----------
        tracks
            The scene's tracks in it. One of a file that is lost in it is gone, unless you set
            `Track.sought`, which rows do not hold.
        time
            The time of the frame, in seconds; by default that of the tracks. With it, also a frame
            without tracks can settle events.

        Raises
        ------
        ConfigError
            If these are no tracks and no time.
        """
        check_listed(tracks)
        if time is not None and not (isinstance(time, NUMBER) and math.isfinite(time)):
            raise ConfigError(f"The time of a frame is in seconds; got {time!r}.")
        self._turn += 1
        events: list[Event] = []
        self._seen = {each.identity: each for each in tracks if each.status is Status.TRACKING}
        for each in tracks:
            if each.identity in self._seen:
                events += self._visible(each)
            elif each.gone and each.identity in self._paths:
                events += self._end(each)
        time = tracks[0].time if tracks and time is None else time
        return self._counted(events + ([] if time is None else self._closed(time - JOINED)))

    def finish(self) -> list[Event]:
        """Return the events of the last frames that no later frame can undo, at a film's end."""
        paths, self._paths = self._paths, {}
        events = [event for path in paths.values() for event in self._last(path)]
        self._ended += paths.values()
        return self._counted(events + self._closed(math.inf))

    @property
    def undecided(self) -> int | None:
        """The first frame that may still get an event; None if no frame so far may."""
        paths = [*self._paths.values(), *self._ended]
        frames = [event.frame for path in paths for event in path.undecided()]
        hidden = [path for path in self._paths.values() if path.turn < self._turn]
        return min([*frames, *(path.frame for path in hidden if path.zones)], default=None)

    def _last(self, path: Trajectory) -> list[Event]:
        """Return the last events of an object; those that do not count are noted."""
        now = path.feet[-1][0]
        path.settle(now, 0)
        events = path.counted(now)
        brief = path.sure if path.came is None else [path.came, *path.sure]
        new = {(event.place or "", event.identity) for event in brief} - self._brief
        self.left_out.update((place, BRIEF) for place, _ in new)
        self._brief |= new
        path.sure, path.came = [], None
        path.touched |= {
            event.place or "" for event in path.over.values() if event.event == "enters"
        }
        path.over = {}
        return events

    def _closed(self, before: float) -> list[Event]:
        """Return the events of leaving zones of the objects that had ended before a time.

        No other object has gone on with their paths.
        """
        done = [path for path in self._ended if path.feet[-1][0] <= before]
        self._ended = [path for path in self._ended if path.feet[-1][0] > before]
        for path in done:
            self.left_out.update((name, EDGE) for name in path.touched)
            if path.counts(path.feet[-1][0]) and not path.continued:
                self.abrupt.update(path.found | path.lost)
            if path.crossed and not path.continued:
                self.turns[path.crossed[0], path.crossed[-1] if len(path.crossed) > 1 else ""] += 1
        return [event for path in done for event in path.leaving]

    def remarks(self) -> list[str]:
        """Return a line for each place at which nothing counted, or something was left out.

        Before them is one on who was left out altogether.
        """
        seen, brief = Counter[str](), self.left_out["", BRIEF]
        lines = [f"left out {BRIEF}: {brief}"] if brief else []
        for (_, _, place, _, _), n in self.counts.items():
            seen[place] += n
        for name in (*self._lines, *self._zones):
            verb = "crossed" if name in self._lines else "entered"
            said = [] if name in seen else [f"nothing {verb} it"]
            said += [
                f"left out {why}: {n}"
                for (place, why), n in self.left_out.items()
                if place == name and n
            ]
            abrupt = self.abrupt[name]
            if abrupt:
                where = "upon" if name in self._lines else "inside"
                said.append(f"objects found or lost {where} it: {abrupt}")
            unsure = self.left_out[name, JUMPED] + abrupt * (name in self._lines)
            if unsure > UNSURE * (unsure + seen[name]):
                said.append("so its count is unsure")
            lines += [f"{name}: {', '.join(said)}"] if said else []
        return lines

    def _counted(self, events: list[Event]) -> list[Event]:
        """Count events, and return them."""
        for event in events:
            key = event.event, event.place or "", event.direction or "", event.label or ""
            self.counts[(int(event.time // MINUTE), *key)] += 1
            self.totals[event.total] += 1
            found = event.place or "", event.identity
            if found in self._brief:  # it flickered before, and is there now
                self._brief.remove(found)
                self.left_out[found[0], BRIEF] -= 1
        return events

    def _begin(self, foot: Point, time: float, limit: float, upon: set[str]) -> Trajectory:
        """Return a new path, or one that goes on with that of an object that is not seen."""
        path = Trajectory(time, foot, deque(), found=upon)
        unseen = [old for identity, old in self._paths.items() if identity not in self._seen]
        before = [
            old
            for old in (*self._ended, *unseen)
            if not old.continued and old.known(self._turn) and old.off(foot, time, JOINED) <= limit
        ]
        if len(before) == 1:  # of two it could be either
            path.go_on(before[0])
        return path

    def _visible(self, each: Track) -> list[Event]:
        box, time = each.box, each.time
        foot, limit = box.foot, JUMP * math.sqrt(box.width * box.height)
        events, jumped, upon = list[Event](), False, self._upon(box)
        path = self._paths.get(each.identity)
        if path is not None and not path.known(self._turn):
            events += self._stop(each, self._paths.pop(each.identity))
            path = None
        if path is None:
            path = self._paths[each.identity] = self._begin(foot, time, limit, upon)
            if each.identity not in self._present:
                path.came = self._event(each, path, foot, "appears")
        else:
            # It then holds something else than before, such as two objects that touch. What was
            # hidden for more than half a second may be anywhere.
            lately = 1.1 * (path.feet[-1][0] - path.feet[0][0])  # times may be in milliseconds
            if path.rows == 2:  # the frame between may have missed it
                lately *= 2
            jumped = path.continued or path.off(foot, time, lately) > limit
            if jumped and path.rows == 2:  # or its second box did, before it had a path
                for name in self._lines.keys() & path.pending.keys():
                    if path.pending[name].frame == path.frame:  # no part of its path before
                        self.left_out[name, JUMPED] += 1
                        del path.pending[name]
        if path.continued:
            path.continued, path.crossed = False, []
        path.step(time, foot, cut=box.is_cut(self._size), ground=self._ground)
        path.frame, path.turn, path.upon = each.frame, self._turn, upon
        path.jumped = path.jumped or jumped
        path.walked = not path.jumped and (path.walked or math.dist(path.first, foot) >= box.height)
        path.settle(time, SETTLED)
        if path.came is not None and path.counts(time):
            events.append(path.came)
            path.came = None
            self._present.add(each.identity)
        events += path.counted(time)
        for name, line in self._lines.items():
            if jumped:
                if crossing(line.points, path.clear.get(name, foot), foot):
                    self.left_out[name, JUMPED] += 1
                path.clear[name] = foot
                path.over.pop(name, None)
            else:
                self._cross(each, path, foot, name, line)
        for name, zone in self._zones.items():
            self._visit(each, path, foot, name, zone)
        return events + path.counted(time)

    def _upon(self, box: Box) -> set[str]:
        """Return the names of the lines upon which an object stands, and of the zones it is in.

        One at the edge of the picture comes or goes there, also where a zone ends.
        """
        foot, margin = box.foot, CLEAR * box.height
        lines = {name for name, line in self._lines.items() if line.gap(foot) < margin}
        if box.is_cut(self._size):
            return lines
        return lines | {name for name, zone in self._zones.items() if zone.holds(foot)}

    def _cross(self, each: Track, path: Trajectory, foot: Point, name: str, line: Line) -> None:
        """Note where an object is beside a line, and whether it has crossed it."""
        height, before = each.box.height, path.clear.get(name)
        off, last = distance(line.points, foot), None
        clear = off >= CLEAR * height
        if name in path.near:
            last = path.went[name]
            if off >= AWAY * max(height, each.box.width) and not any(
                crossing(line.points, at, foot) for _, at in path.feet
            ):
                path.near.remove(name)
        if before is None and clear:
            past = path.past(foot, each.time)
            came = crossing(line.points, path.first, foot) is not None
            before = past if came and distance(line.points, past) >= CLEAR * height else foot
            if before is past:
                path.found = path.found - {name}
        side = None if before is None else crossing(line.points, before, foot)
        if before is None or side is None:
            path.over.pop(name, None)
        else:
            place = meeting_point(line.points, before, foot)
            event = self._event(each, path, place, "crosses", name, line.label[side == "right"])
            _note(path, name, event)
            clear = clear and name not in path.near
        if clear:
            path.clear[name] = foot
            crossed = path.over.pop(name, None)
            if crossed is None or crossed.direction == last:  # it has jumped back meanwhile
                return
            if path.pending.pop(name, None) is None:  # else it is back
                self._begin_crossing(each, path, name, crossed)

    def _begin_crossing(self, each: Track, path: Trajectory, name: str, crossed: Event) -> None:
        """Note a crossing, unless another part of the same vehicle has crossed the line before."""
        known = [other for other in self._seen.values() if other.identity in self._paths]
        parts, shape = whole_of(each, known, self._paths, usual_of(self._shapes[name]))
        others = (self._paths[part] for part in parts if part != each.identity)
        if any(other.direction_at(name) == crossed.direction for other in others):
            self.left_out[name, PART] += 1
            path.pass_by(name, crossed.direction)
        else:
            path.pending[name] = crossed
            self._shapes[name].append(shape)

    def _visit(self, each: Track, path: Trajectory, foot: Point, name: str, zone: Zone) -> None:
        """Note where an object is beside the edge of a zone, and what it does there."""
        time, holds, inside = each.time, zone.holds(foot), name in path.zones
        if name in path.near:
            longer = max(each.box.height, each.box.width)
            off = zone.depth(foot) / min(longer, self._reach[name])
            beside = off >= AWAY and all(zone.holds(at) == holds for _, at in path.feet)
            if beside or off >= 1:  # some pass a zone within half a second
                path.near.remove(name)
        if not holds:
            path.outside.add(name)
        if holds == inside:
            touched = path.over.pop(name, None) is not None
            path.touched |= {name} if touched and not inside else set()
        else:
            _note(path, name, self._event(each, path, foot, "enters" if holds else "leaves", name))
            event = path.over[name]
            margin = min(CLEAR * each.box.height, self._reach[name])
            found = name not in path.outside and time - event.time >= FOUND
            if (zone.depth(foot) < margin or name in path.near) and not found:
                return
            del path.over[name]
            left = path.pending.pop(name, None)
            if not holds:
                seconds = event.time - path.zones.pop(name)
                path.pending[name] = replace(event, seconds=seconds)
                return
            path.touched.discard(name)
            if left is None:
                path.sure.append(event)
                path.pass_by(name, None)
                path.stays.discard(name)
            since = event if left is None else left  # and is back
            path.zones[name] = since.time - (since.seconds or 0)
        if name in path.zones and zone.dwell is not None and name not in path.stays:
            seconds = time - path.zones[name]
            if seconds >= zone.dwell:
                path.stays.add(name)
                path.sure.append(self._event(each, path, foot, "stays", name, seconds=seconds))

    def _stop(self, each: Track, path: Trajectory) -> list[Event]:
        """Return the last events of a path.

        It left its zones when it was seen last, unless another object goes on with it.
        """
        last, foot = path.feet[-1]
        path.lost = path.upon
        events = self._last(path)
        if path.counts(last):
            left = [
                self._event(each, path, foot, "leaves", name, seconds=last - since)
                for name, since in path.zones.items()
            ]
            path.leaving = [replace(event, frame=path.frame, time=last) for event in left]
        self._ended.append(path)
        return events + self._closed(each.time - JOINED)

    def _end(self, each: Track) -> list[Event]:
        """Return the events of an object that is gone. It disappears now."""
        path = self._paths.pop(each.identity)
        last, foot = path.feet[-1]
        events = self._stop(each, path)
        self._brief = {found for found in self._brief if found[1] != each.identity}
        if each.identity in self._present:
            self._present.remove(each.identity)
            events.append(self._event(each, path, foot, "disappears", seconds=last - path.since))
        return events

    def _event(
        self,
        each: Track,
        path: Trajectory,
        place: Point,
        kind: Kind,
        name: str | None = None,
        direction: str | None = None,
        seconds: float | None = None,
    ) -> Event:
        return Event(
            each.frame, each.time, kind, each.identity, *place, path.speed, name, direction,
            seconds, path.metres_per_second, each.label,
        )  # fmt: skip


def _note(path: Trajectory, name: str, event: Event) -> None:
    """Note that an object passes a line or an edge, if that is not noted or was long ago."""
    noted = path.over.get(name)
    if noted is None or event.time - noted.time > LINGERS:
        path.over[name] = event
