"""Detections in the forms that detectors return, and detectors of the user's own."""

import importlib.util
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motes import Frame, Scene, Status, Tracker, as_detections
from motes.core.callables import import_callable
from motes.core.detection import Detection, best
from motes.core.errors import ConfigError, MissingDependencyError
from motes.core.geometry import Box, iou
from motes.mot.detection.background import BackgroundConfig, BackgroundDetector
from motes.mot.detection.custom import CustomDetector
from motes.mot.detection.lookalike import LookalikeDetector
from motes.mot.detection.morphology import _opencv, eroded
from motes.mot.detection.pretrained import FacesConfig, PeopleConfig
from motes.mot.scene_config import named_detector
from oracles import sequence

EMPTY = Frame(0, 0.0, np.zeros((80, 100, 3), np.uint8))


def test_the_surest_is_taken() -> None:
    first, second = Detection(Box(1, 1, 9, 9), 0.3), Detection(Box(40, 40, 9, 9), 0.7)
    assert best([first, second], EMPTY) is second
    assert best([second, first], EMPTY) is second
    assert best([], EMPTY) is None
    assert best([first, Detection(Box(2, 2, 5, 5), 0.3)], EMPTY) is first


@pytest.mark.parametrize(
    "box",
    [
        Box(-9, 5, 10, 10), Box(5, 77, 10, 10), Box(0, 0, 101, 10), Box(5, 5, 1.5, 10),
        Box(5, -9, 10, 10), Box(97, 5, 10, 10), Box(0, 0, 10, 81), Box(5, 5, 10, 1.5),
    ],
)  # fmt: skip
def test_what_no_tracker_could_start_on_is_left_out(box: Box) -> None:
    assert best([Detection(box, 9.0)], EMPTY) is None
    other = Detection(Box(94, 74, 10, 10), 0.1)  # half of it is in the frame
    assert best([Detection(box, 9.0), other], EMPTY) is other


def test_without_dlib_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dlib", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'motes\[faces\]'"):
        FacesConfig().detector()


def test_a_broken_opencv_is_said_and_not_used(
    here: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As one with windows where no OpenGL is, or one for another numpy."""
    broken = "its import fails (ImportError: libGL.so.1: cannot open): install it anew, or what"
    (here / "cv2.py").write_text("raise ImportError('libGL.so.1: cannot\\nopen')")
    monkeypatch.syspath_prepend(here)
    monkeypatch.setitem(sys.modules, "cv2", None)  # to be put back as it was
    del sys.modules["cv2"]
    _opencv.cache_clear()
    try:
        scene = Scene(BackgroundDetector())
        for index in range(2):
            assert eroded(np.eye(3, dtype=np.uint8), (3, 3)).max() == 0
            scene.update(Frame(index, index / 25, EMPTY.pixels))
    finally:
        _opencv.cache_clear()
    assert [broken in line for line in caplog.messages] == [True]
    with pytest.raises(MissingDependencyError) as error:
        PeopleConfig().detector()
    assert broken in str(error.value)


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("dlib") is None, reason="dlib is not installed")
def test_a_found_face_is_followed(data: Path) -> None:
    """As `motes track --detect face` does; with color alone David was lost in frame 13."""
    frames, boxes = sequence(data / "sot" / "David", 30)
    found = best(FacesConfig().detector()(frames[0]), frames[0])
    assert found is not None
    tracker = Tracker()
    tracker.init(frames[0], found.box)
    for frame, truth in zip(frames[1:], boxes[1:], strict=True):
        track = tracker.update(frame)
        assert track.status is Status.TRACKING
        assert iou(track.box, truth) > 0.6


FRAME = Frame(4, 0.2, np.zeros((60, 80, 3), np.uint8))
ONE = Detection(Box(1, 2, 30, 40), 0.75, "car")


@dataclass
class Sides:
    """As the Detections of supervision."""

    xyxy: Any
    confidence: Any = None
    class_id: Any = None
    data: dict[str, Any] = field(default_factory=dict)


SIDES = np.array([[1, 2, 31, 42]])


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ([], []),
        (np.empty((0, 5)), []),
        ([ONE], [ONE]),
        ((ONE,), [ONE]),
        (np.array([[1, 2, 30, 40, 0.75]]), [Detection(Box(1, 2, 30, 40), 0.75)]),
        (np.array([[1, 2, 30, 40, 0.75, 1]]), [ONE]),
        ([(1, 2, 30, 40, 0.75, "car")], [ONE]),
        ([(1, 2, 30, 40), ONE], [Detection(Box(1, 2, 30, 40)), ONE]),
        ([(1, 2, 30, 40, 0.75, 7)], [Detection(Box(1, 2, 30, 40), 0.75, "7")]),
        (Sides(SIDES), [Detection(Box(1, 2, 30, 40))]),
        (Sides(SIDES, [0.75], [1]), [ONE]),
        (Sides(SIDES, [0.75], [1], {"class_name": np.array(["van"])}), [
            Detection(Box(1, 2, 30, 40), 0.75, "van")
        ]),
        (Sides(np.empty((0, 4))), []),
    ],
)  # fmt: skip
def test_all_forms_are_read(value: Any, expected: list[Detection]) -> None:
    assert as_detections(value, ("person", "car")) == expected
    assert as_detections(value, {0: "person", 1: "car"}) == expected


@pytest.mark.parametrize(
    "value",
    [
        None,
        "boxes",
        [1, 2, 3, 4],
        [(1, 2, 3, 4, 5, 6, 7)],
        [("x", 2, 3, 4)],
        Sides([[1, 2, 3]]),
        Sides(SIDES, [0.5, 0.6]),
        Sides(SIDES, ["sure"]),
    ],
)
def test_anything_else_is_one_clear_error(value: Any) -> None:
    with pytest.raises(ConfigError, match="The detector returned") as caught:
        as_detections(value)
    assert "it must return a list of motes.Detection, rows of x, y" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_detections_of_supervision_are_read() -> None:
    supervision = pytest.importorskip("supervision")
    given = supervision.Detections(
        xyxy=np.array([[1.0, 2.0, 31.0, 42.0]]), confidence=np.array([0.75]), class_id=np.array([1])
    )
    assert as_detections(given, ("person", "car")) == [ONE]


MODULE = """
import numpy as np

def boxes(frame):
    return np.array([[frame.index, 2, 30, 40, 0.75]])

def factory():
    return boxes

class Finder:
    def __call__(self, frame):
        return boxes(frame)

class Whole(Finder):
    motion, warnings = np.eye(3), {"light": "it changes"}

    def prepare(self, frames):
        self.seen = list(frames)

    def observe(self, moved):
        self.moved = moved

def number():
    return 3

def fails(frame):
    raise KeyError("weights")

def ends(frame):
    raise SystemExit(3)

def nonsense(frame):
    return 3

it = 3
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the name of a module with detectors in the current folder."""
    (tmp_path / "my_finders.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return "my_finders"


def test_a_callable_is_a_detector_or_makes_one(module: str) -> None:
    for name in ("boxes", "factory", "Finder"):
        found = named_detector(f"{module}:{name}")(FRAME)
        assert found == [Detection(Box(4, 2, 30, 40), 0.75)], name


def test_a_callable_keeps_what_else_a_detector_has(module: str) -> None:
    scene = Scene(named_detector(f"{module}:Whole"))
    assert isinstance(scene.detector, CustomDetector)  # its motion is the camera's
    scene.prepare([FRAME])
    scene.update(FRAME)
    assert (scene.detector.seen, scene.detector.moved) == ([FRAME], [])
    assert scene.warnings == {"light": "it changes"}
    assert not hasattr(named_detector(f"{module}:boxes"), "motion")


def test_the_current_folder_comes_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file there does not take the place of an installed module."""
    for name in ("this_module_is_here", "zipapp"):
        (tmp_path / f"{name}.py").write_text("here = list\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place])
    monkeypatch.delitem(sys.modules, "zipapp", raising=False)
    assert import_callable("this_module_is_here:here") is list
    assert sys.path[-1] == str(tmp_path)
    with pytest.raises(AttributeError):
        import_callable("zipapp:here")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("my_finders:number", "returns a int, which is not a detector"),
        ("my_finders:it", "is a int, which is not callable"),
        ("my_finders:none", "AttributeError"),
        ("no_such_module:none", "ModuleNotFoundError"),
        ("my_finders.py:boxes", "without folders and .py"),
        ("./my_finders:boxes", "without folders and .py"),
    ],
)
def test_what_is_no_detector_is_refused(name: str, words: str, module: str) -> None:
    with pytest.raises(ConfigError, match=f"The detector {name}") as caught:
        named_detector(name)
    assert words in str(caught.value)


def test_a_detector_takes_the_keys_of_its_settings() -> None:
    moving = named_detector("background", {"least": 0.1})
    assert isinstance(moving, BackgroundDetector)
    assert moving.config == BackgroundConfig(least=0.1)
    assert isinstance(named_detector("like", {"box": (1, 2, 30, 40)}), LookalikeDetector)
    for name, settings, words in (
        ("background", {"lest": 1}, "did you mean 'least'"),
        ("like", {}, "A detector is background, "),
        ("like", {"distance": 0.1}, "box"),
        ("lik", {"box": (1, 2, 30, 40)}, "A detector is background, "),
    ):
        with pytest.raises(ConfigError, match=words):
            named_detector(name, settings)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("fails", "KeyError: 'weights'"),
        ("ends", "SystemExit: 3"),
        ("nonsense", "The detector returned 3"),
    ],
)
def test_an_error_of_a_detector_names_it_and_the_frame(name: str, words: str, module: str) -> None:
    with pytest.raises(ConfigError, match=f"{module}:{name} failed in frame 4") as caught:
        named_detector(f"{module}:{name}")(FRAME)
    assert words in str(caught.value)
