"""OpenCV's trackers that are networks, with the files that a user names."""

import sys
import types
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from motes import Box, Frame
from motes_lab.adapters.registry import resolve, tracker_spec


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_networks_need_their_files() -> None:
    Path("a.onnx").write_text("no network")
    for files in ("", "=a.onnx", "=a.onnx,none.onnx"):
        ((_, problem),) = [resolve([f"cv2:nano{files}"])]
        assert "cv2:nano needs 2 ONNX files: cv2:nano=BACKBONE,HEAD" in problem[0].what
    for files in ("", "=none.onnx", "=a.onnx,a.onnx"):
        ((_, problem),) = [resolve([f"cv2:vit{files}"])]
        assert "cv2:vit needs an ONNX file: cv2:vit=NETWORK" in problem[0].what
    entries, problems = resolve(["cv2:nano=a.onnx,a.onnx", "cv2:vit=a.onnx"])
    assert not entries
    assert "cannot use a.onnx or a.onnx; give BACKBONE,HEAD of NanoTrack" in problems[0].what
    assert "cannot use a.onnx; give NETWORK of VitTrack, as ONNX." in problems[1].what


def test_a_network_is_the_same_with_the_same_files(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[tuple[str, str]] = []

    def create(given: types.SimpleNamespace) -> mock.Mock:
        made.append((given.backbone, given.neckhead))
        return mock.Mock()

    other = types.SimpleNamespace(
        __version__="4.14",
        setNumThreads=lambda _: None,
        error=RuntimeError,
        TrackerNano_Params=types.SimpleNamespace,
        TrackerNano_create=create,
    )
    monkeypatch.setitem(sys.modules, "cv2", other)
    Path("a.onnx").write_text("a"), Path("b.onnx").write_text("b")
    spec = tracker_spec("cv2:nano=a.onnx,b.onnx")
    assert (spec.stochastic, made) == (False, [("a.onnx", "b.onnx")])
    assert tracker_spec("cv2:nano=a.onnx,b.onnx").configuration == spec.configuration
    Path("b.onnx").write_text("c")
    assert tracker_spec("cv2:nano=a.onnx,b.onnx").configuration != spec.configuration


def vit() -> str:
    """Write a network that finds a color, for which a target keeps its size; return its name."""
    pytest.importorskip("onnx")
    from onnx_trackers import save_vit

    same = np.ones((2, 16, 16), np.float32)
    return save_vit(Path(), 0.25 * same, 0.5 * same)


def test_vit_follows_what_its_network_sees() -> None:
    """The target has a white spot in its middle; cells of the network are 7.5 pixels wide."""
    adapter = tracker_spec(f"cv2:vit={vit()}").begin(0)
    for i in range(10):
        image = np.zeros((240, 320, 3), np.uint8)
        image[107:123, 107 + 5 * i : 123 + 5 * i] = 255
        box = Box(100 + 5 * i, 100, 30, 30)
        frame = Frame(i, i / 25, image)
        answer = adapter.update(frame) if i else adapter.init(frame, box)
        assert answer.ellipse is not None
        np.testing.assert_allclose(answer.ellipse.box, box, atol=6)
    assert adapter.update(Frame(10, 1, np.zeros((240, 320, 3), np.uint8))).lost


def test_the_default_tracker_takes_part_with_a_network() -> None:
    pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    from onnx_trackers import save_pair

    save_pair(Path())
    name = "default:network=backbone.onnx,head.onnx"
    spec = tracker_spec(name)
    assert (spec.name, spec.stochastic) == (name, True)
    image = np.full((160, 240, 3), 90, np.uint8)
    image[50:80, 60:90] = (220, 30, 30)
    answers = []
    for each in (name, "default"):
        adapter = tracker_spec(each).begin(0)
        adapter.init(Frame(0, 0, image), Box(60, 50, 30, 30))
        answers.append(adapter.update(Frame(1, 0.04, image)).ellipse)
    assert answers[0] != answers[1]
    for files, words in (("none.onnx", "There is no file"), ("head.onnx", "no known kind")):
        _, (problem,) = resolve([f"default:network={files}"])
        assert words in problem.what
