"""Lines, zones, events and counts."""

import itertools
import math
from collections import Counter
from collections.abc import Sequence

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Box, ConfigError, Ellipse, Status, Track
from motes.mot.analytics.event import Event
from motes.mot.analytics.event_counter import BRIEF, EDGE, EventCounter
from motes.mot.analytics.regions import Line, Regions, Zone, crossing
from sightings import seen, told


def test_a_step_crosses_as_its_finer_steps_do() -> None:
    rng = np.random.default_rng(0)
    line, crossings = (10.0, 20.0, 60.0, 45.0), 0
    for _ in range(300):
        start, end = rng.uniform(0, 70, (2, 2))
        fine = [tuple(start + (end - start) * s) for s in np.linspace(0, 1, 8)]
        sides = [crossing(line, a, b) for a, b in itertools.pairwise(fine)]
        found = [side for side in sides if side]
        assert len(found) <= 1
        assert crossing(line, tuple(start), tuple(end)) == (found[0] if found else None)
        crossings += bool(found)
    assert crossings > 30


def test_a_zone_is_a_polygon() -> None:
    zone = Zone((0, 0, 10, 0, 10, 10, 5, 5, 0, 10))  # a square with a notch from below
    inside = [(2, 2), (9, 8), (1, 8), (5, 4)]
    outside = [(5, 8), (-1, 5), (11, 5), (5, -1), (5, 11)]
    assert all(map(zone.holds, inside))
    assert not any(map(zone.holds, outside))


@pytest.mark.parametrize(
    ("line", "crossings"),
    [
        ((50, 40, 50, 99), 1),
        ((50, 98, 50, 40), 1),
        ((50, 40, 50, 90), 0),  # it ends in the picture
        ((20, 98, 40, 98), 0),  # along the edge, before them
    ],
)
def test_a_line_goes_on_beyond_the_picture(line: tuple[int, int, int, int], crossings: int) -> None:
    """Feet that the lower edge cuts off pass there, 4 pixels below the picture."""
    counting = EventCounter(Regions((Line(line),)), (100, 100))
    steps = [seen(i, (10 * i, 103)) for i in range(12)]
    events = told(counting, *steps) + counting.finish()
    assert [each.event for each in events].count("crosses") == crossings


def test_events_of_one_visit() -> None:
    places = Regions((Line((50, 0, 50, 99), "gate"),), (Zone((60, 0, 90, 0, 90, 99, 60, 99)),))
    counting = EventCounter(places)
    events = told(counting, *(seen(i, (10 * i, 40)) for i in range(12)))
    events += told(counting, seen(12, (0, 0), Status.OCCLUDED), seen(13, (0, 0), Status.LOST))
    kinds = [(e.frame, e.event, e.place, e.direction, e.seconds) for e in events]
    assert kinds == [
        (0, "appears", None, None, None),
        (5, "crosses", "gate", "in", None),  # where it stands on the line
        (6, "enters", "zone 1", None, None),
        (9, "leaves", "zone 1", None, 0.75),
        (13, "disappears", None, None, 2.75),
    ]
    assert [e.speed for e in events] == [None, 40, 40, 40, 40]  # 10 pixels in a quarter of a second
    assert (events[-1].x, events[-1].y) == (110, 40)  # where it was last seen
    assert told(counting, seen(14, (0, 0), Status.LOST)) == []
    assert counting.counts[0, "crosses", "gate", "in", ""] == 1
    once = ("appears", "gate in", "zone 1 enters", "zone 1 leaves", "disappears")
    assert counting.totals == dict.fromkeys(once, 1)
    assert places.totals == ["gate in", "gate out", "zone 1 enters", "zone 1 leaves"]
    assert counting.counts.total() == 5
    again = told(counting, *(seen(20 + i, (10 * i, 40)) for i in range(3)))
    assert [(each.frame, each.event) for each in again] == [(20, "appears")]


@pytest.mark.parametrize(
    ("begin", "speed", "crosses"), [((60, 40), 10, [(6, 2)]), ((60, 80), 0, []), ((30, 40), 0, [])]
)
def test_parts_of_one_path_cross_once(
    begin: tuple[float, float], speed: float, crosses: list[tuple[int, int]]
) -> None:
    """One is lost before the line; another begins where the first one's way leads, or elsewhere."""
    counting = gate()
    x, y = begin
    events = told(counting, *(seen(i, (10 * i, 40)) for i in range(5)))
    events += told(counting, seen(5, (0, 0), Status.LOST))
    events += told(counting, *(seen(6 + i, (x + speed * i, y), identity=2) for i in range(6)))
    assert [(e.frame, e.identity) for e in events if e.event == "crosses"] == crosses


@pytest.mark.parametrize(
    ("before", "feet", "crosses"),
    [
        ([], [46, 54, 90, 92, 94], []),  # its second box is over the line, but not on a path
        ([], [46, 54, None, 56, 58], []),  # nor where it is not seen in the next frame
        ([], [42, 48, 54, 91, 93], [(2, 1)]),  # three boxes are a path
        ([42, 46, 50, 54], [58, 62, 99, 101], [(2, 1)]),  # the path before has crossed it
    ],
)
@pytest.mark.parametrize("begin", [0, 1, 2])
def test_a_jump_takes_back_only_what_the_second_box_has_crossed(
    begin: int, before: list[int], feet: list[int | None], crosses: list[tuple[int, int]]
) -> None:
    """Also where times between frames differ by a rounding; `before` is one that is then hidden."""
    tracks = [[seen(i, (x, 40))] for i, x in enumerate(before)]
    hidden, identity = ([seen(0, (0, 0), Status.OCCLUDED)], 2) if before else ([], 1)
    end = feet[-1] or 0
    for i, x in enumerate([*feet, *range(end, end + 40, 2)], start=len(before)):
        here = [] if x is None else [seen(i, (x, 40), identity=identity)]
        tracks.append([*hidden, *here])
    counting, events = gate(), list[Event]()
    for i, each in enumerate(tracks, start=begin):
        events += counting.update([replace(track, time=i / 25) for track in each])
    assert [(e.frame, e.identity) for e in events if e.event == "crosses"] == crosses


def test_a_path_that_another_has_continued_does_not_cross_again() -> None:
    counting = gate()
    tracks = [[seen(i, (10 * i, 40))] for i in range(5)]
    hidden = [seen(i, (0, 0), Status.OCCLUDED) for i in range(12)]
    tracks += [[hidden[i], seen(i, (10 * i, 40), identity=2)] for i in range(6, 9)]
    tracks += [[seen(i, (10 * i, 40)), seen(i, (10 * i, 45), identity=2)] for i in range(9, 14)]
    events = [event for each in tracks for event in counting.update(each)]
    assert [(e.frame, e.identity) for e in events if e.event == "crosses"] == [(6, 2)]


def test_who_stays_is_told_once_for_each_visit() -> None:
    square = (60.0, 0.0, 90.0, 0.0, 90.0, 99.0, 60.0, 99.0)
    places = Regions(
        zone=(Zone(square, "desk", dwell=1), Zone(square, "hall"), Zone(square, "bed", 9))
    )
    counting = EventCounter(places)
    feet = [70, 70, 71, 72, 73, 74, 50, 50, 50, 70, 70, 70, 50, 50, 50, *[70] * 6]
    events = told(counting, *(seen(i, (x, 40)) for i, x in enumerate(feet)))
    stays = [(e.frame, e.place, e.seconds) for e in events if e.event == "stays"]
    assert stays == [(4, "desk", 1.0), (19, "desk", 1.0)]  # four frames a second
    assert counting.counts[0, "stays", "desk", "", ""] == 2
    left = [(e.frame, e.seconds) for e in events if (e.event, e.place) == ("leaves", "desk")]
    assert left == [(6, 1.5), (12, 0.75)]


def test_who_is_hidden_while_it_stays_is_told_when_it_comes_up() -> None:
    shown = [seen(i, (70, 40)) for i in (0, 1, 7)]
    shown.insert(2, seen(5, (70, 40), Status.OCCLUDED))
    events = told(desk(dwell=1), *shown)
    assert [(e.frame, e.seconds) for e in events if e.event == "stays"] == [(7, 1.75)]


def test_what_is_hidden_crosses_when_it_comes_up() -> None:
    counting = gate()
    events = told(
        counting,
        *(seen(i, (26 + 2 * i, 40)) for i in range(3)),
        seen(3, (60, 40), Status.OCCLUDED),
        seen(4, (70, 40), Status.OCCLUDED),
        *(seen(i, (80, 44)) for i in range(5, 8)),
    )
    assert [(e.frame, e.event) for e in events] == [(0, "appears"), (5, "crosses")]
    assert events[1].x == 50  # on the line, from (30, 40) to (80, 44)
    assert events[1].y == pytest.approx(41.6)


@pytest.mark.parametrize(("shown", "hidden", "crosses"), [(3, 33, 0), (6, 6, 1), (6, 7, 0)])
def test_what_is_hidden_for_longer_than_it_was_seen_is_another_object(
    shown: int, hidden: int, crosses: int
) -> None:
    """Whether frames without it have a row of it, or none."""
    for status in (Status.OCCLUDED, None):
        counting, feet = gate(), [*range(30, 30 + shown), *[0] * hidden, *range(70, 76)]
        unseen = range(shown, shown + hidden)
        for i, x in enumerate(feet):
            gone = i in unseen
            tracks = [seen(i, (x, 40), status or Status.LOST)] if gone else [seen(i, (x, 40))]
            counting.update([] if gone and status is None else tracks, i / 4)
        counting.finish()
        kinds = Counter(kind for _, kind, *_ in counting.counts.elements())
        assert (kinds["crosses"], kinds["appears"]) == (crosses, 1)


def test_who_vanishes_in_a_zone_leaves_it() -> None:
    counting = EventCounter(Regions(zone=(Zone((0, 0, 90, 0, 90, 90), "court"),)))
    events = told(counting, seen(0, (50, 20)), seen(4, (51, 20)), seen(9, (0, 0), Status.LOST))
    leaves, disappears = ((e.event, e.seconds, e.frame, e.time) for e in events[-2:])
    assert leaves == ("leaves", 1.0, 4, 1.0)
    assert disappears == ("disappears", 1.0, 9, 2.25)


def test_places_from_toml() -> None:
    text = '[[line]]\npoints = [1, 2, 3, 4]\nname = "gate"\n[[zone]]\npoints = [0, 0, 9, 0, 9, 9]\n'
    places = Regions.parse(text)
    assert list(places.lines) == ["gate"]
    assert list(places.zones) == ["zone 1"]
    with pytest.raises(ConfigError, match="did you mean 'points'"):
        Regions.parse("[[line]]\npoint = [1, 2, 3, 4]\n")
    with pytest.raises(ConfigError, match="have the name 'a'; rename"):
        Regions((Line((0, 0, 1, 1), "a"),), (Zone((0, 0, 9, 9, 2, 3), "a"),))
    with pytest.raises(ConfigError, match="have the name 'zone 1'; rename"):
        Regions((Line((0, 0, 1, 1), "zone 1"),), (Zone((0, 0, 9, 9, 2, 3)),))
    with pytest.raises(ConfigError, match="court has no area; give corners in pixels"):
        Regions(zone=(Zone((10, 10, 20, 20, 30, 30), "court"),))


@pytest.mark.parametrize("points", [(0, 0, 9, 9, 9, 0, 0, 9), (0, 0, 1e15, 1e15, 1e15, 0, 0, 1e15)])
def test_a_zone_that_crosses_itself_is_refused(points: tuple[float, ...]) -> None:
    touching = Zone((0, 0, 9, 0, 9, 9, 4, 0, 0, 9))
    Regions(zone=(touching,))
    with pytest.raises(ConfigError, match="zone 2 crosses itself; give its corners in order"):
        Regions(zone=(touching, Zone(points)))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Line((1, 2, 1, 2)), "two different points"),
        (lambda: Zone((1, 2, 3, 4, 5, 6, 7)), "an x and a y"),
        (lambda: Zone((0, 0, 9, 0, 9, 9), dwell=0.3), r"dwell: got 0.3; it takes number, 0.4 to"),
        (lambda: Zone((1, 2, 3, 4)), "it takes list of at least 6: number"),
        (lambda: Zone((0, 0, 9, 0, 1e300, 9)), r"points\[4\]: got 1e\+300; it takes number, -1,0"),
        (lambda: Line((1, 2, float("nan"), 4)), "finite"),
    ],
)
def test_places_that_are_none(make: object, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        make()  # type: ignore[operator]


def gate(**changes: object) -> EventCounter:
    """Return the counter of a line at x = 50; an object to the right of the picture is left."""
    label = changes.get("label", ("left", "right"))
    return EventCounter(Regions((Line((50, 0, 50, 99), label=label),)))  # type: ignore[arg-type]


def crossings(
    counting: EventCounter, feet: Sequence[float], identity: int = 1
) -> list[tuple[int, str]]:
    """Return frames and directions of the crossings of an object that then is lost."""
    events = told(counting, *(seen(i, (x, 40), identity=identity) for i, x in enumerate(feet)))
    events += told(counting, seen(len(feet), (0, 0), Status.LOST, identity))
    return [(e.frame, e.direction or "") for e in events if e.event == "crosses"]


WAYS: dict[str, tuple[list[float], list[tuple[int, str]]]] = {
    "back within half a second": ([40, 44, 48, 51, 49, 45, 41], []),
    "there and back": (
        [40, 44, 48, 51, 54, 56, 55, 52, 48, 44, 40, 36], [(3, "left"), (8, "right")],
    ),
    # An object 11 pixels high is on the line up to 1.1 pixels from it.
    "never on the other side": ([50.5, 53, 56, 59], []),
    "found on the line": ([49.5, 53, 56, 59], [(1, "left")]),
    "hardly moving": ([50.5, 50.7, 51.2, 51.3, 51.4], []),
    "clear of it at first": ([52, 53, 56, 59], []),
    "one step goes back no further": ([51, 52.4, 53, 54, 55], []),
    "known for a moment": ([45, 55], []),
    "known for longer": ([45, 55, 60], [(1, "left")]),
    # The crossing is where the foot is over; it is clear of the line in frame 5.
    "over from frame 2 on": ([45, 48, 50.2, 50.6, 50.9, 52, 53, 54], [(2, "left")]),
    "over from frame 4 on": ([45, 48, 50.2, 49.5, 50.6, 52, 53, 54], [(4, "left")]),
    "a box that takes in a neighbor": ([40, 41, 42, 43, 73, 74, 75, 76], []),
}  # fmt: skip
"""Feet in each frame, and when and to which side they cross x = 50."""


@pytest.mark.parametrize("way", WAYS)
def test_when_a_way_crosses_a_line(way: str) -> None:
    feet, expected = WAYS[way]
    assert crossings(gate(), feet) == expected


def test_a_stroke_shows_the_first_direction() -> None:
    for points in ((50, 0, 50, 99), (10, 80, 90, 60), (90, 60, 10, 80)):
        line = Line(points)
        begin, tip = line.stroke
        after = (2 * tip[0] - begin[0], 2 * tip[1] - begin[1])
        before = (2 * begin[0] - tip[0], 2 * begin[1] - tip[1])
        assert line.label[crossing(line.points, before, after) == "right"] == "in"


def test_directions_have_the_lines_own_names() -> None:
    counting = gate(label=("in", "out"))
    assert crossings(counting, [42, 47, 52, 57, 62]) == [(2, "in")]
    assert crossings(counting, [58, 53, 48, 43, 38], 2) == [(2, "out")]
    assert counting.counts[0, "crosses", "line 1", "in", ""] == 1
    text = '[[line]]\npoints = [1, 2, 3, 4]\nlabel = ["north", "south"]\n'
    assert Regions.parse(text).line[0].label == ("north", "south")
    with pytest.raises(ConfigError, match="two different names"):
        Line((1, 2, 3, 4), label=("in", "in"))


def test_a_line_over_which_boxes_jump_is_unsure() -> None:
    """One object walks over it, boxes of others jump: a third of them and more."""
    counting = gate()
    assert crossings(counting, [40, 44, 48, 52, 56, 60]) == [(3, "left")]
    assert crossings(counting, [40, 41, 42, 43, 73, 74, 75, 76], 2) == []
    assert crossings(counting, [40, 73, 74, 75, 76], 3) == []  # in its second frame
    said = "line 1: left out boxes that jumped over it: 2, so its count is unsure"
    assert counting.remarks() == [said]
    assert crossings(counting, [60, 56, 52, 48, 44, 40], 4) == [(3, "right")]
    assert "unsure" in counting.remarks()[0]
    for identity in range(5, 10):
        assert crossings(counting, [60, 56, 52, 48, 44, 40], identity) == [(3, "right")]
    assert counting.remarks() == ["line 1: left out boxes that jumped over it: 2"]


@pytest.mark.parametrize(
    ("feet", "unsure"),
    [
        ([36, 40, 44, 48, 50, 50.4, 50.2], True),  # lost upon it
        ([50.2, 50.1, 50, 50.1, 50, 51, 55, 60], True),  # found upon it, without a way before
        ([49.5, 53, 56, 59], False),  # its way before is known
    ],
)
def test_who_is_found_or_lost_upon_a_line_is_said(feet: list[float], unsure: bool) -> None:
    """Six sat down at a table and four were counted; nothing said that two may have been."""
    counting = gate()
    assert len(crossings(counting, feet)) == (not unsure)
    counting.finish()
    said = "found or lost upon it: 1, so its count is unsure"
    assert any(said in each for each in counting.remarks()) == unsure


def test_who_is_not_lost_where_another_goes_on_is_not_said() -> None:
    counting = gate()
    tracks = [seen(i, (38 + 2 * i, 40)) for i in range(6)]
    tracks += [seen(7 + i, (52 + 2 * i, 40), identity=2) for i in range(6)]
    told(counting, *tracks)
    assert [*counting.finish(), counting.abrupt["line 1"]] == [0]


@pytest.mark.parametrize(
    ("feet", "lost", "unsure"),
    [
        ([70 + 0.01 * i for i in range(20)], False, 1),  # a ghost
        ([*range(50, 76), *[75] * 20], True, 1),
        ([*range(50, 76), *[75] * 20], False, 0),  # it is there at the end of the film
        (range(50, 100), True, 0),
    ],
)
def test_who_is_found_or_lost_inside_a_zone_is_said(
    feet: Sequence[float], lost: bool, unsure: int
) -> None:
    """A ghost entered a zone, and nothing said so."""
    counting = desk()
    assert visits(counting, feet, lost=lost)
    said = [f"desk: objects found or lost inside it: {unsure}"] if unsure else []
    assert counting.remarks() == said


def test_who_comes_in_at_the_edge_of_the_picture_is_not_found_inside() -> None:
    zone = Zone((0, 0, 50, 0, 50, 99, 0, 99))
    counting = EventCounter(Regions(zone=(zone,)), (100, 100))
    assert visits(counting, [3, 3, 4, 5, *range(6, 80)]) == [(0, "enters"), (48, "leaves")]
    assert counting.remarks() == []


def test_what_is_hidden_while_it_walks_has_not_jumped() -> None:
    counting = gate()
    tracks = [seen(i, (32 + i, 40)) for i in range(8)]
    tracks += [seen(i, (0, 0), Status.OCCLUDED) for i in range(8, 16)]
    events = told(counting, *tracks, *(seen(i, (57 + i, 40)) for i in range(16, 20)))
    assert [(e.frame, e.event) for e in events] == [(0, "appears"), (16, "crosses")]


def visits(
    counting: EventCounter, feet: Sequence[float], rate: int = 25, *, lost: bool = True
) -> list[tuple[int, str]]:
    """Return frames and kinds of the events at places of an object at a rate of frames."""
    tracks = [seen(i, (x, 40)) for i, x in enumerate(feet)]
    tracks += [seen(len(feet), (0, 0), Status.LOST)] if lost else []
    timed = [replace(each, time=each.frame / rate) for each in tracks]
    events = told(counting, *timed) + counting.finish()
    return [(e.frame, e.event) for e in events if e.place]


def desk(low: float = 60, high: float = 90, dwell: float | None = None) -> EventCounter:
    zone = Zone((low, 0, high, 0, high, 99, low, 99), "desk", dwell)
    return EventCounter(Regions(zone=(zone,)))


def test_a_visit_to_the_edge_alone_is_left_out_and_said() -> None:
    counting = desk()
    assert visits(counting, [50, 58, 60.4, 59, 58, *[50] * 20]) == []
    assert counting.left_out["desk", EDGE] == 1
    assert counting.remarks() == ["desk: nothing entered it, left out visits to its edge alone: 1"]


SWAY = [100 + 3 * math.sin(i / 10) for i in range(400)]
"""A foot that sways across the edge at 100, with a period of 63 frames; its object is 40 high."""


@pytest.mark.parametrize(
    ("feet", "kinds", "touched"),
    [
        ([*range(60, 100, 2), *SWAY], [], 1),
        ([*range(60, 100, 2), *SWAY, *range(100, 140, 2)], ["enters"], 0),
        ([*range(140, 100, -2), *SWAY, *range(100, 60, -2)], ["enters", "leaves"], 0),
        ([103 - 0.01 * i for i in range(200)], ["enters"], 0),  # found at the edge, never outside
        ([96] * 50 + [99.9] + [96] * 50, [], 0),
    ],
)
def test_the_edge_of_a_zone_has_a_margin_in_the_objects_own_size(
    feet: list[float], kinds: list[str], touched: int
) -> None:
    counting, tracks = desk(100, 150), [high(i, (x, 50)) for i, x in enumerate(feet)]
    events = told(counting, *tracks) + counting.finish()
    assert [e.event for e in events if e.event != "appears"] == kinds
    assert counting.left_out == ({("desk", EDGE): touched} if touched else {})


def high(frame: int, foot: tuple[float, float], identity: int = 1) -> Track:
    """Return a track, 25 frames a second, of an object 40 pixels high."""
    ellipse = Ellipse(foot[0], foot[1] - 19.5, 10, 20)
    track = Track(frame, frame / 25, ellipse, np.eye(5), 1.0, Status.TRACKING, 0.0, 1.0)
    return replace(track, identity=identity, detected=True)


@pytest.mark.parametrize(("size", "kinds"), [((200, 100), ["enters", "leaves"]), (None, [])])
def test_the_edge_of_the_picture_is_no_edge_of_a_zone(
    size: tuple[int, int] | None, kinds: list[str]
) -> None:
    """Somebody walks along the lower edge, which hides the feet."""
    zone = Zone((100, 0, 150, 0, 150, 99.5, 100, 99.5), "desk")
    counting = EventCounter(Regions(zone=(zone,)), size)
    tracks = [high(i, (80 + 2 * i, 99)) for i in range(50)]
    events = told(counting, *tracks) + counting.finish()
    assert [e.event for e in events] == ["appears", *kinds]


@pytest.mark.parametrize("gap", [0, 6])
@pytest.mark.parametrize("hidden", [True, False])
def test_an_identity_that_changes_in_a_zone_is_one_visit(gap: int, hidden: bool) -> None:
    """The first one is hidden when the second begins, or gone."""
    counting, events = desk(100, 300, dwell=3), list[Event]()
    for i in range(150):
        first, second = high(i, (80 + 2 * i, 50)), high(i, (80 + 2 * i, 50), 2)
        lost = replace(first, status=Status.LOST)
        tracks = [first] if i < 40 else [replace(lost, sought=True)] if hidden and i < 60 else []
        tracks += [lost] if i == (60 if hidden else 40) else []
        tracks += [second] if i >= 40 + gap else []
        events += counting.update(tracks, i / 25)
    events += counting.finish()
    visit = [(e.event, e.identity, e.seconds) for e in events if e.place]
    assert visit == [("enters", 1, None), ("stays", 2, 3.0), ("leaves", 2, 4.0)]


@pytest.mark.parametrize("hidden", [True, False])
@pytest.mark.parametrize("change", [28, 34, 78])
def test_an_identity_that_changes_right_after_a_line_keeps_the_crossing(
    change: int, hidden: bool
) -> None:
    """It did not count yet: the first one might have come back."""
    lines = Line((100, 0, 100, 999), "west"), Line((200, 0, 200, 999), "east")
    counting, events = EventCounter(Regions(lines)), list[Event]()
    for i in range(140):
        walker = high(i, (50 + 2 * i, 60), 1 if i < change else 2)
        tracks = [walker] if i < 110 else []
        if i == (125 if hidden else change):
            lost = replace(high(i, (0, 0)), status=Status.LOST)
            tracks.insert(0, replace(lost, identity=1))
        if i == 110:
            lost = replace(high(i, (0, 0), 2), status=Status.LOST)
            tracks.append(replace(lost, identity=2))
        events += counting.update(tracks, i / 25)
    events += counting.finish()
    assert [(e.frame, e.place) for e in events if e.place] == [(25, "west"), (75, "east")]
    assert counting.turns == {("west", "east"): 1}


@pytest.mark.parametrize("gap", [0, 6])
def test_turns_are_from_the_first_line_to_the_last(gap: int) -> None:
    """Also of an object that changes its identity between them."""
    lines = Line((100, 0, 100, 999), "west"), Line((200, 0, 200, 999), "east")
    counting = EventCounter(Regions(lines))
    for i in range(90):
        ways = {1: 80 + 2 * i, 3: 220 - 2 * i, 4: 80 + i}
        ways |= {2: ways.pop(1)} if i >= 40 else {}
        tracks = [high(i, (x, 60 * max(n, 2)), n) for n, x in ways.items()]
        if 40 <= i < 40 + gap:
            tracks = [each for each in tracks if each.identity != 2]
        if i == 40:
            last = high(i, (0, 0))
            tracks.insert(0, replace(last, status=Status.LOST))
        counting.update(tracks, i / 25)
    counting.finish()
    assert counting.turns == {("west", "east"): 1, ("east", "west"): 1, ("west", ""): 1}


def test_the_speed_of_a_cut_object_is_that_of_before() -> None:
    """It goes 2 pixels a frame; while an edge of the picture cuts its box, its middle goes 1."""
    zone = Zone((0, 0, 199, 0, 199, 99, 0, 99), "road")
    counting, events = EventCounter(Regions(zone=(zone,)), (200, 100)), list[Event]()
    for i in range(1, 120):
        left, right = max(2.0 * i - 40, 0), min(2.0 * i, 200)
        status = Status.TRACKING if right - left > 2 else Status.LOST
        ellipse = Ellipse.from_box(Box(left, 40, max(right - left, 2), 20))
        track = replace(high(i, (0, 0)), ellipse=ellipse, status=status)
        events += counting.update([replace(track, detected=True)], i / 25)
    events += counting.finish()
    found = [(e.event, e.speed) for e in events]
    assert found == [
        ("appears", None), ("enters", None), ("disappears", pytest.approx(50)),
        ("leaves", pytest.approx(50)),
    ]  # fmt: skip


def test_what_flickers_is_left_out_and_said() -> None:
    """An object is there for 0.2 s and hardly moves: it may be a reflection."""
    counting = desk()
    assert visits(counting, [70, 71, 70, 71, 70]) == []
    assert counting.left_out["desk", BRIEF] == 1
    assert (counting.totals, counting.left_out["", BRIEF]) == ({}, 1)  # it does not even appear
    assert counting.remarks()[0] == f"left out {BRIEF}: 1"
    counting = EventCounter()
    flicker = seen(0, (70, 40)), seen(1, (70, 40)), seen(2, (0, 0), Status.LOST)
    found = [(told(counting, each), counting.undecided) for each in flicker]
    assert found == [([], 0), ([], 0), ([], None)]  # it may appear until it is gone
    counting = desk()
    assert visits(counting, [70, 71, 70, 71, 70], lost=False) == []
    assert counting.left_out["desk", BRIEF] == 1
    assert visits(desk(), [70 + 0.01 * i for i in range(14)], lost=False) == [(0, "enters")]


def test_who_flickers_again_and_again_is_one_that_is_left_out() -> None:
    """And none, if it is seen for long enough at last."""
    for turns, left in (2, 1), (3, 1), (9, 0):
        counting = desk()
        for i in range(8 * min(turns, 3) + 20 * (turns > 3)):
            shown = i % 8 < 2 or i >= 24
            status = Status.TRACKING if shown else Status.OCCLUDED
            counting.update([replace(seen(i, (75, 40), status), time=i / 25)])
        counting.finish()
        assert [counting.left_out[place, BRIEF] for place in ("", "desk")] == [left, left]
        assert counting.totals == ({} if left else {"appears": 1, "desk enters": 1})
        assert any(BRIEF in line for line in counting.remarks()) == bool(left)


@pytest.mark.parametrize(
    ("points", "inside"),
    [
        ((-5, 10, 200, 10), True),  # through the picture, both ends outside
        ((100, 0, 100, 50), False),  # its last column is 99
        ((99, 0, 99, 50), True),
        ((-20, 10, 10, -20), False),  # past the corner
        ((0, 0.5, 1, 0.5), False),  # in shares of the picture
        ((-50, -50, 150, -50, 150, 150, -50, 150), True),  # the whole picture
        ((-50, 0, -10, 0, -10, 90, -50, 90), False),
    ],
)
def test_places_outside_of_the_picture_are_refused(points: tuple[float, ...], inside: bool) -> None:
    made = Line(points, "here") if len(points) == 4 else Zone(points, "here")
    regions = Regions((made,)) if isinstance(made, Line) else Regions(zone=(made,))
    if inside:
        EventCounter(regions, (100, 80))
        return
    with pytest.raises(ConfigError, match=r"here \(.*\) lies outside of the picture, 100x80"):
        EventCounter(regions, (100, 80))
