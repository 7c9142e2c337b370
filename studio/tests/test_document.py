"""Changes of a document: what a person draws, and what makes no sense."""

import pytest

from motes import ConfigError, Ground, Line, Regions, Zone
from motes_studio import commands
from motes_studio.commands import Command, Region
from motes_studio.document import Document, changed, regions_of
from motes_studio.messages import OpenFilm
from motes_studio.plan import needs, pass_to

FILM = OpenFilm("film.mkv", 100, 80, 50, 25.0)
BOX = (30.0, 25.0, 30.0, 40.0)


def after(*commands: Command) -> Document:
    document = Document()
    for command in commands:
        document, _ = changed(document, command, FILM, lambda *_: None)
    return document


def added(frame: int = 10, region: Region = BOX) -> commands.AddObject:
    return commands.AddObject(0, "one", "#000000", frame, region)


def key(frame: int, region: Region = BOX, number: int = 1) -> commands.SetKeyframe:
    return commands.SetKeyframe(0, number, frame, region)


def absent(frame: int) -> commands.SetAbsent:
    return commands.SetAbsent(0, 1, frame, frame)


def test_absences_are_ranges() -> None:
    document = after(added(), absent(20), absent(21), absent(23), absent(22), absent(30))
    assert document.target(1).absent == ((20, 23), (30, 30))
    document, _ = changed(document, key(22), FILM, lambda *_: None)
    assert document.target(1).absent == ((20, 21), (23, 23), (30, 30))
    assert [*document.target(1).keys] == [10, 22]
    document, _ = changed(document, commands.SetAbsent(0, 1, 19, 40), FILM, lambda *_: None)
    assert document.target(1).absent == ((19, 40),)
    assert [*document.target(1).marks] == [10, *range(19, 41)]
    document, _ = changed(document, commands.RemoveKeyframe(0, 1, 25), FILM, lambda *_: None)
    assert document.target(1).absent == ((19, 24), (26, 40))


def test_no_two_objects_get_one_name() -> None:
    nameless = commands.AddObject(0, " ", "#000000", 10, BOX)
    document = after(nameless, nameless, commands.RemoveObject(0, 1), nameless)
    assert [each.name for each in document.targets] == ["Object 2", "Object 3"]


def test_split_and_join_keep_all_marks() -> None:
    document = after(added(), absent(20), key(40), commands.Split(0, 1, 20))
    one, two = document.targets
    assert (one.first, one.last, [*one.keys], one.absent) == (0, 19, [10], ())
    assert (two.first, two.last, [*two.keys], two.absent) == (20, 49, [40], ((20, 20),))
    document, _ = changed(document, commands.Join(0, 1, 2), FILM, lambda *_: None)
    (joined,) = document.targets
    assert (joined.first, joined.last) == (0, 49)
    assert ([*joined.keys], joined.absent) == ([10, 40], ((20, 20),))


def test_a_correction_needs_the_passes_on_its_two_sides() -> None:
    before = needs(after(added(0), key(40)).target(1))
    later = needs(after(added(0), key(40), key(20)).target(1))
    old = {each.key for need in before for each in need.passes}
    new = {each.key for need in later for each in need.passes}
    assert len(new - old) == 4  # both learn from the new keyframe, too
    assert len(new) == 5  # two stretches of two passes, and the one to the end


def test_a_look_takes_the_pass_to_its_frame() -> None:
    target = after(added(10), key(20), key(40)).target(1)
    runs = [pass_to(target, frame) for frame in (0, 10, 19, 20, 49)]
    assert [(run.start, run.stop) for run in runs] == [
        (10, 0),
        (10, 10),
        (10, 19),
        (20, 20),
        (40, 49),
    ]
    assert [run.other and run.other[0] for run in runs] == [None, 20, 20, 40, None]


@pytest.mark.parametrize(
    ("command", "word"),
    [
        (added(50), "frame 50"),
        (added(region=(200.0, 0.0, 5.0, 5.0)), "outside"),
        (commands.RemoveKeyframe(0, 1, 10), "needs a keyframe"),
        (commands.RemoveKeyframe(0, 1, 11), "not marked"),
        (commands.SetAbsent(0, 1, 0, 49), "no keyframe"),
        (commands.ChangeObject(0, 1, name=" "), "needs a name"),
        (commands.Split(0, 1, 20), "no place"),
        (commands.Join(0, 1, 1), "itself"),
        (commands.ChangeObject(0, 1, config="particle = 5"), "particle"),
        (
            commands.SetPlaces(0, commands.Places(lines=(commands.DrawnLine((1, 1, 1, 1)),))),
            "two different",
        ),
    ],
)
def test_what_makes_no_sense_is_one_line(command: Command, word: str) -> None:
    document = after(added())
    with pytest.raises(ConfigError, match=r"(?i).*" + word):
        changed(document, command, FILM, lambda *_: None)


def test_ground_points_are_a_plane() -> None:
    corners = (0.0, 0.0), (50.0, 0.0), (50.0, 50.0), (0.0, 50.0)
    square = tuple((x, y, x / 10, y / 10) for x, y in corners)
    ground = regions_of(commands.Places(ground=square)).ground
    assert ground is not None
    assert ground.metres((25.0, 25.0)) == pytest.approx((2.5, 2.5))
    with pytest.raises(ConfigError):
        regions_of(commands.Places(ground=((0.0, 0.0, 0.0, 0.0),) * 4))


def test_places_come_back_from_their_toml() -> None:
    """Also a zone without a dwell, which has no value in TOML."""
    places = commands.Places(
        lines=(commands.DrawnLine((1.0, 1.0, 50.0, 50.0), name="door"),),
        zones=(
            commands.DrawnZone((60.0, 60.0, 90.0, 60.0, 90.0, 80.0)),
            commands.DrawnZone((0.0, 0.0, 9.0, 0.0, 9.0, 8.0), dwell=2.0),
        ),
        ground=(
            (0.0, 0.0, 0.0, 0.0),
            (9.0, 0.0, 7.0, 0.0),
            (9.0, 9.0, 7.0, 5.0),
            (0.0, 9.0, 0.0, 5.0),
        ),
    )
    assert regions_of(places) == Regions(
        line=(Line((1.0, 1.0, 50.0, 50.0), name="door"),),
        zone=(
            Zone((60.0, 60.0, 90.0, 60.0, 90.0, 80.0)),
            Zone((0.0, 0.0, 9.0, 0.0, 9.0, 8.0), dwell=2.0),
        ),
        ground=Ground(points=places.ground),
    )
