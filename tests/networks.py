"""Networks as ONNX files, small enough to be made in a test."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

CELLS = 16
"""Rows and columns of cells of the maps that VitTrack reads."""
SIZE = 0.25
"""Width and height of the target as shares of the searched region, four times as wide."""

GAIN = 10.0
"""Confidence at a brightness of 1, far above OpenCV's threshold of 0.2."""


def brightness_network(path: Path) -> None:
    """Write a network with VitTrack's inputs and outputs, whose target is what is brightest.

    From `template` (1, 3, 128, 128), which it does not need, and `search` (1, 3, 256, 256) it
    computes a map of confidences, `output1` (1, 1, 16, 16); of sizes, `output2` (1, 2, 16, 16), as
    shares of the region; and of the target's offset from each cell in cells, `output3`.
    """
    onnx = pytest.importorskip("onnx")
    node, info = onnx.helper.make_node, onnx.helper.make_tensor_value_info
    numbers = onnx.TensorProto.FLOAT
    step = 256 // CELLS
    cells = {"kernel_shape": [step, step], "strides": [step, step]}
    constants = {
        # Of the first channel: OpenCV inverts its scales as a quaternion, which turns the signs of
        # the other two.
        "mean": np.array([GAIN, 0, 0]).reshape(1, 3, 1, 1) * np.full((step, step), step**-2.0),
        "nothing": np.zeros((2, 3, step, step)),
        "size": np.full((1, 2, 1, 1), SIZE),
        "offset": np.full((1, 2, 1, 1), 0.5),
        "zero": np.zeros((1, 1, 1, 1)),
    }
    nodes = [
        node("ReduceMean", ["template"], ["learned"], axes=[1, 2, 3], keepdims=1),
        node("Mul", ["learned", "zero"], ["unused"]),
        node("Conv", ["search", "mean"], ["brightness"], **cells),
        node("Add", ["brightness", "unused"], ["score"]),
        node("Relu", ["score"], ["output1"]),
        node("Conv", ["search", "nothing"], ["empty"], **cells),
        node("Add", ["empty", "size"], ["output2"]),
        node("Add", ["empty", "offset"], ["output3"]),
    ]
    shapes = {"output1": 1, "output2": 2, "output3": 2}
    graph = onnx.helper.make_graph(
        nodes,
        "brightness",
        [info("template", numbers, [1, 3, 128, 128]), info("search", numbers, [1, 3, 256, 256])],
        [info(name, numbers, [1, n, CELLS, CELLS]) for name, n in shapes.items()],
        [
            onnx.numpy_helper.from_array(np.float32(value), name)
            for name, value in constants.items()
        ],
    )
    opset = [onnx.helper.make_opsetid("", 13)]
    onnx.save(onnx.helper.make_model(graph, opset_imports=opset, ir_version=8), path)
