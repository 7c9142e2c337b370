"""The marks by which a camera was held: pictures are turned and mirrored by them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from av.sidedata.sidedata import Type as SideData
from numpy.typing import NDArray

if TYPE_CHECKING:
    from av.video.frame import VideoFrame


def display_matrix(frame: VideoFrame) -> NDArray[np.int32]:
    """Return the display matrix, (2, 2): the pixel at (x, y) is shown at (x, y) @ matrix."""
    try:
        side_data: Mapping[Any, Any] = frame.side_data
    except ValueError:  # side data of a kind that PyAV does not know; only the angle is given
        cos, sin = round(math.cos(angle := math.radians(-frame.rotation))), round(math.sin(angle))
        return np.array([[cos, sin], [-sin, cos]], np.int32)
    found = side_data.get(SideData.DISPLAYMATRIX)
    if found is None:
        return np.eye(2, dtype=np.int32)
    return np.frombuffer(bytes(found), np.int32).reshape(3, 3)[:2, :2]


def upright(pixels: NDArray[Any], matrix: NDArray[np.int32]) -> NDArray[Any]:
    """Return a picture rotated and mirrored by a display matrix, to the nearest 90 degrees."""
    across, along = matrix.diagonal().tolist(), matrix[::-1].diagonal().tolist()
    if abs(along[1]) > abs(across[0]):
        pixels, across = pixels.swapaxes(0, 1), along
    if across[0] < 0:
        pixels = pixels[:, ::-1]
    return pixels[::-1] if across[1] < 0 else pixels
