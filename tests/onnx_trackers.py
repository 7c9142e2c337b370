"""Tiny ONNX models with the inputs and outputs of trained trackers, which look for one color.

They take the mean color of each 16x16 cell. A cell's score falls with the squared distance of its
color from that of the template's middle. Boxes are constants, another one for each cell.
"""

from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from numpy.typing import NDArray
from onnx import TensorProto, helper

from onnx_models import CELL, Graph

SURE, SHARP, SHARP_VIT = 6.0, 400.0, 8.0
"""The logit of a cell of the template's color, and how it falls with the squared distance.

The colors of the pair are shares of 1, those of the network of one file multiples of a deviation.
"""
_ROW, _COLUMN = np.mgrid[:16, :16].astype(np.float32)
DISTANCES = np.stack([30 + _COLUMN, 28 + _ROW, 34 - _COLUMN / 2, 36 - _ROW / 2])
"""Distances (4, 16, 16) of the Siamese pair: left, top, right, bottom, in pixels of its input."""
SIZES = np.stack([0.25 + _COLUMN / 100, 0.2 + _ROW / 100])
OFFSETS = np.stack([0.5 + _COLUMN / 50, 0.5 - _ROW / 50])
"""Sizes and offsets (2, 16, 16) of the network of one file."""


def mean_colors(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the mean colors (3, n, n) of cells of pixels (3, H, W).

    Where a row and a column are missing at the end, they are black.
    """
    side = -(-pixels.shape[1] // CELL)
    full = np.zeros((3, side * CELL, side * CELL), np.float32)
    full[:, : pixels.shape[1], : pixels.shape[2]] = pixels
    out: NDArray[np.float32] = full.reshape(3, side, CELL, side, CELL).mean((2, 4))
    return out


def scores(
    template: NDArray[np.float32], cells: NDArray[np.float32], sharp: float
) -> NDArray[np.float64]:
    """Return the scores (16, 16) of cells (3, 16, 16) for a template (3, 8, 8)."""
    wanted = template[:, 3:5, 3:5].mean((1, 2))[:, None, None]
    out: NDArray[np.float64] = 1 / (
        1 + np.exp(sharp * ((cells - wanted) ** 2.0).sum(0, np.float64) - SURE)
    )
    return out


def save_pair(folder: Path, *, opset: int = 17, channels: int = 4) -> tuple[str, str]:
    """Write a backbone and a head, and return their paths."""
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    backbone, head = Graph(), Graph()
    _mean_colors(backbone, "input", share=1 / 255, end=1, name="output")
    logit = _logits(head, "input1", "input2", SHARP)
    background = np.zeros((1, 1, 16, 16), np.float32)
    head.add("Concat", background, logit, axis=1, name="output1")
    distances = DISTANCES[None, :channels]
    # Added to 0 times the logits: OpenCV has no outputs that are constants.
    head.add("Add", head.add("Mul", logit, np.zeros(1, np.float32)), distances, name="output2")
    paths = folder / "backbone.onnx", folder / "head.onnx"
    _save(paths[0], backbone, {"input": (3, 255)}, {"output": (3, 16)}, opset)
    given = {"output1": (2, 16), "output2": (channels, 16)}
    _save(paths[1], head, {"input1": (3, 8), "input2": (3, 16)}, given, opset)
    return str(paths[0]), str(paths[1])


def save_vit(
    folder: Path, sizes: NDArray[np.float32] = SIZES, offsets: NDArray[np.float32] = OFFSETS
) -> str:
    """Write a network of one file, and return its path."""
    graph = Graph()
    template, search = (_mean_colors(graph, name) for name in ("template", "search"))
    logit = _logits(graph, template, search, SHARP_VIT)
    graph.add("Sigmoid", logit, name="output1")
    nothing = graph.add("Mul", logit, np.zeros(1, np.float32))
    graph.add("Add", nothing, sizes[None], name="output2")
    graph.add("Add", nothing, offsets[None], name="output3")
    outputs = {"output1": (1, 16), "output2": (2, 16), "output3": (2, 16)}
    path = folder / "vit.onnx"
    _save(path, graph, {"template": (3, 128), "search": (3, 256)}, outputs, 17)
    return str(path)


def _mean_colors(
    graph: Graph, pixels: str, *, share: float = 1.0, end: int = 0, name: str = ""
) -> str:
    kernel = np.eye(3, dtype=np.float32)[:, :, None, None] * share / CELL**2
    kernel = np.tile(kernel, (1, 1, CELL, CELL)).astype(np.float32)
    pads = [0, 0, end, end]
    return graph.add("Conv", pixels, kernel, name=name, strides=[CELL, CELL], pads=pads)


def _logits(graph: Graph, template: str, cells: str, sharp: float) -> str:
    """Return the logits (1, 1, 16, 16) of cells for a template."""
    first, last, axes = (np.array(each, np.int64) for each in ([3, 3], [5, 5], [2, 3]))
    middle = graph.add("Slice", template, first, last, axes)
    wanted = graph.add("GlobalAveragePool", middle)
    apart = graph.add("Sub", cells, wanted)
    squares = graph.add("Mul", apart, apart)
    kernel = np.full((1, 3, 1, 1), -sharp, np.float32)
    return graph.add("Conv", squares, kernel, np.array([SURE], np.float32))


def _save(
    path: Path,
    graph: Graph,
    inputs: dict[str, tuple[int, int]],
    outputs: dict[str, tuple[int, int]],
    opset: int,
) -> None:
    def values(sizes: dict[str, tuple[int, int]]) -> list[Any]:
        return [
            helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, channels, side, side])
            for name, (channels, side) in sizes.items()
        ]

    whole = helper.make_graph(graph.nodes, "tracker", values(inputs), values(outputs), graph.values)
    opsets = [helper.make_opsetid("", opset)]
    onnx.save(helper.make_model(whole, opset_imports=opsets, ir_version=9), str(path))
