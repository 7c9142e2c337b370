"""The objects that a rig knows, found by camera and by identity, in the order of their births."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter

from msgspec.structs import replace

from motes import Status
from motes_fleet.cameras.camera_report import ObjectReport


@dataclass(slots=True, eq=False)
class KnownObject:
    """An object of a camera, and what is known of it."""

    camera: str
    identity: int
    """The camera's name, and the identity in the rig."""
    seen: float
    """Time of its last certain report."""
    histogram: bytes
    look: bytes
    """Its last color histogram and its last look, packed."""
    last: ObjectReport
    tracked: ObjectReport
    """Its last report, and its last certain report."""
    gone: bool = False
    """Whether its camera reports it no more."""
    interrupted: bool = False
    """Whether its camera was interrupted since that certain report."""
    passed: bool = False
    """Whether its identity now belongs to another object."""
    announced: dict[str, float] = field(default_factory=dict)
    """Since when it is expected at other cameras, by their names."""
    birth: int = 0
    """Its number among all objects of the rig, in the order of their births."""

    @classmethod
    def of(cls, camera: str, identity: int, now: float, report: ObjectReport) -> KnownObject:
        """Return a new object from its first report."""
        assert report.histogram is not None
        return cls(camera, identity, now, report.histogram, report.look, report, report)

    def note(self, report: ObjectReport, now: float) -> None:
        """Keep a new report; an object that is there again may be announced again."""
        if report.seen and not self.last.seen:
            self.announced.clear()
        self.last = report
        if report.histogram is not None:
            self.histogram, self.look = report.histogram, report.look
        self.gone = report.gone
        if report.seen:
            self.seen, self.tracked, self.interrupted = now, report, False

    def lose(self) -> None:
        """Note that its camera will report it no more."""
        self.last, self.gone = replace(self.last, status=Status.LOST), True

    def visible(self, now: float, within: float) -> bool:
        """Return whether it was seen in its last report, at most some seconds ago."""
        return self.last.seen and not self.passed and now - self.seen <= within

    def foot(self, now: float) -> tuple[float, float]:
        """Return the middle of its lower edge, where it should be now."""
        (x, y), (dx, dy), dt = self.tracked.box.foot, self.tracked.velocity, now - self.seen
        return x + dx * dt, y + dy * dt


class KnownObjects:
    """The objects of all cameras.

    What one report takes depends on the objects of a few cameras, however many cameras there are.
    """

    def __init__(self) -> None:
        self._by_camera: defaultdict[str, dict[int, KnownObject]] = defaultdict(dict)
        self._by_identity: defaultdict[int, list[KnownObject]] = defaultdict(list)
        self._births = 0

    def add(self, own: int, known: KnownObject) -> None:
        """Add a new object, which has an identity in its camera."""
        self._births += 1
        known.birth = self._births
        self._by_camera[known.camera][own] = known
        self._by_identity[known.identity].append(known)

    def at(self, camera: str) -> Mapping[int, KnownObject]:
        """Return the objects of a camera by their identities there."""
        return self._by_camera[camera]

    def around(self, cameras: tuple[str, ...]) -> list[KnownObject]:
        """Return the objects of some cameras, the oldest first."""
        found = [known for camera in cameras for known in self._by_camera[camera].values()]
        return sorted(found, key=attrgetter("birth"))

    def named(self, *identities: int) -> list[KnownObject]:
        """Return the objects that have one of some identities in the rig, the oldest first."""
        found = [known for each in identities for known in self._by_identity.get(each, ())]
        return sorted(found, key=attrgetter("birth"))

    def rename(self, known: KnownObject, identity: int) -> None:
        """Give an object another identity in the rig."""
        self._unlist(known)
        known.identity = identity
        self._by_identity[identity].append(known)

    def forget(self, camera: str, before: float) -> None:
        """Forget the lost objects of a camera that were last seen before a time."""
        objects = self._by_camera[camera]
        over = [own for own, known in objects.items() if known.gone and known.seen < before]
        for own in over:
            self._unlist(objects.pop(own))

    def _unlist(self, known: KnownObject) -> None:
        same = self._by_identity[known.identity]
        same.remove(known)
        if not same:
            del self._by_identity[known.identity]
