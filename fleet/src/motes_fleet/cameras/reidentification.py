"""Identities across several cameras: objects that leave one camera are expected at another.

Nummiaro et al., section VII: when a person leaves a room, its camera gives what it knows of the
person to the camera of the other room: an `Arrival`, made of `ObjectReport`s, and no frames.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from motes.cues import bhattacharyya
from motes.mot import assign
from motes_fleet.cameras.arrivals import at_place, in_overlap
from motes_fleet.cameras.camera_report import Arrival, CameraReport, ObjectReport, unpacked
from motes_fleet.cameras.common_ground import CommonGround
from motes_fleet.cameras.known_objects import KnownObject, KnownObjects
from motes_fleet.cameras.passage_times import PassageTimes
from motes_fleet.cameras.rig_config import DISTANCE, CameraLink, Rig, neighbors_of, ways_of

CAMERA_TIMEOUT = 1.0
"""Seconds without a report after which a camera counts as interrupted."""
REIDENTIFICATION_WINDOW = 30.0
"""Seconds for which objects that were visible before an interruption are expected after it."""
FRESH = 0.2
"""Reports of two cameras count as simultaneous up to this many seconds apart."""
SIZES = 2.0
"""Largest ratio of an object's height to the expected height, or of that to it."""
ANNOUNCED = 1.0
"""Seconds for which an overlapping camera is asked for an object that it should see."""
MERGED_AFTER = 1.0
"""Seconds in which two objects of overlapping cameras coincide, after which they are one."""
ALIKE = 0.5
"""Within this share of the largest distance a part of an object is recognized, and a whole one for
sure."""
DEVIATIONS = 3.0
"""Standard deviations of color and time, together, up to which a pair may be the same object."""
SAME = 0.6
"""Largest distance between the histograms of two objects that look the same."""
CLEAR = 1.5
"""Two objects look the same if all others are this many times farther from either of them."""


class CrossCameraAssociation:
    """Gives the objects of several cameras identities that they keep from one to the next.

    With `known_target`, all cameras look for the same one, whose identity is 1.

    Attributes
    ----------
    handed
        How many new objects got the identity of another one.
    newest
        The identity that was given last.
    merged
        Identities that turned out to belong to an object with another one, which it has since then.
    """

    def __init__(self, rig: Rig, *, known_target: bool = False) -> None:
        self._known_target = known_target
        self._ways, self._neighbors = ways_of(rig), neighbors_of(rig)
        self._known = KnownObjects()
        self._times: dict[str, float] = {}
        self._sizes: dict[str, tuple[int, int]] = {}
        self._memory = max(
            [REIDENTIFICATION_WINDOW, *(passage.seconds[1] for passage in rig.passage)]
        )
        self._passing_times: defaultdict[CameraLink, PassageTimes] = defaultdict(PassageTimes)
        self._grounds: defaultdict[str, list[CommonGround]] = defaultdict(list)
        for overlap in rig.overlap:
            ground = CommonGround(overlap)
            for name in overlap.cameras:
                self._grounds[name].append(ground)
        self._together: dict[frozenset[str], dict[tuple[KnownObject, KnownObject], float]] = {}
        self.handed = self.newest = 0
        self.merged: dict[int, int] = {}

    def update(self, report: CameraReport) -> dict[int, int]:
        """Return the identities in the rig of a camera's objects, by those in the camera.

        An object whose identity now belongs to another one has none. Reports of all cameras come in
        the order of their times.
        """
        camera, now = report.camera, report.time
        if now - self._times.get(camera, now) > CAMERA_TIMEOUT:
            reported = {sighting.identity for sighting in report.sightings}
            for own, each in self._known.at(camera).items():
                each.interrupted |= not each.gone
                if own not in reported:  # its process died, and another one has objects of its own
                    each.lose()
        self._times[camera], self._sizes[camera] = now, report.size
        born = []
        for sighting in report.sightings:
            known = self._known.at(camera).get(sighting.identity)
            if known is None:
                born.append(sighting)
            else:
                known.note(sighting, now)
                if known.passed and sighting.seen:
                    # It never left: another object came through the other door.
                    self._known.rename(known, self._new())
                    known.passed = False
        identities = self._inherited(camera, now, born)
        for sighting in born:
            if sighting.partial and sighting.identity not in identities:
                continue  # it is recognized later, or as a new object when it is whole
            identity = identities.get(sighting.identity) or self._new()
            new = KnownObject.of(camera, identity, now, sighting)
            self._known.add(sighting.identity, new)
        for ground in self._grounds[camera]:
            self._compare(ground, now)
        found = {}
        for sighting in report.sightings:
            known = self._known.at(camera).get(sighting.identity)
            if known is not None and not known.passed:
                found[sighting.identity] = known.identity
        self._known.forget(camera, now - self._memory)
        return found

    def arrivals(self, camera: str, now: float) -> tuple[Arrival, ...]:
        """Return the objects that are expected at a camera in its frame at a time.

        - An object that an overlapping camera sees now, where it should be seen here too, is
          announced for each frame until it is, for `ANNOUNCED` seconds at most.
        - An object that has left by a passage is announced once, when its time comes.
        """
        if camera not in self._sizes:
            return ()
        here, found = self._here(camera), dict[int, Arrival]()
        for known in self._known.around(self._neighbors[camera]):
            if known.identity in here or known.passed:
                continue
            arrival = self._overlapping(known, camera, now) or self._passing(known, camera, now)
            if arrival is not None:
                found[known.identity] = arrival
        return tuple(found.values())

    def _new(self) -> int:
        if self._known_target:
            return 1
        self.newest += 1
        return self.newest

    def _here(self, camera: str) -> set[int]:
        """Return the identities of the objects that a camera has."""
        return {
            known.identity
            for known in self._known.at(camera).values()
            if not (known.gone or known.interrupted)
        }

    def _overlapping(self, known: KnownObject, camera: str, now: float) -> Arrival | None:
        """Return where an overlapping camera, which sees an object now, expects it at another."""
        if not known.visible(now, FRESH):
            return None
        for ground in self._grounds[camera]:
            if known.camera in ground.overlap.cameras:
                arrival = in_overlap(ground, known, self._sizes[camera], now, now + FRESH)
                if arrival is None:
                    known.announced.pop(camera, None)
                elif now - known.announced.setdefault(camera, now) <= ANNOUNCED:
                    return arrival
        return None

    def _passing(self, known: KnownObject, camera: str, now: float) -> Arrival | None:
        """Return at which place a camera expects an object that has left another camera."""
        if known.last.seen or camera in known.announced:
            return None
        for passage, first, second in self._ways.get((known.camera, camera), ()):
            opens, closes = (known.seen + seconds for seconds in passage.seconds)
            if first in known.tracked.places and opens <= now <= closes:
                known.announced[camera] = now
                return at_place(known, second, passage.scale_to(camera) or 1.0, now, closes)
        return None

    def _inherited(self, camera: str, now: float, born: Sequence[ObjectReport]) -> dict[int, int]:
        """Return the identities in the rig of the new objects that were expected."""
        here = self._here(camera)
        found: dict[int, int] = {}
        for sighting in born:
            expected = self.merged.get(sighting.expected or 0, sighting.expected)
            if expected is not None and expected not in here:
                found[sighting.identity] = expected
                here.add(expected)
        costs: dict[int, list[float]] = {}
        others = [sighting for sighting in born if sighting.identity not in found]
        for known in self._known.around((camera, *self._neighbors[camera])):
            if known.identity not in here:
                row = costs.setdefault(known.identity, [math.inf] * len(others))
                row[:] = [
                    min(cost, self._cost(known, camera, now, sighting))
                    for cost, sighting in zip(row, others, strict=True)
                ]
        identities = list(costs)
        if others and costs:
            matrix = np.array(list(costs.values()))
            pairs, possible = assign(matrix), np.isfinite(matrix)
            for i, j in pairs:
                if possible[i].sum() == possible[:, j].sum() == 1:
                    self._learn_time(identities[i], camera, now, others[j])
                found[others[j].identity] = identities[i]
        for identity in found.values():
            self.handed += 1
            for known in self._known.named(identity):  # those that are not seen have lost it
                known.passed |= not known.last.seen
        return found

    def _cost(self, known: KnownObject, camera: str, now: float, born: ObjectReport) -> float:
        """Return the cost of giving a new object a known one's identity; infinite if ruled out.

        It is from 0 to 1 if an overlapping camera sees the known one in the same place. If the
        known one is expected here, it is 1 and more: a negative log-likelihood of color and time.
        """
        off = math.inf
        if now - known.seen <= FRESH:
            one = KnownObject.of(camera, 0, now, born)
            grounds = self._grounds[camera]
            off = min((_apart(ground, known, one, now) for ground in grounds), default=off)
        if off <= 1 or known.last.seen or known.passed:
            return off if off <= 1 else math.inf
        since, most = now - known.seen, DEVIATIONS**2 / 2
        passages = self._passages(known, camera, now, born)
        ways = [(each.distance, self._passing_times[each].cost(since)) for each in passages]
        if known.interrupted and known.camera == camera and since <= REIDENTIFICATION_WINDOW:
            ways.append((DISTANCE, 0.0))
        unlike = _unlike(known, born) / (ALIKE if born.partial else 1)
        costs = (most * (unlike / limit) ** 2 + late for limit, late in ways if limit)
        cost = min(costs, default=math.inf)
        return 1 + cost if cost <= most else math.inf

    def _passages(
        self, known: KnownObject, camera: str, now: float, born: ObjectReport
    ) -> list[CameraLink]:
        """Return the passages through which a known object may have come to a camera."""
        return [
            passage
            for passage, first, second in self._ways.get((known.camera, camera), ())
            if first in known.tracked.places
            and second in born.places
            and passage.seconds[0] <= now - known.seen <= passage.seconds[1]
            and _fits(passage, known, camera, born)
        ]

    def _learn_time(self, identity: int, camera: str, now: float, born: ObjectReport) -> None:
        """Learn how long an object took that has no rival, if it looks like itself."""
        ways = [
            (self._passing_times[passage], now - known.seen)
            for known in self._known.named(identity)
            if not (known.last.seen or known.passed)
            for passage in self._passages(known, camera, now, born)
            if _unlike(known, born) <= ALIKE * passage.distance
        ]
        for times, seconds in ways if len(ways) == 1 else ():
            times.learn(seconds)

    def _compare(self, ground: CommonGround, now: float) -> None:
        """Learn from what two overlapping cameras see now, and merge objects that coincide.

        Two objects coincide if the least-cost assignment of the one camera's objects to the
        other's has them as a pair. So people side by side are not merged.
        """
        cameras = ground.overlap.cameras
        ones, others = (
            [each for each in self._known.at(name).values() if each.visible(now, FRESH)]
            for name in cameras
        )
        apart = [[_apart(ground, one, other, now) for other in others] for one in ones]
        off = np.array(apart, float).reshape(len(ones), len(others))
        pairs = [(ones[i], others[j]) for i, j in assign(np.where(off <= 1, off, np.inf))]
        same = [(one, other) for one, other in pairs if one.identity == other.identity]
        learned = ground.overlap.homography is None
        certain = (*same, *(unmistakable(ones, others) if learned else ()))
        for one, other in dict.fromkeys(certain):  # in the same order in each process
            feet = one.foot(now), other.foot(now)
            ground.add(feet, one.last.box, other.last.box)
        seen = {*ones, *others}
        together = self._together[frozenset(cameras)] = {
            pair: since
            for pair, since in self._together.get(frozenset(cameras), {}).items()
            if pair in pairs or not (seen.issuperset(pair) or any(each.gone for each in pair))
        }
        for pair in pairs:
            since = together.setdefault(pair, now)
            if now - since >= MERGED_AFTER and pair[0].identity != pair[1].identity:
                self._merge(pair)

    def _merge(self, pair: tuple[KnownObject, KnownObject]) -> None:
        """Give two objects the older one of their identities, which a camera's others may lose."""
        keep, gone = sorted(each.identity for each in pair)
        named, taken = self._known.named(keep, gone), set[str]()
        named.sort(key=lambda one: (one not in pair, not one.last.seen, one.gone, one.identity))
        for each in named:  # in each camera the first one has it
            rival, present = each.camera in taken, not (each.gone or each.passed)
            self._known.rename(each, self._new() if rival and present else keep)
            each.passed |= rival and each.gone
            if present:
                taken.add(each.camera)
        self.merged = {old: keep if new == gone else new for old, new in self.merged.items()}
        self.merged[gone] = keep


def unmistakable(
    ones: Sequence[KnownObject], others: Sequence[KnownObject]
) -> list[tuple[KnownObject, KnownObject]]:
    """Return the pairs of objects of two cameras that cannot be mistaken for others by their looks.

    In both cameras, everybody else is more than `CLEAR` times as far from it as its partner.
    """
    if not ones or not others:
        return []
    looks = np.array([unpacked(each.histogram) for each in others])
    distances = np.array([bhattacharyya(looks, unpacked(each.histogram)) for each in ones])
    pairs = []
    for i, j in zip(*np.nonzero(distances <= SAME), strict=True):
        rivals = np.concatenate([np.delete(distances[i], j), np.delete(distances[:, j], i)])
        if (rivals > CLEAR * distances[i, j]).all():
            pairs.append((ones[i], others[j]))
    return pairs


def _apart(ground: CommonGround, one: KnownObject, other: KnownObject, now: float) -> float:
    """Return how far apart two objects are on common ground, in `reach`; infinite if elsewhere."""
    overlap = ground.overlap
    if overlap.cameras == (other.camera, one.camera):
        one, other = other, one
    elif overlap.cameras != (one.camera, other.camera):
        return math.inf
    there = ground.there(one.foot(now), one.tracked.box.width, one.camera)
    if there is None:
        return math.inf
    return math.dist(there, other.foot(now)) / (overlap.reach * other.tracked.box.width)


def _unlike(known: KnownObject, born: ObjectReport) -> float:
    """Return the distance between the looks of a known object and a new one."""
    return float(bhattacharyya(unpacked(born.look)[None], unpacked(known.look))[0])


def _fits(passage: CameraLink, known: KnownObject, camera: str, born: ObjectReport) -> bool:
    """Return whether a new object has the height that is expected of a known one."""
    scale = passage.scale_to(camera)
    if scale is None:
        return True
    ratio = born.box.height / (scale * known.tracked.box.height)
    return 1 / SIZES <= ratio <= SIZES
