"""What the overlay draws, where, and on what."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import Box, ConfigError, Ellipse, Frame, Line, Regions, SourceError, Status, Track, Zone
from motes.cli import Moment, ScenePainter
from motes.cli.annotated_video import speed_label
from motes.output.overlay import COLORS, PARTICLE, draw
from motes.output.scene_overlay import color_of, draw_scene


def track(ellipse: Ellipse, status: Status = Status.TRACKING, confidence: float = 0.5) -> Track:
    return Track(7, 0.28, ellipse, np.eye(5), confidence, status, 0.2, 50.0)


def gray(width: int = 320, height: int = 240) -> NDArray[np.uint8]:
    return np.full((height, width, 3), 128, np.uint8)


def near(pixels: NDArray[np.uint8], color: tuple[int, int, int], within: int) -> NDArray[np.bool_]:
    return np.asarray(np.abs(pixels.astype(int) - color).max(axis=-1) <= within)


def colored(pixels: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Return where an outline's color is, also half of it; frame and casing are gray."""
    return np.asarray(np.ptp(pixels.astype(int), axis=-1) > 50)


@pytest.mark.parametrize("theta", [0.7, -2.0])
@pytest.mark.parametrize("size", [(160, 120), (1280, 960)])
def test_the_outline_lies_on_the_ellipse(size: tuple[int, int], theta: float) -> None:
    width, height = size
    ellipse = Ellipse(0.52 * width, 0.47 * height, 0.3 * width, 0.2 * height, theta)
    out = draw(gray(*size), track(ellipse), label="")
    changed = (out != 128).any(axis=2)
    y, x = np.mgrid[:height, :width]
    u, v = x - ellipse.x, y - ellipse.y
    cos, sin = math.cos(theta), math.sin(theta)
    radius = np.hypot((u * cos + v * sin) / ellipse.a, (v * cos - u * sin) / ellipse.b)
    # The distance from the outline is at most this; lines are up to 3 pixels of 240 rows wide.
    distance = np.abs(radius - 1) * ellipse.a
    line = max(1, height / 240)
    assert distance[changed].max() < (2 * line + 1) * ellipse.a / ellipse.b
    assert not changed[radius < 0.8].any()
    for px, py in np.rint(ellipse.polygon(90)).astype(int):
        assert colored(out[py, px]), (px, py)


def test_the_status_decides_color_and_dashes() -> None:
    ellipse = Ellipse(160, 120, 80, 50, 0.3)
    points = np.rint(ellipse.polygon(400)).astype(int)
    share = {}
    for status in set(Status) - {Status.ABSENT}:
        out = draw(gray(), track(ellipse, status), label="")[points[:, 1], points[:, 0]]
        share[status] = colored(out).mean()
        assert near(out, COLORS[status], 0).sum() > 20
    assert share[Status.TRACKING] > 0.98
    for status in set(share) - {Status.TRACKING}:
        assert 0.4 < share[status] < 0.65
    assert len(set(COLORS.values())) == len(Status)
    absent = draw(gray(), track(Ellipse(*[math.nan] * 5), Status.ABSENT), label="")
    assert (absent == gray()).all()


def test_the_input_is_left_as_it_is() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (120, 160, 3), np.uint8)
    before = pixels.copy()
    pixels.flags.writeable = False
    out = draw(
        pixels, track(Ellipse(80, 60, 20, 10)), particles=[[80.0, 60]], trail=[(1, 1), (9, 9)]
    )
    assert np.array_equal(pixels, before)
    assert not np.shares_memory(pixels, out)
    assert out.flags.writeable
    assert (out != before).any()


@given(
    ellipse=st.builds(
        Ellipse,
        st.floats(-1e4, 1e4) | st.floats(-1e9, 1e9),
        st.floats(-300, 300),
        st.floats(1e-9, 1e9),
        st.floats(1e-3, 1e4),
        st.floats(-10, 10),
    ),
    status=st.sampled_from(Status),
    size=st.sampled_from([(1, 1), (2, 5), (96, 72), (320, 240)]),
)
def test_any_ellipse_on_any_frame(ellipse: Ellipse, status: Status, size: tuple[int, int]) -> None:
    pixels = gray(*size)
    out = draw(
        pixels,
        track(ellipse, status),
        particles=np.array([ellipse]),
        trail=np.array([ellipse[:2], (0, 0)]),
    )
    assert out.shape == pixels.shape
    assert out.dtype == np.uint8


def test_a_particle_is_visible_on_every_background() -> None:
    """A dot of a pixel and a half is lost among leaves, and in the compression of a film."""
    target, where = track(Ellipse(100, 100, 20, 20)), slice(198, 203)
    for color in (PARTICLE, (128, 128, 128)):
        pixels = np.full((240, 320, 3), color, np.uint8)
        dot = draw(pixels, target, particles=[(200, 200)], label="")[where, where]
        assert (np.abs(dot.astype(int) - color).max(axis=-1) > 50).sum() >= 5


def test_wrong_shapes_are_refused() -> None:
    target = track(Ellipse(100, 100, 20, 20))
    with pytest.raises(ConfigError, match="2 particles needs one weight for each"):
        draw(gray(), target, particles=np.ones((2, 5)), weights=[1.0])
    with pytest.raises(ConfigError, match="particles of an overlay must be rows"):
        draw(gray(), target, particles=[1.0, 2, 3])
    with pytest.raises(ConfigError, match="trail of an overlay must be rows"):
        draw(gray(), target, trail=[[1.0]])
    with pytest.raises(SourceError, match="An image has shape"):
        draw(np.zeros((5, 5, 2), np.uint8), target)


@pytest.mark.parametrize("status", [Status.TRACKING, Status.OCCLUDED])
def test_no_label_covers_another(status: Status) -> None:
    one = replace(track(Ellipse.from_box(Box(100, 100, 90, 60))), identity=1)
    other = replace(track(Ellipse.from_box(Box(104, 104, 30, 50)), status), identity=2)
    alone, both = draw_scene(gray(), [one], {}), draw_scene(gray(), [one, other], {})
    assert (near(both, color_of(1), 0) == near(alone, color_of(1), 0)).all()
    if status is not Status.TRACKING:  # who is seen has the usual place
        turned = draw_scene(gray(), [other, one], {})
        assert (near(turned, color_of(1), 0) == near(alone, color_of(1), 0)).all()
    rows = [near(both, color_of(n), 0).any(axis=1).argmax() for n in (1, 2)]
    assert rows[0] < rows[1]  # the other label is below
    crowd = [replace(one, identity=1 + n) for n in range(20)]
    assert draw_scene(gray(), crowd, {}).shape == gray().shape


def test_a_name_has_no_accents_that_the_font_lacks() -> None:
    one = replace(track(Ellipse.from_box(Box(100, 100, 90, 60))), identity=1)
    drawn = []
    for name in ("Süden", "Suden"):
        line = Line((10, 10, 90, 10), label=(name, "out"))
        drawn.append(draw_scene(gray(), [replace(one, label=name)], {}, Regions((line,)), [name]))
    assert (drawn[0] == drawn[1]).all()


def test_a_class_that_is_wider_than_the_picture_hides_no_number() -> None:
    one = replace(track(Ellipse.from_box(Box(0, 100, 30, 30))), identity=1)
    plain, long = (draw(gray(), replace(one, label=label)) for label in (None, 200 * "x"))
    assert near(long, (255, 255, 255), 60)[near(plain, (255, 255, 255), 60)].all()
    bar = near(long, COLORS[Status.TRACKING], 0)[:40].any(axis=0)
    assert 150 <= np.count_nonzero(bar) <= 160  # a confidence of 0.5
    short, long = (draw_scene(gray(), [replace(one, label=label)]) for label in ("x", 200 * "x"))
    assert (short[:, :8] == long[:, :8]).all()


def test_a_caption_and_a_label_do_not_cover_each_other() -> None:
    one = replace(track(Ellipse.from_box(Box(-100, -100, 150, 150))), identity=1, label="walker")
    label, caption, both = (
        draw_scene(gray(), tracks, caption=text)
        for tracks, text in (([one], ()), ([], "0:00"), ([one], "0:00"))
    )
    white = (255, 255, 255)
    for color, within, alone in ((color_of(1), 0, label), (white, 60, caption)):
        shown = np.count_nonzero(near(alone, color, within))
        assert shown == np.count_nonzero(near(both, color, within)) > 0


def test_a_caption_may_be_one_text_and_a_note_a_number() -> None:
    one = replace(track(Ellipse.from_box(Box(100, 100, 90, 60))), identity=1)
    drawn = [
        draw_scene(gray(), [one], caption=caption, notes={1: note})
        for caption, note in (("12", 0), (["12"], "0"), ([12], 0))
    ]
    assert (drawn[0] == drawn[1]).all()
    assert (drawn[0] == drawn[2]).all()


def test_who_is_not_seen_has_a_dark_label() -> None:
    one = replace(track(Ellipse.from_box(Box(100, 100, 90, 60))), identity=1)
    seen, unseen = (
        draw_scene(gray(), [replace(one, status=status)])[95:97, 100:102]
        for status in (Status.TRACKING, Status.OCCLUDED)
    )
    assert near(seen, color_of(1), 0).all()
    assert (unseen < 128).all()


def test_a_trail_is_interrupted_where_nothing_is_seen() -> None:
    painter = ScenePainter(Regions())
    for index, x in enumerate(range(60, 260, 10)):
        status = Status.LOST if 5 <= index < 15 else Status.TRACKING
        one = replace(track(Ellipse(x, 100.0, 8.0, 20.0, 0.0), status), identity=1)
        drawn = painter.painted(Moment(Frame(index, index / 25, gray()), [one]))
    row = np.logical_or.reduce(colored(drawn)[round(one.box.foot[1]) - 1 :])
    assert row[62:98].all()
    assert not row[104:206].any()
    assert row[212:248].all()


def test_lines_and_zones_have_their_names_where_there_are_several() -> None:
    line, other = Line((40, 120, 140, 120)), Line((180, 120, 280, 120), "b")
    zone, outside = Zone((40, 20, 100, 20, 70, 60)), Zone((-90, -90, 400, -90, 400, 20))

    def drawn(line: tuple[Line, ...], zone: tuple[Zone, ...] = ()) -> NDArray[np.uint8]:
        return draw_scene(gray(), [], {}, Regions(line, zone))

    assert (drawn((other,)) == drawn((replace(other, name="c"),))).all()
    assert (drawn((), (zone,)) == drawn((), (replace(zone, name="d"),))).all()
    assert (drawn((line, other)) != drawn((line, replace(other, name="c")))).any()
    named = drawn((line,), (replace(zone, name="d"),)) != drawn((line,), (zone,))
    rows, columns = named.any(axis=2).nonzero()
    assert 20 <= rows.min() < rows.max() < 40
    assert 40 <= columns.min() < columns.max() < 100
    assert (drawn((line,), (outside,)) != drawn((line,), (replace(outside, name="e"),))).any()
    corner, far = Zone((0, 0, 100, 0, 100, 60)), Zone((200, 20, 280, 20, 240, 60))
    named = [
        draw_scene(gray(), [], {}, Regions((), (replace(corner, name=each), far)), [*"01234"])
        for each in ("a", "bbbb")
    ]
    rows = (named[0] != named[1]).any(axis=2).any(axis=1).nonzero()[0]
    assert rows.min() > 40  # the caption of five lines covers no name


def test_a_caption_begins_with_the_frame_that_refine_asks_for() -> None:
    moments = [Moment(Frame(index, 2.0, gray())) for index in (50, 51)]
    corners = [ScenePainter(Regions()).painted(each) for each in moments]
    assert (corners[0] != corners[1]).any()


@pytest.mark.parametrize(
    ("speed", "deviation", "text"),
    [(5.4e-5, 4e-5, "0.00 m/s"), (5.4e-5, 1e-6, "5.4e-05 m/s"), (1.5, math.nan, "1.50 m/s")],
)
def test_an_object_at_rest_has_no_speed(speed: float, deviation: float, text: str) -> None:
    known = {"speed": speed, "speed_std": deviation}
    assert speed_label(replace(track(Ellipse(50, 50, 9, 9)), further=known)) == text
