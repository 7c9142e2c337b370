"""What cameras give each other: sample distributions and expected arrivals, without pictures."""

import numpy as np
import pytest
from msgspec.structs import replace
from test_reidentification import BLUE, RED, RIG, SHIFT, Watching, looks, sighting

from motes import Status
from motes_fleet.cameras.arrivals import expected_of
from motes_fleet.cameras.camera_report import Arrival, CameraReport, ObjectReport
from motes_fleet.cameras.known_objects import KnownObject
from motes_fleet.cameras.reidentification import unmistakable

SIZE = 320, 240
DT = 0.04


class Giving(Watching):
    """Cameras with pictures of a size."""

    def tell(self, camera: str, time: float, *sightings: ObjectReport) -> list[int]:
        """Return the identities in the rig."""
        report = CameraReport(camera, round(25 * time), time, sightings, SIZE)
        found = self.handover.update(report)
        return [found[each.identity] for each in sightings if each.identity in found]

    def expected(self, camera: str, time: float) -> tuple[Arrival, ...]:
        """Return what a camera expects."""
        return self.handover.arrivals(camera, time)


def walking(identity: int = 1, x: float = 150.0) -> ObjectReport:
    """Return a report of somebody who walks to the right."""
    covariance = tuple(np.diag([4.0, 1.0, 0.5, 0.5, 0.0]).ravel().tolist())
    seen = sighting(identity, at=(), x=x)
    return replace(seen, velocity=(100.0, 0.0), covariance=covariance)


def test_an_overlapping_camera_gets_a_distribution_in_the_next_frame() -> None:
    cameras = Giving(RIG + SHIFT)
    cameras.tell("office", 1.0)
    (who,) = cameras.tell("hall", 1.0, walking())
    (arrival,) = cameras.expected("office", 1.04)
    assert arrival.identity == who
    assert arrival.place is None
    # It is 100 pixels further left there, and has moved on by 4; its size is the same.
    assert arrival.ellipse[:4] == pytest.approx((150 + 9.5 - 100 + 4, 119.5, 10, 20))
    assert arrival.velocity == pytest.approx((100, 0))
    # Its own covariance, and that of the ground: half of the reach, which is a width.
    assert np.diag(np.reshape(arrival.covariance, (5, 5))) == pytest.approx([104, 101, 0.5, 0.5, 0])
    assert np.frombuffer(arrival.histogram, np.float32).argmax() == 0


def test_samples_are_where_the_object_is_when_they_are_used() -> None:
    cameras = Giving(RIG + SHIFT)
    cameras.tell("office", 1.0)
    cameras.tell("hall", 1.0, walking())
    (arrival,) = cameras.expected("office", 1.0)
    rng = np.random.default_rng(0)
    found = expected_of(arrival, rng, 1.1, np.empty((0, 4)), 4000)
    assert found.certain
    assert found.samples.mean(axis=0)[:2] == pytest.approx((69.5, 119.5), abs=1)
    assert found.samples.std(axis=0)[:2] == pytest.approx((10.2, 10), rel=0.1)
    assert tuple(found.velocity) == pytest.approx((100, 0))


def test_it_is_announced_until_it_is_there_and_for_a_second_at_most() -> None:
    cameras = Giving(RIG + SHIFT)
    cameras.tell("office", 1.0)
    who = cameras.tell("hall", 1.0, walking())
    seen = replace(sighting(5, at=(), x=90, color=BLUE), expected=who[0])
    assert cameras.expected("office", 1.04)
    assert cameras.tell("office", 1.04, seen) == who  # as what it began, wherever it is
    assert cameras.handover.handed == 1
    assert cameras.expected("office", 1.08) == ()
    cameras = Giving(RIG + SHIFT)
    asked = []
    for index in range(60):
        cameras.tell("office", index * DT)
        cameras.tell("hall", index * DT, replace(walking(), velocity=(0.0, 0.0)))
        asked.append(bool(cameras.expected("office", index * DT + DT)))
    assert asked[:25] == [True] * 25
    assert not any(asked[26:])


def test_a_passage_expects_the_object_at_the_place_when_its_time_comes() -> None:
    cameras = Giving(f"{RIG}scale = 0.5\n")
    cameras.tell("office", 1.0)
    who = cameras.leaves()
    assert cameras.expected("office", 1.9) == ()
    (arrival,) = cameras.expected("office", 2.0)
    assert (arrival.identity, arrival.place, arrival.until) == (who, "door", 5.0)
    assert arrival.ellipse[2:4] == pytest.approx((5, 10))
    assert cameras.expected("office", 2.04) == ()  # it knows
    boxes = np.array([[0.0, 0.0, 20.0, 240.0]])
    found = expected_of(arrival, np.random.default_rng(0), 2.04, boxes, 500)
    assert not found.certain
    assert found.samples[:, 0].max() < 20
    assert found.samples[:, 1].max() > 200
    # Who comes back, and leaves again, is announced again.
    cameras.leaves(2.2)
    assert len(cameras.expected("office", 3.3)) == 1


def test_two_identities_of_one_object_are_merged() -> None:
    """Half of somebody at the border stands elsewhere: a birth that is wrong for a second only."""
    cameras = Giving(RIG + SHIFT)
    assert cameras.tell("hall", 0.0, sighting(1, at=(), x=150)) == [1]
    assert cameras.tell("office", 0.0, sighting(5, at=(), x=90)) == [2]
    found = []
    for index in range(1, 40):
        time = index * DT
        cameras.tell("hall", time, sighting(1, at=(), x=150))
        found += cameras.tell("office", time, sighting(5, at=(), x=55))
    assert found[:24] == [2] * 24
    assert found[26:] == [1] * len(found[26:])
    assert cameras.handover.merged == {2: 1}


def test_people_side_by_side_are_not_merged() -> None:
    cameras = Giving(RIG + SHIFT)
    for index in range(50):
        hall = cameras.tell(
            "hall", index * DT, sighting(1, at=(), x=150), sighting(2, at=(), x=162)
        )
        office = cameras.tell(
            "office", index * DT, sighting(5, at=(), x=50), sighting(6, at=(), x=62)
        )
        assert hall == office == [1, 2]
    assert cameras.handover.merged == {}


@pytest.mark.parametrize(
    ("status", "identities"), [("tracking", [3, 1]), ("occluded", [3, 1]), ("lost", [1])]
)
def test_who_had_the_identity_by_mistake_gets_a_new_one(status: str, identities: list[int]) -> None:
    """Who is hidden too, so as not to come back with it; who is just lost has none."""
    cameras = Giving(RIG + SHIFT)
    cameras.tell("hall", 0.0, sighting(1, at=(), x=150))
    wrong = replace(sighting(5, at=(), x=250), expected=1)
    assert cameras.tell("office", 0.0, wrong, sighting(6, at=(), x=90)) == [1, 2]
    wrong = replace(wrong, status=Status(status))
    for index in range(1, 40):
        cameras.tell("hall", index * DT, sighting(1, at=(), x=150))
        found = cameras.tell("office", index * DT, wrong, sighting(6, at=(), x=52))
    assert found == identities


@pytest.mark.parametrize("status", ["tracking", "occluded"])
def test_who_had_the_younger_identity_by_mistake_gets_a_new_one(status: str) -> None:
    cameras = Giving(RIG + SHIFT)
    one, wrong = sighting(1, at=(), x=150), replace(sighting(2, at=(), x=20), expected=2)
    cameras.tell("hall", 0.0, one)
    assert cameras.tell("office", 0.0, sighting(6, at=(), x=90)) == [2]
    assert cameras.tell("hall", 0.02, one, wrong) == [1, 2]
    wrong = replace(wrong, status=Status(status))
    for index in range(1, 40):
        office = cameras.tell("office", index * DT, sighting(6, at=(), x=52))
        hall = cameras.tell("hall", index * DT + 0.02, one, wrong)
    assert (hall, office) == ([1, 3], [1])


def test_an_overlap_without_a_homography_is_learned_and_merges() -> None:
    cameras = Giving(RIG + SHIFT.rpartition("homography")[0])
    for index in range(90):
        x = 110.0 + 2 * index
        seen = replace(walking(1, x), velocity=(50.0, 0.0))
        hall = cameras.tell("hall", index * DT, seen)
        seen = replace(walking(5, x - 100), velocity=(50.0, 0.0))
        office = cameras.tell("office", index * DT, seen)
        if not index:
            assert hall != office
    assert hall == office == [1]
    cameras.tell("hall", 4.0, sighting(1, at=(), x=230), sighting(2, at=(), x=190))
    cameras.tell("office", 4.0, sighting(5, at=(), x=130))
    (arrival,) = cameras.expected("office", 4.04)
    assert arrival.ellipse.x == pytest.approx(99.5, abs=1)


def test_only_looks_that_nobody_else_has_pair_objects() -> None:
    report = sighting(1)
    known = {
        (camera, color): KnownObject.of(camera, 0, 0.0, replace(report, histogram=looks(color)))
        for camera in ("hall", "office")
        for color in (0, 3, 5)
    }
    hall = [known["hall", 0], known["hall", 3], known["hall", 5]]
    office = [known["office", 5], known["office", 0]]
    assert set(unmistakable(hall, office)) == {
        (known["hall", 0], known["office", 0]),
        (known["hall", 5], known["office", 5]),
    }
    twin = KnownObject.of("hall", 0, 0.0, replace(report, histogram=looks(5)))
    assert unmistakable([*hall, twin], office) == [(known["hall", 0], known["office", 0])]
    assert unmistakable([], office) == []


def test_a_moment_out_of_sight_does_not_delay_a_merge() -> None:
    cameras = Giving(RIG + SHIFT)
    cameras.tell("hall", 0.0, sighting(1, at=(), x=150))
    cameras.tell("office", 0.0, sighting(5, at=(), x=90))
    for index in range(1, 30):
        time = index * DT
        cameras.tell("hall", time, sighting(1, at=(), x=150, detected=index % 9 > 0))
        found = cameras.tell("office", time, sighting(5, at=(), x=55))
    assert found == [1]


def test_a_part_is_somebody_expected_or_nobody_yet() -> None:
    for color, known in ((RED, True), (BLUE, False)):
        cameras = Giving()
        who = cameras.leaves()
        part = replace(sighting(5, color=color), partial=True)
        assert cameras.tell("office", 3.0, part) == [who] * known
        assert cameras.handover.handed == known
        whole = sighting(5)  # as it looks when it is seen whole
        assert cameras.tell("office", 3.04, whole) == [who]


def test_a_part_has_to_look_more_like_it_than_the_whole() -> None:
    """Its distance is 0.49: within 0.85, but not within half of it."""
    mixed = np.full(8, 0.005, np.float32)
    mixed[[RED, BLUE]] = 0.485, 0.485
    cameras = Giving()
    who = cameras.leaves()
    half = replace(sighting(5), look=mixed.tobytes(), partial=True)
    assert cameras.tell("office", 3.0, half) == []
    assert cameras.tell("office", 3.04, replace(half, partial=False)) == [who]
