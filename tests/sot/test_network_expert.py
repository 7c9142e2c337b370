"""A trained network as one more expert: its voice, its proportions, and where it is placed anew."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.errors import ConfigError, SourceError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box, Ellipse, iou
from motes.sot.discriminative.evidence import NEUTRAL
from motes.sot.discriminative.network_expert import NetworkExpert, NetworkSight, NetworkTarget
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.network.network import Network, NetworkModel
from motes.sot.network.view import Candidate, Choice, NetworkView
from motes.sot.opencv_api import OpenCVTracker
from motes.sot.tracker import Tracker
from onnx_trackers import save_pair

BOX = Box(60.0, 50.0, 30.0, 30.0)
PLACE = Ellipse.from_box(BOX)


def film(count: int) -> list[Frame]:
    """Return frames with a red square that moves to the right before gray noise."""
    rng = np.random.default_rng(0)
    ground = rng.integers(90, 130, (160, 240, 1), np.uint8).repeat(3, axis=2)
    frames = []
    for index in range(count):
        pixels = ground.copy()
        pixels[50:80, 60 + 2 * index : 90 + 2 * index] = (220, 30, 30)
        frames.append(Frame(index, index * FRAME_INTERVAL, pixels))
    return frames


def sight(box: Box, score: float = 0.9) -> NetworkSight:
    """Return what a network sees that sees one box."""
    one = np.ones(1)
    view = NetworkView(np.array([box]), score * one, one, (30.0, 30.0), Choice())
    return NetworkSight(view, Candidate(box, score))


EXPERT = NetworkExpert(Network(("none.onnx",)))


@pytest.fixture
def network(tmp_path: Path) -> Network:
    return Network(save_pair(tmp_path))


def test_its_score_is_a_voice_for_the_places_in_its_box() -> None:
    seen = sight(BOX)
    here, beside, away = (
        EXPERT.log_odds(seen, PLACE._replace(x=PLACE.x + shift)) for shift in (0.0, 15.0, 60.0)
    )
    assert here == pytest.approx(EXPERT.weight * (0.9 - NEUTRAL))
    assert here > beside > away == -EXPERT.weight * NEUTRAL


def test_it_follows_by_itself_until_the_evidence_has_decided_against_it() -> None:
    before = NetworkTarget(NetworkModel(np.zeros((1, 1, 1, 1), np.float32)), PLACE)
    wide = Box(100.0, 50.0, 40.0, 20.0)
    frame, found = film(1)[0], Ellipse(20.0, 30.0, 20.0, 20.0)

    def after(place: Ellipse, share: float) -> Ellipse:
        return EXPERT.updated(before, frame, sight(wide), place, share).place

    assert after(found, 0.0) == Ellipse.from_box(wide)
    placed = after(found, 1.0)
    assert placed[:2] == found[:2]
    assert placed.side == pytest.approx(found.side)
    near = Ellipse.from_box(wide._replace(x=104.0))
    assert after(near, 1.0) == Ellipse.from_box(wide)


def test_without_a_network_the_tracker_has_none() -> None:
    assert "network" not in Discriminative().experts.named


def test_a_network_makes_the_tracker_surer_of_what_it_sees(network: Network) -> None:
    frames, evidence = film(6), {}
    for joined in (None, network):
        tracker = Tracker(Discriminative(network=joined))
        tracker.init(frames[0], BOX)
        for frame in frames[1:]:
            track = tracker.update(frame)
        assert iou(track.box, BOX._replace(x=70.0)) > 0.5
        evidence[joined] = math.log(track.confidence / (1 - track.confidence))
    assert evidence[network] > evidence[None] + 0.5


def test_the_box_is_between_that_of_the_tracker_and_that_of_the_network(network: Network) -> None:
    """The pair's boxes are constants, 64 pixels of its input wide and high."""
    frames = film(2)
    alone, joined = Tracker(), Tracker(Discriminative(network=network))
    for tracker in (alone, joined):
        tracker.init(frames[0], BOX)
    own, both = alone.update(frames[1]), joined.update(frames[1])
    state = joined._state.experts["network"]
    low, high = sorted((own.ellipse.a, state.place.a))
    assert low < both.ellipse.a < high
    assert both.ellipse.a != pytest.approx(own.ellipse.a, rel=1e-3)
    info = joined.info
    np.testing.assert_allclose(info.weights @ info.ellipses[:, :4], both.ellipse[:4], rtol=1e-3)


def test_a_tracker_with_a_network_goes_on_after_it_was_saved(
    network: Network, tmp_path: Path
) -> None:
    frames = film(5)
    tracker = Tracker(Discriminative(network=network), seed=3)
    tracker.init(frames[0], BOX)
    tracker.update(frames[1])
    tracker.save(tmp_path / "state")
    loaded = Tracker.load(tmp_path / "state")
    for frame in frames[2:]:
        assert tracker.update(frame).ellipse == loaded.update(frame).ellipse


def test_a_corrected_target_is_where_the_network_looks_next(network: Network) -> None:
    frames = film(2)
    config, rng = Discriminative(network=network), np.random.default_rng(0)
    state, _ = config.init(rng, frames[0], PLACE)
    away = replace(state.experts["network"], place=PLACE._replace(x=200.0))
    lost = replace(state, experts=state.experts | {"network": away})
    corrected, _ = config.correct(lost, frames[0], PLACE)
    assert corrected.experts["network"].place == PLACE


def test_files_alone_name_a_network(network: Network) -> None:
    frames = film(2)
    tracker = Tracker(network=network.files)
    assert tracker.config == Discriminative(network=network)
    assert Tracker(network=",".join(network.files)).config == tracker.config
    peer = OpenCVTracker.create(network=network.files)
    peer.init(frames[0].pixels[:, :, ::-1], BOX)
    tracker.init(frames[0], BOX)
    peer.update(frames[1].pixels[:, :, ::-1])
    assert peer.tracker.info.track.ellipse == tracker.update(frames[1]).ellipse


def test_a_network_that_cannot_be_used_is_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="choose preset default"):
        Tracker("nummiaro", network=["a.onnx"])
    with pytest.raises(SourceError, match=r"a\.onnx"):
        Tracker(network=[str(tmp_path / "a.onnx")])
