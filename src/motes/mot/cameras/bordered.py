"""A part of a large rig: its cameras' objects, and what neighboring parts report about theirs.

Each part associates the objects of its own cameras. Of the cameras on the other side of a border
it knows the objects by `Seen`. Parts are cut at passages alone (`neighborhoods.parts_of`).

Where all news arrive before the next report, parts give the same identities as the whole rig, up to
their numbers. Where they are late, this still holds as long as

- they are less late than the shortest passage across a border takes, and
- no object is recognized behind two borders within that time. Then the earlier claim holds, and the
  later camera's object gets a new identity as soon as it hears of it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import msgspec
from msgspec.structs import replace

from motes.mot.cameras.camera_report import CameraReport, ObjectReport
from motes.mot.cameras.known_object import KnownObject
from motes.mot.cameras.neighborhoods import neighbors_of
from motes.mot.cameras.reidentification import CrossCameraAssociation
from motes.mot.cameras.rig_config import Rig


class Seen(msgspec.Struct, frozen=True, tag=True):
    """A report of a camera at a border, and the identities of its objects in the rig."""

    report: CameraReport
    identities: dict[int, int]


class Claimed(msgspec.Struct, frozen=True, tag=True):
    """A camera has recognized an identity; objects that are not seen any more have lost it."""

    identity: int
    time: float
    camera: str


class Merged(msgspec.Struct, frozen=True, tag=True):
    """An identity turned out to be another one."""

    gone: int
    kept: int


News = Seen | Claimed | Merged


class BorderedAssociation(CrossCameraAssociation):
    """Gives the objects of one part of a rig identities; other parts give it and get news.

    Identities are unique in the rig without a common counter: part k of n counts k + 1, k + 1 + n
    and so on.

    Parameters
    ----------
    rig
        The whole rig.
    parts
        The names of the cameras of all parts.
    index
        The part.
    known_target
        As for `CrossCameraAssociation`; only for parts without borders.
    """

    def __init__(
        self, rig: Rig, parts: Sequence[tuple[str, ...]], index: int, *, known_target: bool = False
    ) -> None:
        part_of = {name: n for n, part in enumerate(parts) for name in part}
        near = neighbors_of(rig)
        self._audience = {
            name: tuple(sorted({part_of[each] for each in near[name]} - {index}))
            for name in parts[index]
        }
        self._around = tuple(sorted({n for parts in self._audience.values() for n in parts}))
        own = part_rig(rig, parts[index])
        super().__init__(own, known_target=known_target, first=index + 1, step=len(parts))
        self._outbox: defaultdict[int, list[News]] = defaultdict(list)
        self._claims: dict[Claimed, None] = {}
        """The claims of all parts that are known here, the oldest first."""
        self._own_claims: dict[int, Claimed] = {}
        """The latest claim of an identity by a camera of this part."""

    def update(self, report: CameraReport) -> dict[int, int]:
        """Return the identities in the rig of a camera's objects, by those in the camera."""
        identities = super().update(report)
        for part in self._audience[report.camera]:
            self._outbox[part].append(Seen(_without_borders(report), identities))
        self._forget_claims(report.time)
        return identities

    def news(self) -> dict[int, list[News]]:
        """Return what happened since the last call that other parts must know, by their indices."""
        news, self._outbox = dict(self._outbox), defaultdict(list)
        return news

    def hear(self, news: Sequence[News]) -> None:
        """Take the news of another part, in its order."""
        for each in news:
            if isinstance(each, Seen):
                self._see(each)
            elif isinstance(each, Claimed):
                self._concede(each)
            elif self._known.named(each.gone):
                self._rename_all(each)

    def _see(self, seen: Seen) -> None:
        camera, now = seen.report.camera, seen.report.time
        for sighting in seen.report.sightings:
            own, identity = sighting.identity, seen.identities.get(sighting.identity)
            known = self._known.get(camera, own)
            if known is None:
                if identity is not None and sighting.histogram is not None:
                    self._known.add(own, KnownObject.of(camera, identity, now, sighting))
                continue
            known.note(sighting, now)
            if identity is None:
                known.passed = True
            elif identity != known.identity:
                self._known.rename(known, identity)
                known.passed = False
        self._known.forget(camera, now - self._memory)

    def _concede(self, claim: Claimed) -> None:
        """Note a claim; give the identity up if this part has claimed it later, unaware of it."""
        if claim in self._claims:
            return
        self._claims[claim] = None
        ours = self._own_claims.get(claim.identity)
        if ours is not None and (claim.time, claim.camera) < (ours.time, ours.camera):
            for known in self._known.named(claim.identity):
                if known.camera == ours.camera and not known.passed:
                    self._known.rename(known, self._new())
                    self.handed -= 1
            del self._own_claims[claim.identity]
        if self._known.named(claim.identity):
            self._pass_on(claim.identity)
            self._tell(claim)

    def _rename_all(self, merged: Merged) -> None:
        for known in self._known.named(merged.gone):
            self._known.rename(known, merged.kept)
        self._note_merged(merged.gone, merged.kept)
        self._tell(merged)

    def _inherited(self, camera: str, now: float, born: Sequence[ObjectReport]) -> dict[int, int]:
        found = super()._inherited(camera, now, born)
        for identity in found.values():
            claim = Claimed(identity, now, camera)
            self._claims[claim] = None
            self._own_claims[identity] = claim
            self._tell(claim)
        return found

    def _merge(self, one: KnownObject, other: KnownObject) -> None:
        kept, gone = sorted((one.identity, other.identity))
        super()._merge(one, other)
        self._tell(Merged(gone, kept))

    def _tell(self, news: Claimed | Merged) -> None:
        for part in self._around:
            self._outbox[part].append(news)

    def _forget_claims(self, now: float) -> None:
        """Forget claims of objects that no camera expects any more."""
        while self._claims and (oldest := next(iter(self._claims))).time < now - self._memory:
            del self._claims[oldest]
            if self._own_claims.get(oldest.identity) == oldest:
                del self._own_claims[oldest.identity]


def part_rig(rig: Rig, names: Sequence[str]) -> Rig:
    """Return some cameras of a rig with their neighbors, and how these are joined to them."""
    near = neighbors_of(rig)
    known = {*names, *(each for name in names for each in near[name])}
    return Rig(
        tuple(camera for camera in rig.camera if camera.name in known),
        tuple(
            passage
            for passage in rig.passage
            if any(end.rpartition("/")[0] in names for end in passage.between)
        ),
        tuple(overlap for overlap in rig.overlap if overlap.cameras[0] in names),
    )


def _without_borders(report: CameraReport) -> CameraReport:
    """Return a report without what only an overlap needs, since none lies across a border."""
    sightings = tuple(replace(each, covariance=()) for each in report.sightings)
    return replace(report, sightings=sightings)
