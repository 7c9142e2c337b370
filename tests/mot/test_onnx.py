"""Trained detectors in ONNX files: every head, to the pixel."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("onnx", reason="onnx is not installed")
pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")

from motes import ConfigError, Detection, Frame, SourceError
from motes.mot.detection.onnx_detector import OnnxConfig, OnnxDetector
from motes.mot.detection.onnx_heads import KINDS, Boxes, decoded, suppressed
from motes.mot.scene_config import named_detector
from onnx_models import save

RED, BLUE, GRAY = (255, 20, 20), (10, 10, 250), (60, 60, 60)
HEADS = list(KINDS)


def picture(*blobs: tuple[int, int, int, int, tuple[int, int, int]], size: Any = (96, 64)) -> Frame:
    """Return a gray picture with colored blobs: x, y, width, height, color."""
    pixels = np.full((size[1], size[0], 3), GRAY, np.uint8)
    for x, y, width, height, color in blobs:
        pixels[y : y + height, x : x + width] = color
    return Frame(0, 0.0, pixels)


def model(folder: Path, head: str, **how: Any) -> Path:
    """Return a model whose input is scaled as the models of its head have it."""
    usual = KINDS[head]
    mean, deviation = usual.scale
    said = {"head": "RTDETRDecoder"} if head == "rtdetr" else {}
    given = {"order": usual.order, "mean": mean, "deviation": deviation, "metadata": said, **how}
    return save(folder / f"{head}.onnx", head, **given)


def boxes(found: list[Detection]) -> dict[tuple[float, ...], str | None]:
    """Return the classes of detections by their boxes, rounded to a thousandth of a pixel."""
    return {tuple(round(value, 3) for value in each.box): each.label for each in found}


@pytest.mark.parametrize("head", HEADS)
def test_boxes_of_each_head_are_exact(head: str, tmp_path: Path) -> None:
    detector = OnnxDetector(OnnxConfig(str(model(tmp_path, head))))
    assert detector.head == head
    found = detector(picture((16, 32, 16, 16, RED), (64, 0, 16, 16, BLUE)))
    assert boxes(found) == {(16, 32, 16, 16): "0", (64, 0, 16, 16): "1"}
    assert all(0.9 < each.score <= 1 for each in found)
    assert found == sorted(found, key=lambda each: -each.score)
    assert detector(picture()) == []


@pytest.mark.parametrize("head", HEADS)
def test_frames_of_another_size_are_fitted(head: str, tmp_path: Path) -> None:
    """A frame of 288x96 is a third as large in the input: 96x32, of 64 rows, or stretched."""
    detector = OnnxDetector(OnnxConfig(str(model(tmp_path, head))))
    fit = KINDS[head].fit
    # The frame's row that lies at the input's row 16, 32 or, stretched, 16.
    y, height = {"letterbox": (0, 48), "corner": (48, 48), "stretch": (24, 24)}[fit]
    found = detector(picture((144, y, 48, height, RED), size=(288, 96)))
    [(box, label)] = boxes(found).items()
    assert label == "0"
    assert box == (144, y, 48, height)


def test_a_file_beside_it_says_what_the_model_does_not(tmp_path: Path) -> None:
    """Other units, channels last, and names of classes."""
    path = model(
        tmp_path, "yolo", order="bgr", mean=(1, 2, 3), deviation=(9, 8, 7), channels_last=True
    )
    wrong = OnnxDetector(OnnxConfig(str(path)))(picture((16, 32, 16, 16, RED)))
    assert boxes(wrong) != {(16, 32, 16, 16): "red"}
    (tmp_path / "yolo.toml").write_text(
        'order = "bgr"\nmean = [1, 2, 3]\ndeviation = [9, 8, 7]\nclasses = ["red", "blue"]\n'
        'layout = "nhwc"\nscore = 0.8\nfit = "stretch"\nsize = [96, 64]\nhead = "yolo"\n'
    )
    detector = named_detector(str(path))
    found = detector(picture((16, 32, 16, 16, RED), (64, 0, 16, 16, BLUE)))
    assert boxes(list(found)) == {(16, 32, 16, 16): "red", (64, 0, 16, 16): "blue"}


@pytest.mark.parametrize("form", ["rtdetr", "rtdetr classes"])
@pytest.mark.parametrize(
    "said", [{"head": "RTDETRDecoder"}, {"description": "Ultralytics rtdetr-l model"}]
)
def test_an_rtdetr_of_ultralytics_is_known_by_its_metadata(
    form: str, said: dict[str, str], tmp_path: Path
) -> None:
    """Its six columns look like those of models with their own suppression, in other units."""
    path = save(tmp_path / "model.onnx", form, metadata=said)
    detector = OnnxDetector(OnnxConfig(str(path)))
    found = detector(picture((32, 64, 32, 32, RED), (128, 0, 32, 32, BLUE), size=(192, 64 * 2)))
    assert detector.head == "rtdetr"
    assert boxes(found) == {(32, 64, 32, 32): "0", (128, 0, 32, 32): "1"}


def test_a_model_for_another_task_is_refused(tmp_path: Path) -> None:
    """The outputs for poses have the shape of boxes with classes."""
    path = model(tmp_path, "yolo", metadata={"task": "pose"})
    with pytest.raises(ConfigError, match="It is a model for the task pose; export one for detect"):
        OnnxDetector(OnnxConfig(str(path)))


def test_scores_and_overlaps_are_limits(tmp_path: Path) -> None:
    path = str(model(tmp_path, "yolo"))
    dim = picture((16, 32, 16, 16, (180, 60, 60)))  # 0.47 of red: below one half
    assert OnnxDetector(OnnxConfig(path, score=0.5))(dim) == []
    assert len(OnnxDetector(OnnxConfig(path, score=0.1))(dim)) == 1
    sides = np.array([[0, 0, 10, 10], [1, 0, 11, 10], [1, 0, 11, 10], [20, 0, 30, 10.0]])
    found = Boxes(sides, np.array([0.9, 0.8, 0.7, 0.6]), np.array([0, 0, 1, 0]))
    assert suppressed(found, 0.6).scores.tolist() == [0.9, 0.7, 0.6]
    assert suppressed(found, 0.9).scores.tolist() == [0.9, 0.8, 0.7, 0.6]


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        ('head = "yolox"', "Its outputs are not those of head yolox"),
        ("heads = 1", "detr.toml: Config has no key 'heads'; did you mean 'head'"),
        ('file = "x"', "has the key file"),
        ("[[", "not valid TOML"),
        ("size = [30, 30]", "does not run"),
    ],
)
def test_a_bad_file_beside_it_is_refused(toml: str, words: str, tmp_path: Path) -> None:
    path = model(tmp_path, "detr")
    (tmp_path / "detr.toml").write_text(toml)
    with pytest.raises((ConfigError, SourceError)) as caught:
        named_detector(str(path))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("head", "named", "scores"),
    [("yolov5", "yolo", 92), ("yolo", "yolov5", 3312), ("yolo", "nms", 36), ("nms", "yolo", 96)],
)
def test_scores_that_are_none_are_those_of_another_head(
    head: str, named: Any, scores: int, tmp_path: Path
) -> None:
    path = str(model(tmp_path, head))
    words = rf"not those of head {named}: .* are 0 to {scores}; change head \(--set detector.head"
    with pytest.raises(ConfigError, match=words):
        OnnxDetector(OnnxConfig(path, head=named))(picture((16, 32, 16, 16, RED)))


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan])
def test_boxes_without_an_end_are_no_detections(value: float) -> None:
    rows = np.tile([0.2, 0.2, 0.1, 0.1, 0.9, 1.0], (1, 3, 1))
    for head in ("nms", "rtdetr"):
        some, every = rows.copy(), rows.copy()
        some[0, 1, 2], every[..., :4] = value, value
        assert len(decoded(head, {"out": some}, (96, 64)).scores) == 2
        assert len(decoded(head, {"out": rows[:, :0]}, (96, 64)).scores) == 0
        with pytest.raises(ConfigError, match=f"head {head}: 0 of 3 boxes are finite, scores are"):
            decoded(head, {"out": every}, (96, 64))


def test_unknown_outputs_are_named(tmp_path: Path) -> None:
    """With one cell more, the boxes of no grid fit."""
    path = model(tmp_path, "yolo")
    with pytest.raises(ConfigError, match=r"The form of its outputs is not known: .*one of yolox"):
        OnnxDetector(OnnxConfig(str(save_odd(path))))


def save_odd(path: Path) -> Path:
    """Write a model with an output of rows of three numbers."""
    import onnx
    from onnx import TensorProto, helper

    given = helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, 64, 96])
    out = helper.make_tensor_value_info("odd", TensorProto.FLOAT, [1, 3])
    node = helper.make_node("ReduceMean", ["images"], ["odd"], axes=[2, 3], keepdims=0)
    graph = helper.make_graph([node], "odd", [given], [out])
    odd = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    onnx.save(odd, str(path))
    return path
