"""ViTTrack: one network that takes the template and the region of search.

The template shows twice the target's mean side in 128x128 pixels, the region of search four times
in 256x256, black beside the frame. Each of 16x16 cells has a score, the offset of the center from
its corner in cells, and the size as a share of the region. Channels are normalized as ImageNet's;
OpenCV gives blue first, and so does this.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes.core.config import Config
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.onnx_session import Session
from motes.core.types import Floats, Singles
from motes.sot.network.network import NetworkFamily
from motes.sot.network.view import BLACK, Choice, NetworkView, Square, hann, read, view_of

TEMPLATE, SEARCH, CELLS = 128, 256, 16
TEMPLATE_SIDES, SEARCH_SIDES = 2.0, 4.0
"""The sides of the regions, in mean sides of the target."""
MEAN = 255 * np.array([0.485, 0.456, 0.406], np.float32)[:, None, None]
DEVIATION = 255 * np.array([0.229, 0.224, 0.225], np.float32)[:, None, None]
SCORES, SIZES, OFFSETS = "output1", "output2", "output3"


class Vit(NetworkFamily, Config, frozen=True, tag="vit"):
    """A network that takes two pictures, such as ViTTrack."""

    known_as = (
        "ViTTrack's one (it takes template 1x3x128x128 and search 1x3x256x256, and gives output1, "
        "output2 and output3)"
    )

    def arranged(self, files: Sequence[Session]) -> tuple[Session, ...] | None:
        """Return the file; see `NetworkFamily`."""
        if len(files) != 1:
            return None
        (file,) = files
        inputs = {each.name: each for each in file.inputs}
        usual = {"template": TEMPLATE, "search": SEARCH}
        fits = inputs.keys() == usual.keys() and all(
            inputs[name].holds(1, 3, side, side) for name, side in usual.items()
        )
        gives = {each.name for each in file.outputs} == {SCORES, SIZES, OFFSETS}
        return (file,) if fits and gives else None

    def learn(self, sessions: Sequence[Session], frame: Frame, ellipse: Ellipse) -> Singles:
        """Return the template: its pixels as the network takes them (1, 3, 128, 128)."""
        return _pixels(frame, _region(ellipse, TEMPLATE_SIDES), TEMPLATE)

    def look(
        self, sessions: Sequence[Session], template: Singles, frame: Frame, place: Ellipse
    ) -> NetworkView:
        """Return what the network sees around a place; see `NetworkFamily`."""
        region = _region(place, SEARCH_SIDES)
        search = _pixels(frame, region, SEARCH)
        outputs = sessions[0].run({"template": template, "search": search})
        scores = outputs[SCORES].reshape(-1).astype(np.float64)
        sizes = outputs[SIZES].reshape(2, -1).T * region.side
        cells = np.stack([each.ravel() for each in np.mgrid[:CELLS, :CELLS][::-1]], axis=1)
        offsets = outputs[OFFSETS].reshape(2, -1).T
        centers = (cells + offsets) * (region.side / CELLS) + (region.left, region.top)
        sides: Floats = np.concatenate([centers - sizes / 2, centers + sizes / 2], axis=1)
        window = hann(CELLS, zero_at_border=False)
        return view_of(sides, scores, window, place.box[2:], WINDOW_ALONE)


WINDOW_ALONE = Choice(window=1.0, multiplied=True, penalty=0.0, rate=1.0)
"""As OpenCV's tracker chooses; its new size is that of the box, though, whatever its score."""


def _region(ellipse: Ellipse, sides: float) -> Square:
    """Return the region of some mean sides around an ellipse."""
    _, _, width, height = ellipse.box
    return Square.around(ellipse.x, ellipse.y, sides * float(np.sqrt(width * height)))


def _pixels(frame: Frame, region: Square, size: int) -> Singles:
    """Return a region as the network takes it (1, 3, size, size)."""
    blue_first = read(frame, region, size, BLACK)[:, ::-1]
    return np.ascontiguousarray((blue_first - MEAN) / DEVIATION)
