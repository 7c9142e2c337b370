"""Tiny ONNX models that find colored blobs, with the outputs of trained detectors.

A convolution takes the mean over each 16x16 cell. What a cell has of red above the other channels
is the score of class 0, of blue that of class 1. So a blob of 16x16 pixels in a cell is found to
the pixel. The model first undoes the scaling of its input, so that wrong values of it show.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

STEPS = (8, 16, 32)
CELL = 16
SHARP = 40.0
"""How steeply a score rises with the share of the color, from 0.5 at one half."""


class Graph:
    """A graph under construction."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.values: list[Any] = []

    def add(self, kind: str, *inputs: str | NDArray[Any], name: str = "", **how: Any) -> str:
        """Add a node, and return the name of its output; arrays become constants."""
        names = []
        for each in inputs:
            if not isinstance(each, str):
                self.values.append(numpy_helper.from_array(each, f"c{len(self.values)}"))
                each = self.values[-1].name
            names.append(each)
        out = name or f"n{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, names, [out], **how))
        return out


def cells(width: int, height: int, step: int) -> NDArray[np.float32]:
    """Return the centers of a grid's cells (n, 2), row by row."""
    y, x = np.mgrid[: height // step, : width // step]
    return (np.stack([x.ravel(), y.ravel()], axis=1) + 0.5).astype(np.float32) * step


def save(
    path: Path,
    head: str,
    *,
    size: tuple[int, int] = (96, 64),
    order: str = "rgb",
    mean: tuple[float, ...] = (0.0, 0.0, 0.0),
    deviation: tuple[float, ...] = (255.0, 255.0, 255.0),
    channels_last: bool = False,
    names: str = "",
    open_sides: bool = False,
    metadata: Mapping[str, str] = {},
) -> Path:
    """Write a model with a head of `onnx_heads` for inputs of a size, and return the path."""
    width, height = size
    graph = Graph()
    pixels = "images"
    if channels_last:
        pixels = graph.add("Transpose", pixels, perm=[0, 3, 1, 2])
    shape = (1, 3, 1, 1)
    raw = graph.add("Mul", pixels, np.array(deviation, np.float32).reshape(shape))
    raw = graph.add("Add", raw, np.array(mean, np.float32).reshape(shape))
    # The weights of class 0 are for red, those of class 1 for blue.
    weights = np.array([[1, -0.5, -0.5], [-0.5, -0.5, 1]], np.float32)
    if order == "bgr":
        weights = weights[:, ::-1]
    kernel = np.repeat(np.repeat(weights[:, :, None, None], CELL, 2), CELL, 3) / (255 * CELL**2)
    share = graph.add("Conv", raw, np.ascontiguousarray(kernel), strides=[CELL, CELL])
    share = graph.add("Reshape", share, np.array([1, 2, -1]))
    logits = graph.add(
        "Mul", graph.add("Sub", share, np.array(0.5, np.float32)), np.array(SHARP, np.float32)
    )
    scores = graph.add("Sigmoid", logits)
    outputs = _HEADS[head](graph, logits, scores, width, height)
    layout: list[Any] = [1, height, width, 3] if channels_last else [1, 3, height, width]
    if open_sides:
        layout = [1, 3, "height", "width"]
    given = helper.make_tensor_value_info("images", TensorProto.FLOAT, layout)
    inputs = [given]
    if head == "lists":
        inputs.append(helper.make_tensor_value_info("orig_target_sizes", TensorProto.INT64, [1, 2]))
    whole = helper.make_graph(
        graph.nodes,
        "blobs",
        inputs,
        [helper.make_tensor_value_info(name, kind, None) for name, kind in outputs.items()],
        graph.values,
    )
    model = helper.make_model(whole, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    helper.set_model_props(model, {**metadata, "names": names})
    onnx.save(model, str(path))
    return path


FLOAT, INT = TensorProto.FLOAT, TensorProto.INT64


def _dense(graph: Graph, scores: str, width: int, height: int) -> str:
    """Return the scores (1, 2, A) of all grids, which are 0 but for the cells."""
    empty = [np.zeros((1, 2, len(cells(width, height, step))), np.float32) for step in STEPS]
    return graph.add("Concat", empty[0], scores, empty[2], axis=2)


def _yolo(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    centers = np.concatenate([cells(width, height, step) for step in STEPS])
    boxes = np.hstack([centers, np.full_like(centers, CELL)]).T[None]
    dense = _dense(graph, scores, width, height)
    return {graph.add("Concat", np.ascontiguousarray(boxes), dense, axis=1): FLOAT}


def _yolox(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    """Return offsets of half a cell, and sizes of `CELL` pixels as logarithms."""
    parts = [
        np.tile(np.array([0.5, 0.5, *[np.log(CELL / step)] * 2, 1.0], np.float32), (n, 1))
        for step in STEPS
        for n in [len(cells(width, height, step))]
    ]
    dense = graph.add("Transpose", _dense(graph, scores, width, height), perm=[0, 2, 1])
    return {graph.add("Concat", np.concatenate(parts)[None], dense, axis=2): FLOAT}


def _yolov5(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    """Return three anchors for each cell, of which only the first sees anything."""
    centers = np.concatenate([cells(width, height, step) for step in STEPS])
    once = np.hstack([centers, np.full_like(centers, CELL), np.ones((len(centers), 1))])
    boxes = np.concatenate([once, once, once]).astype(np.float32)[None]
    dense = graph.add("Transpose", _dense(graph, scores, width, height), perm=[0, 2, 1])
    blind = np.zeros((1, 2 * len(centers), 2), np.float32)
    dense = graph.add("Concat", dense, blind, axis=1)
    return {graph.add("Concat", boxes, dense, axis=2): FLOAT}


def _rows(graph: Graph, scores: str) -> tuple[str, str]:
    """Return the best score and its class of each cell: (1, n, 1) each, the class as a float."""
    turned = graph.add("Transpose", scores, perm=[0, 2, 1])
    best = graph.add("ReduceMax", turned, axes=[2], keepdims=1)
    which = graph.add("ArgMax", turned, axis=2, keepdims=1)
    return best, graph.add("Cast", which, to=FLOAT)


def _corners(width: int, height: int) -> NDArray[np.float32]:
    centers = cells(width, height, CELL)
    return np.hstack([centers - CELL / 2, centers + CELL / 2]).astype(np.float32)


def _nms(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    best, which = _rows(graph, scores)
    return {graph.add("Concat", _corners(width, height)[None], best, which, axis=2): FLOAT}


def _shares(width: int, height: int) -> NDArray[np.float32]:
    centers = cells(width, height, CELL)
    boxes = np.hstack([centers, np.full_like(centers, CELL)]) / (width, height, width, height)
    return boxes.astype(np.float32)[None]


def _detr(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    turned = graph.add("Transpose", logits, perm=[0, 2, 1])
    nothing = np.zeros((1, len(cells(width, height, CELL)), 1), np.float32)
    logit = graph.add("Concat", turned, nothing, axis=2, name="pred_logits")
    boxes = graph.add("Identity", _shares(width, height), name="pred_boxes")
    return {logit: FLOAT, boxes: FLOAT}


def _rfdetr(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    boxes = graph.add("Identity", _shares(width, height), name="dets")
    return {boxes: FLOAT, graph.add("Transpose", logits, perm=[0, 2, 1], name="labels"): FLOAT}


def _rtdetr(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    best, which = _rows(graph, scores)
    return {graph.add("Concat", _shares(width, height), best, which, axis=2): FLOAT}


def _rtdetr_classes(
    graph: Graph, logits: str, scores: str, width: int, height: int
) -> dict[str, int]:
    """Return the scores of all classes, as older exports do; none is quite 0 or 1."""
    turned = graph.add("Transpose", scores, perm=[0, 2, 1])
    turned = graph.add(
        "Add", graph.add("Mul", turned, np.array([0.98], np.float32)), np.array([0.01], np.float32)
    )
    return {graph.add("Concat", _shares(width, height), turned, axis=2): FLOAT}


def _lists(graph: Graph, logits: str, scores: str, width: int, height: int) -> dict[str, int]:
    """Return boxes in the size that the second input gives."""
    best, which = _rows(graph, scores)
    asked = graph.add("Cast", "orig_target_sizes", to=FLOAT)
    twice = graph.add("Concat", asked, asked, axis=1)
    shares = _corners(width, height) / np.array([width, height, width, height], np.float32)
    boxes = graph.add("Mul", shares[None], graph.add("Reshape", twice, np.array([1, 1, 4])))
    labels = graph.add("Cast", graph.add("Squeeze", which, np.array([2])), to=INT, name="labels")
    found = graph.add("Squeeze", best, np.array([2]), name="scores")
    return {labels: INT, graph.add("Identity", boxes, name="boxes"): FLOAT, found: FLOAT}


_HEADS = {
    "yolo": _yolo,
    "yolox": _yolox,
    "yolov5": _yolov5,
    "nms": _nms,
    "detr": _detr,
    "rfdetr": _rfdetr,
    "rtdetr": _rtdetr,
    "rtdetr classes": _rtdetr_classes,
    "lists": _lists,
}
