"""Simulated cameras: people walk from room to room through doors, and reports of them, no pictures.

A room has one camera, or two that see the same ground in its middle. People enter a room on one
side and leave it on the other, and come into the next room after a moment.
"""

import heapq
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from motes import Box, Place, Status
from motes_fleet.cameras.camera_report import CameraReport, ObjectReport
from motes_fleet.cameras.rig_config import Camera, CameraLink, Overlap, Rig

SIZE = 320, 240
WIDTH, HEIGHT = 20.0, 60.0
"""Of a person, in pixels."""
SPEED = 80.0
"""Pixels a second."""
BETWEEN = 0.8, 1.6
"""Least and most seconds from one room to the next."""
SECONDS = 0.5, 2.5
"""As the rig knows it, from the last certain report to the first one."""
AT_DOOR = 0.5
"""Seconds for which a person is at the door."""
LOST_AFTER = 0.3
"""Seconds from the last sight of a person until its camera gives it up."""
SHIFT = 200.0
"""Pixels from the left edge of a room's first camera to that of its second."""
BINS = 512
"""Of a histogram, as those of cameras."""
WEST, EAST = ("w", "n"), ("e", "s")
ONWARD = {"e": (0, 1, "w"), "w": (0, -1, "e"), "s": (1, 0, "n"), "n": (-1, 0, "s")}
"""The next room's row and column from here, and its door, by the door that one leaves by."""

Room = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Visit:
    """A person before a camera: when, from which x on, at which velocity, through which doors."""

    person: int
    own: int
    start: float
    end: float
    x: float
    y: float
    velocity: float
    doors: tuple[str | None, str | None]


@dataclass(frozen=True)
class Building:
    """Rooms in a grid, each with one camera or two."""

    rows: int
    columns: int
    cameras: int = 1

    def camera(self, room: Room, door: str) -> str:
        """Return the name of the camera that sees a door of a room."""
        row, column = room
        return f"{row}.{column}" + ("" if self.cameras == 1 else "ab"[door in EAST])

    def rig(self) -> Rig:
        """Return the cameras and how they are joined."""
        cameras: dict[str, list[Place]] = defaultdict(list)
        passages, overlaps = [], []
        for room in self.rooms():
            for door in (*WEST, *EAST):
                place = Place(name=door, box=(0 if door in WEST else 300, 0, 20, 240))
                cameras[self.camera(room, door)].append(place)
            for door in EAST:
                down, right, other = ONWARD[door]
                after = room[0] + down, room[1] + right
                if after in self.rooms():
                    ends = (
                        f"{self.camera(room, door)}/{door}",
                        f"{self.camera(after, other)}/{other}",
                    )
                    passages.append(CameraLink(ends, SECONDS))
            if self.cameras == 2:
                pair = self.camera(room, "w"), self.camera(room, "e")
                overlaps.append(Overlap(pair, ((1, 0, -SHIFT), (0, 1, 0), (0, 0, 1))))
        named = tuple(Camera(name, "", place=tuple(doors)) for name, doors in cameras.items())
        return Rig(named, tuple(passages), tuple(overlaps))

    def rooms(self) -> list[Room]:
        """Return the rooms."""
        return [(row, column) for row in range(self.rows) for column in range(self.columns)]


class Simulation:
    """People who walk through a building, and the reports of its cameras: `rate` a second.

    `people` are in a room at a time, on average; later, they are those behind each object, by the
    camera's name and the identity there.
    """

    def __init__(
        self, building: Building, seconds: float, people: float = 1.0, rate: float = 10.0,
        seed: int = 0,
    ) -> None:  # fmt: skip
        self._building, self._rate, self._seconds = building, rate, seconds
        self._rng = np.random.default_rng(seed)
        self._visits: dict[str, list[Visit]] = {camera.name: [] for camera in building.rig().camera}
        self._looks: list[bytes] = []
        self.people: dict[tuple[str, int], int] = {}
        for _ in range(round(people * building.rows * building.columns)):
            now = -float(self._rng.uniform(0, 5))
            while now < seconds:
                now = self._walk(now)
        self._starts = {name: float(self._rng.uniform(0, 1 / rate)) for name in self._visits}

    def _walk(self, now: float) -> float:
        """Let a new person walk until outside; return when."""
        rng, building = self._rng, self._building
        rooms = building.rooms()
        room = rooms[rng.integers(len(rooms))]
        door = str(rng.choice([*WEST, *EAST]))
        person = len(self._looks)
        look = rng.dirichlet(np.full(8, 0.5))
        histogram = np.zeros(BINS, np.float32)
        histogram[rng.choice(BINS, 8, replace=False)] = look
        self._looks.append(histogram.tobytes())
        while room in rooms and now < self._seconds:
            out = str(rng.choice(EAST if door in WEST else WEST))
            now = self._cross(person, room, (door, out), now, float(rng.uniform(40, 160)))
            down, right, door = ONWARD[out]
            room = room[0] + down, room[1] + right
            now += float(rng.uniform(*BETWEEN))
        return now

    def _cross(
        self, person: int, room: Room, doors: tuple[str, str], now: float, y: float
    ) -> float:
        """Let a person cross a room; return when."""
        reach = SIZE[0] - WIDTH
        way = (1 if doors[0] in WEST else -1) * SPEED
        if self._building.cameras == 1:
            end = now + reach / SPEED
            self._see(self._building.camera(room, "w"), person, now, end, way, y, doors)
            return end
        first, second = (self._building.camera(room, door) for door in doors)
        self._see(first, person, now, now + reach / SPEED, way, y, (doors[0], None))
        later = now + SHIFT / SPEED
        self._see(second, person, later, later + reach / SPEED, way, y, (None, doors[1]))
        return later + reach / SPEED

    def _see(
        self, camera: str, person: int, start: float, end: float, velocity: float, y: float,
        doors: tuple[str | None, str | None],
    ) -> None:  # fmt: skip
        x = 0.0 if velocity > 0 else SIZE[0] - WIDTH
        visits = self._visits[camera]
        own = len(visits) + 1
        self.people[camera, own] = person
        visits.append(Visit(person, own, start, end, x, y, velocity, doors))

    def reports(self) -> Iterator[CameraReport]:
        """Yield the reports of all cameras in the order of their times."""
        return heapq.merge(*map(self._reports, self._visits), key=lambda report: report.time)

    def _reports(self, camera: str) -> Iterator[CameraReport]:
        coming = sorted(self._visits[camera], key=lambda visit: visit.start)[::-1]
        here: list[Visit] = []
        for frame in range(int(self._seconds * self._rate)):
            now = self._starts[camera] + frame / self._rate
            while coming and coming[-1].start <= now:
                here.append(coming.pop())
            seen = tuple(self._sighting(visit, now) for visit in here)
            yield CameraReport(camera, frame, now, seen, SIZE)
            here = [visit for visit in here if now < visit.end + LOST_AFTER]

    def _sighting(self, visit: Visit, now: float) -> ObjectReport:
        last = min(now, visit.end)
        seen = now < visit.end
        gone = now >= visit.end + LOST_AFTER
        status = Status.TRACKING if seen else Status.LOST if gone else Status.OCCLUDED
        box = Box(visit.x + visit.velocity * (last - visit.start), visit.y, WIDTH, HEIGHT)
        early, late = visit.doors
        places = [early] if last - visit.start < AT_DOOR else []
        places += [late] if visit.end - last < AT_DOOR else []
        named = tuple(place for place in places if place is not None)
        covariance = (4.0, *(0.0,) * 5, 1.0, *(0.0,) * 5, 0.5, *(0.0,) * 5, 0.5, *(0.0,) * 6)
        return ObjectReport(
            visit.own, status, box, 0.9, None, seen, named, self._looks[visit.person],
            (visit.velocity, 0.0), covariance, look=self._looks[visit.person],
        )  # fmt: skip
