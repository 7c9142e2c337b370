"""Small evaluations with known numbers."""

from collections.abc import Sequence as Many
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from motes import Box, Ellipse
from motes_lab.datasets.sot import Sequence
from motes_lab.protocols.sot import Start
from motes_lab.protocols.trace import TrackerOutput
from motes_lab.runner import Pass
from motes_lab.scores import Outcome

Floats = NDArray[np.float64]
TARGET = (20.0, 10.0, 20.0, 30.0)


def ellipses(boxes: Floats) -> Floats:
    return np.array([Ellipse.from_box(box) for box in boxes.tolist()]).reshape(-1, 5)


def sequence(
    name: str = "Book", frames: int = 20, absent: Many[int] = (), source: str | Path = "nowhere.mp4"
) -> Sequence:
    """Return a sequence with a target that stands still."""
    boxes = np.tile(TARGET, (frames, 1))
    boxes[list(absent)] = np.nan
    return Sequence(name, source, boxes, ellipses(boxes))


def pictures(folder: Path, frames: int = 20, size: tuple[int, int] = (80, 60)) -> Path:
    """Make a folder of pictures, each darker than the one before."""
    folder.mkdir(parents=True)
    for i in range(frames):
        Image.new("RGB", size, (250 - 10 * i,) * 3).save(folder / f"{i:04d}.png")
    return folder


def shifted(dx: Many[float]) -> Floats:
    """Return the target's boxes (n, 4), moved to the right."""
    boxes: Floats = np.array(TARGET) + np.outer(dx, (1, 0, 0, 0))
    return boxes


def trace(
    boxes: Floats,
    confidence: Many[float] | float = np.nan,
    lost: Many[bool] | bool = False,
    seconds: float = 0.002,
    start: int = 0,
    covariance: Many[float] = (np.nan,) * 3,
) -> TrackerOutput:
    """Return a trace that says these boxes."""
    n = len(boxes)
    return TrackerOutput(
        np.arange(start, start + n),
        ellipses(boxes),
        np.broadcast_to(np.asarray(confidence, np.float64), (n,)).copy(),
        np.broadcast_to(np.asarray(lost, bool), (n,)).copy(),
        np.full(n, seconds),
        np.tile(covariance, (n, 1)),
    )


def outcome(
    tracker: str,
    where: Sequence,
    said: TrackerOutput | str,
    seed: int = 0,
    protocol: str = "ope",
    label: str = "",
    frame: int = 0,
) -> Outcome:
    """Return the outcome of a pass; a text instead of a trace is why it failed."""
    item = Pass(tracker, where.name, Start(protocol, label, frame, Box(*TARGET)), seed)
    return Outcome(where, item, *((None, said) if isinstance(said, str) else (said, "")))
