"""A large rig in parts: who is a neighbor, how it is cut, and identities as in the whole."""

from __future__ import annotations

import heapq
import itertools
from unittest.mock import ANY

import pytest
from test_reidentification import BLUE, RIG, SHIFT, sighting

from motes.mot.cameras.bordered import BorderedAssociation, Merged, News, Seen
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.neighborhoods import components, neighbors_of, parts_of
from motes.mot.cameras.reidentification import CrossCameraAssociation
from motes.mot.cameras.rig_config import Camera, Rig
from simulated_cameras import Building, Simulation


def joined(*rigs: Rig) -> Rig:
    """Return several rigs as one, whose cameras have a letter each in front."""
    cameras, passages = [], []
    for letter, rig in zip("xyz", rigs, strict=False):
        for camera in rig.camera:
            cameras.append(Camera(letter + camera.name, "", place=camera.place))
        for passage in rig.passage:
            one, other = (letter + end for end in passage.between)
            passages.append(type(passage)((one, other), passage.seconds))
    return Rig(tuple(cameras), tuple(passages))


def test_passages_and_overlaps_make_neighbors() -> None:
    assert neighbors_of(Rig.parse(RIG)) == {"hall": ("office",), "office": ("hall",)}
    assert neighbors_of(Rig.parse(RIG.partition("[[passage]]")[0] + SHIFT)) == {
        "hall": ("office",),
        "office": ("hall",),
    }
    apart = Rig.parse(RIG.partition("[[passage]]")[0])
    assert neighbors_of(apart) == {"hall": (), "office": ()}
    assert components(apart) == [("hall",), ("office",)]


def test_a_rig_falls_into_its_components() -> None:
    one, two = Building(2, 2).rig(), Building(1, 3).rig()
    rig = joined(one, two)
    names = [camera.name for camera in rig.camera]
    assert components(rig) == [tuple(names[:4]), tuple(names[4:])]
    assert parts_of(rig, 4) == components(rig)


@pytest.mark.parametrize(("cameras", "largest"), [(1, 6), (2, 6), (2, 1), (1, 100)])
def test_parts_are_no_larger_than_they_may_be_and_keep_overlaps_whole(
    cameras: int, largest: int
) -> None:
    rig = Building(4, 5, cameras).rig()
    parts = parts_of(rig, largest)
    assert sorted(itertools.chain(*parts)) == sorted(camera.name for camera in rig.camera)
    assert max(map(len, parts)) <= max(largest, cameras)
    assert len(parts) <= 2 * max(len(rig.camera) // max(largest, cameras), 1)
    part_of = {name: n for n, part in enumerate(parts) for name in part}
    for overlap in rig.overlap:
        assert len({part_of[name] for name in overlap.cameras}) == 1


def test_a_part_has_a_camera_at_least() -> None:
    with pytest.raises(ValueError, match="largest=0"):
        parts_of(Building(1, 2).rig(), 0)


class Parts:
    """The parts of a rig, whose news are on the way for some seconds."""

    def __init__(self, rig: Rig, parts: list[tuple[str, ...]], delay: float = 0.0) -> None:
        self.part_of = {name: n for n, part in enumerate(parts) for name in part}
        self.parts = [BorderedAssociation(rig, parts, n) for n in range(len(parts))]
        self._delay, self._number = delay, itertools.count()
        self._mail: list[tuple[float, int, int, list[News]]] = []

    def update(self, report: CameraReport) -> dict[int, int]:
        """Return the identities of a report, after the news that have come by then."""
        self.deliver(report.time)
        part = self.part_of[report.camera]
        found = self.parts[part].update(report)
        self._post(part, report.time)
        if not self._delay:
            self.deliver(report.time)
        return found

    def deliver(self, until: float) -> None:
        """Deliver the news that come by a time, and what parts pass on."""
        while self._mail and self._mail[0][0] <= until:
            at, _, part, news = heapq.heappop(self._mail)
            self.parts[part].hear(news)
            self._post(part, at)

    def _post(self, part: int, now: float) -> None:
        for to, news in self.parts[part].news().items():
            heapq.heappush(self._mail, (now + self._delay, next(self._number), to, news))


def differences(rig: Rig, simulation: Simulation, parts: Parts) -> tuple[int, int]:
    """Return how often parts and the whole differ but for numbers, and how often they handed on."""
    whole = CrossCameraAssociation(rig)
    there, back = dict[int, int](), dict[int, int]()
    wrong = 0
    for report in simulation.reports():
        expected, found = whole.update(report), parts.update(report)
        wrong += len(expected.keys() ^ found.keys())
        for own in expected.keys() & found.keys():
            one, other = expected[own], found[own]
            wrong += there.setdefault(one, other) != other or back.setdefault(other, one) != one
    assert sum(part.handed for part in parts.parts) == whole.handed or wrong
    return wrong, whole.handed


def test_components_give_the_identities_of_the_whole() -> None:
    """Each on its own, with no news to exchange."""
    building = Building(2, 3)
    simulations = [Simulation(building, 15, 2, seed=seed) for seed in (0, 1)]
    rig = joined(building.rig(), building.rig())
    whole = CrossCameraAssociation(rig)
    parts = Parts(rig, components(rig))
    there = dict[int, int]()
    reports = heapq.merge(
        *(
            (_renamed(report, letter) for report in simulation.reports())
            for letter, simulation in zip("xy", simulations, strict=True)
        ),
        key=lambda report: report.time,
    )
    for report in reports:
        expected, found = whole.update(report), parts.update(report)
        assert expected.keys() == found.keys()
        for own, identity in expected.items():
            assert there.setdefault(identity, found[own]) == found[own]
    assert len(set(there.values())) == len(there) > 10
    assert whole.handed == sum(part.handed for part in parts.parts) > 10
    assert not any(part.news() for part in parts.parts)


def _renamed(report: CameraReport, letter: str) -> CameraReport:
    return CameraReport(
        letter + report.camera, report.frame, report.time, report.sightings, report.size
    )


@pytest.mark.parametrize(
    ("cameras", "largest", "delay"),
    [(1, 4, 0.0), (1, 1, 0.0), (2, 4, 0.0), (1, 4, 0.4), (2, 2, 0.4)],
)
def test_parts_of_a_component_give_the_identities_of_the_whole(
    cameras: int, largest: int, delay: float
) -> None:
    """Also with news that are later by less than the shortest passage of 0.5 s."""
    building = Building(3, 4, cameras)
    rig = building.rig()
    parts = Parts(rig, parts_of(rig, largest), delay)
    assert len(parts.parts) > 2
    wrong, handed = differences(rig, Simulation(building, 20, 1.5, seed=3), parts)
    assert handed > 40
    assert wrong == 0


def test_news_that_are_later_than_a_passage_cost_handovers() -> None:
    building = Building(3, 4)
    rig = building.rig()
    parts = Parts(rig, parts_of(rig, 2), delay=4.0)
    wrong, _ = differences(rig, Simulation(building, 20, 1.5, seed=3), parts)
    assert wrong > 0


FORK = """
camera = [
  { name = "left", source = "", place = [{ name = "in", box = [0, 0, 9, 9] }] },
  { name = "hall", source = "", place = [{ name = "out", box = [0, 0, 9, 9] }] },
  { name = "right", source = "", place = [{ name = "in", box = [0, 0, 9, 9] }] },
]
passage = [
  { between = ["hall/out", "left/in"], seconds = [1, 9] },
  { between = ["hall/out", "right/in"], seconds = [1, 9] },
]
"""


@pytest.mark.parametrize(("first", "second"), [("left", "right"), ("right", "left")])
def test_of_two_claims_of_one_identity_the_earlier_holds(first: str, second: str) -> None:
    """Both sides of a fork see somebody alike before they hear of each other."""
    rig = Rig.parse(FORK)
    parts = Parts(rig, [("left",), ("hall",), ("right",)], delay=0.5)

    def tell(camera: str, time: float, door: str, own: int, status: str) -> list[int]:
        seen = sighting(own, at=(door,), status=status)
        found = parts.update(CameraReport(camera, round(25 * time), time, (seen,)))
        return [*found.values()]

    (who,) = tell("hall", 0.0, "out", 1, "tracking")
    tell("hall", 0.2, "out", 1, "lost")
    assert tell(first, 2.0, "in", 5, "tracking") == [who]
    assert tell(second, 2.1, "in", 6, "tracking") == [who]  # not yet aware
    parts.deliver(4.0)
    assert tell(first, 4.0, "in", 5, "tracking") == [who]
    (other,) = tell(second, 4.1, "in", 6, "tracking")
    assert other != who
    assert sum(part.handed for part in parts.parts) == 1


def test_identities_are_unique_without_a_common_counter() -> None:
    rig = Rig.parse(FORK)
    parts = Parts(rig, [("left",), ("hall",), ("right",)])
    found: list[int] = []
    for n, camera in enumerate(["left", "hall", "right", "left", "hall", "right"]):
        report = CameraReport(camera, n, n / 10, (sighting(n, at=(), color=BLUE),))
        found += parts.update(report).values()
    assert found == [1, 2, 3, 4, 5, 6]


def test_a_merged_identity_is_merged_in_other_parts_too() -> None:
    """Somebody in the yard bears an identity that the next part finds to be another one."""
    door = 'place = [{ name = "d", box = [0, 0, 9, 9] }]'
    text = RIG.partition("[[passage]]")[0] + SHIFT
    text += f'\n[[camera]]\nname = "yard"\nsource = ""\n{door}\n'
    text += '\n[[passage]]\nbetween = ["office/exit", "yard/d"]\nseconds = [1, 4]\n'
    indoors, yard = Parts(Rig.parse(text), [("hall", "office"), ("yard",)]).parts

    def tell(part: BorderedAssociation, camera: str, time: float, x: float) -> int:
        report = CameraReport(camera, round(25 * time), time, (sighting(at=(), x=x),))
        (identity,) = part.update(report).values()
        return identity

    assert tell(yard, "yard", 0.0, 100) == 2
    yard.hear([Merged(2, 1)])
    assert tell(yard, "yard", 0.1, 100) == 1
    assert yard.news() == {0: [Seen(ANY, {1: 2}), Merged(2, 1), Seen(ANY, {1: 1})]}
    assert tell(indoors, "hall", 3.0, 150) == 1
    assert tell(indoors, "office", 3.3, 50) == 3  # the hall's is not fresh any more
    for n in range(30):
        tell(indoors, "hall", 3.4 + n / 10, 150)
        last = tell(indoors, "office", 3.45 + n / 10, 50)
    assert last == 1
    assert Merged(3, 1) in indoors.news()[1]
