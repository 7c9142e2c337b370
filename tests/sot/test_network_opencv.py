"""NanoTrack's own tracker, on views of its network, has the boxes of OpenCV's TrackerNano."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.sot.network.network import Network, _opened
from motes.sot.network.region import Region
from motes.sot.network.siamese import SEARCH, TEMPLATE, features, look_in

WINDOW, PENALTY, RATE = 0.455, 0.055, 0.37


class OpencvsChoice:
    """What TrackerNano does beside its network, its odd roundings included.

    It cuts whole pixels around a rounded place, takes twice the template's side for the region of
    search, and compares the sizes of boxes with the target's place in the picture. Its window is
    the root of Hann's, as `createHanningWindow` makes it.
    """

    def __init__(self, network: Network, frame: Frame, box: tuple[int, int, int, int]) -> None:
        x, y, width, height = box
        self._sessions = _opened(network).sessions
        self._place = np.array([x + width / 2, y + height / 2], np.float32)
        self._size = np.array([width, height], np.float32)
        side = int(np.sqrt((1.5 * width + 0.5 * height) * (1.5 * height + 0.5 * width)))
        self._template = features(self._sessions[0], frame, self._region(side), TEMPLATE)

    def _region(self, side: int) -> Region:
        left, top = (int(value) - (side + 1) // 2 for value in self._place)
        return Region(left, top, side)

    def update(self, frame: Frame) -> tuple[int, ...]:
        """Return the target's box in the next frame."""
        around = 0.5 * int(self._size.sum())
        extent = float(np.sqrt((self._size + around).prod()))
        region = self._region(int(2 * extent))
        width, height = self._size.tolist()
        view = look_in(self._sessions, self._template, frame, region, (width, height))
        scale = SEARCH / region.side
        sizes = view.boxes[:, 2:] * scale
        centers = (view.boxes[:, :2] - region[:2]) * scale + sizes / 2
        ratios = self._extents(sizes) / self._extents(self._place)
        shapes = width / height * sizes[:, 1] / sizes[:, 0]
        worse = np.maximum(ratios, 1 / ratios) * np.maximum(shapes, 1 / shapes)
        kept = np.exp(-(worse - 1) * PENALTY)
        row = int((kept * view.scores * (1 - WINDOW) + np.sqrt(view.window) * WINDOW).argmax())
        rate = kept[row] * view.scores[row] * RATE
        unit = TEMPLATE / extent
        limit = np.array([frame.width, frame.height])
        moved = self._place + (centers[row] - SEARCH / 2) / unit
        self._place = moved.clip(0, limit).astype(np.float32)
        grown = sizes[row] / unit * rate + (1 - rate) * self._size
        self._size = grown.clip(10, limit).astype(np.float32)
        return tuple(int(value) for value in (*(self._place - self._size / 2), *self._size))

    @staticmethod
    def _extents(sizes: NDArray[Any]) -> NDArray[Any]:
        context = sizes.sum(axis=-1, keepdims=True) / 2
        out: NDArray[Any] = np.sqrt((sizes + context).prod(axis=-1))
        return out


@pytest.mark.slow
@pytest.mark.parametrize("name", ["David", "Couple"])
def test_boxes_are_those_of_opencv(data: Path, name: str) -> None:
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    folder = data / "sot" / name
    files = [str(data.parent / "nano" / file) for file in ("backbone.onnx", "head.onnx")]
    for path in (*files, str(folder)):
        if not Path(path).exists():
            pytest.skip(f"{path} is not there")
    first = (folder / "groundtruth_rect.txt").read_text().splitlines()[0]
    x, y, width, height = (int(float(value)) for value in re.split(r"[,\s]+", first.strip()))
    box = (x - 1, y - 1, width, height)
    network = Network(tuple(files))
    assert network.open() == "siamese"
    parameters = cv2.TrackerNano_Params()
    parameters.backbone, parameters.neckhead = files
    theirs = cv2.TrackerNano_create(parameters)
    pictures = [cv2.imread(str(path)) for path in sorted((folder / "img").iterdir())[:51]]
    frames = [Frame(0, 0.0, picture[:, :, ::-1]) for picture in pictures]
    theirs.init(pictures[0], box)
    ours = OpencvsChoice(network, frames[0], box)
    for picture, frame in zip(pictures[1:], frames[1:], strict=True):
        _, wanted = theirs.update(picture)
        assert np.abs(np.subtract(ours.update(frame), wanted)).max() <= 1
