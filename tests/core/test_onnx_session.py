"""ONNX files and what runs them: one mechanism for detectors and trackers."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from motes.core.errors import MotesError

pytest.importorskip("onnx", reason="onnx is not installed")
pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")

import onnx
from onnx import TensorProto, helper, numpy_helper

from forks import in_a_child
from motes.core.errors import MissingDependencyError, SourceError
from motes.core.onnx_session import LARGEST, Session, Tensor
from onnx_trackers import mean_colors, save_pair

PIXELS = np.random.default_rng(0).uniform(0, 255, (1, 3, 255, 255)).astype(np.float32)


@pytest.fixture(scope="module")
def backbone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(save_pair(tmp_path_factory.mktemp("models"))[0])


def save_weights_outside(folder: Path) -> Path:
    """Write a model that adds weights, which lie in a file of their own, to its input."""
    weights = numpy_helper.from_array(np.arange(600, dtype=np.float32), "weights")
    one = helper.make_tensor_value_info("x", TensorProto.FLOAT, [600])
    two = helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n"])
    add = helper.make_node("Add", ["x", "weights"], ["y"])
    # Old files list weights among the inputs, too.
    also = helper.make_tensor_value_info("weights", TensorProto.FLOAT, [600])
    graph = helper.make_graph([add], "add", [one, also], [two], [weights])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    helper.set_model_props(model, {"author": "us"})
    path = folder / "add.onnx"
    onnx.save(model, str(path), save_as_external_data=True, location="add.data", size_threshold=100)
    return path


def test_a_file_says_what_its_model_takes_and_gives(backbone: Path, tmp_path: Path) -> None:
    file = Session(str(backbone))
    assert file.inputs == (Tensor("input", "float32", (1, 3, 255, 255)),)
    assert file.outputs == (Tensor("output", "float32", (1, 3, 16, 16)),)
    assert str(file) == (
        "backbone.onnx (takes input float32 1x3x255x255; gives output float32 1x3x16x16)"
    )
    other = Session(str(save_weights_outside(tmp_path)))
    assert other.inputs == (Tensor("x", "float32", (600,)),)
    assert other.outputs == (Tensor("y", "float32", (600,)),)
    assert other.metadata == {"author": "us"}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_child_of_fork_runs_it_with_threads_of_its_own(backbone: Path) -> None:
    session = Session(str(backbone), threads=2)
    (expected,) = session.run({"input": PIXELS}).values()
    found = in_a_child(lambda: float(session.run({"input": PIXELS})["output"].sum()))
    assert float(found) == pytest.approx(float(expected.sum()), rel=1e-3)


def test_a_model_runs_with_pictures_of_any_size(backbone: Path) -> None:
    session = Session(str(backbone), open_sizes=True)
    (first,) = session.run({"input": PIXELS}).values()
    kept = first.copy()
    np.testing.assert_allclose(first[0], mean_colors(PIXELS[0]) / 255, atol=1e-5)
    (small,) = session.run({"input": np.ascontiguousarray(PIXELS[:, :, :127, :127])}).values()
    np.testing.assert_allclose(small[0], mean_colors(PIXELS[0, :, :127, :127]) / 255, atol=1e-5)
    np.testing.assert_array_equal(first, kept)  # it has not been written over
    with pytest.raises(SourceError, match=r"backbone\.onnx does not run"):
        session.run({"input": np.zeros((1, 4, 255, 255), np.float32)})


@pytest.mark.parametrize("opened", [False, True])
def test_weights_may_lie_in_another_file(opened: bool, tmp_path: Path) -> None:
    path = save_weights_outside(tmp_path)
    out = Session(str(path), open_sizes=opened).run({"x": np.zeros(600, np.float32)})
    np.testing.assert_array_equal(out["y"], np.arange(600))
    (tmp_path / "add.data").unlink()
    with pytest.raises(SourceError, match=r"weights in add\.data, which is not there"):
        Session(str(path))


def damaged(kind: str, folder: Path, good: bytes) -> Path:
    """Return a file that is no usable model."""
    path = folder / "bad.onnx"
    if kind == "large":
        with path.open("wb") as file:
            file.truncate(LARGEST + 1)  # it takes no room on the disk
    elif kind == "form":
        model = onnx.load(save_pair(folder)[0])
        model.ir_version = 99
        path.write_bytes(model.SerializeToString())
    elif kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind != "missing":
        parts = {"cut": good[: len(good) // 2], "empty": b"", "zeros": b"\0\0"}
        path.write_bytes(parts[kind])
    return path


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("missing", "There is no file"),
        ("folder", "There is no file"),
        pytest.param("pipe", "There is no file",
                     marks=pytest.mark.skipif(os.name == "nt", reason="no pipes")),
        ("empty", "is empty"),
        ("cut", "is cut off or no ONNX file"),
        ("zeros", "is cut off or no ONNX file"),
        ("large", "has 1.0 GB"),
        ("form", "cannot be read as ONNX: Unsupported model IR version: 99, max"),
    ],
)  # fmt: skip
def test_a_bad_file_ends_in_one_clear_line(
    kind: str, words: str, backbone: Path, tmp_path: Path
) -> None:
    path = damaged(kind, tmp_path, backbone.read_bytes())
    with pytest.raises(SourceError) as caught:
        Session(str(path))
    assert words in str(caught.value)
    assert path.name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_every_cut_of_a_file_is_refused(backbone: Path, tmp_path: Path) -> None:
    good = backbone.read_bytes()
    for length in {*range(0, len(good), 97), len(good) - 1}:
        (tmp_path / "cut.onnx").write_bytes(good[:length])
        with pytest.raises(MotesError):
            Session(str(tmp_path / "cut.onnx"))


def test_without_onnx_runtime_the_remedy_is_named(
    backbone: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'motes\[onnx\]'"):
        Session(str(backbone))
