"""Who is who among cameras: by hand, without a picture and without a process."""

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Box, ConfigError, Status
from motes_fleet.cameras.camera_report import CameraReport, ObjectReport
from motes_fleet.cameras.reidentification import CrossCameraAssociation
from motes_fleet.cameras.rig_config import Rig

RIG = """
[[camera]]
name = "hall"
source = "hall.mp4"
place = [{ name = "door", box = [300, 0, 20, 240] }]

[[camera]]
name = "office"
source = "office.mp4"
place = [{ name = "door", box = [0, 0, 20, 240] }, { name = "exit", box = [300, 0, 20, 240] }]

[[passage]]
between = ["hall/door", "office/door"]
seconds = [1, 4]
"""
SHIFT = """
[[overlap]]
cameras = ["hall", "office"]
homography = [[1, 0, -100], [0, 1, 0], [0, 0, 1]]
"""
RED, BLUE = 0, 7


def looks(color: int) -> bytes:
    """Return the histogram of somebody mostly of one color."""
    histogram = np.full(8, 0.005, np.float32)
    histogram[color] = 0.965
    return histogram.tobytes()


def sighting(
    identity: int = 1,
    *,
    at: tuple[str, ...] = ("door",),
    color: int = RED,
    status: str = "tracking",
    x: float = 0.0,
    height: float = 40.0,
    detected: bool = True,
) -> ObjectReport:
    box = Box(x, 100, 20, height)
    colors = looks(color)
    return ObjectReport(identity, Status(status), box, 0.9, None, detected, at, colors, look=colors)


class Watching:
    """Cameras that tell what a test says."""

    def __init__(self, text: str = RIG) -> None:
        self.handover = CrossCameraAssociation(Rig.parse(text))

    def tell(self, camera: str, time: float, *sightings: ObjectReport) -> list[int]:
        """Return the identities in the rig."""
        found = self.handover.update(CameraReport(camera, round(25 * time), time, sightings))
        return [found[each.identity] for each in sightings if each.identity in found]

    def leaves(self, time: float = 1.0, **how: object) -> int:
        """Have somebody leave the hall at a time; return who."""
        (who,) = self.tell("hall", time, sighting(**how))  # type: ignore[arg-type]
        self.tell("hall", time + 0.3, sighting(status="lost", **how))  # type: ignore[arg-type]
        return who


def test_who_leaves_by_a_door_comes_in_by_the_other() -> None:
    cameras = Watching()
    who = cameras.leaves()
    assert cameras.tell("office", 3.0, sighting(5)) == [who]
    assert cameras.handover.handed == 1
    assert cameras.tell("office", 3.04, sighting(5), sighting(6)) == [who, who + 1]


def test_who_was_covered_before_leaving_is_known_by_the_look_from_before() -> None:
    cameras = Watching()
    (who,) = cameras.tell("hall", 1.0, covered := replace(sighting(), histogram=looks(BLUE)))
    cameras.tell("hall", 1.3, replace(covered, status=Status.LOST))
    assert cameras.tell("office", 3.0, sighting(5)) == [who]


@pytest.mark.parametrize(
    ("time", "how"),
    [
        (1.9, {}),  # too early
        (5.1, {}),  # too late
        (3.0, {"color": BLUE}),
        (3.0, {"at": ("exit",)}),
        (3.0, {"at": ()}),
    ],
)
def test_who_is_not_expected_starts_anew(time: float, how: dict[str, object]) -> None:
    cameras = Watching()
    who = cameras.leaves()
    assert cameras.tell("office", time, sighting(5, **how)) != [who]  # type: ignore[arg-type]
    assert cameras.handover.handed == 0


def test_two_at_once_are_told_apart_by_their_looks() -> None:
    cameras = Watching()
    red, blue = cameras.tell("hall", 1.0, sighting(1), sighting(2, color=BLUE))
    gone = sighting(1, status="lost"), sighting(2, color=BLUE, status="lost")
    cameras.tell("hall", 1.3, *gone)
    assert cameras.tell("office", 3.0, sighting(5, color=BLUE), sighting(6)) == [blue, red]


def test_who_is_hidden_but_not_yet_lost_is_expected_too() -> None:
    cameras = Watching()
    (who,) = cameras.tell("hall", 1.0, sighting())
    cameras.tell("hall", 1.3, sighting(status="occluded"))
    assert cameras.tell("office", 2.5, sighting(5)) == [who]
    (other,) = cameras.tell("hall", 2.6, sighting())  # so it was somebody else
    assert other not in (who, None)
    assert cameras.tell("office", 2.7, sighting(5)) == [who]


def walked(cameras: Watching, *seconds: float) -> float:
    """Have people walk through the passage, one at a time; return when the last one is gone."""
    now = 0.0
    for n, took in enumerate(seconds, start=10):
        who = cameras.leaves(now, identity=n)
        assert cameras.tell("office", now + took, sighting(n)) == [who]
        cameras.tell("office", now + took + 0.3, sighting(n, at=(), status="lost"))
        now += 100
    return now


def test_who_comes_in_the_usual_time_is_known_before_who_comes_late() -> None:
    """Both look alike. Without a usual time it is the older one."""
    for known, chosen in (((), 0), ((2.0, 2.4, 1.7), 1)):
        cameras = Watching(RIG.replace("seconds = [1, 4]", ""))
        now = walked(cameras, *known)
        both = cameras.leaves(now, identity=1), cameras.leaves(now + 10, identity=2)
        assert cameras.tell("office", now + 12, sighting(5)) == [both[chosen]]


def test_times_are_learned_from_those_without_a_rival() -> None:
    cameras = Watching(RIG.replace("seconds = [1, 4]", ""))
    times = cameras.handover._passing_times
    one, two = cameras.leaves(0.0, identity=1), cameras.leaves(1.0, identity=2)
    assert cameras.tell("office", 2.0, sighting(5)) == [one]
    assert [each.cost(30.0) for each in times.values()] == [0.0]
    assert cameras.tell("office", 3.0, sighting(5), sighting(6)) == [one, two]
    (passage,) = times.values()
    assert passage.cost(30.0) > 1.0


def test_heights_matter_where_the_rig_says_how() -> None:
    for scale, height, same in ((0.5, 20, True), (0.5, 45, False), (2.0, 20, False)):
        cameras = Watching(f"{RIG}scale = {scale}\n")
        who = cameras.leaves(height=40.0)
        assert (cameras.tell("office", 3.0, sighting(5, height=height)) == [who]) is same
        cameras = Watching(f"{RIG}scale = {scale}\n")  # and the other way round
        (who,) = cameras.tell("office", 1.0, sighting(height=height))
        cameras.tell("office", 1.3, sighting(height=height, status="lost"))
        assert (cameras.tell("hall", 3.0, sighting(5, height=40.0)) == [who]) is same


def test_views_that_overlap_see_the_same_object() -> None:
    """In the office everything is 100 pixels further left; colors do not matter."""
    cameras = Watching(RIG + SHIFT)
    (who,) = cameras.tell("hall", 1.0, sighting(at=(), x=150))
    found = cameras.tell(
        "office", 1.04, sighting(5, at=(), x=65, color=BLUE), sighting(6, at=(), x=90)
    )
    assert found == [who, who + 1]
    # The other way round, and who is there already is nobody else.
    assert cameras.tell("hall", 1.08, sighting(2, at=(), x=191), sighting(at=(), x=150)) == [
        who + 1,
        who,
    ]
    assert cameras.tell("office", 1.4, sighting(7, at=(), x=50)) == [who + 2]


def test_an_interruption_makes_nobody_new() -> None:
    cameras = Watching()
    who = cameras.tell("hall", 1.0, sighting(1, at=()), sighting(2, at=(), color=BLUE))
    gone = sighting(1, at=(), status="lost"), sighting(2, at=(), color=BLUE, status="lost")
    cameras.tell("hall", 9.0, *gone)
    found = cameras.tell("hall", 9.1, sighting(3, at=(), color=BLUE), sighting(4, at=(), color=3))
    assert found == [who[1], who[1] + 1]
    cameras.tell("hall", 9.2)  # but who goes without one is gone
    cameras.tell("hall", 9.3, sighting(3, at=(), color=BLUE, status="lost"))
    assert cameras.tell("hall", 9.6, sighting(8, at=(), color=BLUE)) == [who[1] + 2]


def test_who_was_there_before_a_process_died_is_found_after_it() -> None:
    """The next process knows nothing of the objects of the one before, so it reports no loss."""
    cameras = Watching()
    who = cameras.tell("hall", 1.0, sighting(1, at=()), sighting(2, at=(), color=BLUE))
    cameras.tell("hall", 9.0)
    assert cameras.tell("hall", 9.1, sighting(3, at=(), color=BLUE)) == [who[1]]
    assert cameras.tell("hall", 9.2, sighting(4, at=(), color=3)) == [who[1] + 1]
    for time in range(10, 50):
        cameras.tell("hall", time)
    assert cameras.tell("hall", 50, sighting(5, at=())) == [who[1] + 2]


def test_who_came_up_elsewhere_after_an_interruption_is_told_of_once() -> None:
    cameras = Watching()
    who = cameras.tell("hall", 1.0, sighting(1, at=()))
    hidden = sighting(1, at=(), detected=False)  # where it should be by now, nothing is found
    assert cameras.tell("hall", 2.2, hidden) == who
    assert cameras.tell("hall", 2.3, hidden, sighting(2, at=())) == who
    assert cameras.tell("hall", 2.4, sighting(1, at=()), sighting(2, at=())) == [who[0] + 1, *who]


def test_who_is_seen_right_after_an_interruption_is_expected_no_more() -> None:
    cameras = Watching()
    who = cameras.tell("hall", 1.0, sighting(1, at=()))
    assert cameras.tell("hall", 2.2, sighting(1, at=())) == who
    cameras.tell("hall", 2.3, sighting(1, at=(), status="lost"))
    assert cameras.tell("hall", 2.4, sighting(2, at=())) == [who[0] + 1]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the key 'camera' is missing"),
        (
            RIG.replace("hall/door", "hall/window"),
            "'hall/window', which is not in this rig; known are hall/door",
        ),
        (RIG.replace("office", "hall"), "need names, each its own"),
        (RIG.replace("[1, 4]", "[4, 1]"), "least time comes first"),
        (RIG.replace("seconds", "second"), "did you mean 'seconds'"),
        (
            RIG + SHIFT.replace('"office"', '"attic"'),
            "'attic', which is not in this rig; known are hall, office.",
        ),
        (RIG + SHIFT.replace("[0, 0, 1]", "[0, 0, 0]"), "onto a line"),
        (RIG + SHIFT.replace(", [0, 0, 1]", ""), "it takes list of 3"),
        (RIG + "[[", "not valid TOML"),
    ],
)
def test_a_bad_rig_is_refused(text: str, words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        Rig.parse(text)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
