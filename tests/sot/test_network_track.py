"""A trained network beside the particles: where both agree, where they part, and who gives way."""

import math
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Discriminative, OpenCVTracker, Status, Tracker
from motes.core.errors import ConfigError, FormatError, SourceError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box, Ellipse, iou
from motes.core.types import Singles
from motes.sot.discriminative.exclusion import Taken
from motes.sot.discriminative.network_track import AGREES, NetworkTrack
from motes.sot.discriminative.redetection import MIN_HALF_AXIS
from motes.sot.discriminative.report import at_region
from motes.sot.discriminative.rival import Rival
from motes.sot.discriminative.standing import FRAMES, Standing
from motes.sot.network.network import Network
from motes.sot.network.view import Choice, NetworkView
from onnx_trackers import save_pair

BOX = Box(60.0, 50.0, 30.0, 30.0)
AWAY = Ellipse(215.0, 135.0, 15.0, 15.0)
"""Where neither the particles' window nor the network's region shows the target."""


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


@pytest.fixture
def network(tmp_path: Path) -> Network:
    return Network(save_pair(tmp_path))


class Reds(Network, frozen=True):
    """A network that sees what is red near by, and else stays where it is, as sure as can be."""

    def open(self) -> str:
        """Return a name of its family."""
        return "reds"

    def learn(self, frame: Frame, ellipse: Ellipse) -> Singles:
        """Return any model."""
        return np.zeros((1, 1, 1, 1), np.float32)

    def look(self, template: Singles, frame: Frame, place: Ellipse) -> NetworkView:
        """Return one box."""
        rows, columns = np.nonzero(frame.pixels[:, :, 0] > 200)
        x, y = columns.mean(), rows.mean()
        near = np.hypot(x - place.x, y - place.y) < 2 * place.side
        seen = place._replace(x=x, y=y) if near else place
        one = np.ones(1)
        return NetworkView(np.array([seen.box]), one, one, seen.box[2:], Choice())


REDS = Reds(("reds.onnx",))


def begun(*, backward: bool = False) -> tuple[Tracker, list[Frame]]:
    """Return a tracker after two frames, and the frames after these."""
    frames = film(9)[:: -1 if backward else 1]
    tracker = Tracker(Discriminative(network=REDS), backward=backward)
    tracker.init(frames[0], truth(frames[0]))
    tracker.update(frames[1])
    return tracker, frames[2:]


def truth(frame: Frame) -> Box:
    """Return the box of the square."""
    return BOX._replace(x=BOX.x + 2 * frame.index)


def test_a_network_puts_nobody_where_another_target_is() -> None:
    """Where both agree, the network alone finds a lost target again, but not at another one."""
    tracker, frames = begun()
    there = Ellipse.from_box(truth(frames[0]))
    lost = replace(tracker._state, standing=Standing(Status.SEARCHING, FRAMES))
    for taken, found in ((Taken(), True), (Taken((there,)), False)):
        state = replace(lost, taken=taken)
        after, _ = tracker._stepped(frames[0], state)
        assert (after.standing.status is Status.TRACKING) is found
        assert after.taken == Taken()


def test_the_box_is_between_that_of_the_tracker_and_that_of_the_network(network: Network) -> None:
    """The pair's boxes are constants, 64 pixels of its input wide and high."""
    frames = film(2)
    alone, joined = Tracker(), Tracker(Discriminative(network=network))
    for tracker in (alone, joined):
        tracker.init(frames[0], BOX)
    own, both = alone.update(frames[1]), joined.update(frames[1])
    seen = joined._state.network
    low, high = sorted((own.ellipse.a, seen.place.a))
    assert low < both.ellipse.a < high
    assert both.ellipse.a != pytest.approx(own.ellipse.a, rel=1e-3)
    assert both.confidence == pytest.approx((own.confidence * seen.score) ** 0.5)
    info = joined.info
    np.testing.assert_allclose(info.weights @ info.ellipses[:, :4], both.ellipse[:4], rtol=1e-3)


def test_particles_are_reported_where_the_box_is() -> None:
    """Moved, scaled and turned as the particles' own estimate is to become the region."""
    tracker, frames = begun()
    own = tracker.update(frames[0]).ellipse
    info = replace(tracker.info, ellipses=np.array([own, own._replace(x=own.x + 3, a=own.a / 2)]))
    region = Ellipse(own.x + 5, own.y - 2, 1.5 * own.a, 2 * own.b, own.theta + 0.1)
    moved = at_region(info, region, 0.25, Status.OCCLUDED)
    expected = [region, region._replace(x=region.x + 3, a=region.a / 2)]
    assert moved.ellipses == pytest.approx(np.array(expected))
    assert (moved.track.ellipse, moved.track.confidence) == (region, 0.25)


def test_a_doubt_who_it_is_lowers_the_confidence_and_moves_no_box(network: Network) -> None:
    frames = film(2)
    sure, doubting = (Tracker(Discriminative(network=network)) for _ in range(2))
    for tracker in (sure, doubting):
        tracker.init(frames[0], BOX)
    state = doubting._state
    alike = np.tile(state.belief.first, (len(state.belief.neighbors), 1))
    twins = replace(state.belief, lead=-0.3, neighbors=alike)
    doubting._state = replace(state, belief=twins)
    one, other = sure.update(frames[1]), doubting.update(frames[1])
    assert one.ellipse == other.ellipse
    assert other.confidence < 0.5 * one.confidence


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


@pytest.mark.parametrize("backward", [False, True])
def test_a_network_that_is_elsewhere_begins_again_where_the_particles_are(
    *, backward: bool
) -> None:
    tracker, frames = begun(backward=backward)
    state = tracker._state
    tracker._state = replace(state, network=state.network.placed(AWAY))
    for count, frame in enumerate(frames, 1):
        track = tracker.update(frame)
        assert iou(track.box, truth(frame)) > 0.7
        near = iou(tracker._state.network.place.box, track.box) > AGREES
        assert bool(near) is (count >= FRAMES)
        assert (track.confidence > 0.5) is (count > FRAMES)
        assert (track.status is Status.TRACKING) is (count < FRAMES or count >= 2 * FRAMES)


def test_particles_that_are_elsewhere_begin_again_where_the_network_is() -> None:
    tracker, frames = begun()
    state = tracker._state
    tracker._state = replace(state, ellipse=AWAY, rival=Rival(AWAY))
    for frame in frames[:FRAMES]:
        assert iou(tracker._state.ellipse.box, truth(frame)) == 0
        track = tracker.update(frame)
        assert iou(track.box, truth(frame)) > 0.7
        assert math.isnan(track.belief)  # of who is at the network's place, nothing is known
    assert tracker._state.ellipse == tracker._state.network.place == track.ellipse


def test_only_frames_in_a_row_decide_between_them() -> None:
    track = NetworkTrack(np.zeros((1, 1, 1, 1), np.float32), AWAY)
    for lead in (1.0, 5.0, -0.1, -3.0, 2.0, 0.1):
        track = track.compared(lead)
        assert track.ahead is (lead > 0)
        assert not track.decided
    assert not track.agreed().compared(1.0).decided
    assert track.compared(0.5).decided


def test_a_corrected_target_is_where_the_network_looks_next() -> None:
    tracker, _ = begun()
    lost = replace(tracker._state.network, standing=Standing(Status.LOST))
    tracker._state = replace(tracker._state, network=lost)
    tracker.correct(AWAY.box)
    network = tracker._state.network
    assert (network.place, network.standing) == (AWAY, Standing())


@pytest.mark.parametrize("saved", [False, True])
def test_a_state_belongs_to_a_tracker_with_a_network_or_without(
    network: Network, tmp_path: Path, *, saved: bool
) -> None:
    joined, alone = Tracker(Discriminative(network=network)), Tracker()
    for tracker in (joined, alone):
        tracker.init(film(1)[0], BOX)
    given, other = (joined, alone) if saved else (alone, joined)
    given.config = other.config
    given.save(tmp_path / "state")
    with pytest.raises(FormatError, match="network"):
        Tracker.load(tmp_path / "state")


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


def test_its_place_stays_in_the_frame() -> None:
    frame = film(1)[0]
    track = NetworkTrack.begin(REDS, frame, Ellipse(500.0, -20.0, 130.0, 1.0))
    assert track.followed(REDS, frame).place == Ellipse(239.0, 0.0, 120.0, MIN_HALF_AXIS)
