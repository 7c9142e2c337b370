"""Searchers: how far they go, what they are drawn to, and that the past is left alone."""

import numpy as np
import pytest

from motes import Ellipse, Frame
from motes.sot.discriminative.redetection import RESTART_EVERY, Redetection

LAST = Ellipse(60.0, 60.0, 12.0, 12.0, 0.0)
SIDE = 24.0


def picture(x: int, y: int) -> Frame:
    """Return noise with a striped square of 24 pixels around a place."""
    pixels = np.random.default_rng(3).integers(90, 130, (200, 300, 3), np.uint8)
    stripes = np.where(np.arange(24) % 8 < 4, 240, 20).astype(np.uint8)
    pixels[y - 12 : y + 12, x - 12 : x + 12] = stripes[None, :, None]
    return Frame(0, 0.0, pixels)


def start(count: int = 400) -> np.ndarray:
    return np.tile(np.array(LAST), (count, 1))


@pytest.mark.parametrize("missed", [1, 4])
def test_fresh_searchers_are_anywhere_within_reach(missed: int) -> None:
    flat = Redetection(sigma=1e3)  # all are equally likely, so that selection keeps them
    frame = picture(60, 60)
    model = flat.learn(frame, LAST)
    searchers, _ = flat.step(np.random.default_rng(0), model, start(4000), frame, LAST, missed)
    off = np.abs(searchers[:, :2] - LAST[:2]).max(axis=1)
    reach = flat.speed * missed * SIDE
    walked = 5 * LAST.a / 2
    assert off.max() <= max(reach, walked)
    # The share of a uniform spread, and of a walk of 6 pixels, that is beyond 0.8 of the reach.
    beyond = np.mean(off > 0.8 * reach)
    expected = (1 - 0.8**2) / RESTART_EVERY
    if missed == 4:
        assert beyond == pytest.approx(expected, abs=0.03)
    sizes = np.log(searchers[:, 2] / LAST.a)
    assert np.mean(sizes != 0) == pytest.approx(1 / RESTART_EVERY, abs=0.03)
    assert sizes[sizes != 0].std() == pytest.approx(flat.growth, rel=0.15)
    assert np.allclose(searchers[:, 2], searchers[:, 3])


def test_the_first_place_is_the_target() -> None:
    cue = Redetection()
    model = cue.learn(picture(60, 60), LAST)
    frame = picture(220, 140)
    rng, searchers = np.random.default_rng(1), start()
    near = 0
    for missed in range(20, 40):
        searchers, places = cue.step(rng, model, searchers, frame, LAST, missed)
        near += np.hypot(places[0].x - 220, places[0].y - 140) < 12
    assert near >= 15
    # By then most of those who were not just sent out have gathered there.
    gathered = np.hypot(searchers[:, 0] - 220, searchers[:, 1] - 140) < SIDE
    assert gathered.mean() > 0.5


@pytest.mark.parametrize("quarters", [1, 2])
def test_one_of_the_places_is_turned_as_the_gradients_there_are(quarters: int) -> None:
    """A square that grows lighter to one side, in a frame that is turned by quarters."""
    y, x = np.mgrid[:120, :120].astype(float)
    gray = np.random.default_rng(3).uniform(90, 100, (120, 120))
    inside = (abs(x - 59.5) < 12) & (abs(y - 59.5) < 12)
    gray[inside] = 130 + 4 * (x - 59.5)[inside] + 2 * (y - 59.5)[inside]
    pixels = np.repeat(gray[:, :, None], 3, axis=2).astype(np.uint8)
    last = Ellipse(59.5, 59.5, 10.0, 10.0)
    cue, rng = Redetection(), np.random.default_rng(8)
    model = cue.learn(Frame(0, 0.0, pixels), last)
    turned = Frame(1, 0.04, np.ascontiguousarray(np.rot90(pixels, -quarters)))
    searchers = np.tile(np.array(last), (20, 1))
    places = [cue.step(rng, model, searchers, turned, last, 1)[1] for _ in range(200)]
    turns = np.array([[place.theta for place in each] for each in places])
    assert (turns[:, :-1] == 0).all()
    off = (turns[:, -1] - quarters * np.pi / 2 + np.pi) % (2 * np.pi) - np.pi
    assert np.mean(abs(off) < np.pi / 4) > 0.8
    assert abs(np.median(off)) < np.pi / 8
    assert off.std() > 0.05  # anywhere within a bin


def test_where_nothing_has_a_direction_any_turn_will_do() -> None:
    frame = Frame(0, 0.0, np.full((120, 120, 3), 100, np.uint8))
    last, cue, rng = Ellipse(59.5, 59.5, 10.0, 10.0), Redetection(), np.random.default_rng(8)
    model, searchers = cue.learn(frame, last), np.tile(np.array(last), (20, 1))
    turns = [cue.step(rng, model, searchers, frame, last, 1)[1][-1].theta for _ in range(200)]
    assert np.histogram(turns, 4, (-np.pi / 16, 2 * np.pi - np.pi / 16))[0].min() > 30


def test_another_color_speaks_against_a_place_by_the_weight_of_a_search_particle() -> None:
    cue, frame = Redetection(), picture(60, 60)
    model = cue.updated(cue.learn(frame, LAST), frame, LAST, 0.05)  # the first counts as a whole
    assert cue.log_odds(model, frame, LAST) == 0
    red = frame.pixels.copy()
    red[48:72, 48:72, 1:] //= 4
    tinted = Frame(1, 0.04, red)
    strict = cue.log_odds(model, tinted, LAST)
    assert strict < -3
    model = cue.updated(model, tinted, LAST, 0.05)  # and the second one half
    assert cue.log_odds(model, tinted, LAST) == pytest.approx(strict / 2)
    for _ in range(100):  # the target has been red for long
        model = cue.updated(model, tinted, LAST, 0.05)
    assert cue.log_odds(model, tinted, LAST) == pytest.approx(0, abs=0.05)
    assert cue.log_odds(model, frame, LAST) == 0  # and is as likely as it was at first


def test_searchers_stay_in_the_frame() -> None:
    frame, cue = picture(60, 60), Redetection()
    model = cue.learn(frame, LAST)
    corner = LAST._replace(x=2.0, y=197.0)
    given = np.tile(np.array(corner), (400, 1))
    searchers, places = cue.step(np.random.default_rng(6), model, given, frame, corner, 50)
    for x, y in [*searchers[:, :2].tolist(), *(place[:2] for place in places)]:
        assert 0 <= x <= 299
        assert 0 <= y <= 199
