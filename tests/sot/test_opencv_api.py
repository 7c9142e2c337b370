"""The methods of OpenCV's trackers; and images are read where they lie in memory."""

import inspect
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from PIL import Image

from kinds import ALGORITHMS, CONFIGS, KINDS
from motes import Ellipse, OpenCVTracker, Track, Tracker, draw, synthetic
from motes.core.errors import ConfigError, SourceError
from motes.core.frame import Frame, as_rgb, from_bgr
from motes.core.types import Bytes
from motes.mot.detection.background import BackgroundDetector

CLIP = synthetic.still((160, 120), target=(30, 40), frames=3)
BOX = tuple(round(value) for value in Ellipse(*CLIP.targets[0].states[0]).box)


@cache
def shown(index: int) -> Bytes:
    """Return a frame of the clip as OpenCV reads it."""
    return CLIP[index][0].pixels[:, :, ::-1]


def test_the_methods_are_those_of_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    theirs = {name for name in dir(cv2.TrackerMIL) if not name.startswith("_")} - {"Params"}
    assert theirs <= set(dir(OpenCVTracker))


def test_the_same_calls_work_for_both() -> None:
    cv2 = pytest.importorskip("cv2")
    for kind in (cv2.TrackerMIL, OpenCVTracker):
        tracker = kind.create()
        assert tracker.init(image=shown(0), boundingBox=BOX) is None
        ok, box = tracker.update(image=shown(1))
        assert ok is True
        assert all(type(value) is int for value in box)
        assert np.abs(np.array(box) - BOX).max() <= 3


def test_create_is_the_constructor() -> None:
    made, created = (
        inspect.signature(each).parameters for each in (OpenCVTracker, OpenCVTracker.create)
    )
    assert made == created


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: OpenCVTracker.create("csrt"), ConfigError, "No preset"),
        (lambda: OpenCVTracker().init(shown(0), (30, 36, 10)), ConfigError, "A box has 4 numbers"),
        (lambda: OpenCVTracker().init(shown(0), None), ConfigError, "got None"),  # type: ignore[arg-type]
        (lambda: OpenCVTracker().init(None, BOX), SourceError, "no picture"),  # type: ignore[arg-type]
        (lambda: OpenCVTracker().init((True, shown(0)), BOX), SourceError, "got tuple"),  # type: ignore[arg-type]
        (lambda: OpenCVTracker().update(shown(0)), ConfigError, "no target yet"),
        (lambda: OpenCVTracker().track, ConfigError, "no track before init"),
    ],
)
def test_what_is_refused(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


def test_an_image_of_pillow_is_rgb() -> None:
    image = Image.fromarray(shown(0)[:, :, ::-1])
    np.testing.assert_array_equal(as_rgb(from_bgr(image)), shown(0)[:, :, ::-1])  # type: ignore[arg-type]


def test_found_and_confident_is_what_is_tracked() -> None:
    tracker = OpenCVTracker("nummiaro")
    image = np.zeros((60, 80, 3), np.uint8)
    image[20:40, 30:50] = 200, 60, 20
    tracker.init(image, (30, 20, 20, 20))
    ok, box = tracker.update(image)
    assert ok
    assert tuple(map(round, tracker.track.box)) == box
    assert tracker.track.confidence > 0.5
    answers = [tracker.update(np.zeros_like(image))[0] for _ in range(6)]
    assert answers[-1] is False


TURNING = synthetic.turning((120, 90), frames=3)
START = Ellipse(*TURNING.targets[0].states[0])


@cache
def pictures() -> list[Bytes]:
    return [frame.pixels for frame, _ in TURNING]


def bgr(pixels: Bytes) -> Bytes:
    """Return a view of a BGR image."""
    return pixels[:, :, ::-1].copy()[:, :, ::-1]


def bgra(pixels: Bytes) -> Bytes:
    """Return a view of a BGR image with alpha."""
    return np.dstack([pixels[:, :, ::-1], pixels[:, :, :1]])[:, :, 2::-1]


def part(pixels: Bytes) -> Bytes:
    """Return a part of a larger image, which has other pixels around."""
    return np.pad(pixels, ((3, 4), (5, 2), (0, 0)), constant_values=77)[3:-4, 5:-2]


def sparse(pixels: Bytes) -> Bytes:
    """Return every second pixel of every third row of a larger BGR image."""
    large = np.repeat(np.repeat(pixels, 3, axis=0), 2, axis=1)
    large[1::3], large[:, 1::2] = 5, 250
    return bgr(large)[::3, ::2]


def locked(pixels: Bytes) -> Bytes:
    """Return an image that must not be written."""
    copy = pixels.copy()
    copy.flags.writeable = False
    return copy


VIEWS: tuple[Callable[[Bytes], Bytes], ...] = (bgr, bgra, part, sparse, locked)


def follow(name: str, images: list[Bytes], region: Ellipse = START) -> list[Track]:
    """Return the tracks of a tracker."""
    tracker = Tracker(CONFIGS[name], seed=2)
    tracks = []
    for index, image in enumerate(images):
        frame = Frame(index, index / 25, image)
        tracks.append(tracker.update(frame) if index else tracker.init(frame, region))
    return tracks


@cache
def expected(name: str) -> list[Track]:
    return follow(name, pictures())


def assert_same(found: list[Track], wanted: list[Track]) -> None:
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_array_equal([*one.ellipse], [*other.ellipse])
        np.testing.assert_array_equal(one.covariance, other.covariance)
        assert (one.status, one.confidence) == (other.status, other.confidence)


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_views_give_the_same_tracks(name: str) -> None:
    for view in VIEWS:
        views = [view(pixels) for pixels in pictures()]
        for pixels, image in zip(pictures(), views, strict=True):
            assert as_rgb(image) is image
            np.testing.assert_array_equal(image, pixels)
        assert_same(follow(name, views), expected(name))


@pytest.mark.parametrize("name", ALGORITHMS)
def test_opencv_images_are_read_where_they_lie(name: str) -> None:
    tracker = OpenCVTracker(name, seed=2)
    box = tuple(round(value) for value in START.box)
    plain = Tracker(name, seed=2)
    image = pictures()[0][:, :, ::-1].copy()
    tracker.init(image, box)
    assert_same([tracker.tracker.info.track], [plain.init(pictures()[0], box)])
    for pixels in pictures()[1:]:
        image[:] = pixels[:, :, ::-1]  # as a camera writes into the same memory again
        tracker.update(image)
        assert_same([tracker.tracker.info.track], [plain.update(pixels)])


@pytest.mark.slow
def test_detectors_and_drawings_take_views() -> None:
    rng = np.random.default_rng(0)
    moving = [rng.integers(95, 106, (120, 160, 3)).astype(np.uint8) for _ in range(40)]
    for index, pixels in enumerate(moving[30:]):
        pixels[40:70, 5 * index : 5 * index + 20] = (250, 220, 60)
    found, drawn = [], []
    for view in (np.copy, bgr, part):
        detector = BackgroundDetector()
        frames = [Frame(i, i / 25, view(pixels)) for i, pixels in enumerate(moving)]
        found.append([detector(frame) for frame in frames])
        drawn.append(draw(frames[0].pixels, expected("nummiaro")[0]))
    assert found[0] == found[1] == found[2]
    assert any(found[0])
    np.testing.assert_array_equal(drawn[1:], [drawn[0]] * 2)
