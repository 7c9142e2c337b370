"""The default tracker: on every kind of target, behind things, out of the frame and back."""

import math
import weakref
from io import BytesIO
from itertools import islice
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from motes import Discriminative, Status, Track, Tracker
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box, Ellipse, iou
from motes.cues.color import borders
from motes.sot.discriminative import placing
from motes.sot.discriminative.expert import Evidence
from motes.sot.discriminative.localization import WindowEstimate, localize
from motes.sot.discriminative.placing import TURN, Found, turned
from motes.sot.discriminative.prediction import Transition
from motes.sot.discriminative.redetection import Redetection
from motes.sot.discriminative.report import particles_of, report
from motes.sot.discriminative.rival import DECIDED, Rival
from motes.sot.discriminative.standing import FRAMES, Standing
from motes.synthetic.pitch import Pitch
from motes.synthetic.street import Street
from textured import blocks

Pixels = NDArray[np.uint8]
Place = tuple[float, float]


def wall(height: int, width: int) -> Pixels:
    """Return a dull texture."""
    return blocks(11, height, width, 8, (60, 60, 60), (120, 120, 120))


def coat(height: int, width: int) -> Pixels:
    """Return a bright texture of some six blocks to a side."""
    side = max(min(height, width) // 6, 1)
    return blocks(7, height, width, side, (120, 60, 0), (255, 160, 120))


def film(
    places: list[Place], size: tuple[int, int], background: Pixels, bar: Box | None = None
) -> tuple[list[Frame], list[Box]]:
    """Return frames with a coat of `size` (w, h) centered at each place, and its boxes.

    A bar hides what is behind it.
    """
    frames, boxes = [], []
    width, height = size
    target = Image.fromarray(coat(height, width))
    for index, (x, y) in enumerate(places):
        picture = Image.fromarray(background).copy()
        left, top = round(x - (width - 1) / 2), round(y - (height - 1) / 2)
        picture.paste(target, (left, top))
        if bar is not None:
            x0, y0, w, h = map(round, bar)
            picture.paste((70, 75, 80), (x0, y0, x0 + w, y0 + h))
        frames.append(Frame(index, index * FRAME_INTERVAL, np.array(picture)))
        boxes.append(Box(left, top, width, height))
    return frames, boxes


def follow(frames: list[Frame], box: Box) -> list[Track]:
    tracker = Tracker()
    return [tracker.init(frames[0], box)] + [tracker.update(each) for each in frames[1:]]


def colorless(frames: list[Frame]) -> list[Frame]:
    return [Frame(each.index, each.time, each.pixels.mean(2).astype(np.uint8)) for each in frames]


def circle(middle: Place, radius: float, count: int) -> list[Place]:
    x, y = middle
    turns = [step / 8 for step in range(count)]
    return [(x + radius * math.sin(t), y + radius * (1 - math.cos(t))) for t in turns]


@pytest.mark.slow
@pytest.mark.parametrize("gray", [False, True], ids=["color", "gray"])
@pytest.mark.parametrize(
    ("size", "frame"),
    [((8, 8), (160, 120)), ((12, 60), (320, 240)), ((160, 120), (320, 240))],
    ids=["8 pixels", "thin", "half of the frame"],
)
def test_follows_targets_of_every_size(
    size: tuple[int, int], frame: tuple[int, int], gray: bool
) -> None:
    background = wall(frame[1], frame[0])
    places = circle((frame[0] / 2, frame[1] / 2), min(size) / 2, 20)
    frames, boxes = film(places, size, background)
    if gray:
        frames = colorless(frames)
    tracks = follow(frames, boxes[0])
    overlaps = [float(iou(track.box, box)) for track, box in zip(tracks, boxes, strict=True)]
    assert min(overlaps) > 0.6
    assert {track.status for track in tracks} == {Status.TRACKING}


@pytest.mark.slow
def test_a_hidden_target_is_lost_and_found_again() -> None:
    """It is behind a bar in frames 20 to 39, of which nothing is learned, and comes out."""
    x = np.concatenate([np.linspace(40, 150, 21), np.full(18, 150.0), np.linspace(150, 260, 21)])
    places = [(value, 100.0) for value in x.tolist()]
    frames, boxes = film(places, (30, 40), wall(200, 320), Box(125, 60, 50, 80))
    tracker = Tracker()
    tracks, learned = [tracker.init(frames[0], boxes[0])], [True]
    for frame in frames[1:]:
        before = tracker.info.models["correlation"]
        tracks.append(tracker.update(frame))
        learned.append(tracker.info.models["correlation"] is not before)
    assert {track.status for track in tracks[:15]} == {Status.TRACKING}
    assert Status.LOST in {track.status for track in tracks[18:32]}
    assert {track.status for track in tracks[30:38]} == {Status.SEARCHING}
    assert all(learned[3:13])
    assert not any(learned[27:37])
    assert {track.status for track in tracks[-8:]} == {Status.TRACKING}
    # What is found is believed after three frames, and then learned.
    there = [i for i in range(41, 60) if iou(tracks[i].box, boxes[i]) > 0.5]
    waited = [(tracks[i].status, learned[i]) for i in there]
    assert waited[:2] == [(Status.SEARCHING, False)] * 2
    assert (Status.TRACKING, True) in waited[2:4]
    assert iou(tracks[-1].box, boxes[-1]) > 0.6


@pytest.mark.slow
def test_a_car_of_another_color_is_not_taken_for_the_one_that_is_hidden() -> None:
    """A red car goes behind a lorry; a black one of the same shape comes before it is out."""
    tracker, found = Tracker(seed=0), []
    for index, (frame, (truth, *_)) in enumerate(Street()):
        track = tracker.update(frame) if index else tracker.init(frame, truth.ellipse)
        if truth.visible > 0.5:
            found.append(iou(track.box, truth.ellipse.box) > 0.5)
    assert np.mean(found) > 0.85


def test_a_turned_region_stays_turned() -> None:
    frames, boxes = film(circle((160.0, 100.0), 15, 10), (40, 40), wall(240, 320))
    region = Ellipse.from_box(boxes[0])._replace(a=22.0, b=14.0, theta=0.6)
    tracker = Tracker()
    tracker.init(frames[0], region)
    for frame in frames[1:]:
        track = tracker.update(frame)
    assert track.ellipse.theta == pytest.approx(0.6, abs=0.01)
    assert track.ellipse.a / track.ellipse.b == pytest.approx(22 / 14)
    center = boxes[-1].x + 19.5, boxes[-1].y + 19.5
    assert track.ellipse[:2] == pytest.approx(center, abs=3)


def spinning(degrees: float, count: int) -> list[Frame]:
    """Return frames with a long striped oval that turns about its center, (160, 120)."""
    stripes = np.zeros((81, 81, 3), np.uint8)
    stripes[:, np.arange(81) % 12 < 6] = (230, 190, 40)
    stripes[:, 52:] = (200, 60, 30)
    background, target = Image.fromarray(wall(240, 320)), Image.fromarray(stripes)
    oval = Image.new("L", (81, 81))
    ImageDraw.Draw(oval).ellipse((8, 24, 72, 56), fill=255)
    frames = []
    for index in range(count):
        picture, turn = background.copy(), (-index * degrees, Image.Resampling.BILINEAR)
        picture.paste(target.rotate(*turn), (120, 80), oval.rotate(*turn))
        frames.append(Frame(index, index * FRAME_INTERVAL, np.array(picture)))
    return frames


@pytest.mark.parametrize(
    ("degrees", "window", "prior", "theta"),
    [
        (20.0, 0.0, -2.0, TURN),
        (-20.0, 0.0, -2.0, -TURN),
        (0.0, 0.0, -2.0, 0.0),
        (0.0, 4 * TURN, -2.0, 0.0),  # not by a step back: its angle is that of the first frame
        (57.0, 4 * TURN, -2.0, 4 * TURN),  # it is turned by as much
        (20.0, 0.0, -30.0, 0.0),  # it is not seen, turned or not
    ],
)
def test_a_target_is_seen_as_it_is_turned(
    degrees: float, window: float, prior: float, theta: float
) -> None:
    frames, config = spinning(degrees, 2), Discriminative(evidence=Evidence(prior=prior))
    rng, region = np.random.default_rng(0), Ellipse.from_box(Box(128.0, 104.0, 65.0, 33.0))
    state, _ = config.init(rng, frames[0], region)
    place = state.ellipse._replace(theta=window)
    sights = config.experts.look(state.experts, frames[1], place)
    look = localize(config, rng, state, frames[1], place, sights)
    found = turned(config, rng, state, frames[1], look)
    assert found.pose.theta == theta
    assert found.evidence >= look.evidence
    assert found.pose[:2] == pytest.approx((160, 120), abs=3)


def begun(config: Discriminative, places: list[Place]) -> tuple[list[Frame], Any, Any]:
    """Return a film of two frames, its random numbers, and the state after the first."""
    frames, boxes = film(places, (30, 40), wall(240, 320))
    rng = np.random.default_rng(0)
    return frames, rng, config.init(rng, frames[0], Ellipse.from_box(boxes[0]))[0]


def test_a_lost_target_is_followed_by_what_is_most_like_it() -> None:
    """It may only look different for a while, and must not be left behind."""
    config = Discriminative(evidence=Evidence(prior=-30.0))
    frames, rng, state = begun(config, [(160.0, 100.0), (168.0, 100.0)])
    state = replace(state, standing=Standing(Status.SEARCHING, missed=5))
    after, info = config.step(rng, state, frames[1])
    assert (after.standing.status, after.standing.missed) == (Status.SEARCHING, 6)
    assert after.ellipse[:2] == pytest.approx((168.0, 100.0), abs=1)
    assert info.track.ellipse[:2] == pytest.approx(after.ellipse[:2])
    assert after.correlation is state.correlation  # nothing is learned
    assert len(info.ellipses) == config.particles  # those of the search


@pytest.mark.parametrize(("log_odds", "statuses"), [(0.4, "tttt"), (-1.3, "ttls")])
def test_a_target_is_lost_once_that_is_decided(log_odds: float, statuses: str) -> None:
    """In between it is tracked with a confidence below one half, as when half of it is hidden."""
    frames, boxes = film([(160.0, 100.0)] * 5, (30, 40), wall(240, 320))
    clear = Evidence().prior + math.log(1 / follow(frames[:2], boxes[0])[1].confidence - 1)
    tracker = Tracker(Discriminative(evidence=Evidence(prior=clear + log_odds)))
    tracker.init(frames[0], boxes[0])
    tracks = [tracker.update(each) for each in frames[1:]]
    assert "".join(each.status[0] for each in tracks) == statuses
    assert all(each.confidence < 0.5 for each in tracks[1:])


@pytest.mark.slow
def test_a_twin_near_by_is_not_taken_for_the_target() -> None:
    """The target passes another one just like it."""
    places = [(100.0 + 3 * index, 100.0) for index in range(40)]
    frames, boxes = film(places, (30, 40), wall(240, 320))
    for frame in frames:
        frame.pixels[136:176, 160:190] = coat(40, 30)
    tracks = follow(frames, boxes[0])
    overlaps = [float(iou(track.box, box)) for track, box in zip(tracks, boxes, strict=True)]
    assert min(overlaps) > 0.5


def test_nothing_is_learned_while_a_rival_lives() -> None:
    config = Discriminative()
    frames, rng, state = begun(config, [(160.0, 100.0)] * 2)
    still = frames[1].pixels.copy()
    twin = coat(40, 30)
    frames[1].pixels[80:120, 200:230] = twin
    rival = Rival(state.ellipse._replace(x=214.5, y=99.5), 0.0, alive=True)
    after, _ = config.step(rng, replace(state, rival=rival), frames[1])
    assert after.rival.alive
    assert after.rival.place[:2] == pytest.approx((214.5, 99.5), abs=2)
    assert after.correlation is state.correlation
    assert after.experts["confined"] is state.experts["confined"]
    alone, _ = config.step(rng, state, Frame(1, FRAME_INTERVAL, still))
    assert not alone.rival.alive
    assert alone.experts["confined"] is not state.experts["confined"]


def test_a_rival_with_more_evidence_becomes_the_target() -> None:
    """As when a place on the background is followed by mistake."""
    config = Discriminative()
    frames, rng, state = begun(config, [(160.0, 100.0)] * 2)
    wrong = replace(state, ellipse=state.ellipse._replace(x=110.0))
    after, info = config.step(rng, wrong, frames[1])
    assert after.ellipse[:2] == pytest.approx((160.0, 100.0), abs=2)
    assert not after.rival.alive
    assert info.track.status is Status.TRACKING


HERE, THERE = Ellipse(50.0, 50.0, 10.0, 10.0), Ellipse(90.0, 50.0, 10.0, 10.0)
FRAME = Frame(0, 0.0, np.zeros((100, 150, 3), np.uint8))


def estimate(place: Ellipse, evidence: float) -> Any:
    return SimpleNamespace(pose=place, evidence=evidence, sights={})


def compared(
    state: Any, here: Any, there: Any, transition: Transition | None = None, given: Any = None
) -> Found:
    """Return what becomes of a place that is followed and of another one, which is looked at."""
    config, frame = (given or (Discriminative(), FRAME))[:2]
    places = [] if state.rival.alive else [there.pose]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(placing, "localize", lambda *_: there)
        return placing._compare(
            config, np.random.default_rng(0), state, frame, here, np.zeros(2), places, transition
        )


@pytest.mark.parametrize(
    ("here", "there", "transition", "wins"),
    [
        (0.1, 4.5, None, False),  # what is followed looks like the target: the other is a neighbor
        (0.1, 4.5, Transition(50.0, 50.0, 200.0), False),
        (0.0, 1.5, None, True),  # it does not any more
        (-1.0, 0.5, Transition(50.0, 50.0, 2.0), True),  # it is not where it was expected
    ],
)
def test_a_rival_wins_only_where_the_target_is_seen_no_more(
    here: float,
    there: float,
    transition: Transition | None,
    wins: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Redetection, "log_odds", lambda *_: 0.0)
    state = SimpleNamespace(rival=Rival(HERE), appearance=None)
    found = compared(state, estimate(HERE, here), estimate(THERE, there), transition)
    assert (found.estimate.pose == THERE) is wins
    assert found.rival.alive is not wins


@pytest.mark.parametrize(
    ("sigma", "lead"),
    [(2.0, -DECIDED), (40.0, -0.5), (400.0, -0.005)],  # it is the likelier the more erratic
)
def test_a_rival_begins_with_the_odds_of_a_leap(sigma: float, lead: float) -> None:
    state, leap = SimpleNamespace(rival=Rival(HERE)), Transition(50.0, 50.0, sigma)
    found = compared(state, estimate(HERE, 1.0), estimate(THERE, 1.5), leap)
    assert found.rival.lead == pytest.approx(lead + 0.5)


def test_a_rival_with_clearly_less_evidence_is_given_up() -> None:
    """Else nothing would ever be learned again beside a neighbor who stays."""
    for evidence, alive in ((0.1, True), (-0.1, False)):
        state = SimpleNamespace(rival=Rival(THERE, 0.0, alive=True))
        found = compared(state, estimate(HERE, 1.0), estimate(THERE, evidence))
        assert found.rival.alive is alive


def test_a_team_mate_does_not_take_over() -> None:
    """Before and behind each other in a film of few details, where they look alike."""
    tracker, overlaps = Tracker(), list[float]()
    for frame, (truth, *_) in islice(Pitch(), 20, 65):
        jpeg = BytesIO()
        Image.fromarray(frame.pixels).save(jpeg, "JPEG", quality=4)
        frame = Frame(frame.index, frame.time, np.array(Image.open(jpeg)))
        place = truth.ellipse
        track = tracker.update(frame) if overlaps else tracker.init(frame, place)
        overlaps.append(float(iou(track.box, place.box)))
    assert min(overlaps) > 0.5


RED, BLACK = Ellipse(40.0, 50.0, 12.0, 8.0), Ellipse(100.0, 50.0, 12.0, 8.0)


def seen_at(place: Ellipse, evidence: float) -> Any:
    return WindowEstimate(place, *[None] * 6, place, *[None] * 3, evidence)  # type: ignore


@pytest.fixture
def cars() -> tuple[Discriminative, Frame, Any]:
    """Return two cars of one shape; the red one was there first, the black one is followed."""
    pixels = np.full((100, 150, 3), 120, np.uint8)
    pixels[42:59, 28:53], pixels[42:59, 88:113] = (200, 30, 30), (20, 20, 30)
    frame, redetection = Frame(0, 0.0, pixels), Redetection()
    appearance = redetection.updated(redetection.learn(frame, RED), frame, RED, 0.05)
    state = SimpleNamespace(
        appearance=appearance,
        search_particles=np.empty((0, 5)),
        ellipse=BLACK,
        standing=Standing(missed=5),
    )
    return Discriminative(particles=100, redetection=redetection), frame, state


@pytest.mark.parametrize(("there", "clear"), [(RED, True), (BLACK, False)])
def test_the_search_finds_what_looks_like_the_first_region(
    there: Ellipse, clear: bool, cars: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As likely by all other voices."""
    config, frame, lost = cars
    windows = list[weakref.ref[Any]]()

    def seen(place: Ellipse, evidence: float) -> Any:
        window = np.zeros((1, 1, 1), np.float32)
        windows.append(weakref.ref(window))
        assert sum(each() is not None for each in windows) <= 2  # the best one's, and a new one's
        return WindowEstimate(place, window, *[None] * 5, place, *[None] * 3, evidence)  # type: ignore

    monkeypatch.setattr(placing, "localize", lambda *_: seen(there, 2.0))
    before = Found(seen(HERE, -1.0), Rival(HERE))
    windows.clear()
    found = placing.search(config, np.random.default_rng(0), lost, frame, before)
    assert found.jumped is clear
    assert found.estimate.pose == (there if clear else HERE)


def test_the_search_goes_on_from_its_particles_and_reaches_farther_in_each_frame(
    cars: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, frame, lost = cars
    moved, asked = np.ones((100, 5)), list[tuple[Any, ...]]()

    def step(*given: Any) -> tuple[Any, list[Ellipse]]:
        asked.append(given)
        return moved, [HERE]

    monkeypatch.setattr(Redetection, "step", step)
    monkeypatch.setattr(placing, "localize", lambda *_: seen_at(HERE, 0.9))  # not decided
    found = Found(seen_at(THERE, -1.0), Rival(THERE))
    for missed in (0, 1):
        lost.standing = Standing(missed=missed)
        found = placing.search(config, np.random.default_rng(0), lost, frame, found)
        lost.search_particles = found.searchers
    assert found.estimate.pose == THERE
    (*_, first, _, _, once), (*_, second, _, _, twice) = asked
    assert (first == np.array(BLACK)).all()  # where it was last
    assert second is moved
    assert (once, twice) == (1, 2)


def test_the_search_takes_its_best_look(cars: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    config, frame, lost = cars
    told = list[float]()

    def seen(*_: object) -> Any:
        told.append((2.0, 4.0, 3.0)[len(told) % 3])
        return seen_at(RED, told[-1])

    monkeypatch.setattr(placing, "localize", seen)
    before = Found(estimate(HERE, -1.0), Rival(HERE))
    found = placing.search(config, np.random.default_rng(0), lost, frame, before)
    assert len(told) > 1
    likeness = config.redetection.log_odds(lost.appearance, frame, RED)
    assert found.estimate.evidence == max(told) + likeness


@pytest.mark.parametrize(
    ("here", "there", "evidence", "wins"),
    [
        (RED, BLACK, 2.0, False),
        (HERE._replace(y=15.0), THERE._replace(y=15.0), 2.0, True),  # neither does
        (BLACK, RED, 2.0, True),
        (BLACK, RED, 0.5, False),  # the histograms alone do not decide
    ],
)
def test_a_rival_has_to_look_like_the_first_region(
    here: Ellipse, there: Ellipse, evidence: float, wins: bool, cars: Any
) -> None:
    state = cars[2]
    state.rival = Rival(here)
    found = compared(state, estimate(here, 0.0), estimate(there, evidence), given=cars)
    assert (found.estimate.pose == there) is wins


def test_in_a_gray_film_texture_tells_the_place_and_gray_the_border() -> None:
    """Before gray stripes, finer ones."""
    stripes = np.tile(np.where(np.arange(200) // 8 % 2 == 0, 140, 100), (150, 1))
    stripes[50:90, 70:120] = np.where(np.arange(50) // 2 % 2 == 0, 140, 100)
    frame = Frame(0, 0.0, stripes[..., None].repeat(3, axis=2).astype(np.uint8))
    config, rng, place = Discriminative(), np.random.default_rng(0), Ellipse(95, 70, 25, 20)
    state, _ = config.init(rng, frame, place)
    sights = config.experts.look(state.experts, frame, place)
    look = localize(config, rng, state, frame, place, sights)
    assert min(state.contrast, look.contrast) > 0.5
    gray = config.posterior.integral(state.posterior, look.window)
    middle = np.array([0.0, 0.0, *state.correlation.grid.half])
    np.testing.assert_array_equal(look.integral, gray)
    np.testing.assert_array_equal(state.border, borders(gray, middle[None])[0])


def test_fewer_particles_where_the_place_is_clear() -> None:
    frames, boxes = film([(160.0, 100.0)] * 2, (30, 40), wall(240, 320))
    config, rng = Discriminative(), np.random.default_rng(0)
    state, _ = config.init(rng, frames[0], Ellipse.from_box(boxes[0]))
    empty = Frame(1, FRAME_INTERVAL, wall(240, 320))

    def count(frame: Frame) -> int:
        sights = config.experts.look(state.experts, frame, state.ellipse)
        look = localize(config, rng, state, frame, state.ellipse, sights)
        return len(look.centers)

    clear, unclear = ([count(frame) for _ in range(9)] for frame in (frames[1], empty))
    assert max(clear) == config.particles // 4
    assert config.particles // 4 < np.mean(unclear) <= config.particles


@pytest.mark.parametrize("missed", [0, FRAMES])
def test_the_particles_of_a_search_are_reported_while_it_goes_on(missed: int) -> None:
    (frame,), config = spinning(0.0, 1), Discriminative()
    region, rng = Ellipse.from_box(Box(128.0, 104.0, 65.0, 33.0)), np.random.default_rng(0)
    state, _ = config.init(rng, frame, region)
    sights = config.experts.look(state.experts, frame, state.ellipse)
    look = localize(config, rng, state, frame, state.ellipse, sights)
    searched = np.tile(np.array(state.ellipse), (3, 1))
    state = replace(state, search_particles=searched, standing=Standing(missed=missed))
    info = report(config, state, frame, look, particles_of(look, state, state.ellipse))
    assert len(info.ellipses) == (3 if missed else len(look.centers))
