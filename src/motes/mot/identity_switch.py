"""Which of two objects is which when they part: by color, or by edges where colors are alike.

Zhao and Pei, section 3: the color histogram distinguishes two objects after an occlusion, and the
histogram of oriented gradients where their colors are alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.cues.hog import Hog
from motes.mot.boxes import as_rows
from motes.mot.tracked_object import TrackedObject

EDGES = Hog(cells=3, rotation_normalized=False)
"""The 72 bins by which the paper distinguishes targets of one color, without rotation."""
SWAP_MARGIN = 0.2
"""Least difference between the sums of distances for a decision by one cue."""


def is_identity_switch(one: TrackedObject, other: TrackedObject, frame: Frame) -> bool:
    """Return whether each of two objects looks like the other one did before they met."""
    boxes = as_rows([one.track.box, other.track.box])
    colors = np.array([each.distances(frame, boxes) for each in (one, other)])
    if abs(swap_gain(colors)) > SWAP_MARGIN or one.shape_model is None or other.shape_model is None:
        return swap_gain(colors) > SWAP_MARGIN
    ellipses = np.array([Ellipse.from_box(box) for box in boxes.tolist()])
    shapes = [EDGES.distances(each.shape_model, frame, ellipses) for each in (one, other)]
    return swap_gain(np.array(shapes)) > SWAP_MARGIN


def swap_gain(distances: NDArray[np.float64]) -> float:
    """Return by how much two models' distances (2, 2) to two regions fall if these are swapped."""
    return float(distances[0, 0] + distances[1, 1] - distances[0, 1] - distances[1, 0])
