"""The experts of the default tracker: what each says, and what models learn of two looks."""

import math
from typing import Any

import numpy as np
import pytest

from motes import ConfigError, Discriminative, Ellipse, Status, Tracker
from motes.core.config import Config, from_dict, from_toml
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.cues.base import Cue
from motes.cues.color import Color, Posterior
from motes.cues.correlation_filter import Correlation
from motes.sot.discriminative.expert import Confined, Evidence, Expert, Experts, probability
from motes.sot.discriminative.standing import Standing
from motes.testing import check_expert

PLACE = Ellipse(120.0, 90.0, 15.0, 12.0)


def picture(x: float = PLACE.x, y: float = PLACE.y, *, gray: bool = False) -> Frame:
    """Return a frame with a red-and-yellow target before gray noise."""
    pixels = np.random.default_rng(3).integers(90, 130, (180, 240, 1), np.uint8).repeat(3, axis=2)
    blocks = np.random.default_rng(5).integers(0, 2, (4, 5)).repeat(6, axis=0).repeat(6, axis=1)
    target = np.where(blocks[..., None], (230, 60, 40), (200, 170, 20)).astype(np.uint8)
    top, left = round(y - 11.5), round(x - 14.5)
    pixels[top : top + 24, left : left + 30] = (
        target.mean(axis=2, keepdims=True) if gray else target
    )
    return Frame(0, 0.0, pixels)


class Sure(Expert, Config, frozen=True):
    """An expert that says the same of all places, and proposes one."""

    says: float = 0.0
    place: tuple[float, float] | None = None

    def learn(self, frame: Frame, box: Ellipse) -> Any:
        """Return any model."""
        return Color().learn(frame, box)

    def look(self, model: Any, frame: Frame, place: Ellipse) -> Ellipse:
        """Return the place."""
        return place

    def log_odds(self, sight: Ellipse, place: Ellipse) -> float:
        """Return what it always says."""
        return self.says

    def proposes(self, sight: Ellipse) -> Ellipse | None:
        """Return its place."""
        return sight._replace(x=self.place[0], y=self.place[1]) if self.place else None


def test_it_keeps_the_rules() -> None:
    check_expert(Confined())


def test_it_can_be_switched_off() -> None:
    none = {"confined": {"weight": 0.0}, "backdrop": {"weight": 0.0}}
    off: Discriminative = from_dict(none, Discriminative)
    assert off.experts.named == {}
    assert from_dict(from_toml(off.to_toml(), "it"), Discriminative) == off
    tracker = Tracker(off)
    tracker.init(picture(), PLACE)
    track = tracker.update(Frame(1, FRAME_INTERVAL, picture(124.0).pixels))
    assert track.ellipse[:2] == pytest.approx((124.0, PLACE.y), abs=1.5)


def test_log_odds_are_added() -> None:
    together = Experts({"a": Sure(1.5), "b": Sure(-0.5), "c": Sure()})
    frame = picture()
    sights = together.look(together.learn(frame, PLACE), frame, PLACE)
    assert together.log_odds(sights, PLACE) == 1.0
    assert together.proposals(sights) == []


class NumpySure(Sure, frozen=True):
    """The same, with a NumPy number."""

    def log_odds(self, sight: Ellipse, place: Ellipse) -> float:
        """Return what it always says."""
        voice: float = np.float64(self.says)
        return voice


def test_a_numpy_number_is_a_number() -> None:
    """The status changed between tracking and lost in every third frame."""
    tracker = Tracker(Discriminative(extra_experts={"sure": NumpySure(1.0)}))
    tracker.init(picture(), PLACE)
    pixels = picture().pixels
    tracks = [tracker.update(Frame(n, n * FRAME_INTERVAL, pixels)) for n in range(1, 9)]
    assert {track.status for track in tracks} == {Status.TRACKING}


def sight_of(expert: Expert, frame: Frame) -> Any:
    return expert.look(expert.learn(picture(), PLACE), frame, PLACE)


def test_the_confined_filter_speaks_for_the_target_and_finds_it() -> None:
    confined = Confined()
    sight = sight_of(confined, picture(126.0, 96.0))
    assert confined.proposes(sight)[:2] == pytest.approx((126.0, 96.0), abs=1.5)
    target, beside = PLACE._replace(x=126.0, y=96.0), PLACE._replace(x=80.0)
    assert confined.log_odds(sight, target) > confined.log_odds(sight, beside) + 1


def test_an_expert_makes_the_tracker_surer_by_what_it_says() -> None:
    evidence = {}
    for says in (-1.0, 2.0):
        config = Discriminative(extra_experts={"sure": Sure(says)})
        rng = np.random.default_rng(0)
        state, _ = config.init(rng, picture(), PLACE)
        after, info = config.step(rng, state, Frame(1, FRAME_INTERVAL, picture().pixels))
        confidence = info.track.confidence / after.belief.probability
        evidence[says] = math.log(confidence / (1 - confidence))
    assert evidence[2.0] - evidence[-1.0] == pytest.approx(3.0)


@pytest.mark.parametrize("voice", ["gradients", "contrast"])
def test_each_voice_speaks_for_the_target(voice: str) -> None:
    said = {"gradients": 0.5, "contrast": 0.5}
    less, more = (said | {voice: value} for value in (0.2, 0.4))
    gained = Evidence().log_odds(**more) - Evidence().log_odds(**less)
    assert gained == pytest.approx(0.2 * getattr(Evidence(), voice))
    mute = Evidence(**{voice: 0.0})
    assert mute.log_odds(**more) == mute.log_odds(**less)


def test_probabilities_of_log_odds() -> None:
    assert probability(0.0) == 0.5
    assert probability(math.log(3)) == pytest.approx(0.75)
    assert 0 < probability(-1e9) < 1e-12 < 1 - 1e-12 < probability(1e9) <= 1


REGION = Ellipse(60, 50, 16, 20)
BOX = REGION.box


def look(seed: int, index: int = 0) -> Frame:
    """Return a frame with a target whose texture is drawn anew for each seed."""
    pixels = np.full((100, 120, 3), 90, np.uint8)
    blocks = np.random.default_rng(seed).integers(0, 256, (5, 4, 3), np.uint8)
    pixels[30:70, 44:76] = blocks.repeat(8, axis=0).repeat(8, axis=1)
    return Frame(index, index / 25, pixels)


@pytest.mark.parametrize("cue", [Color(), Correlation(), Posterior()])
def test_a_model_of_two_looks_is_near_to_both(cue: Cue) -> None:
    one, two, region = look(1), look(2), np.array([REGION])
    model = cue.learn(one, REGION)
    both = cue.learn_also(model, two, REGION)
    alone = [float(cue.distances(model, frame, region)[0]) for frame in (one, two)]
    found = [float(cue.distances(both, frame, region)[0]) for frame in (one, two)]
    assert alone[0] < 0.1 or cue == Posterior()
    assert found[1] < alone[1] - 0.1
    # The first look counts more in a correlation filter, whose first frame is its anchor.
    assert found[0] == pytest.approx(found[1], abs=0.3 if isinstance(cue, Correlation) else 0.05)


@pytest.mark.parametrize("name", ["default", "nummiaro", "mean_shift"])
def test_the_target_stays_where_it_is(name: str) -> None:
    tracker = Tracker(name)
    with pytest.raises(ConfigError, match="no target yet"):
        tracker.learn_also(look(2), BOX)
    before = tracker.init(look(1), BOX)
    alone = Tracker(name)
    alone.init(look(1), BOX)
    tracker.learn_also(look(2), BOX)
    assert tracker.info.track is before
    after = tracker.update(look(2, 1))
    assert after.ellipse[:2] == pytest.approx(REGION[:2], abs=2)
    assert after.distance < alone.update(look(2, 1)).distance or name == "default"
    with pytest.raises(ConfigError, match="outside the frame"):
        tracker.learn_also(look(2), (900, 900, 9, 9))


def test_another_expert_can_decide_between_two_places() -> None:
    """What it proposes is followed as a rival, and is lost without evidence."""
    far = (200.0, 40.0)
    config = Discriminative(extra_experts={"sure": Sure(place=far)})
    rng = np.random.default_rng(0)
    state, _ = config.init(rng, picture(), PLACE)
    after, info = config.step(rng, state, Frame(1, FRAME_INTERVAL, picture().pixels))
    assert info.track.ellipse[:2] == pytest.approx(PLACE[:2], abs=1)
    assert after.standing == Standing(confirmed=1)


def test_a_histogram_is_the_mean_and_its_anchor_stays() -> None:
    color = Color()
    one = color.learn(look(1), REGION)
    both = color.learn_also(one, look(2), REGION)
    seen = color.observe(one, look(2), REGION)
    assert both.histogram == pytest.approx((one.histogram + seen) / 2)
    assert both.anchor is one.anchor
    outside = Ellipse(-900, -900, 5, 5)
    assert color.learn_also(one, look(2), outside) is one
