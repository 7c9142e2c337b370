"""The belief that what is followed is the target, and not a neighbor who looks alike."""

import numpy as np
import pytest
from msgspec.structs import replace
from PIL import Image

from motes import Status, Track, Tracker
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box, Ellipse, iou
from motes.core.types import Bytes
from motes.sot.discriminative.belief import EVERY, MEMORY, Belief, distances, look_at
from textured import blocks

Color = tuple[int, int, int]

FRAMES = 86
STANDS, APART = 140, 56
"""The target's left edge, and a frame in which the other has left it."""


def person(trousers: Color) -> Bytes:
    """Return a bright texture, whose lower half is seen through a color."""
    pixels = blocks(7, 40, 30, 5, (120, 60, 0), (255, 160, 120)).copy()
    pixels[20:] = pixels[20:] * (np.array(trousers) / 255)
    return pixels


def meeting(*, in_front: bool, alike: bool = False) -> tuple[list[Frame], list[Box], list[Box]]:
    """Return a film of a target that stands while another walks past from the right.

    The other is in front of the target, which then leaves unseen behind it; or it is behind. Both
    differ in the color of their trousers, unless they are alike.
    """
    wall = blocks(11, 200, 320, 8, (60, 60, 60), (120, 120, 120))
    target = person((255, 255, 255))
    other = target if alike else person((160, 160, 255))
    frames, ours, others = [], [], []
    for index in range(FRAMES):
        picture, left = Image.fromarray(wall).copy(), 260 - 3 * index
        shown = [(target, STANDS, 80)] if not in_front or left > STANDS else []
        shown.insert(len(shown) if in_front else 0, (other, left, 82))
        for each, x, y in shown:
            picture.paste(Image.fromarray(each), (x, y))
        frames.append(Frame(index, index * FRAME_INTERVAL, np.array(picture)))
        ours.append(Box(STANDS, 80, 30, 40))
        others.append(Box(left, 82, 30, 40))
    return frames, ours, others


def follow(frames: list[Frame], box: Box, seed: int) -> list[Track]:
    tracker = Tracker(seed=seed)
    return [tracker.init(frames[0], box), *(tracker.update(frame) for frame in frames[1:])]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_who_is_followed_by_mistake_is_not_reported_as_the_target(seed: int) -> None:
    frames, ours, others = meeting(in_front=True)
    tracks = follow(frames, ours[0], seed)
    assert all(track.confidence > 0.5 for track in tracks[:30])
    for track, other in list(zip(tracks, others, strict=True))[APART:]:
        assert iou(track.box, other) > 0.5  # it is the other who is followed, with a clear evidence
        assert track.confidence < 0.5
        assert track.belief < 0.5
        assert track.status is Status.SEARCHING


def beliefs(frames: list[Frame], boxes: list[Box]) -> list[float]:
    """Return the belief after each frame if these boxes are followed."""
    belief, found = Belief.begin(frames[0], Ellipse.from_box(boxes[0])), []
    for frame, box in zip(frames[1:], boxes[1:], strict=True):
        place = Ellipse.from_box(box)
        belief = belief.after(frame, place, np.zeros(2), seen=True)
        found.append(belief.probability)
    return found


def test_belief_falls_on_the_neighbor_and_returns_on_the_target() -> None:
    frames, ours, others = meeting(in_front=False)
    found = beliefs(frames, ours[:APART] + others[APART : APART + 12] + ours[APART + 12 :])
    assert min(found[: APART - 1]) > 0.9
    assert found[APART + 10] < 0.3
    assert found[-1] > 0.9


@pytest.mark.parametrize("before", [1.0, -1.0])
def test_twins_are_one_as_likely_as_the_other(before: float) -> None:
    """Nothing that is seen tells them apart, however often it is seen."""
    frames, ours, _ = meeting(in_front=False, alike=True)
    place = Ellipse.from_box(ours[0])
    belief = Belief.begin(frames[0], place)
    twins = np.tile(belief.first, (MEMORY, 1))
    belief = replace(belief, neighbors=twins, lead=before)
    for frame in 60 * frames[:1]:
        belief = replace(belief.after(frame, place, np.zeros(2), seen=True), neighbors=twins)
    assert belief.probability == pytest.approx(0.5, abs=0.05)


def test_a_target_that_turns_back_to_an_earlier_side_is_believed_in() -> None:
    """Another who looks nearly like its second side is not nearer than that side itself."""
    front, side, back = (255, 255, 255), (160, 255, 160), (255, 90, 90)
    wall = blocks(11, 200, 320, 8, (60, 60, 60), (120, 120, 120))
    frames = []
    for index in range(FRAMES):
        pixels = wall.copy()
        shows = (front, side, back, side)[min(index // 18, 3)]
        pixels[80:120, STANDS : STANDS + 30] = person(shows)
        left = 260 - index
        pixels[82:122, left : left + 30] = person((150, 255, 150))
        frames.append(Frame(index, index * FRAME_INTERVAL, pixels))
    assert min(beliefs(frames, [Box(STANDS, 80, 30, 40)] * FRAMES)) > 0.5


def test_what_does_not_move_is_no_neighbor() -> None:
    frames, ours, others = meeting(in_front=False)
    still = [Frame(index, frame.time, frames[30].pixels) for index, frame in enumerate(frames)]
    found = beliefs(still, ours[:APART] + [others[30]] * (FRAMES - APART))
    assert min(found) > 0.5


def test_a_camera_that_moves_makes_no_neighbors_of_the_scenery() -> None:
    wall = blocks(11, 240, 600, 8, (0, 0, 0), (255, 255, 255))
    box = Ellipse(220.0, 100.0, 15.0, 20.0)
    belief = Belief.begin(Frame(0, 0.0, wall[:200, :320]), box)
    for index in range(1, 5 * EVERY):
        pixels = wall[:200, 3 * index : 320 + 3 * index]
        place = box._replace(x=220.0 - 3 * index)
        belief = belief.after(
            Frame(index, index * FRAME_INTERVAL, pixels), place, np.array([-3.0, 0.0]), seen=True
        )
    assert not belief.neighbors.any()


def test_nothing_is_known_of_who_is_not_seen() -> None:
    frames, ours, others = meeting(in_front=False)
    belief = Belief.begin(frames[0], Ellipse.from_box(ours[0]))
    for frame in frames[1:30]:
        place = Ellipse.from_box(ours[0])
        belief = belief.after(frame, place, np.zeros(2), seen=True)
    wrong = Ellipse.from_box(others[30])
    unseen = belief.after(frames[30], wrong, np.zeros(2), seen=False)
    assert unseen.probability == belief.probability
    assert belief.after(frames[30], wrong, np.zeros(2), seen=True).probability < belief.probability


def test_looks_tell_a_shirt_from_trousers() -> None:
    pixels = np.full((100, 100, 3), 200, np.uint8)
    pixels[50:] = 40
    upside_down = np.ascontiguousarray(pixels[::-1])
    place = Ellipse(50.0, 49.5, 20.0, 40.0)
    looks = [look_at(Frame(0, 0.0, each), place) for each in (pixels, upside_down)]
    turned = look_at(Frame(0, 0.0, upside_down), place._replace(theta=np.pi))
    nobody = np.zeros_like(looks[0])
    found = distances(np.stack([*looks, turned, nobody]), looks[0])
    assert found == pytest.approx([0, 1, 0, 1], abs=0.05)


def test_placed_by_the_user_it_is_the_target_again() -> None:
    frames, ours, others = meeting(in_front=True)
    tracker = Tracker()
    tracker.init(frames[0], ours[0])
    for frame in frames[1:APART]:
        track = tracker.update(frame)
    assert track.confidence < 0.5
    assert tracker.correct(others[APART - 1]).confidence > 0.9
    assert all(tracker.update(frame).confidence > 0.5 for frame in frames[APART:])
