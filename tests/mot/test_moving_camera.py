"""A camera that moves: its motion is found, and all that moves is followed before it."""

from inspect import getattr_static
from types import SimpleNamespace

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Detection, Frame, LookalikeDetector, Scene
from motes.core.geometry import Box, iou
from motes.core.types import Bytes
from motes.mot.detection import moving_camera
from motes.mot.detection.background import BackgroundDetector
from motes.mot.detection.global_motion import GlobalMotion, Model
from motes.mot.detection.moving_camera import Camera, MovingCamera, PannedDetector, before_camera
from motes.mot.scene_config import DetectionSelection, scene_config

cv2 = pytest.importorskip("cv2", reason="the motion of a camera needs OpenCV")
SIZE = 240, 160
RED = 220, 40, 30


COARSE = np.random.default_rng(3).integers(40, 200, (60, 90, 3)).astype(np.uint8)
GROUND: Bytes = cv2.resize(COARSE, (720, 480), interpolation=cv2.INTER_CUBIC)
"""A wide ground with corners everywhere."""


def shown(x: float, y: float, turn: float = 0.0, scale: float = 1.0) -> np.ndarray:
    """Return the motion (3, 3) from the ground to a picture whose middle is at x, y."""
    cos, sin = scale * np.cos(turn), scale * np.sin(turn)
    matrix = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1.0]])
    matrix[:2, 2] = np.array(SIZE) / 2 - matrix[:2, :2] @ (x, y)
    return matrix


def picture(matrix: np.ndarray, pixels: Bytes) -> Bytes:
    out: Bytes = cv2.warpAffine(pixels, matrix[:2], SIZE)
    return out


@pytest.mark.parametrize("model", ["similarity", "homography"])
def test_a_motion_is_found_to_a_fraction_of_a_pixel(model: Model) -> None:
    pixels, camera = GROUND.copy(), GlobalMotion(model)
    before = shown(300, 200)
    assert camera.update(picture(before, pixels)) is None
    for i in range(1, 4):
        now = shown(300 + 5 * i, 200 - 3 * i, 0.02 * i, 1 + 0.02 * i)
        found = camera.update(picture(now, pixels))
        assert found is not None
        corners = np.array([[20, 220, 20, 220], [20, 20, 140, 140], [1, 1, 1, 1]])
        there, true = found @ corners, now @ np.linalg.inv(before) @ corners
        np.testing.assert_allclose(there[:2] / there[2], true[:2], atol=0.5)
        before = now


@pytest.mark.parametrize("model", ["similarity", "homography"])
def test_writing_that_stays_in_the_picture_is_not_the_ground(model: Model) -> None:
    pixels, camera = cv2.blur(GROUND, (5, 5)), GlobalMotion(model)
    for i in range(4):
        seen = picture(shown(300 + 5 * i, 200), pixels)
        for row in range(2):
            cv2.putText(seen, "HOME 3:1 AWAY 45:12", (12, 20 + 10 * row), 0, 0.35, (255,) * 3)
        found = camera.update(seen)
    assert found is not None
    middle = found @ (120, 110, 1)
    np.testing.assert_allclose(middle[:2] / middle[2], (115, 110), atol=0.5)


def test_where_nothing_can_be_followed_there_is_no_motion() -> None:
    flat, camera = np.full((160, 240, 3), 90, np.uint8), GlobalMotion()
    assert camera.update(flat) is None
    assert camera.update(flat) is None
    assert camera.update(np.full((80, 80, 3), 90, np.uint8)) is None


def walkers(index: int) -> tuple[Frame, list[Detection]]:
    """Return a frame of a camera that jumps to and fro, and three alike in a row before it."""
    pixels, middle = GROUND.copy(), 300 + 20 * (index % 2)
    boxes = [Box(250 + 20 * i, 190, 12, 24) for i in range(3)]
    for x, y, w, h in boxes:
        pixels[int(y) : int(y + h), int(x) : int(x + w)] = RED
    frame = Frame(index, index / 25, picture(shown(middle, 200), pixels))
    moved = [box._replace(x=box.x + 120 - middle, y=box.y - 120) for box in boxes]
    return frame, [Detection(box) for box in moved]


@pytest.mark.parametrize("camera", ["auto", "moving", "still"])
def test_identities_are_kept_where_the_camera_jumps(camera: Camera) -> None:
    found: list[Detection] = []
    scene = Scene(lambda frame: found, replace(scene_config(), camera=camera))
    places: list[dict[int, float]] = []
    for index in range(12):
        frame, found[:] = walkers(index)
        tracks = scene.update(frame)
        origin = 300 + 20 * (index % 2) - 120
        places.append({each.identity: each.box.x + origin for each in tracks})
    kept = [
        len(places[-1]) == 3 and abs(places[-1].get(identity, 0) - x) < 3
        for identity, x in places[5].items()
    ]
    assert (len(kept) == 3 and all(kept)) == (camera != "still")


def test_a_slow_detector_leaves_no_motion_of_the_camera_out() -> None:
    """Between its looks, objects are followed too: a motion of several frames comes twice."""
    standing = [Box(270 + 30 * i, (190, 160, 230, 190)[i], 14, 28) for i in range(4)]
    colors = RED, (30, 40, 220), (30, 200, 40), (230, 220, 30)
    pixels, found = GROUND.copy(), list[Detection]()
    for (x, y, w, h), color in zip(standing, colors, strict=True):
        pixels[int(y) : int(y + h), int(x) : int(x + w)] = color
    rule = DetectionSelection(every=5)
    scene = Scene(lambda _: found, replace(scene_config(), camera="moving", detections=rule))
    right = 0
    for index in range(33):
        middle = 200 + 6 * index
        boxes = [box._replace(x=box.x + 120 - middle, y=box.y - 120) for box in standing]
        shows = [box for box in boxes if box.x > 0 and box.x + box.width < SIZE[0]]
        found[:] = [Detection(box) for box in shows]
        tracks = scene.update(Frame(index, index / 25, picture(shown(middle, 200), pixels)))
        if index >= 15:
            right += sum(any(iou(box, each.box) > 0.5 for each in tracks) for box in shows)
    assert scene.created == 4
    assert right > 60  # of 71; 39 where it comes twice


def test_the_motion_that_a_detector_tells_is_taken_once() -> None:
    """It is told at a look, and still there in the frames between, in which nothing moves."""

    class Told:
        motion = np.array([[1.0, 0.0, 20.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        x = -20.0

        def __call__(self, frame: Frame) -> list[Detection]:
            self.x += 20
            return [Detection(Box(self.x, 60, 20, 40))]

    detector, rule = Told(), DetectionSelection(every=2)
    scene = Scene(detector, replace(scene_config(), camera="moving", detections=rule))
    for index in range(20):
        pixels = np.full((*SIZE[::-1], 3), 120, np.uint8)
        pixels[60:100, 20 * (index // 2) : 20 * (index // 2) + 20] = RED
        tracks = scene.update(Frame(index, index / 25, pixels))
        if index >= 10:
            assert len(tracks) == 1
            assert abs(tracks[0].box.x - detector.x) < 4
    assert scene.created == 1


@pytest.mark.parametrize("detected", [True, False])
def test_what_a_detector_finds_is_not_the_camera(detected: bool) -> None:
    """A lorry that fills most of the picture drives by."""
    found: list[Detection] = []
    camera, pixels = MovingCamera(lambda frame: found), GROUND.copy()
    for index in range(12):
        seen = picture(shown(300, 200), pixels)
        seen[10:150, 20:220] = pixels[300:440, 100 + 3 * index : 300 + 3 * index]
        found[:] = [Detection(Box(20, 10, 200, 140))] if detected else []
        camera(Frame(index, index / 25, seen))
    assert (camera.motion is None) == detected


def test_without_opencv_it_is_said_that_nobody_sees_whether_the_camera_moves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(moving_camera, "opencv", lambda: None)
    scene = Scene(lambda frame: [])
    scene.update(walkers(0)[0])
    assert "Without OpenCV" in scene.warnings["unseen"]
    still = Scene(lambda frame: [], replace(scene_config(), camera="still"))
    still.update(walkers(0)[0])
    assert not still.warnings


def panned(index: int) -> tuple[Frame, Box]:
    """Return a frame of a camera that pans, and the box of one who walks in from the right."""
    pixels = GROUND.copy()
    x, y = 430 - 3 * index, 180
    pixels[y : y + 30, x : x + 20] = RED
    camera_x = 260 + 2 * index
    frame = Frame(index, index / 25, picture(shown(camera_x, 200), pixels))
    return frame, Box(x + 120 - camera_x, y - 120, 20, 30)


@pytest.mark.slow
def test_what_moves_is_found_while_the_camera_pans() -> None:
    detector, still = PannedDetector(), BackgroundDetector()
    hits = 0
    for index in range(42):
        frame, box = panned(index)
        found = detector(frame)
        assert still(frame) == []
        hits += any(iou(box, each.box) > 0.6 for each in found)
        assert len(found) <= 2
    assert hits >= 20  # from frame 21 on
    assert detector.motion is not None
    np.testing.assert_allclose(detector.motion[:2, 2], (-2, 0), atol=0.3)


@pytest.mark.slow
def test_between_its_looks_a_background_that_moves_along_follows_the_camera() -> None:
    """The motion of several frames came at a look, though objects are followed between them."""
    rule = DetectionSelection(every=2)
    scene = Scene(BackgroundDetector(), replace(scene_config(), camera="moving", detections=rule))
    detector, hits = PannedDetector(), 0
    assert isinstance(scene.detector, PannedDetector)
    for index in range(42):
        frame, box = panned(index)
        scene.update(frame)
        if index:
            motion = scene.detector.motion
            assert motion is not None
            np.testing.assert_allclose(motion[:2, 2], (-2, 0), atol=0.3)
        if index % 2:
            detector.glance(frame)
        else:
            hits += any(iou(box, each.box) > 0.6 for each in detector(frame))
    assert hits >= 9
    detector.glance(Frame(42, 2.0, np.zeros_like(frame.pixels)))  # the motion is not clear
    frame, _ = panned(43)
    detector.glance(frame)
    assert detector(panned(44)[0]) == []


@pytest.mark.slow
@pytest.mark.parametrize("sways", [False, True])
def test_what_stays_in_the_picture_exactly_is_writing(sways: bool) -> None:
    """An object that a camera follows stays in the picture too, but not to a pixel."""
    rng, detector = np.random.default_rng(5), PannedDetector()
    written, found = Box(150, 110, 20, 30), 0
    for index in range(40):
        frame, box = panned(index)
        x, y = np.array((150, 110)) + sways * rng.integers(-2, 3, 2)
        frame.pixels[y : y + 30, x : x + 20] = RED
        frame.pixels[y + 2 : y + 28 : 4, x + 2 : x + 18] = 255
        boxes = [each.box for each in detector(frame)]
        found += index >= 20 and any(iou(written, each) > 0.4 for each in boxes)
        if 21 <= index < 28:  # before the other one comes there
            assert any(iou(box, each) > 0.6 for each in boxes)
    assert found >= 15 if sways else found == 0


def test_each_detector_gets_what_it_needs_before_a_camera() -> None:
    still = BackgroundDetector()
    assert isinstance(before_camera(still, "moving"), PannedDetector)
    assert before_camera(still, "auto") is still
    alike = LookalikeDetector((1, 1, 9, 9))
    assert before_camera(alike, "moving") is alike
    among = LookalikeDetector((1, 1, 9, 9), lambda frame: [])
    assert isinstance(before_camera(among, "auto"), MovingCamera)
    assert before_camera(among, "still") is among
    own = SimpleNamespace(warnings={"light": "it changes"}, __call__=lambda frame: [])
    assert MovingCamera(own).warnings == own.warnings
    able = SimpleNamespace(prepare=list, observe=print, __call__=lambda frame: [])
    seen = MovingCamera(able)  # by a protocol, from Python 3.12 on
    assert [getattr_static(seen, name) for name in ("prepare", "observe")] == [list, print]
