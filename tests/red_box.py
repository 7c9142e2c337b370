"""A red box that goes to and fro before a camera, or walks by, and a detector that finds it."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes import Box, Detection, Frame, VideoWriter


def moving(index: int) -> NDArray[np.uint8]:
    """Return a picture with a red box that goes to and fro."""
    pixels = np.random.default_rng(index).integers(95, 106, (96, 160, 3)).astype(np.uint8)
    x = 60 + round(20 * np.sin(index / 40))
    pixels[30:60, x : x + 16] = (230, 40, 40)
    return pixels


def walk(path: Path, frames: int, enters: int) -> None:
    """Write a film of a red box that walks over noise after a frame, to the right, and out."""
    rng = np.random.default_rng(0)
    with VideoWriter(path, 25) as writer:
        for index in range(frames):
            pixels = rng.integers(95, 106, (96, 160, 3)).astype(np.uint8)
            x = 4 * (index - enters) - 16
            pixels[40:70, max(x, 0) : max(x + 16, 0)] = (230, 40, 40)
            writer.write(pixels)


def red(frame: Frame) -> list[Detection]:
    """Find the box."""
    rows, columns = np.nonzero(frame.pixels[:, :, 0] > 160)
    left, top = int(columns.min()), int(rows.min())
    return [Detection(Box(left, top, int(columns.max()) - left + 1, int(rows.max()) - top + 1))]
